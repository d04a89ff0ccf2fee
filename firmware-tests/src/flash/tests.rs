//! The controllers at their registers: unlocking, what they demand, times, and what a cut leaves.

use std::collections::BTreeSet;

use super::registers::{BUSY, KEYS, Place};
use super::*;
use crate::chip::{Chip, STM32F405, STM32G474};

const US: u64 = 1_000;
const MS: u64 = 1_000_000;
const ERROR_INTERRUPTS: u32 = CR_ERROR_ENABLE | CR_END_ENABLE;
/// PSIZE of the STM32F4: 32 bits.
const WORDS: u32 = 2 << 8;
const BANK_2: u32 = 1 << 11;

struct Lone {
    flash: Flash,
    options: u32,
    now_ns: u64,
}

impl Lone {
    fn new(chip: &'static Chip) -> Self {
        let mut flash = Flash::new(&chip.flash);
        flash.reset();
        let (_, _, options) = chip.option_bytes;
        Self {
            flash,
            options,
            now_ns: 0,
        }
    }

    fn unlocked(chip: &'static Chip) -> Self {
        let mut lone = Self::new(chip);
        lone.keys(KEYS);
        lone
    }

    /// Words of 32 bits on the chip that can choose.
    fn width(&self) -> u32 {
        match self.flash.part.registers {
            Registers::Sectors => WORDS,
            Registers::Pages => 0,
        }
    }

    fn keys(&mut self, keys: [u32; 2]) {
        for key in keys {
            self.write(Place::Key, key);
        }
    }

    fn offset(&self, place: Place) -> u32 {
        let all = (0..0x20).step_by(4);
        let found = all
            .into_iter()
            .find(|offset| self.flash.place(*offset) == Some(place));
        found.expect("the register is there")
    }

    fn write(&mut self, place: Place, value: u32) {
        let offset = self.offset(place);
        let known = self.flash.write(offset, value, self.options, self.now_ns);
        assert!(known);
    }

    fn read(&self, place: Place) -> u32 {
        self.flash.read(self.offset(place)).unwrap()
    }

    fn store(&mut self, offset: u32, size: u32, value: u32) {
        let address = FLASH + offset;
        self.flash
            .store(address, size, value, self.options, self.now_ns);
    }

    /// Both words of a double word.
    fn store_double(&mut self, offset: u32, value: u64) {
        self.store(offset, 4, value as u32);
        self.store(offset + 4, 4, (value >> 32) as u32);
    }

    fn run(&mut self, ns: u64) {
        self.now_ns += ns;
        self.flash.advance(self.now_ns);
    }

    fn word(&self, offset: u32) -> u32 {
        self.flash.content.value(FLASH + offset, 4) as u32
    }

    /// Programs a word over the whole of a range, with the time that it takes.
    fn fill(&mut self, range: Range<u32>, value: u32) {
        let bytes = value.to_le_bytes().repeat(range.len() / 4);
        let mut content = self.flash.content.clone();
        assert!(content.write(FLASH + range.start, &bytes));
        self.flash.set_content(content);
    }

    fn errors(&mut self) -> u32 {
        let status = self.read(Place::Status);
        self.write(Place::Status, status);
        status
    }
}

#[test]
fn both_keys_in_their_order_unlock_and_a_wrong_one_locks_until_the_reset() {
    for chip in Chip::ALL {
        let mut lone = Lone::new(chip);
        lone.write(Place::Control, CR_PROGRAM);
        assert_eq!(lone.read(Place::Control) & (CR_PROGRAM | CR_LOCK), CR_LOCK);
        lone.write(Place::Key, KEYS[1]);
        lone.keys(KEYS);
        assert_eq!(
            lone.read(Place::Control) & CR_LOCK,
            CR_LOCK,
            "{}",
            chip.name
        );
        lone.flash.reset();
        lone.keys(KEYS);
        assert_eq!(lone.read(Place::Control) & CR_LOCK, 0, "{}", chip.name);
        lone.write(Place::Control, CR_LOCK);
        lone.write(Place::Control, CR_PROGRAM);
        assert_eq!(lone.read(Place::Control) & CR_PROGRAM, 0, "{}", chip.name);
    }
}

#[test]
fn programming_takes_its_time_and_clears_bits_only() {
    let mut lone = Lone::unlocked(&STM32F405);
    lone.write(Place::Control, WORDS | CR_PROGRAM);
    lone.fill(0x100..0x104, 0xFF00_FF0F);
    lone.store(0x100, 4, 0x0FF0_FFFF);
    lone.run(100 * US - 1);
    assert_eq!(lone.read(Place::Status), BUSY);
    assert_eq!(lone.word(0x100), 0xFF00_FF0F);
    lone.run(1);
    assert_eq!(
        (lone.read(Place::Status), lone.word(0x100)),
        (0, 0x0F00_FF0F)
    );

    let mut lone = Lone::unlocked(&STM32G474);
    lone.write(Place::Control, CR_PROGRAM);
    lone.store(0x100, 4, 1);
    assert_eq!(lone.read(Place::Status), 0, "half a double word");
    lone.store(0x104, 4, 2);
    lone.run(83_349);
    assert_eq!(
        (lone.read(Place::Status), lone.word(0x100)),
        (BUSY, u32::MAX)
    );
    lone.run(1);
    assert_eq!(lone.read(Place::Status), 0);
    assert_eq!((lone.word(0x100), lone.word(0x104)), (1, 2));
}

#[test]
fn the_end_is_told_only_with_its_interrupt() {
    for chip in Chip::ALL {
        for (enable, expected) in [(0, 0), (CR_END_ENABLE, END)] {
            let mut lone = Lone::unlocked(chip);
            lone.write(Place::Control, lone.width() | CR_PROGRAM | enable);
            lone.store_double(0, 0);
            assert!(!lone.flash.line());
            lone.run(MS);
            assert_eq!(lone.read(Place::Status), expected, "{}", chip.name);
            assert_eq!(lone.flash.line(), expected != 0, "{}", chip.name);
            lone.write(Place::Status, END);
            assert!(!lone.flash.line());
        }
    }
}

#[test]
fn the_f405_refuses_what_its_manual_forbids() {
    let mut lone = Lone::unlocked(&STM32F405);
    lone.write(Place::Control, WORDS | ERROR_INTERRUPTS);
    lone.store(0, 4, 0);
    assert_eq!(lone.errors(), SEQUENCE | OPERATION_ERROR);
    lone.write(Place::Control, WORDS | CR_PROGRAM | ERROR_INTERRUPTS);
    for (offset, size, error) in [(0, 2, SIZE), (0, 1, SIZE), (0x0E, 4, ALIGNMENT)] {
        lone.store(offset, size, 0);
        assert!(lone.flash.line());
        assert_eq!(lone.errors(), error | OPERATION_ERROR, "{offset:#x} {size}");
    }
    // Sector 4 protected: 0x1_0000 to 0x1_FFFF.
    lone.options &= !(1 << 20);
    for (offset, error) in [
        (0xFFF0, 0),
        (0x1_0000, PROTECTED),
        (0x1_FFF0, PROTECTED),
        (0x2_0000, 0),
    ] {
        lone.store(offset, 4, 0);
        lone.run(MS);
        assert_eq!(
            lone.errors() & !(END | OPERATION_ERROR),
            error,
            "{offset:#x}"
        );
        assert_eq!(lone.word(offset) == 0, error == 0);
    }
    lone.write(Place::Control, WORDS | CR_ERASE | 4 << 3 | CR_START);
    assert_eq!(lone.errors(), PROTECTED);
    // Without the interrupt OPERR stays clear.
    lone.write(Place::Control, WORDS);
    lone.store(0, 4, 0);
    assert_eq!(lone.errors(), SEQUENCE);
}

#[test]
fn the_g474_refuses_what_its_manual_forbids() {
    const PROGRAM_ERROR: u32 = 1 << 3;
    let mut lone = Lone::unlocked(&STM32G474);
    lone.store(0, 4, 0);
    assert_eq!(lone.errors(), SEQUENCE);
    lone.write(Place::Control, CR_PROGRAM | CR_ERASE);
    lone.store(0, 4, 0);
    assert_eq!(lone.errors(), SEQUENCE);
    lone.write(Place::Control, CR_PROGRAM);
    for (offset, size, error) in [(0, 2, SIZE), (0, 1, SIZE), (4, 4, ALIGNMENT)] {
        lone.store(offset, size, 0);
        assert_eq!(lone.errors(), error, "{offset} {size}");
    }
    lone.store(0, 4, 1);
    lone.store(0x0C, 4, 2);
    assert_eq!(lone.errors(), ALIGNMENT);
    // A double word is programmed once; zeros may go over it.
    for (value, error, expected) in [(5, 0, 5), (4, PROGRAM_ERROR, 5), (0, 0, 0), (0, 0, 0)] {
        lone.store_double(0x20, value);
        lone.run(MS);
        assert_eq!(
            (lone.errors(), lone.word(0x20)),
            (error, expected),
            "{value}"
        );
    }
    // An error that was not cleared stops the next program and erase.
    lone.store(0, 2, 0);
    lone.store_double(0x40, 0);
    assert_eq!(lone.read(Place::Status), SIZE | SEQUENCE);
    lone.write(Place::Control, CR_ERASE | CR_START);
    assert!(!lone.flash.is_changing());
    lone.errors();
    lone.write(Place::Control, CR_ERASE | CR_PROGRAM | CR_START);
    assert_eq!((lone.flash.is_changing(), lone.errors()), (false, SEQUENCE));
}

#[test]
fn sectors_and_pages_lie_where_the_manuals_say_and_take_their_time() {
    for (chip, control, range, ms) in [
        (&STM32F405, WORDS | 3 << 3, 0xC000..0x1_0000, 500),
        (&STM32F405, WORDS | 4 << 3, 0x1_0000..0x2_0000, 1_100),
        (&STM32F405, WORDS | 11 << 3, 0xE_0000..0x10_0000, 2_000),
        (&STM32F405, 11 << 3, 0xE_0000..0x10_0000, 4_000),
        (&STM32G474, 127 << 3, 0x3_F800..0x4_0000, 24),
        (&STM32G474, BANK_2 | 1 << 3, 0x4_0800..0x4_1000, 24),
    ] {
        let mut lone = Lone::unlocked(chip);
        let all = 0..chip.flash.bytes();
        lone.fill(all.clone(), 0);
        lone.write(Place::Control, control | CR_ERASE | CR_START);
        lone.run(ms * MS - 1);
        let name = format!("{} {range:x?}", chip.name);
        assert_eq!(lone.word(range.start), 0, "{name}");
        assert_eq!(lone.read(Place::Status), BUSY, "{name}");
        lone.run(MS);
        assert_eq!(lone.read(Place::Status), 0, "{name}");
        assert_eq!(lone.read(Place::Control) & CR_START, 0, "{name}");
        let erased = all.step_by(4).filter(|at| lone.word(*at) == u32::MAX);
        let erased: Vec<u32> = erased.collect();
        let ends = (erased[0], erased[erased.len() - 1] + 4);
        assert_eq!(ends, (range.start, range.end), "{name}");
        assert_eq!(4 * erased.len(), range.len(), "{name}");
    }
}

#[test]
fn the_f405_is_busy_as_a_whole_and_the_g474_by_banks() {
    for (chip, control, expected) in [
        (&STM32F405, WORDS | 11 << 3, [true, true]),
        (&STM32G474, 0, [true, false]),
        (&STM32G474, BANK_2, [false, true]),
    ] {
        let mut lone = Lone::unlocked(chip);
        lone.write(Place::Control, control | CR_ERASE | CR_START);
        let half = chip.flash.bytes() / 2;
        let busy = [FLASH, FLASH + half].map(|address| lone.flash.is_busy(address));
        assert_eq!(busy, expected, "{}", chip.name);
        assert!(!lone.flash.is_busy(0x2000_0000));
        lone.run(5_000 * MS);
        assert!(!lone.flash.is_busy(FLASH) && !lone.flash.is_busy(FLASH + half));
    }
}

/// The words of the first sector or page after an erase that was cut off, of 0x1234_5678 everywhere before.
fn half_erased(chip: &'static Chip, seed: u64) -> (Vec<u32>, usize) {
    let mut lone = Lone::unlocked(chip);
    lone.fill(0..chip.flash.bytes(), 0x1234_5678);
    lone.flash.seed = seed;
    lone.write(Place::Control, lone.width() | CR_ERASE | CR_START);
    lone.flash.reset();
    let first = lone.flash.part.sector(0).unwrap();
    let bytes = first.end - first.start;
    assert_eq!(lone.word(bytes), 0x1234_5678, "only the sector suffers");
    assert!(!lone.flash.is_changing() && !lone.flash.is_busy(FLASH));
    let words = (0..bytes).step_by(4).map(|at| lone.word(at)).collect();
    (words, lone.flash.content.damaged().count())
}

#[test]
fn an_erase_that_is_cut_off_leaves_old_erased_and_random_words() {
    for (chip, has_codes) in [(&STM32F405, false), (&STM32G474, true)] {
        let (words, damaged) = half_erased(chip, 1);
        let count = |wanted: &dyn Fn(u32) -> bool| words.iter().filter(|w| wanted(**w)).count();
        let kinds = [
            count(&|word| word == 0x1234_5678),
            count(&|word| word == u32::MAX),
            count(&|word| word != u32::MAX && word != 0x1234_5678),
        ];
        let least = words.len() / 6;
        assert!(kinds.iter().all(|kind| *kind > least), "{kinds:?}");
        assert_eq!(damaged > 0, has_codes, "{}", chip.name);
        assert_eq!(half_erased(chip, 1), (words.clone(), damaged), "same seed");
        assert_ne!(half_erased(chip, 2).0, words, "another seed");
    }
}

#[test]
fn a_program_that_is_cut_off_has_changed_some_of_its_bits() {
    let (old, value) = (0xFFFF_F0FF_u32, 0x0F0F_3333_u32);
    let mut left = BTreeSet::new();
    for seed in 0..50 {
        let mut lone = Lone::unlocked(&STM32F405);
        lone.fill(0..4, old);
        lone.flash.seed = seed;
        lone.write(Place::Control, WORDS | CR_PROGRAM);
        lone.store(0, 4, value);
        lone.flash.reset();
        let word = lone.word(0);
        assert_eq!(word & !old, 0, "a bit was set by programming");
        assert_eq!(word & old & value, old & value, "a bit was lost");
        left.insert(word);
    }
    assert!(left.len() > 10, "{left:x?}");
}

#[test]
fn nothing_ends_and_nothing_begins_without_supply() {
    let mut lone = Lone::unlocked(&STM32F405);
    lone.write(Place::Control, WORDS | CR_PROGRAM);
    lone.flash.lose_supply_at_ns(50 * US);
    lone.store(0, 4, 0);
    lone.run(MS);
    assert!(lone.flash.is_changing());
    assert_eq!(lone.flash.next_event_ns(), None);
    lone.flash.reset();
    lone.keys(KEYS);
    lone.write(Place::Control, WORDS | CR_PROGRAM);
    lone.flash.lose_supply_at_ns(MS);
    lone.store(8, 4, 0);
    assert_eq!((lone.flash.is_changing(), lone.word(8)), (false, u32::MAX));
}

/// A G474 with a damaged double word in its second bank, and the offset of that.
fn damaged() -> (Lone, u32) {
    let mut lone = Lone::unlocked(&STM32G474);
    lone.write(Place::Control, BANK_2 | CR_ERASE | CR_START);
    lone.flash.reset();
    lone.keys(KEYS);
    let first = lone.flash.content.damaged().next();
    (lone, first.unwrap() - FLASH)
}

#[test]
fn a_double_word_with_two_errors_is_told_once_with_its_place() {
    let (mut lone, offset) = damaged();
    assert!(!lone.flash.read_data(FLASH));
    assert!(lone.flash.read_data(FLASH + offset + 5));
    assert!(!lone.flash.read_data(FLASH + offset), "told already");
    let expected = 1 << 31 | 1 << 21 | (offset - 0x4_0000);
    assert_eq!(lone.read(Place::Errors), expected);
    lone.write(Place::Errors, 1 << 31);
    assert_eq!(lone.read(Place::Errors) >> 31, 0);
    assert!(lone.flash.read_data(FLASH + offset));
}

#[test]
fn an_erase_mends_it_and_so_do_zeros_but_no_other_value() {
    let (mut lone, offset) = damaged();
    lone.write(Place::Control, CR_PROGRAM);
    lone.store_double(offset, 7);
    assert_eq!(lone.errors(), 1 << 3);
    lone.store_double(offset, 0);
    lone.run(MS);
    assert!(!lone.flash.read_data(FLASH + offset));

    let (mut lone, offset) = damaged();
    lone.write(Place::Control, BANK_2 | CR_ERASE | CR_START);
    lone.run(25 * MS);
    assert!(!lone.flash.read_data(FLASH + offset));
    assert_eq!(lone.flash.content.damaged().count(), 0);
    assert_eq!(lone.flash.hidden(), []);
}

#[test]
#[should_panic(expected = "a mass erase of the flash is not modelled")]
fn a_mass_erase_is_refused() {
    let mut lone = Lone::unlocked(&STM32F405);
    lone.write(Place::Control, CR_MASS_ERASE | CR_START);
}

#[test]
#[should_panic(expected = "SNB 12: there is no such sector")]
fn a_sector_that_is_not_there_is_refused() {
    let mut lone = Lone::unlocked(&STM32F405);
    lone.write(Place::Control, CR_ERASE | 12 << 3 | CR_START);
}
