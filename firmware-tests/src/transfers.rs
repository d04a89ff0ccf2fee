//! The memory side of DMA transfers: the register models do not see memory, so they are carried out beside the processor.

use crate::cpu::Engine;
use crate::dma::{Direction, Transfer};

/// Carries out what the DMA controllers have to move now.
pub fn carry_out(engine: &mut Engine<'_>) {
    let mut some = false;
    while let Some((controller, transfer)) = engine.get_data().next_transfer() {
        some = true;
        let moved = move_item(engine, controller, &transfer);
        let dma = &mut engine.get_data_mut().dma[controller];
        match moved {
            Some(()) => dma.finish(&transfer),
            None => dma.fail(&transfer),
        }
    }
    if some {
        engine.get_data_mut().process();
    }
}

/// Moves one item; `None` when an address is not within reach.
fn move_item(engine: &mut Engine<'_>, controller: usize, transfer: &Transfer) -> Option<()> {
    let &Transfer {
        peripheral,
        peripheral_size,
        memory,
        memory_size,
        ..
    } = transfer;
    let reached = engine.get_data().dma[controller].reaches(transfer);
    let mut bytes = [0; 4];
    match transfer.direction {
        Direction::ToMemory => {
            // The item is taken from the peripheral before the bus tells that it cannot be stored.
            let value = engine.get_data_mut().read(peripheral, peripheral_size);
            bytes = value.to_le_bytes();
            let item = reached.then_some(&bytes[..memory_size])?;
            engine.mem_write(u64::from(memory), item).ok()
        }
        Direction::FromMemory => {
            reached.then_some(())?;
            let item = &mut bytes[..memory_size];
            engine.mem_read(u64::from(memory), item).ok()?;
            let value = u32::from_le_bytes(bytes);
            engine
                .get_data_mut()
                .write(peripheral, peripheral_size, value);
            Some(())
        }
    }
}
