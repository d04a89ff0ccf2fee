//! Parts of a line that several formats share.

use super::error::LineError;
use crate::frame::{Frame, MAX_DATA_BYTES};

/// What an error calls each part.
pub(super) const TIME: &str = "a time";
pub(super) const IDENTIFIER: &str = "an identifier";
pub(super) const LENGTH: &str = "a data length 0..=8";
const DATA_BYTE: &str = "a data byte";

/// The parts of a line between blanks, without the colours of a terminal.
#[derive(Debug, Clone)]
pub(super) struct Words<'a>(core::str::SplitAsciiWhitespace<'a>);

impl<'a> Words<'a> {
    pub(super) fn of(line: &'a str) -> Self {
        Self(line.split_ascii_whitespace())
    }

    pub(super) fn next(&mut self, expected: &'static str) -> Result<&'a str, LineError> {
        self.next_if_any().ok_or(LineError::Missing { expected })
    }

    pub(super) fn next_if_any(&mut self) -> Option<&'a str> {
        self.0
            .by_ref()
            .map(without_colours)
            .find(|word| !word.is_empty())
    }

    pub(super) fn peek(&self) -> Option<&'a str> {
        self.clone().next_if_any()
    }

    /// Exactly `len` data bytes, hexadecimal or decimal; another one behind them contradicts the length.
    pub(super) fn data(&mut self, len: usize, radix: u32) -> Result<Data, LineError> {
        let data = self.first_data(len, radix)?;
        self.no_more_data(len, radix)?;
        Ok(data)
    }

    /// That no data byte follows.
    pub(super) fn no_more_data(&self, len: usize, radix: u32) -> Result<(), LineError> {
        match self.peek() {
            Some(word) if byte(word, radix).is_ok() => Err(LineError::DataLength {
                expected: len,
                actual: len + 1,
            }),
            _ => Ok(()),
        }
    }

    /// `len` data bytes, whatever stands behind them.
    pub(super) fn first_data(&mut self, len: usize, radix: u32) -> Result<Data, LineError> {
        let mut data = Data::default();
        for index in 0..len {
            let Some(word) = self.next_if_any() else {
                return Err(LineError::DataLength {
                    expected: len,
                    actual: index,
                });
            };
            data.push(byte(word, radix)?)?;
        }
        Ok(data)
    }
}

/// A data byte: up to two hexadecimal digits, or three decimal ones, or eight binary ones.
pub(super) fn byte(word: &str, radix: u32) -> Result<u8, LineError> {
    let most_digits = match radix {
        16 => 2,
        10 => 3,
        _ => 8,
    };
    u8::from_str_radix(word, radix)
        .ok()
        .filter(|_| word.len() <= most_digits && !word.starts_with('+'))
        .ok_or_else(|| LineError::field(DATA_BYTE, word))
}

/// A word without the escape sequences in front of it and behind it.
pub(super) fn without_colours(word: &str) -> &str {
    const ESCAPE: char = '\u{1b}';
    if !word.bytes().any(|byte| byte == b'\x1b') {
        return word;
    }
    let mut word = word;
    while let Some((_, rest)) = word
        .strip_prefix(ESCAPE)
        .and_then(|rest| rest.split_once('m'))
    {
        word = rest;
    }
    word.split_once(ESCAPE).map_or(word, |(front, _)| front)
}

/// Data bytes of one frame.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Data {
    bytes: [u8; MAX_DATA_BYTES],
    len: usize,
}

impl Data {
    pub(super) fn push(&mut self, byte: u8) -> Result<(), LineError> {
        let Some(place) = self.bytes.get_mut(self.len) else {
            return Err(LineError::DataLength {
                expected: MAX_DATA_BYTES,
                actual: self.len + 1,
            });
        };
        *place = byte;
        self.len += 1;
        Ok(())
    }

    /// Pairs of hexadecimal digits without anything between them, or with dots.
    pub(super) fn of_hex(text: &str) -> Result<Self, LineError> {
        let mut data = Self::default();
        let mut digits = text.bytes().filter(|byte| *byte != b'.');
        while let Some(high) = digits.next() {
            let byte = hex_digit(high).zip(digits.next().and_then(hex_digit));
            let (high, low) = byte.ok_or_else(|| LineError::field(DATA_BYTE, text))?;
            data.push(high << 4 | low)?;
        }
        Ok(data)
    }

    /// The other way round.
    pub(super) fn reverse(&mut self) {
        self.bytes[..self.len].reverse();
    }

    pub(super) fn as_slice(&self) -> &[u8] {
        &self.bytes[..self.len]
    }
}

fn hex_digit(byte: u8) -> Option<u8> {
    match byte {
        b'0'..=b'9' => Some(byte - b'0'),
        b'a'..=b'f' => Some(byte - b'a' + 10),
        b'A'..=b'F' => Some(byte - b'A' + 10),
        _ => None,
    }
}

/// A hexadecimal identifier.
pub(super) fn hex_id(text: &str) -> Result<u32, LineError> {
    radix_id(text, 16)
}

pub(super) fn radix_id(text: &str, radix: u32) -> Result<u32, LineError> {
    u32::from_str_radix(text, radix)
        .ok()
        .filter(|_| !text.starts_with('+'))
        .ok_or_else(|| LineError::field(IDENTIFIER, text))
}

pub(super) fn data_frame(id: u32, extended: bool, data: &[u8]) -> Result<Frame, LineError> {
    Frame::new(id, extended, data).ok_or_else(|| wrong_id(id, extended))
}

pub(super) fn remote_frame(id: u32, extended: bool, len: usize) -> Result<Frame, LineError> {
    // The length is at most 8 wherever it comes from.
    Frame::remote(id, extended, len as u8).ok_or_else(|| wrong_id(id, extended))
}

fn wrong_id(id: u32, extended: bool) -> LineError {
    let expected = if extended {
        "an identifier of at most 29 bits"
    } else {
        "an identifier of at most 11 bits"
    };
    LineError::field(expected, &format!("0x{id:X}"))
}

/// The number of a bus or a channel.
pub(super) fn bus(text: &str) -> Result<&str, LineError> {
    let is_number = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    is_number
        .then_some(text)
        .ok_or_else(|| LineError::field("the number of a bus", text))
}

/// A data length 0 ..= 8.
pub(super) fn length(text: &str) -> Result<usize, LineError> {
    match text.parse() {
        Ok(len) if len <= MAX_DATA_BYTES => Ok(len),
        _ => Err(LineError::field(LENGTH, text)),
    }
}

/// The highest length code.
pub(super) const HIGHEST_CODE: usize = 15;

/// The data bytes of a classic length code: codes above 8 stand for 8 bytes.
pub(super) fn classic_length(code: &str, radix: u32) -> Result<usize, LineError> {
    match usize::from_str_radix(code, radix) {
        Ok(code) if code <= HIGHEST_CODE => Ok(code.min(MAX_DATA_BYTES)),
        _ => Err(LineError::field("a data length code 0..=15", code)),
    }
}

/// A time in units of `unit_ns`, such as seconds in `1.2505`; further decimals than a nanosecond are dropped.
pub(super) fn time_ns(text: &str, unit_ns: u64) -> Result<u64, LineError> {
    plain_time_ns(text, unit_ns)
        .or_else(|| exponent_time_ns(text, unit_ns))
        .ok_or_else(|| LineError::field(TIME, text))
}

fn plain_time_ns(text: &str, unit_ns: u64) -> Option<u64> {
    let (whole, decimals) = text.split_once('.').unwrap_or((text, ""));
    let whole = digits(whole)?;
    let mut fraction_ns = 0;
    let mut place_ns = unit_ns;
    for digit in decimals.bytes() {
        place_ns /= 10;
        fraction_ns += u64::from(digit.is_ascii_digit().then(|| digit - b'0')?) * place_ns;
    }
    whole.checked_mul(unit_ns)?.checked_add(fraction_ns)
}

fn digits(text: &str) -> Option<u64> {
    let is_number = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    is_number.then(|| text.parse().ok())?
}

/// Python writes short times as `5e-05`.
fn exponent_time_ns(text: &str, unit_ns: u64) -> Option<u64> {
    let time: f64 = text.parse().ok()?;
    let ns = time * unit_ns as f64;
    (text.contains(['e', 'E']) && (0.0..9e18).contains(&ns)).then_some(ns.round() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;

    #[test]
    fn times_are_exact() {
        assert_eq!(
            time_ns("1732560000.150050", S),
            Ok(1_732_560_000_150_050_000)
        );
        assert_eq!(time_ns("0.000000001", S), Ok(1));
        assert_eq!(time_ns("12.5", 1_000_000), Ok(12_500_000));
        assert_eq!(time_ns("5e-05", S), Ok(50_000));
        for text in [
            "",
            ".5",
            "-1.0",
            "1.2.3",
            "1,5",
            "inf",
            "99999999999999999999",
            "1e99",
        ] {
            assert_eq!(time_ns(text, S), Err(LineError::field(TIME, text)));
        }
    }

    #[test]
    fn data_is_pairs_of_digits() {
        assert_eq!(
            Data::of_hex("fF.88").map(|data| data.as_slice().to_vec()),
            Ok(vec![0xFF, 0x88])
        );
        assert!(Data::of_hex("FF8").is_err());
        assert!(Data::of_hex("GG").is_err());
        assert_eq!(
            Data::of_hex("112233445566778899").unwrap_err(),
            LineError::DataLength {
                expected: 8,
                actual: 9
            }
        );
    }
}
