//! Every frame in a few bytes: base64 of numbers in groups of seven bits, least significant first, the top bit set while more follow.
//!
//! For each frame: time since the start of the frame before in units of 100 ns, length in bits, number of its text.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::sim::recording::Sighting;

/// Unit of the times.
const UNIT_NS: u64 = 100;

/// The block of these frames, in the order of their starts.
pub(super) fn block<'a>(frames: impl Iterator<Item = &'a Sighting>) -> String {
    let (mut bytes, mut before) = (Vec::new(), 0);
    for frame in frames {
        let start = frame.start_ns / UNIT_NS;
        push(&mut bytes, start - before);
        push(&mut bytes, u64::from(frame.bits));
        push(&mut bytes, frame.text as u64);
        before = start;
    }
    STANDARD.encode(bytes)
}

fn push(bytes: &mut Vec<u8>, mut number: u64) {
    while number >= 0x80 {
        bytes.push(number as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_bytes() {
        let frames =
            [(150_000_000, 47, 0), (150_100_000, 61, 300)].map(|(start_ns, bits, text)| Sighting {
                start_ns,
                bits,
                text,
            });
        let bytes = STANDARD.decode(block(frames.iter())).unwrap();
        // 1 500 000 is 0b1011011_1000110_1100000; 1000 is 0b111_1101000; 300 is 0b10_0101100.
        assert_eq!(bytes, [0xE0, 0xC6, 0x5B, 47, 0, 0xE8, 0x07, 61, 0xAC, 0x02]);
    }
}
