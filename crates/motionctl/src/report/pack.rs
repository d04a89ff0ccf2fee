//! Numbers in a few bytes: base64 of groups of seven bits, least significant first, the top bit set while more follow.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// A block in the making.
#[derive(Debug, Default)]
pub(super) struct Block {
    bytes: Vec<u8>,
}

impl Block {
    pub(super) fn push(&mut self, mut number: u64) {
        while number >= 0x80 {
            self.bytes.push(number as u8 | 0x80);
            number >>= 7;
        }
        self.bytes.push(number as u8);
    }

    /// 0, -1, 1, -2, 2 ... as 0, 1, 2, 3, 4 ...
    pub(super) fn push_signed(&mut self, number: i64) {
        self.push(((number << 1) ^ (number >> 63)) as u64);
    }

    pub(super) fn text(self) -> String {
        STANDARD.encode(self.bytes)
    }
}

/// Each number as its difference to the one before, the first to 0.
pub(super) fn differences(numbers: impl Iterator<Item = i64>) -> String {
    let (mut block, mut before) = (Block::default(), 0_i64);
    for number in numbers {
        block.push_signed(number.wrapping_sub(before));
        before = number;
    }
    block.text()
}

/// The numbers that are there: how many places further each is, and its difference to the one before.
pub(super) fn sparse(numbers: impl Iterator<Item = Option<i64>>) -> String {
    let (mut block, mut before, mut last) = (Block::default(), 0_i64, None);
    for (place, number) in (0_u64..).zip(numbers) {
        let Some(number) = number else { continue };
        block.push(last.map_or(place + 1, |last| place - last));
        block.push_signed(number.wrapping_sub(before));
        (before, last) = (number, Some(place));
    }
    block.text()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(text: &str) -> Vec<u8> {
        STANDARD.decode(text).unwrap()
    }

    #[test]
    fn golden_bytes() {
        let mut block = Block::default();
        // 1 500 000 is 0b1011011_1000110_1100000; 300 is 0b10_0101100.
        for number in [1_500_000, 47, 0, 300] {
            block.push(number);
        }
        assert_eq!(bytes(&block.text()), [0xE0, 0xC6, 0x5B, 47, 0, 0xAC, 0x02]);
        assert_eq!(bytes(&differences([5, 3, 3].into_iter())), [10, 3, 0]);
        let some = [None, Some(-1), None, None, Some(4)];
        assert_eq!(bytes(&sparse(some.into_iter())), [2, 1, 3, 10]);
    }

    #[test]
    fn the_widest_numbers_have_room() {
        let mut block = Block::default();
        block.push_signed(i64::MIN);
        block.push_signed(i64::MAX);
        let bytes = bytes(&block.text());
        assert_eq!(bytes.len(), 20);
        assert_eq!(bytes[..9], [0xFF; 9]);
    }
}
