//! Where the table of `worst_case/table.rs` comes from, and the proof that it is right: exhaustive by dynamic programming.
//!
//! What a frame still costs depends on CRC register, level and run alone. So the most stuff bits that k more data bits and
//! the CRC behind them can bring is found for every state at once, from the end of the frame to its head: 2^18 states,
//! 64 steps, two choices a step.

use std::cmp::Reverse;
use std::ops::Range;
use std::string::String;
use std::vec::Vec;
use std::{format, vec};

use crate::wire::{exact_bits, worst_bits};
use crate::worst_case::{GROUP, LENGTHS, SHORTFALLS, shortfall};

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

/// For each identifier, how many stuff bits the worst frame of 1 to 8 bytes has fewer than a free CRC would let it have.
fn search() -> Vec<[u8; 8]> {
    let mut table = vec![[0; 8]; 0x800];
    let mut most: Vec<u8> = (0..STATES).map(stuffed_by_crc).collect();
    for len in 1..=8 {
        for _ in 0..8 {
            most = one_more_data_bit(&most);
        }
        for (id, row) in table.iter_mut().enumerate() {
            let (from, _) = head(id, len);
            let behind = 8 * len + 15;
            let possible = ((from & 3) + behind) / 4;
            row[len - 1] = possible as u8 - most[from];
        }
    }
    table
}

/// For each length the shortfalls, the most frequent first, so that most take a single bit of the table.
fn ranks(table: &[[u8; 8]]) -> [[u8; SHORTFALLS]; 8] {
    [0, 1, 2, 3, 4, 5, 6, 7].map(|place| {
        let mut order: [u8; SHORTFALLS] = [0, 1, 2, 3, 4, 5];
        let count = |shortfall: &u8| table.iter().filter(|row| row[place] == *shortfall).count();
        order.sort_by_key(|shortfall| Reverse(count(shortfall)));
        order
    })
}

/// The bits of the table of these lengths, and where each group of identifiers begins.
fn pack(
    table: &[[u8; 8]],
    ranks: &[[u8; SHORTFALLS]; 8],
    lengths: Range<usize>,
) -> (Vec<u32>, Vec<u16>) {
    let (mut words, mut groups, mut length) = (vec![0_u32], vec![], 0_usize);
    for (id, row) in table.iter().enumerate() {
        if id % GROUP == 0 {
            groups.push(length as u16);
        }
        for (shortfall, order) in row.iter().zip(ranks).take(lengths.end).skip(lengths.start) {
            let rank = order.iter().position(|of| of == shortfall).unwrap();
            for bit in (0..=rank).map(|place| u32::from(place < rank)) {
                words.resize(length / 32 + 1, 0);
                words[length / 32] |= bit << (length % 32);
                length += 1;
            }
        }
    }
    (words, groups)
}

fn source(table: &[[u8; 8]]) -> String {
    let ranks = ranks(table);
    let mut text = format!("{HEADER}pub(super) static RANKS: [[u8; {SHORTFALLS}]; 8] = [\n");
    for order in ranks {
        text += &format!("    {order:?},\n");
    }
    text += "];\n";
    for (name, lengths) in [("SHORT", 0..LENGTHS), ("LONG", LENGTHS..2 * LENGTHS)] {
        let first_last = (lengths.start + 1, lengths.end);
        let (words, groups) = pack(table, &ranks, lengths);
        text += &header_of_groups(name);
        text += &format!("[u16; {}] = [\n", groups.len());
        for row in groups.chunks(16) {
            let row: Vec<String> = row.iter().map(|bit| format!("{bit},")).collect();
            text += &format!("    {}\n", row.join(" "));
        }
        text += &format!(
            "];\n{}[u32; {}] = [\n",
            header_of_bits(name, first_last),
            words.len()
        );
        for row in words.chunks(12) {
            let row: Vec<String> = row.iter().map(|word| format!("{word:#010x},")).collect();
            text += &format!("    {}\n", row.join(" "));
        }
        text += "];\n";
    }
    text
}

const HEADER: &str = "\
//! Worst-case lengths, found by exhaustive search and written by `worst_case_search.rs`, whose test checks every entry.

/// The shortfalls of each length of 1 to 8 bytes, the most frequent first.
";

fn header_of_groups(name: &str) -> String {
    format!(
        "\n/// The bit of [`{name}`] where each group of identifiers begins.\n#[rustfmt::skip]\npub(super) static {name}_GROUPS: "
    )
}

fn header_of_bits(name: &str, (first, last): (usize, usize)) -> String {
    format!(
        "\n/// For each identifier, and each length of {first} to {last} bytes, the place of its shortfall in [`RANKS`]: so many ones and a zero, from\n/// the lowest bit.\n#[rustfmt::skip]\npub(super) static {name}: "
    )
}

#[test]
fn every_entry_is_the_worst_case() {
    for (id, row) in (0..).zip(search()) {
        for (place, expected) in (0..).zip(row) {
            assert_eq!(
                shortfall(id, place),
                expected,
                "{id:#x}, {} bytes",
                place + 1
            );
        }
    }
}

/// Each length of the search itself, not of the table alone: the stuff bits of the head are counted again here.
#[test]
fn every_length_is_the_worst_case() {
    let mut most: Vec<u8> = (0..STATES).map(stuffed_by_crc).collect();
    for len in 0..=8 {
        for id in 0..=0x7FF {
            let (from, stuffed) = head(id, len);
            let worst = 47 + 8 * len as u16 + u16::from(stuffed + most[from]);
            assert_eq!(
                worst_bits(id as u16, len as u8),
                worst,
                "{id:#x}, {len} bytes"
            );
        }
        for _ in 0..8 {
            most = one_more_data_bit(&most);
        }
    }
}

/// `cargo test -p can-frame write_the_table -- --ignored` writes the source file anew.
#[test]
#[ignore = "writes a source file"]
fn write_the_table() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/worst_case/table.rs");
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
