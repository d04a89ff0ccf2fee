//! Exception entry and return with a program of a few instructions, and that the test would notice a model that forgets the
//! floating-point registers.

use drive_sim::{BitRate, Bus, ScriptedFaults};
use firmware_tests::can::Wire;
use firmware_tests::chip::STM32F405;
use firmware_tests::image::Piece;
use firmware_tests::{Board, Image, Stop, cpu};
use unicorn_engine::RegisterARM;

const FLASH: u32 = 0x0800_0000;
const STACK: u32 = 0x2000_1000;
const MAIN: u32 = FLASH + 0x100;
const HANDLER: u32 = FLASH + 0x180;
const SUPERVISOR_CALL: usize = 11;

/// Switches the floating-point unit on, sets s0 to 1.0 and r2 to 7, calls the supervisor, copies s0 to r3 and stays there.
const PROGRAM: [u8; 36] = [
    0x4E, 0xF6, 0x88, 0x50, // movw r0, #0xED88
    0xCE, 0xF2, 0x00, 0x00, // movt r0, #0xE000
    0x00, 0x21, // movs r1, #0
    0xC0, 0xF2, 0xF0, 0x01, // movt r1, #0x00F0
    0x01, 0x60, // str r1, [r0]
    0xB7, 0xEE, 0x00, 0x0A, // vmov.f32 s0, #1.0
    0x07, 0x22, // movs r2, #7
    0x00, 0xDF, // svc #0
    0x10, 0xEE, 0x10, 0x3A, // vmov r3, s0
    0xFE, 0xE7, // b .
    0x00, 0xBF, // nop
    0x00, 0xBF, // nop
    0x00, 0xBF, // nop
];

/// Spoils what it may spoil: r0, r2 and s0 are the caller's to keep only by the frame on the stack.
const SPOILER: [u8; 10] = [
    0x00, 0x20, // movs r0, #0
    0x00, 0x22, // movs r2, #0
    0xB0, 0xEE, 0x00, 0x0A, // vmov.f32 s0, #2.0
    0x70, 0x47, // bx lr
];

fn vector_table() -> Vec<u8> {
    let mut words = [0_u32; 16];
    words[0] = STACK;
    words[1] = MAIN | 1;
    words[SUPERVISOR_CALL] = HANDLER | 1;
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

/// Runs the program; returns r2, r3 and the stack pointer at its end.
fn run(forget_floating_point: bool) -> [u32; 3] {
    let pieces = [
        (FLASH, vector_table()),
        (MAIN, PROGRAM.to_vec()),
        (HANDLER, SPOILER.to_vec()),
    ];
    let pieces = pieces.map(|(address, bytes)| Piece { address, bytes });
    let bus = Bus::with_faults(BitRate::Kbit1000, ScriptedFaults::new());
    let image = Image::of_pieces(pieces.to_vec());
    let mut board =
        Board::new(&STM32F405, image, 8_000_000, Wire::new(bus)).expect("the emulator works");
    board.soc_mut().skip_floating_point = forget_floating_point;
    assert_eq!(board.run_until_ns(100_000), Stop::Limit);
    assert!(board.faults().is_empty(), "{:x?}", board.faults());
    [RegisterARM::R2, RegisterARM::R3, RegisterARM::SP]
        .map(|register| cpu::get(board.engine_mut(), register))
}

#[test]
fn registers_survive_an_exception() {
    assert_eq!(run(false), [7, 1.0_f32.to_bits(), STACK]);
}

#[test]
fn a_model_that_forgets_the_floating_point_registers_is_noticed() {
    assert_eq!(run(true), [7, 2.0_f32.to_bits(), STACK]);
}
