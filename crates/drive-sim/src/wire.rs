//! Exact length of a classic CAN frame on the wire.
//!
//! Law (Bosch CAN 2.0 B, sections 3.1.1 and 5; ISO 11898-1): SOF to CRC is stuffed, a bit of the opposite level follows every five equal
//! bits, counts as the first bit of the next run, and also follows the last CRC bit when that completes five. The CRC has 15 bits,
//! polynomial 0x4599, start value 0, over SOF to data. Ten unstuffed bits follow (CRC delimiter, ACK slot, ACK delimiter, 7 EOF), then three
//! bits of interframe space.
//!
//! [`WireLength::of`] runs once for every frame on the simulated bus and walks two tables byte by byte. [`StuffedBits`] walks the bits one by
//! one; the tests hold the two against each other.

use core::fmt;

use embedded_can::Id;

use crate::frame::{EXTENSION_BITS, Frame, extension};

/// CRC polynomial of classic CAN, without its leading term.
const CRC15_POLYNOMIAL: u16 = 0x4599;

/// Bits of the CRC.
const CRC15_BITS: u32 = 15;

/// CRC delimiter, ACK slot, ACK delimiter and EOF: never stuffed.
pub const TAIL_BITS: u32 = 10;

/// Interframe space between a frame and the next SOF.
pub const INTERFRAME_BITS: u32 = 3;

/// Equal bits in a row after which a bit of the opposite level is stuffed.
const STUFF_RUN: u8 = 5;

/// Length of one frame on the wire, in bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WireLength {
    /// CRC over SOF to data.
    pub crc15: u16,
    /// Stuff bits from SOF to the last CRC bit, including one behind that.
    pub stuff_bits: u32,
    /// SOF to EOF and three bits of interframe space: what the frame costs the bus.
    pub bits_with_ifs: u32,
    /// SOF to the last EOF bit: when receivers have the frame.
    pub bits_without_ifs: u32,
}

impl WireLength {
    /// Computes the exact length of `frame`.
    pub fn of(frame: &Frame) -> Self {
        let body = HeadAndData::of(frame);
        let crc15 = body.crc15();
        let region = body.with_crc(crc15);
        let stuff_bits = region.count_stuff_bits();
        let bits_without_ifs = region.len + stuff_bits + TAIL_BITS;
        Self {
            crc15,
            stuff_bits,
            bits_with_ifs: bits_without_ifs + INTERFRAME_BITS,
            bits_without_ifs,
        }
    }
}

/// Length without any stuff bit, with interframe space: 47 + 8 n bits for a standard, 67 + 8 n for an extended frame of n data bytes.
pub fn unstuffed_bits_with_ifs(frame: &Frame) -> u32 {
    HeadAndData::of(frame).len + CRC15_BITS + TAIL_BITS + INTERFRAME_BITS
}

/// Upper bound of the length with interframe space: 55 + 10 n bits for a standard, 80 + 10 n for an extended frame of n data bytes.
///
/// The first stuff bit needs five bits, each later one four more: at most (L - 1) / 4 stuff bits in a stuffed region of L bits.
pub fn worst_bits_with_ifs(frame: &Frame) -> u32 {
    let region = HeadAndData::of(frame).len + CRC15_BITS;
    region + (region - 1) / 4 + TAIL_BITS + INTERFRAME_BITS
}

/// The bits from SOF to the last CRC bit as they go over the wire, stuff bits included; `true` is recessive.
pub fn sof_to_crc_stuffed(frame: &Frame) -> StuffedBits {
    let body = HeadAndData::of(frame);
    StuffedBits {
        rest: body.with_crc(body.crc15()),
        last: true,
        run: 0,
    }
}

/// Up to 118 bits before stuffing, right-aligned, the bit that is sent first being the most significant.
#[derive(Debug, Clone, Copy)]
struct Bits {
    value: u128,
    len: u32,
}

/// SOF to the last data bit, before stuffing.
struct HeadAndData {
    value: u128,
    len: u32,
}

impl HeadAndData {
    fn of(frame: &Frame) -> Self {
        let control = u64::from(frame.length_code());
        let remote = u64::from(embedded_can::Frame::is_remote_frame(frame));
        let (head, head_bits) = match embedded_can::Frame::id(frame) {
            // SOF, identifier, RTR, IDE = 0, r0 = 0, DLC.
            Id::Standard(id) => (u64::from(id.as_raw()) << 7 | remote << 6 | control, 19),
            // SOF, base identifier, SRR = 1, IDE = 1, extension, RTR, r1 = r0 = 0, DLC.
            Id::Extended(id) => {
                let base = u64::from(id.standard_id().as_raw());
                let id_bits = (base << 2 | 0b11) << EXTENSION_BITS | u64::from(extension(id));
                (id_bits << 7 | remote << 6 | control, 39)
            }
        };
        let data_bits = 8 * frame.data_bytes() as u32;
        Self {
            value: u128::from(head) << data_bits | u128::from(frame.data_bits()),
            len: head_bits + data_bits,
        }
    }

    /// Leading zeros do not change a CRC that starts with zero, so whole bytes can be taken.
    fn crc15(&self) -> u16 {
        (0..self.len.div_ceil(8)).rev().fold(0, |crc: u16, byte| {
            let index = usize::from(crc >> 7) ^ usize::from((self.value >> (8 * byte)) as u8);
            (crc << 8 ^ CRC15_TABLE[index]) & 0x7FFF
        })
    }

    fn with_crc(&self, crc15: u16) -> Bits {
        Bits {
            value: self.value << CRC15_BITS | u128::from(crc15),
            len: self.len + CRC15_BITS,
        }
    }
}

impl Bits {
    /// Alternating bits in front fill the first byte: they never make a run, and the last of them is recessive as the idle bus is.
    fn count_stuff_bits(&self) -> u32 {
        let padded = (u128::MAX / 3) << self.len | self.value;
        let (_, count) =
            (0..self.len.div_ceil(8))
                .rev()
                .fold((START_STATE, 0), |(state, count), byte| {
                    let step =
                        STUFF_TABLE[usize::from(state)][usize::from((padded >> (8 * byte)) as u8)];
                    (step & 0x0F, count + u32::from(step >> 4))
                });
        count
    }

    fn pop_first(&mut self) -> Option<bool> {
        self.len = self.len.checked_sub(1)?;
        Some(self.value >> self.len & 1 == 1)
    }
}

/// Iterator over the bits of [`sof_to_crc_stuffed`]; its `Display` writes what is left as a string of `0` and `1`.
#[derive(Debug, Clone)]
pub struct StuffedBits {
    rest: Bits,
    last: bool,
    run: u8,
}

impl Iterator for StuffedBits {
    type Item = bool;

    fn next(&mut self) -> Option<bool> {
        let bit = if self.run == STUFF_RUN {
            !self.last
        } else {
            self.rest.pop_first()?
        };
        self.run = if bit == self.last { self.run + 1 } else { 1 };
        self.last = bit;
        Some(bit)
    }
}

impl fmt::Display for StuffedBits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.clone()
            .try_for_each(|bit| f.write_str(if bit { "1" } else { "0" }))
    }
}

/// State of the stuffing automaton: level of the last bit << 2 | (run length - 1). A run of five is left at once by its stuff bit.
const START_STATE: u8 = 1 << 2;

/// Next state and, in the high half, the stuff bits added, for each state and byte.
static STUFF_TABLE: [[u8; 256]; 8] = stuff_table();

static CRC15_TABLE: [u16; 256] = crc15_table();

const fn stuff_table() -> [[u8; 256]; 8] {
    let mut table = [[0; 256]; 8];
    let mut index = 0;
    while index < 8 * 256 {
        table[index / 256][index % 256] = stuff_step((index / 256) as u8, (index % 256) as u8);
        index += 1;
    }
    table
}

const fn stuff_step(state: u8, byte: u8) -> u8 {
    let mut level = state >> 2;
    let mut run = (state & 3) + 1;
    let mut stuffed = 0;
    let mut bit = 8;
    while bit > 0 {
        bit -= 1;
        let next = byte >> bit & 1;
        run = if next == level { run + 1 } else { 1 };
        level = next;
        if run == STUFF_RUN {
            stuffed += 1;
            level ^= 1;
            run = 1;
        }
    }
    stuffed << 4 | level << 2 | (run - 1)
}

const fn crc15_table() -> [u16; 256] {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut crc = (byte as u16) << 7;
        let mut bit = 0;
        while bit < 8 {
            let feedback = crc & 0x4000 != 0;
            crc = (crc << 1) & 0x7FFF;
            if feedback {
                crc ^= CRC15_POLYNOMIAL;
            }
            bit += 1;
        }
        table[byte] = crc;
        byte += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::tests::{extended, remote, standard};

    struct Golden {
        frame: Frame,
        crc15: u16,
        stuff_bits: u32,
        bits_with_ifs: u32,
        sof_to_crc: &'static str,
    }

    /// Values of an independent reference.
    fn golden() -> Vec<Golden> {
        let g = |frame, crc15, stuff_bits, bits_with_ifs, sof_to_crc| Golden {
            frame,
            crc15,
            stuff_bits,
            bits_with_ifs,
            sof_to_crc,
        };
        vec![
            g(
                standard(0x000, &[]),
                0,
                6,
                53,
                "0000010000010000010000010000010000010000",
            ),
            g(
                standard(0x001, &[]),
                8723,
                3,
                50,
                "0000010000010100000100010001000010011",
            ),
            g(
                standard(0x7EF, &[]),
                24272,
                2,
                49,
                "011111010111100000100101111011010000",
            ),
            g(
                standard(0x7FF, &[0xFF]),
                31253,
                5,
                60,
                "01111101111101000001011111011111011101000010101",
            ),
            g(standard(0x555, &[0xAA]), 30722, 2, 57, ""),
            g(
                standard(0x2C7, &[0xDC, 0x4F, 0x0E, 0x0D]),
                15215,
                1,
                80,
                "0010110001110000100110111000100111100001110000011101011101101101111",
            ),
        ]
    }

    #[test]
    fn golden_vectors() {
        for want in golden() {
            let got = WireLength::of(&want.frame);
            let expected = WireLength {
                crc15: want.crc15,
                stuff_bits: want.stuff_bits,
                bits_with_ifs: want.bits_with_ifs,
                bits_without_ifs: want.bits_with_ifs - 3,
            };
            assert_eq!(got, expected, "{}", want.frame);
            if !want.sof_to_crc.is_empty() {
                assert_eq!(
                    sof_to_crc_stuffed(&want.frame).to_string(),
                    want.sof_to_crc,
                    "{}",
                    want.frame
                );
            }
        }
    }

    #[test]
    fn bounds_follow_the_formulas() {
        for bytes in 0..=8_u32 {
            let data = vec![0; bytes as usize];
            assert_eq!(unstuffed_bits_with_ifs(&standard(1, &data)), 47 + 8 * bytes);
            assert_eq!(worst_bits_with_ifs(&standard(1, &data)), 55 + 10 * bytes);
            assert_eq!(unstuffed_bits_with_ifs(&extended(1, &data)), 67 + 8 * bytes);
            assert_eq!(worst_bits_with_ifs(&extended(1, &data)), 80 + 10 * bytes);
            assert_eq!(unstuffed_bits_with_ifs(&remote(1, bytes as usize)), 47);
        }
    }

    /// Bit by bit, from the definition alone.
    fn plain(frame: &Frame) -> (u16, String) {
        let mut bits = plain_head(frame);
        for byte in embedded_can::Frame::data(frame) {
            bits.push_str(&format!("{byte:08b}"));
        }
        let mut crc = 0_u16;
        for bit in bits.bytes() {
            let feedback = u16::from(bit == b'1') ^ (crc >> 14 & 1);
            crc = (crc << 1 & 0x7FFF) ^ (feedback * 0x4599);
        }
        bits.push_str(&format!("{crc:015b}"));
        let mut stuffed = String::new();
        for bit in bits.chars() {
            stuffed.push(bit);
            if stuffed.ends_with("00000") {
                stuffed.push('1');
            } else if stuffed.ends_with("11111") {
                stuffed.push('0');
            }
        }
        (crc, stuffed)
    }

    fn plain_head(frame: &Frame) -> String {
        let rtr = u8::from(embedded_can::Frame::is_remote_frame(frame));
        let dlc = embedded_can::Frame::dlc(frame);
        match embedded_can::Frame::id(frame) {
            Id::Standard(id) => format!("0{:011b}{rtr}00{dlc:04b}", id.as_raw()),
            Id::Extended(id) => {
                let id = format!("{:029b}", id.as_raw());
                format!("0{}11{}{rtr}00{dlc:04b}", &id[..11], &id[11..])
            }
        }
    }

    fn assert_agrees_with_plain(frame: &Frame) {
        let (crc, stuffed) = plain(frame);
        let got = WireLength::of(frame);
        assert_eq!(got.crc15, crc, "{frame}");
        assert_eq!(got.bits_without_ifs as usize, stuffed.len() + 10, "{frame}");
        assert_eq!(sof_to_crc_stuffed(frame).to_string(), stuffed, "{frame}");
    }

    #[test]
    fn every_identifier_agrees_with_the_plain_walk() {
        for id in 0..=0x7FF {
            assert_agrees_with_plain(&standard(id, &[]));
            assert_agrees_with_plain(&standard(id, &[0xFF, 0x00]));
            assert_agrees_with_plain(&remote(id, usize::from(id % 9)));
            assert_agrees_with_plain(&extended(u32::from(id) * 0x3_7F01 % 0x2000_0000, &[0; 8]));
        }
    }

    proptest::proptest! {
        #[test]
        fn any_frame_agrees_with_the_plain_walk(id in 0_u32..0x2000_0000, is_extended: bool, data in proptest::collection::vec(0_u8.., 0..=8)) {
            let frame = if is_extended { extended(id, &data) } else { standard((id >> 18) as u16, &data) };
            assert_agrees_with_plain(&frame);
            proptest::prop_assert!(WireLength::of(&frame).bits_with_ifs <= worst_bits_with_ifs(&frame));
            proptest::prop_assert!(WireLength::of(&frame).bits_with_ifs >= unstuffed_bits_with_ifs(&frame));
        }
    }

    #[test]
    fn extremes_of_short_frames_are_those_of_the_exhaustive_search() {
        let lengths = (0..=0x7FF).map(|id| WireLength::of(&standard(id, &[])).bits_with_ifs);
        assert_eq!((lengths.clone().min(), lengths.max()), (Some(48), Some(53)));
        let lengths = (0..=0x7FF).flat_map(|id| {
            (0..=0xFF).map(move |byte| WireLength::of(&standard(id, &[byte])).bits_with_ifs)
        });
        assert_eq!((lengths.clone().min(), lengths.max()), (Some(56), Some(62)));
    }
}
