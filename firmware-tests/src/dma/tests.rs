//! The controllers at their registers: what a driver relies on, and what it must not do.

use super::*;
use crate::chip::{Chip, STM32F405, STM32G474};

/// A controller of each chip with the places of the registers of its stream or channel 5.
struct Lone {
    dma: Dma,
    /// Control, number of items, peripheral, memory, flags, clearing of flags.
    offsets: [u32; 6],
}

const CONTROL: usize = 0;
const ITEMS: usize = 1;
const PERIPHERAL: usize = 2;
const MEMORY: usize = 3;
const FLAGS: usize = 4;
const CLEAR: usize = 5;
const INDEX: usize = 5;

/// Control of a circular transfer of bytes to memory with every interrupt; and of one from memory that ends.
const TO_MEMORY: [u32; 2] = [
    4 << 25 | 1 << 10 | 1 << 8 | 0b111 << 2,
    1 << 7 | 1 << 5 | 0b111 << 1,
];
const FROM_MEMORY: [u32; 2] = [4 << 25 | 1 << 10 | 1 << 6, 1 << 7 | 1 << 4];

impl Lone {
    fn both() -> [Self; 2] {
        [Self::of(&STM32F405), Self::of(&STM32G474)]
    }

    fn of(chip: &'static Chip) -> Self {
        let dma = Dma::new(&chip.dma.controllers[0]);
        let offsets = match dma.wiring.registers {
            Registers::Streams => [0x88, 0x8C, 0x90, 0x94, 0x04, 0x0C],
            Registers::Channels => [0x6C, 0x70, 0x74, 0x78, 0x00, 0x04],
        };
        Self { dma, offsets }
    }

    fn write(&mut self, register: usize, value: u32) {
        self.dma.write(self.offsets[register], value, |_, _| true);
    }

    fn read(&self, register: usize) -> u32 {
        self.dma.read(self.offsets[register])
    }

    fn kind(&self) -> usize {
        usize::from(self.dma.wiring.registers == Registers::Channels)
    }

    fn start(&mut self, control: [u32; 2], items: u32) {
        self.write(ITEMS, items);
        self.write(PERIPHERAL, 0x4000_4404);
        self.write(MEMORY, 0x2000_0100);
        self.write(CONTROL, control[self.kind()] | 1);
    }

    fn next(&self) -> Option<Transfer> {
        self.dma.next_transfer(|_| true, |index, _| index == INDEX)
    }

    fn serve(&mut self) -> Transfer {
        let transfer = self.next().expect("a transfer");
        self.dma.finish(&transfer);
        transfer
    }

    /// Half, complete and error.
    fn events(&self) -> [bool; 3] {
        let bits: [u32; 3] = match self.dma.wiring.registers {
            // Stream 5 is the second of HISR.
            Registers::Streams => [10, 11, 9],
            Registers::Channels => [22, 21, 23],
        };
        bits.map(|bit| self.read(FLAGS) >> bit & 1 != 0)
    }

    fn clear(&mut self) {
        let all = [0x3D << 6, 0xF << 20][self.kind()];
        self.write(CLEAR, all);
    }

    fn is_pending(&self) -> bool {
        self.dma.lines().any(|(number, level)| {
            assert!(!level || number == 16, "another line than that of stream 5");
            level
        })
    }
}

#[test]
fn a_circular_transfer_fills_memory_and_begins_again() {
    for mut lone in Lone::both() {
        lone.start(TO_MEMORY, 4);
        let addresses: Vec<u32> = (0..6).map(|_| lone.serve().memory).collect();
        let offsets: Vec<u32> = addresses.iter().map(|at| at - 0x2000_0100).collect();
        assert_eq!(offsets, [0, 1, 2, 3, 0, 1], "{}", lone.kind());
        assert_eq!(lone.read(ITEMS), 2);
        assert_eq!(lone.read(CONTROL) & 1, 1);
    }
}

#[test]
fn half_and_complete_are_told_and_cleared() {
    for mut lone in Lone::both() {
        lone.start(TO_MEMORY, 4);
        lone.serve();
        assert_eq!((lone.events(), lone.is_pending()), ([false; 3], false));
        lone.serve();
        assert_eq!(lone.events(), [true, false, false]);
        assert!(lone.is_pending());
        lone.clear();
        assert_eq!((lone.events(), lone.is_pending()), ([false; 3], false));
        lone.serve();
        lone.serve();
        assert_eq!(lone.events(), [false, true, false]);
    }
}

#[test]
fn at_the_end_a_stream_is_disabled_and_a_channel_is_not_but_neither_is_served() {
    for (mut lone, enabled) in Lone::both().into_iter().zip([0, 1]) {
        lone.start(FROM_MEMORY, 2);
        for _ in 0..2 {
            assert_eq!(lone.serve().direction, Direction::FromMemory);
        }
        assert_eq!((lone.read(CONTROL) & 1, lone.read(ITEMS)), (enabled, 0));
        assert_eq!(lone.next(), None);
        // Without the enables nothing is pending.
        assert!(lone.events()[1] && !lone.is_pending());
    }
}

#[test]
fn disabling_stops_it_where_it_is_and_a_stream_tells_that_it_has_ended() {
    for (mut lone, complete) in Lone::both().into_iter().zip([true, false]) {
        lone.start(TO_MEMORY, 4);
        lone.serve();
        lone.write(CONTROL, TO_MEMORY[lone.kind()]);
        assert_eq!(lone.next(), None);
        assert_eq!(lone.read(ITEMS), 3);
        assert_eq!(lone.events()[1], complete);
    }
}

#[test]
fn while_it_is_enabled_addresses_and_number_stay() {
    for mut lone in Lone::both() {
        lone.start(TO_MEMORY, 4);
        lone.write(ITEMS, 9);
        lone.write(MEMORY, 0x2000_0900);
        assert_eq!((lone.read(ITEMS), lone.read(MEMORY)), (4, 0x2000_0100));
    }
}

#[test]
fn an_error_disables_it() {
    for mut lone in Lone::both() {
        lone.start(TO_MEMORY, 4);
        let transfer = lone.next().unwrap();
        lone.dma.fail(&transfer);
        assert_eq!(lone.events(), [false, false, true]);
        assert_eq!(lone.read(CONTROL) & 1, 0);
        assert!(lone.is_pending());
    }
}

#[test]
fn each_controller_reaches_its_memory_only() {
    let reach = |chip: &'static Chip, direction, memory| {
        let mut lone = Lone::of(chip);
        lone.start(TO_MEMORY, 1);
        let transfer = lone.next().unwrap();
        lone.dma.reaches(&Transfer {
            direction,
            memory,
            ..transfer
        })
    };
    let (into, from) = (Direction::ToMemory, Direction::FromMemory);
    for (memory, direction, expected) in [
        (0x2000_0000, into, [true, true]),
        (0x2001_FFFF, from, [true, true]),
        (0x2002_0000, into, [false, false]),
        (0x0800_0000, from, [true, true]),
        (0x0800_0000, into, [false, false]),
        // Core-coupled memory.
        (0x1000_0000, into, [false, true]),
        (0x1000_0000, from, [false, true]),
    ] {
        let reached = [&STM32F405, &STM32G474].map(|chip| reach(chip, direction, memory));
        assert_eq!(reached, expected, "{direction:?} {memory:#x}");
    }
}

#[test]
fn the_higher_priority_goes_first_and_of_equals_the_lower_number() {
    let mut dma = Dma::new(&STM32F405.dma.controllers[0]);
    let set = |dma: &mut Dma, stream: u32, priority: u32| {
        let first = 0x10 + 0x18 * stream;
        dma.write(first + 4, 1, |_, _| true);
        dma.write(first, priority << 16 | 1, |_, _| true);
    };
    set(&mut dma, 6, 1);
    set(&mut dma, 2, 0);
    set(&mut dma, 1, 0);
    let order: Vec<usize> = (0..3)
        .map(|_| {
            let transfer = dma.next_transfer(|_| true, |_, _| true).unwrap();
            dma.finish(&transfer);
            transfer.stream
        })
        .collect();
    assert_eq!(order, [6, 1, 2]);
}

#[test]
#[should_panic(expected = "flags of its last transfer are set")]
fn a_stream_must_not_be_enabled_with_its_flags_set() {
    let mut lone = Lone::of(&STM32F405);
    lone.start(FROM_MEMORY, 1);
    lone.serve();
    lone.start(FROM_MEMORY, 1);
}

#[test]
#[should_panic(expected = "only the direct mode is modelled")]
fn the_fifo_mode_is_refused() {
    let mut lone = Lone::of(&STM32F405);
    lone.dma.write(0x9C, 1 << 2, |_, _| true);
    lone.start(TO_MEMORY, 1);
}

#[test]
#[should_panic(expected = "stream 5, channel 4: the peripheral behind it is not modelled")]
fn a_stream_of_a_peripheral_without_a_model_is_refused() {
    let mut lone = Lone::of(&STM32F405);
    lone.dma.write(0x88, TO_MEMORY[0] | 1, |index, channel| {
        (index, channel) != (5, 4)
    });
}

#[test]
#[should_panic(expected = "from memory to memory are not modelled")]
fn a_channel_between_memories_is_refused() {
    let mut lone = Lone::of(&STM32G474);
    lone.write(CONTROL, 1 << 14 | 1);
}

#[test]
#[should_panic(expected = "its transfer error is set")]
fn a_channel_must_not_be_enabled_with_its_error_set() {
    let mut lone = Lone::of(&STM32G474);
    lone.start(TO_MEMORY, 4);
    let transfer = lone.next().unwrap();
    lone.dma.fail(&transfer);
    lone.start(TO_MEMORY, 4);
}
