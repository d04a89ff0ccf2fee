//! Programs of a few instructions that meet a flash which is being programmed or erased, and boards whose supply is cut meanwhile.

use drive_sim::{BitRate, Bus, ScriptedFaults};
use firmware_tests::can::Wire;
use firmware_tests::chip::{Chip, STM32F405, STM32G474};
use firmware_tests::flash::FlashContent;
use firmware_tests::image::Piece;
use firmware_tests::{Board, Image, ResetCause, Stop, cpu};
use unicorn_engine::RegisterARM;

const FLASH: u32 = 0x0800_0000;
const RAM: u32 = 0x2000_0800;
const STACK: u32 = 0x2000_1000;
/// Where the program is in flash, the handler of the non-maskable interrupt and that of PendSV.
const MAIN: u32 = FLASH + 0x100;
const NMI: u32 = FLASH + 0x80;
const PEND_SV: u32 = FLASH + 0x88;
const US: u64 = 1_000;
const MS: u64 = 1_000_000;
const COUNTER: RegisterARM = RegisterARM::R2;
const LOADED: RegisterARM = RegisterARM::R3;

/// Instructions, as halfwords.
const STORE: u16 = 0x6001; // str r1, [r0]
const STORE_NEXT: u16 = 0x6041; // str r1, [r0, #4]
const LOAD: u16 = 0x6803; // ldr r3, [r0]
const NEXT_RUN: u16 = 0xE7FF; // b to the next
const JUMP: u16 = 0x4720; // bx r4
const STORE_REGISTER: u16 = 0x602C; // str r4, [r5]
/// adds r2, #1; b to it
const COUNT: [u16; 2] = [0x3201, 0xE7FD];

/// movw and movt: a constant into a register below r8.
fn set(register: u16, value: u32) -> [u16; 4] {
    let half = |code: u16, value: u16| {
        let (imm4, i, imm3, imm8) = (value >> 12, value >> 11 & 1, value >> 8 & 7, value & 0xFF);
        [code | i << 10 | imm4, imm3 << 12 | register << 8 | imm8]
    };
    let [low, high] = [
        half(0xF240, value as u16),
        half(0xF2C0, (value >> 16) as u16),
    ];
    [low[0], low[1], high[0], high[1]]
}

/// A program that begins with these parts, with r0 and r1 set, and then counts in r2.
fn program(address: u32, value: u32, parts: &[u16]) -> Vec<u16> {
    let mut code = [set(0, address), set(1, value)].concat();
    code.extend(set(2, 0));
    code.extend(parts);
    code.extend(COUNT);
    code
}

struct Lone {
    board: Board,
}

impl Lone {
    /// A board that executes this code at this address.
    fn new(chip: &'static Chip, at: u32, code: &[u16]) -> Self {
        let mut table = [0_u32; 16];
        (table[0], table[1]) = (STACK, at | 1);
        (table[2], table[14]) = (NMI | 1, PEND_SV | 1);
        let table = table.into_iter().flat_map(u32::to_le_bytes).collect();
        let stay = vec![0xFE, 0xE7];
        let code = code.iter().flat_map(|half| half.to_le_bytes()).collect();
        let pieces = [
            (FLASH, table),
            (NMI, stay.clone()),
            (PEND_SV, stay),
            (at, code),
        ];
        let pieces = pieces.map(|(address, bytes)| Piece { address, bytes });
        let image = Image::of_pieces(pieces.to_vec());
        let bus = Bus::with_faults(BitRate::Kbit1000, ScriptedFaults::new());
        let board = Board::new(chip, image, chip.crystal_hz, Wire::new(bus)).unwrap();
        Self { board }
    }

    fn registers(&self) -> [u32; 2] {
        let base = self.board.soc().chip.flash_access;
        match self.board.soc().chip.name {
            "stm32f405" => [base + 0x04, base + 0x10],
            _ => [base + 0x08, base + 0x14],
        }
    }

    fn control(&mut self, value: u32) {
        let [key, control] = self.registers();
        let soc = self.board.soc_mut();
        for unlock in [0x4567_0123, 0xCDEF_89AB] {
            soc.write(key, 4, unlock);
        }
        soc.write(control, 4, value);
    }

    /// Unlocked, with PG, and words on the chip that can choose.
    fn programmable(mut self) -> Self {
        let width = if self.board.soc().chip.name == "stm32f405" {
            2 << 8
        } else {
            0
        };
        self.control(1 | width);
        self
    }

    fn run(&mut self, ns: u64) {
        let until_ns = self.board.soc().now_ns() + ns;
        assert_eq!(self.board.run_until_ns(until_ns), Stop::Limit);
        assert!(self.board.faults().is_empty(), "{:x?}", self.board.faults());
    }

    fn received(&mut self) -> Vec<u8> {
        let received = self.board.soc_mut().serial.line.take_received();
        received.iter().map(|received| received.byte).collect()
    }

    fn get(&mut self, register: RegisterARM) -> u32 {
        cpu::get(self.board.engine_mut(), register)
    }

    /// How far it counts in a time.
    fn counts_in(&mut self, ns: u64) -> u32 {
        let before = self.get(COUNTER);
        self.run(ns);
        self.get(COUNTER) - before
    }

    fn stalled_us(&self) -> u64 {
        let soc = self.board.soc();
        soc.stalled * 1_000_000 / soc.clock.hclk_hz()
    }

    fn content(&self, address: u32) -> u32 {
        let bytes = self.board.soc().flash.content().read(address..address + 4);
        u32::from_le_bytes(bytes.unwrap().try_into().unwrap())
    }
}

/// The last sector or page.
fn far(chip: &Chip) -> u32 {
    FLASH + chip.flash.bytes() - 0x800
}

#[test]
fn the_f405_stands_still_while_it_programs_and_goes_on_after_it() {
    let far = far(&STM32F405);
    let code = program(far, 0x1234_5678, &[STORE]);
    let mut lone = Lone::new(&STM32F405, MAIN, &code).programmable();
    lone.run(95 * US);
    // One count stands in the same straight run as the store.
    assert_eq!(lone.get(COUNTER), 1);
    assert_eq!(lone.content(far), u32::MAX);
    assert!(lone.counts_in(20 * US) > 50);
    assert_eq!(lone.board.peek(far), Some(0x1234_5678));
    assert!(
        lone.stalled_us().abs_diff(100) <= 1,
        "{}",
        lone.stalled_us()
    );
}

#[test]
fn code_in_memory_goes_on_until_it_reads_the_flash_and_then_reads_the_new_value() {
    let far = far(&STM32F405);
    let mut lone = Lone::new(&STM32F405, RAM, &program(far, 7, &[STORE])).programmable();
    lone.run(5 * US);
    assert!(lone.board.soc().flash.is_changing());
    assert!(lone.counts_in(90 * US) > 200);
    assert_eq!(lone.stalled_us(), 0);

    let mut lone =
        Lone::new(&STM32F405, RAM, &program(far, 7, &[STORE, NEXT_RUN, LOAD])).programmable();
    lone.run(95 * US);
    assert_eq!((lone.get(COUNTER), lone.get(LOADED)), (0, 0));
    lone.run(20 * US);
    assert_eq!(lone.get(LOADED), 7);
    assert!(lone.get(COUNTER) > 20);
}

#[test]
fn code_in_memory_waits_when_it_jumps_into_the_flash() {
    let far = far(&STM32F405);
    let mut code = set(4, MAIN | 1).to_vec();
    code.extend(program(far, 7, &[STORE, NEXT_RUN, NEXT_RUN, JUMP]));
    let mut lone = Lone::new(&STM32F405, RAM, &code).programmable();
    let mut content = lone.board.soc().flash.content().clone();
    let counting: Vec<u8> = COUNT.iter().flat_map(|half| half.to_le_bytes()).collect();
    assert!(content.write(MAIN, &counting));
    lone.board.soc_mut().flash.set_content(content);
    lone.run(95 * US);
    assert_eq!(lone.get(COUNTER), 0);
    assert!(lone.counts_in(20 * US) > 20);
}

#[test]
fn two_stores_are_programmed_one_after_the_other() {
    let far = far(&STM32F405);
    let code = program(far, 5, &[STORE, STORE_NEXT]);
    let mut lone = Lone::new(&STM32F405, RAM, &code).programmable();
    lone.run(250 * US);
    assert_eq!((lone.content(far), lone.content(far + 4)), (5, 5));
    let history = lone.board.soc().flash.history();
    assert_eq!(history.len(), 2);
    assert!(history[1].starts_ns >= history[0].ends_ns);
}

#[test]
fn a_write_of_the_control_register_waits_for_the_end() {
    let far = far(&STM32F405);
    let mut code = [set(4, 1 << 31), set(5, 0x4002_3C10)].concat();
    code.extend(program(far, 5, &[STORE, STORE_REGISTER]));
    let mut lone = Lone::new(&STM32F405, RAM, &code).programmable();
    lone.run(150 * US);
    assert!(
        lone.stalled_us().abs_diff(100) <= 2,
        "{}",
        lone.stalled_us()
    );
    assert_eq!(lone.board.soc_mut().read(0x4002_3C10, 4) >> 31, 1);
}

#[test]
fn the_g474_stands_still_only_for_the_bank_that_it_runs_from() {
    // Page 5 of either bank.
    for (bank, stands) in [(0, true), (1 << 11, false)] {
        let mut lone = Lone::new(&STM32G474, MAIN, &program(0, 0, &[]));
        lone.run(10 * US);
        lone.control(1 << 16 | bank | 5 << 3 | 1 << 1);
        let counted = lone.counts_in(20 * MS);
        assert_eq!(counted == 0, stands, "{counted}");
        assert!(lone.counts_in(6 * MS) > 1_000);
        let expected = if stands { 24_470 } else { 0 };
        assert!(
            lone.stalled_us().abs_diff(expected) <= 1,
            "{}",
            lone.stalled_us()
        );
    }
}

#[test]
fn the_g474_waits_when_it_reads_the_other_bank_while_that_changes() {
    let far = far(&STM32G474);
    let code = program(far, 9, &[STORE, STORE_NEXT, NEXT_RUN, LOAD]);
    let mut lone = Lone::new(&STM32G474, MAIN, &code).programmable();
    lone.run(80 * US);
    assert_eq!(lone.get(COUNTER), 0);
    lone.run(20 * US);
    assert_eq!(lone.get(LOADED), 9);
    assert!(lone.get(COUNTER) > 20);
}

#[test]
fn a_store_without_permission_is_an_error_and_changes_nothing() {
    for chip in Chip::ALL {
        let code = program(far(chip), 0, &[STORE, STORE_NEXT, NEXT_RUN, LOAD]);
        let mut lone = Lone::new(chip, MAIN, &code);
        lone.run(20 * US);
        assert_eq!(lone.get(LOADED), u32::MAX, "{}", chip.name);
        assert!(lone.counts_in(20 * US) > 50, "{}", chip.name);
    }
}

#[test]
fn interrupts_are_taken_after_the_stall() {
    let code = program(far(&STM32F405), 5, &[STORE]);
    let mut lone = Lone::new(&STM32F405, MAIN, &code).programmable();
    lone.run(50 * US);
    lone.board.soc_mut().write(0xE000_ED04, 4, 1 << 28);
    lone.run(45 * US);
    assert!(!lone.board.soc().nvic.is_active(14));
    lone.run(20 * US);
    assert!(lone.board.soc().nvic.is_active(14));
    // The table of vectors is in flash, so code in memory stops at the interrupt.
    let code = program(far(&STM32F405), 5, &[STORE]);
    let mut lone = Lone::new(&STM32F405, RAM, &code).programmable();
    lone.run(50 * US);
    lone.board.soc_mut().write(0xE000_ED04, 4, 1 << 28);
    assert!(lone.counts_in(45 * US) < 5);
    assert!(!lone.board.soc().nvic.is_active(14));
    lone.run(20 * US);
    assert!(lone.board.soc().nvic.is_active(14));
}

#[test]
fn serial_bytes_reach_memory_while_the_processor_stands_still() {
    let mut lone = Lone::new(&STM32F405, MAIN, &program(0, 0, &[]));
    let soc = lone.board.soc_mut();
    for (register, value) in [
        (0x4002_3830, 1 << 21 | 1),
        (0x4002_3840, 1 << 17),
        (0x4002_0000, 0b10 << 6),
        (0x4002_0020, 7 << 12),
        (0x4000_4408, 139),
        (0x4000_4414, 1 << 6),
        (0x4000_440C, 1 << 13 | 1 << 2),
        (0x4002_608C, 64),
        (0x4002_6090, 0x4000_4404),
        (0x4002_6094, 0x2000_0000),
        (0x4002_6088, 4 << 25 | 1 << 10 | 1 << 8 | 1),
    ] {
        soc.write(register, 4, value);
    }
    let text = *b"through the erase of a sector...";
    soc.serial.line.send_bytes(1_000, &text);
    lone.control(1 << 16 | 2 << 8 | 11 << 3 | 1 << 1);
    lone.run(500 * MS);
    assert_eq!(lone.get(COUNTER), 0);
    let words = (0..text.len() as u32).step_by(4);
    let memory: Vec<u8> = words
        .flat_map(|at| lone.board.peek(0x2000_0000 + at).unwrap().to_le_bytes())
        .collect();
    assert_eq!(memory, text);
    assert_eq!(lone.board.soc().serial.port.overruns(), 0);
}

#[test]
fn a_watchdog_that_is_not_fed_during_an_erase_leaves_half_of_it() {
    let mut lone = Lone::new(&STM32F405, MAIN, &program(0, 0, &[]));
    let mut content = FlashContent::erased(STM32F405.flash.bytes() as usize);
    let kept = lone.board.soc().flash.content().read(FLASH..FLASH + 0x200);
    assert!(content.write(FLASH, kept.unwrap()));
    let last = FLASH + 0xE_0000;
    assert!(content.write(last, &[0x55; 0x2_0000]));
    lone.board.set_flash_content(content);
    lone.board.soc_mut().write(0x4000_3000, 4, 0xCCCC);
    lone.control(1 << 16 | 2 << 8 | 11 << 3 | 1 << 1);
    lone.run(600 * MS);
    let causes: Vec<_> = lone
        .board
        .resets()
        .iter()
        .map(|reset| reset.cause)
        .collect();
    assert_eq!(causes, [ResetCause::Pin, ResetCause::Watchdog]);
    let bytes = lone.board.soc().flash.content();
    let bytes = bytes.read(last..last + 0x2_0000).unwrap();
    let old = bytes.iter().filter(|byte| **byte == 0x55).count();
    let erased = bytes.iter().filter(|byte| **byte == 0xFF).count();
    assert!(old > 0x4000 && erased > 0x4000, "{old} {erased}");
    assert!(lone.counts_in(MS) > 1_000);
}

#[test]
fn a_cut_of_the_supply_within_an_operation_is_seen_after_it_and_the_board_starts_again() {
    let far = far(&STM32F405);
    let code = program(far, 0x1234_5678, &[STORE]);
    let mut whole = Lone::new(&STM32F405, MAIN, &code).programmable();
    whole.run(MS);
    let operation = whole.board.soc().flash.history()[0].clone();
    for (at_ns, expected) in [
        (operation.starts_ns, Some(u32::MAX)),
        (operation.ends_ns + 1, Some(0x1234_5678)),
        ((operation.starts_ns + operation.ends_ns) / 2, None),
    ] {
        let mut lone = Lone::new(&STM32F405, MAIN, &code).programmable();
        let memory = lone.board.engine_mut();
        memory.mem_write(0x2000_0000, &[1, 2, 3, 4]).unwrap();
        let stop = lone.board.cut_power_at_ns(at_ns, 5 * MS, 3).unwrap();
        assert_eq!(stop, Stop::Limit);
        let reset = lone.board.resets()[0];
        assert_eq!(reset.cause, ResetCause::PowerOn);
        assert!(reset.at_ns.abs_diff(at_ns) < 1_000, "{reset:?} {at_ns}");
        assert!(lone.board.soc().now_ns() >= at_ns + 5 * MS);
        let left = lone.board.peek(far).unwrap();
        match expected {
            Some(expected) => assert_eq!(left, expected),
            None => {
                assert_eq!(left & 0x1234_5678, 0x1234_5678);
                assert!(left != 0x1234_5678 && left != u32::MAX, "{left:#x}");
            }
        }
        assert_eq!(lone.board.peek(0x2000_0000), Some(0xA5A5_A5A5));
        // It starts from its reset: the flash is locked again, so the store fails, and it counts.
        assert!(lone.counts_in(20 * US) > 20);
        assert_eq!(lone.content(far), left);
    }
}

#[test]
fn the_content_goes_from_one_board_into_another() {
    for chip in Chip::ALL {
        let far = far(chip);
        let code = program(far, 0x1234_5678, &[STORE, STORE_NEXT]);
        let mut lone = Lone::new(chip, MAIN, &code).programmable();
        lone.run(MS);
        let content = lone.board.soc().flash.content().clone();
        let code = program(far, 0, &[LOAD]);
        let mut other = Lone::new(chip, MAIN, &code);
        other.run(20 * US);
        assert_eq!(other.get(LOADED), u32::MAX, "{}", chip.name);
        other.board.set_flash_content(content);
        other.run(20 * US);
        // It runs the first program now.
        assert_eq!(other.get(RegisterARM::R1), 0x1234_5678, "{}", chip.name);
        assert_eq!(other.content(far), 0x1234_5678, "{}", chip.name);
    }
}

#[test]
fn code_that_was_programmed_over_is_executed() {
    let code = program(0, 0, &[]);
    let at = MAIN + 2 * (code.len() as u32 - 2);
    let mut lone = Lone::new(&STM32F405, MAIN, &code);
    assert!(lone.counts_in(20 * US) > 50);
    // 16 bits: adds r2, #1 becomes adds r2, #0.
    lone.control(1 | 1 << 8);
    lone.board.soc_mut().store_to_flash(at, 2, 0x3200);
    lone.run(110 * US);
    assert_eq!(lone.counts_in(20 * US), 0);
}

#[test]
fn other_code_in_the_flash_is_counted_anew() {
    // Two narrow instructions or a wide one before the count: the run has as many bytes.
    let narrow = program(0, 0, &[0xBF00, 0xBF00, 0x3201, 0xE7FB]);
    let wide = program(0, 0, &[0xF3AF, 0x8000, 0x3201, 0xE7FB]);
    let mut lone = Lone::new(&STM32F405, MAIN, &narrow);
    lone.run(10 * US);
    assert!(lone.counts_in(100 * US).abs_diff(100 * 16 / 4) < 3);
    let content = Lone::new(&STM32F405, MAIN, &wide);
    let content = content.board.soc().flash.content().clone();
    lone.board.set_flash_content(content);
    lone.run(10 * US);
    assert!(lone.counts_in(100 * US).abs_diff(100 * 16 / 3) < 3);
}

#[test]
fn a_text_in_flash_is_sent_after_the_operation() {
    let mut lone = Lone::new(&STM32F405, MAIN, &program(0, 0, &[])).programmable();
    lone.board.soc_mut().store_to_flash(far(&STM32F405), 4, 0);
    for (register, value) in [
        (0x4002_3830, 1 << 21 | 1),
        (0x4002_3840, 1 << 17),
        (0x4002_0000, 0b10 << 4),
        (0x4002_0020, 7 << 8),
        // 1 Mbit/s.
        (0x4000_4408, 16),
        (0x4000_4414, 1 << 7),
        (0x4000_440C, 1 << 13 | 1 << 3),
        (0x4002_60A4, 4),
        (0x4002_60A8, 0x4000_4404),
        (0x4002_60AC, FLASH),
        (0x4002_60A0, 4 << 25 | 1 << 10 | 1 << 6 | 1),
    ] {
        lone.board.soc_mut().write(register, 4, value);
    }
    let line = &mut lone.board.soc_mut().serial.line;
    line.set_rate(1_000_000);
    lone.run(100 * US);
    assert!(lone.received().is_empty());
    lone.run(60 * US);
    assert_eq!(lone.received(), STACK.to_le_bytes());
}

#[test]
fn a_damaged_double_word_raises_the_non_maskable_interrupt_when_it_is_read() {
    let far = far(&STM32G474);
    let code = program(far, 0x1234_5678, &[STORE, STORE_NEXT]);
    let mut damaged = 0;
    for seed in 0..16 {
        let mut lone = Lone::new(&STM32G474, MAIN, &code).programmable();
        lone.board.cut_power_at_ns(50 * US, 0, seed).unwrap();
        let content = lone.board.soc().flash.content();
        let is_damaged = content.damaged().any(|word| word == far);
        let mut image = content.clone();
        damaged += u32::from(is_damaged);
        // The same flash with a program that reads it.
        let reader = program(far, 0, &[LOAD]);
        let bytes: Vec<u8> = reader.iter().flat_map(|half| half.to_le_bytes()).collect();
        assert!(image.write(MAIN, &bytes));
        let expected = lone.content(far);
        lone.board.set_flash_content(image);
        lone.run(20 * US);
        assert_eq!(
            lone.board.soc().nvic.is_active(2),
            is_damaged,
            "seed {seed}"
        );
        assert_eq!(lone.get(LOADED), expected, "seed {seed}");
        let errors = lone.board.soc_mut().read(0x4002_2018, 4);
        assert_eq!(errors >> 31 == 1, is_damaged, "seed {seed}");
    }
    assert!((1..16).contains(&damaged), "{damaged} of 16");
}
