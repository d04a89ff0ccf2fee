//! How far the CRC keeps the longest frame of each identifier below what its bits could have in stuff bits.
//!
//! 16,384 numbers of 0 to 5, most of them the same for a length: the most frequent take one bit, so all of them take 2.6 KiB.

mod table;

use table::{BITS, GROUPS, RANKS};

/// There are so many different shortfalls.
pub(crate) const SHORTFALLS: usize = 6;
/// Identifiers in a group, whose first bit is known: what has to be read to find the last of them.
pub(crate) const GROUP: usize = 32;
/// Lengths in a row of the table: 1 to 8 bytes.
const LENGTHS: usize = 8;

/// The shortfall of an identifier of 11 bits with `more_bytes` (0 to 7) more than one byte, in stuff bits.
pub(crate) const fn shortfall(id: u16, more_bytes: u8) -> u8 {
    let (id, more_bytes) = (id as usize & 0x7FF, more_bytes as usize % LENGTHS);
    let mut bit = GROUPS[id / GROUP] as usize;
    let mut before = id % GROUP * LENGTHS + more_bytes;
    let mut rank = 0;
    // The table ends behind the last zero: the check is for the compiler, which cannot know it.
    while bit / 32 < BITS.len() && rank < SHORTFALLS {
        let is_one = BITS[bit / 32] >> (bit % 32) & 1 == 1;
        bit += 1;
        match (is_one, before) {
            (true, 0) => rank += 1,
            (true, _) => {}
            (false, 0) => return RANKS[more_bytes][rank],
            (false, _) => before -= 1,
        }
    }
    0
}
