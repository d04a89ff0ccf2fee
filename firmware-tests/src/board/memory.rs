//! What lies where for the processor: flash, memory and registers.

use unicorn_engine::{Prot, Unicorn, uc_error};

use crate::cpu::Engine;
use crate::flash_memory;
use crate::image::Image;
use crate::soc::{FLASH, Soc};

const RAM: u32 = 0x2000_0000;
const RAM_SIZE: u64 = 0x2_0000;
const CORE_COUPLED_RAM: u64 = 0x1000_0000;
const CORE_COUPLED_RAM_SIZE: u64 = 0x1_0000;
/// The memory of the maker, which cannot be written; the number of the chip is there.
const SYSTEM_MEMORY: u64 = 0x1FFF_0000;
const SYSTEM_MEMORY_SIZE: u64 = 0x1_0000;
/// Peripherals of the chip and of the processor: first address and size.
const REGISTERS: [(u32, u64); 4] = [
    (0x4000_0000, 0x8_0000),
    (0x4800_0000, 0x3000),
    (0x5000_0000, 0x6_1000),
    (0xE000_0000, 0x10_0000),
];
/// Memory after power-on is anything; this value also shows how much of the stack was used.
pub(super) const PAINT: u8 = 0xA5;

/// Flashes the image.
pub(super) fn load(engine: &mut Engine<'_>, image: &Image) -> Result<(), uc_error> {
    let mut content = engine.get_data().flash.content().clone();
    for piece in image.load() {
        if !content.write(piece.address, &piece.bytes) {
            engine.mem_write(u64::from(piece.address), &piece.bytes)?;
        }
    }
    engine.get_data_mut().flash.set_content(content);
    Ok(())
}

pub(super) fn paint(engine: &mut Engine<'_>) -> Result<(), uc_error> {
    engine.mem_write(u64::from(RAM), &vec![PAINT; RAM_SIZE as usize])?;
    let core_coupled = vec![PAINT; CORE_COUPLED_RAM_SIZE as usize];
    engine.mem_write(CORE_COUPLED_RAM, &core_coupled)
}

pub(super) fn map_memory(engine: &mut Engine<'_>, flash_bytes: u64) -> Result<(), uc_error> {
    engine.mem_map(u64::from(FLASH), flash_bytes, Prot::READ | Prot::EXEC)?;
    engine.mem_map(CORE_COUPLED_RAM, CORE_COUPLED_RAM_SIZE, Prot::ALL)?;
    engine.mem_map(SYSTEM_MEMORY, SYSTEM_MEMORY_SIZE, Prot::READ)?;
    engine.mem_map(u64::from(RAM), RAM_SIZE, Prot::ALL)?;
    paint(engine)?;
    for (base, size) in REGISTERS {
        engine.mmio_map(
            u64::from(base),
            size,
            Some(move |engine: &mut Unicorn<Soc>, offset: u64, size: usize| {
                u64::from(engine.get_data_mut().read(base + offset as u32, size))
            }),
            Some(
                move |engine: &mut Unicorn<Soc>, offset: u64, size: usize, value: u64| {
                    let address = base + offset as u32;
                    if engine.get_data().waits_for_flash(address) {
                        flash_memory::wait(engine);
                    }
                    let soc = engine.get_data_mut();
                    soc.write(address, size, value as u32);
                },
            ),
        )?;
    }
    Ok(())
}
