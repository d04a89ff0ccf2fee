//! How far the CRC keeps the longest frame of each identifier below what its bits could have in stuff bits.
//!
//! 16,384 numbers of 0 to 5, most of them the same for a length: the most frequent take one bit, so all of them take 2.6 KiB, in two halves: a program whose
//! frames are short has no need of the other.

mod table;

use table::{LONG, LONG_GROUPS, RANKS, SHORT, SHORT_GROUPS};

/// There are so many different shortfalls.
pub(crate) const SHORTFALLS: usize = 6;
/// Identifiers in a group, whose first bit is known: what has to be read to find the last of them.
pub(crate) const GROUP: usize = 32;
/// Lengths in a row of a table: 1 to 4 bytes, or 5 to 8.
pub(crate) const LENGTHS: usize = 4;

/// The shortfall of an identifier of 11 bits with `more_bytes` (0 to 7) more than one byte, in stuff bits. Inlined: where the length is
/// known one of the tables is not needed.
#[inline(always)]
pub(crate) const fn shortfall(id: u16, more_bytes: u8) -> u8 {
    if (more_bytes as usize) < LENGTHS {
        shortfall_of_short(id, more_bytes)
    } else {
        shortfall_of_long(id, more_bytes)
    }
}

#[inline(never)]
const fn shortfall_of_short(id: u16, more_bytes: u8) -> u8 {
    look_up((&SHORT, &SHORT_GROUPS), id, more_bytes)
}

#[inline(never)]
const fn shortfall_of_long(id: u16, more_bytes: u8) -> u8 {
    look_up((&LONG, &LONG_GROUPS), id, more_bytes)
}

#[inline(always)]
const fn look_up((bits, groups): (&[u32], &[u16; 64]), id: u16, more_bytes: u8) -> u8 {
    let id = id as usize & 0x7FF;
    let ranks = &RANKS[more_bytes as usize % RANKS.len()];
    let mut bit = groups[id / GROUP] as usize;
    let mut before = id % GROUP * LENGTHS + more_bytes as usize % LENGTHS;
    let mut rank = 0;
    // The table ends behind the last zero: the check is for the compiler, which cannot know it.
    while bit / 32 < bits.len() && rank < SHORTFALLS {
        let is_one = bits[bit / 32] >> (bit % 32) & 1 == 1;
        bit += 1;
        match (is_one, before) {
            (true, 0) => rank += 1,
            (true, _) => {}
            (false, 0) => return ranks[rank],
            (false, _) => before -= 1,
        }
    }
    0
}
