//! Where the table of `worst_case.rs` comes from, and the proof that it is right: exhaustive by dynamic programming.
//!
//! What a frame still costs depends on CRC register, level and run alone. So the most stuff bits that k more data bits and
//! the CRC behind them can bring is found for every state at once, from the end of the frame to its head: 2^18 states,
//! 64 steps, two choices a step.

use std::string::String;
use std::vec::Vec;
use std::{format, vec};

use crate::wire::{bound_bits, exact_bits, worst_bits};
use crate::worst_case::SLACK;

const STATES: usize = 1 << 18;

/// CRC register << 3 | level << 2 | (run - 1); a run of five is left at once by its stuff bit.
fn state(crc: usize, level: usize, run: usize) -> usize {
    crc << 3 | level << 2 | (run - 1)
}

/// Level and run behind a bit, and the stuff bits it brings.
fn stuff(level: usize, run: usize, bit: usize) -> (usize, usize, u8) {
    match if bit == level { run + 1 } else { 1 } {
        5 => (1 - bit, 1, 1),
        run => (bit, run, 0),
    }
}

fn step(from: usize, bit: usize) -> (usize, u8) {
    let crc = from >> 3;
    let feedback = (crc >> 14) ^ bit;
    let (level, run, stuffed) = stuff(from >> 2 & 1, (from & 3) + 1, bit);
    (
        state((crc << 1 & 0x7FFF) ^ (feedback * 0x4599), level, run),
        stuffed,
    )
}

fn stuffed_by_crc(from: usize) -> u8 {
    let (mut level, mut run, mut total) = (from >> 2 & 1, (from & 3) + 1, 0);
    for bit in (0..15).rev() {
        let stuffed;
        (level, run, stuffed) = stuff(level, run, from >> (3 + bit) & 1);
        total += stuffed;
    }
    total
}

/// Most stuff bits from each state to the end, with no data bit left, then one more data bit, and so on.
fn one_more_data_bit(most: &[u8]) -> Vec<u8> {
    let after = |from, bit| {
        let (to, stuffed) = step(from, bit);
        stuffed + most[to]
    };
    (0..STATES)
        .map(|from| after(from, 0).max(after(from, 1)))
        .collect()
}

/// State behind SOF, identifier, RTR, IDE, r0 and DLC, and the stuff bits up to there.
fn head(id: usize, len: usize) -> (usize, u8) {
    let field = id << 7 | len;
    (0..19)
        .rev()
        .fold((state(0, 1, 1), 0), |(from, total), bit| {
            let (to, stuffed) = step(from, field >> bit & 1);
            (to, total + stuffed)
        })
}

/// The table: octal digit `len`, counted from the right, is how far the worst frame stays below the bound.
fn search() -> Vec<u32> {
    let mut table = vec![0; 0x800];
    let mut most: Vec<u8> = (0..STATES).map(stuffed_by_crc).collect();
    for len in 0..=8 {
        for (id, row) in table.iter_mut().enumerate() {
            let (from, stuffed) = head(id, len);
            let worst = 47 + 8 * len as u32 + u32::from(stuffed + most[from]);
            *row |= (u32::from(bound_bits(len as u8)) - worst) << (3 * len);
        }
        for _ in 0..8 {
            most = one_more_data_bit(&most);
        }
    }
    table
}

fn source(table: &[u32]) -> String {
    let mut text = String::from(HEADER);
    for row in table.chunks(8) {
        let row: Vec<String> = row.iter().map(|entry| format!("0o{entry:09o},")).collect();
        text += &format!("    {}\n", row.join(" "));
    }
    text + "];\n"
}

const HEADER: &str = "\
//! Worst-case lengths, found by exhaustive search; see `worst_case_search.rs`, whose test checks every entry.

/// For each identifier, how far its longest frame stays below `bound_bits`: octal digit `len`, counted from the right.
#[rustfmt::skip]
pub(crate) static SLACK: [u32; 0x800] = [
";

#[test]
fn every_entry_is_the_worst_case() {
    assert!(search() == SLACK);
}

/// `cargo test -p can-frame write_the_table -- --ignored` writes the source file anew.
#[test]
#[ignore = "writes a source file"]
fn write_the_table() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/worst_case.rs");
    std::fs::write(path, source(&search())).unwrap();
}

/// The search merges payloads that reach the same state; this does not.
#[test]
fn all_one_byte_payloads_agree() {
    for id in 0..=0x7FF {
        let longest = (0..=u8::MAX).map(|byte| exact_bits(id, &[byte])).max();
        assert_eq!(longest, Some(worst_bits(id, 1)), "identifier {id:#x}");
    }
}
