//! Decimal numbers, exactly.

use crate::error::ErrorKind;

/// A decimal number in steps of 10^-9, digits behind which are cut off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Decimal(i64);

const BILLION: i64 = 1_000_000_000;
const LONGEST: usize = 20;
const MOST_DIGITS: usize = 9;

impl Decimal {
    /// Reads a number from its text: a sign, digits, a point and digits.
    pub(crate) fn read(letter: char, text: &str) -> Result<Self, ErrorKind> {
        if text.len() > LONGEST {
            return Err(ErrorKind::LongNumber);
        }
        let (is_negative, digits) = match text.as_bytes() {
            [b'-', rest @ ..] => (true, rest),
            [b'+', rest @ ..] => (false, rest),
            rest => (false, rest),
        };
        let (mut value, mut unit, mut before, mut seen) = (0_i64, BILLION, 0, 0);
        let mut has_point = false;
        for byte in digits {
            match byte {
                b'.' if !has_point => has_point = true,
                b'0'..=b'9' if has_point => {
                    unit /= 10;
                    value += i64::from(byte - b'0') * unit;
                    seen += 1;
                }
                b'0'..=b'9' => {
                    before += 1;
                    if before > MOST_DIGITS {
                        return Err(ErrorKind::LongNumber);
                    }
                    value = value * 10 + i64::from(byte - b'0') * BILLION;
                    seen += 1;
                }
                _ => return Err(ErrorKind::Number { letter }),
            }
        }
        if seen == 0 {
            return Err(ErrorKind::Number { letter });
        }
        Ok(Self(if is_negative { -value } else { value }))
    }

    /// In units of 2^-24 micrometres, for a number of a unit of so many tenths of a micrometre; `None` beyond 2^60.
    pub(crate) fn coordinate(self, tenths_um: u32) -> Option<i64> {
        let product = (i128::from(self.0) * i128::from(tenths_um)) << 24;
        let divisor = i128::from(BILLION) * 10;
        let half = divisor / 2;
        let rounded = (product + if product < 0 { -half } else { half }) / divisor;
        i64::try_from(rounded)
            .ok()
            .filter(|value| value.unsigned_abs() < 1 << 60)
    }

    /// Times 10, if that is a whole number that is not negative.
    pub(crate) fn tenths(self) -> Option<u32> {
        let tenth = BILLION / 10;
        if self.0 < 0 || self.0 % tenth != 0 {
            return None;
        }
        u32::try_from(self.0 / tenth).ok()
    }

    /// Of a number of seconds that is not negative: its milliseconds, a part of one as a whole one.
    pub(crate) fn milliseconds(self) -> Option<u32> {
        const MILLIONTH: u64 = BILLION as u64 / 1_000;
        let billionths = u64::try_from(self.0).ok()?;
        u32::try_from(billionths.div_ceil(MILLIONTH)).ok()
    }

    pub(crate) fn value(self) -> f64 {
        self.0 as f64 / BILLION as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_exact() {
        let read = |text| Decimal::read('X', text);
        assert_eq!(read("-12.5"), Ok(Decimal(-12_500_000_000)));
        assert_eq!(read("+.25"), Ok(Decimal(250_000_000)));
        assert_eq!(read("3."), Ok(Decimal(3_000_000_000)));
        assert_eq!(read("0.1234567891"), Ok(Decimal(123_456_789)));
        assert_eq!(read("999999999"), Ok(Decimal(999_999_999 * BILLION)));
        for none in ["", "-", ".", "1.2.3", "1e3", "--1"] {
            assert_eq!(read(none), Err(ErrorKind::Number { letter: 'X' }), "{none}");
        }
        assert_eq!(read("1000000000"), Err(ErrorKind::LongNumber));
        assert_eq!(read("0.0000000000000000001"), Err(ErrorKind::LongNumber));
    }

    #[test]
    fn millimetres_and_inches_are_micrometres() {
        let um = |text, tenths| Decimal::read('X', text).ok()?.coordinate(tenths);
        assert_eq!(um("1.5", 10_000), Some(1_500 << 24));
        assert_eq!(um("-1", 254_000), Some(-25_400 << 24));
        assert_eq!(um("999999999", 254_000), None);
    }
}
