//! A frame as a line: `t03C2FF88`, `T000000018AABBCCDDEEFF0011`, `r03C0`, `R000000010`.

use std::fmt::Write as _;

use drive_sim::Frame;
use embedded_can::{ExtendedId, Frame as _, Id, StandardId};

/// Digits of a time stamp: milliseconds of a minute (`Z1`), or of a counter of 32 bits as newer adapters have it (`Z2`).
const STAMP_DIGITS: [usize; 2] = [4, 8];

/// The line of a frame, without its CR.
pub(crate) fn encode(frame: &Frame) -> String {
    let (letter, id) = match (frame.id(), frame.is_remote_frame()) {
        (Id::Standard(id), false) => ('t', format!("{:03X}", id.as_raw())),
        (Id::Standard(id), true) => ('r', format!("{:03X}", id.as_raw())),
        (Id::Extended(id), false) => ('T', format!("{:08X}", id.as_raw())),
        (Id::Extended(id), true) => ('R', format!("{:08X}", id.as_raw())),
    };
    let mut line = format!("{letter}{id}{}", frame.dlc());
    for byte in frame.data() {
        // Writing to a string cannot fail.
        let _ = write!(line, "{byte:02X}");
    }
    line
}

/// The frame of a line without its CR, with or without a time stamp; `None` for anything else.
pub(crate) fn decode(line: &[u8]) -> Option<Frame> {
    let (&letter, rest) = line.split_first()?;
    let is_extended = letter.is_ascii_uppercase();
    let (id, rest) = rest.split_at_checked(if is_extended { 8 } else { 3 })?;
    let (&length, data) = rest.split_first()?;
    let id = number(id)?;
    let id = if is_extended {
        Id::Extended(ExtendedId::new(id)?)
    } else {
        Id::Standard(StandardId::new(u16::try_from(id).ok()?)?)
    };
    let length = usize::from(length.checked_sub(b'0')?);
    match letter {
        b't' | b'T' => Frame::new(id, &bytes(data, length)?),
        b'r' | b'R' if data.is_empty() || is_stamp(data) => Frame::new_remote(id, length),
        _ => None,
    }
}

fn bytes(digits: &[u8], length: usize) -> Option<Vec<u8>> {
    let (data, rest) = digits.split_at_checked(2 * length)?;
    if !rest.is_empty() && !is_stamp(rest) {
        return None;
    }
    let byte = |pair| number(pair).and_then(|value| u8::try_from(value).ok());
    data.chunks(2).map(byte).collect()
}

fn is_stamp(digits: &[u8]) -> bool {
    STAMP_DIGITS.contains(&digits.len()) && digits.iter().all(u8::is_ascii_hexdigit)
}

fn number(digits: &[u8]) -> Option<u32> {
    // `from_str_radix` would take a sign.
    if !digits.iter().all(u8::is_ascii_hexdigit) {
        return None;
    }
    u32::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn standard(id: u16, data: &[u8]) -> Frame {
        Frame::new(StandardId::new(id).unwrap(), data).unwrap()
    }

    #[test]
    fn golden_lines_read_both_ways() {
        let extended = |id| ExtendedId::new(id).unwrap();
        let golden = [
            // The examples of the CAN232 manual: `t`, `T`, `r`, `R`.
            ("t10021133", standard(0x100, &[0x11, 0x33])),
            (
                "T0000010021133",
                Frame::new(extended(0x100), &[0x11, 0x33]).unwrap(),
            ),
            (
                "r1002",
                Frame::new_remote(StandardId::new(0x100).unwrap(), 2).unwrap(),
            ),
            ("R000001002", Frame::new_remote(extended(0x100), 2).unwrap()),
            ("t03C188", standard(0x03C, &[0x88])),
            ("t7FF0", standard(0x7FF, &[])),
        ];
        for (line, frame) in golden {
            assert_eq!(encode(&frame), line);
            assert_eq!(decode(line.as_bytes()), Some(frame), "{line}");
        }
    }

    #[test]
    fn lower_case_and_time_stamps_are_read() {
        assert_eq!(decode(b"t03c2ff88"), Some(standard(0x03C, &[0xFF, 0x88])));
        assert_eq!(decode(b"t03C1880BB8"), Some(standard(0x03C, &[0x88])));
        assert_eq!(decode(b"t03C18800010BB8"), Some(standard(0x03C, &[0x88])));
        assert_eq!(decode(b"t7FF000010BB8"), Some(standard(0x7FF, &[])));
    }

    #[test]
    fn anything_else_is_no_frame() {
        for line in [
            "",
            "t",
            "t03C",
            "t03C9",
            "t03C188FF",
            "t03C18",
            "t8001FF",
            "tG3C188",
            "t+3C188",
            "x03C188",
            "T200000001FF",
            "t03C18888888",
            "t03C188888888888",
            "t03C1888888888888",
            "r03C1FF",
        ] {
            assert_eq!(decode(line.as_bytes()), None, "{line}");
        }
    }

    proptest! {
        #[test]
        fn every_frame_survives_its_line(
            id in 0..0x800_u16, extended: bool, data in proptest::collection::vec(any::<u8>(), 0..=8)
        ) {
            let id = if extended {
                Id::Extended(ExtendedId::new(u32::from(id) << 18 | 5).unwrap())
            } else {
                Id::Standard(StandardId::new(id).unwrap())
            };
            let frame = Frame::new(id, &data).unwrap();
            prop_assert_eq!(decode(encode(&frame).as_bytes()), Some(frame));
        }

        #[test]
        fn no_line_panics(line in proptest::collection::vec(any::<u8>(), 0..40)) {
            let _ = decode(&line);
        }
    }
}
