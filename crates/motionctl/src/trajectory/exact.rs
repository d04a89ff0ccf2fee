//! Times as whole numbers, so that the difference of two large ones loses nothing.

/// Digits behind the point that are kept.
const DECIMALS: i32 = 12;
/// Most digits in front of the point: with the decimals they fit 128 bits.
const WHOLE_DIGITS: i32 = 24;

/// A time in 10^-12 of its unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ExactTime(i128);

impl ExactTime {
    /// A decimal number, with or without an exponent; `None` for anything else and for more than 24 digits in front of
    /// the point. What comes behind the twelfth decimal is rounded.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let (number, exponent) = match text.split_once(['e', 'E']) {
            Some((number, exponent)) => (number, exponent.parse::<i32>().ok()?),
            None => (text, 0),
        };
        let (sign, digits) = match number.strip_prefix('-') {
            Some(digits) => (-1, digits),
            None => (1, number.strip_prefix('+').unwrap_or(number)),
        };
        let (whole, decimals) = digits.split_once('.').unwrap_or((digits, ""));
        let all = || whole.bytes().chain(decimals.bytes());
        if all().next().is_none() || !all().all(|byte| byte.is_ascii_digit()) {
            return None;
        }
        // Place of the first digit, counted from the last that is kept.
        let whole_digits = i32::try_from(whole.len()).ok()?.checked_add(exponent)?;
        let mut place = whole_digits.checked_add(DECIMALS)?.checked_sub(1)?;
        let mut value: i128 = 0;
        for byte in all() {
            let digit = i128::from(byte - b'0');
            match place {
                0.. if digit != 0 => {
                    if place >= WHOLE_DIGITS + DECIMALS {
                        return None;
                    }
                    value += digit * 10_i128.pow(place.unsigned_abs());
                }
                -1 if digit >= 5 => value += 1,
                _ => {}
            }
            place = place.saturating_sub(1);
        }
        Some(Self(sign * value))
    }

    /// Seconds from an earlier time to this one, for a unit of which so many are a second.
    pub(super) fn seconds_since(self, start: Self, units_per_s: u32) -> f64 {
        // Shortened first: short numbers are exact, and their quotient is then rounded once.
        let (mut difference, mut one_s) =
            (self.0 - start.0, 10_i128.pow(12) * i128::from(units_per_s));
        while difference % 10 == 0 && one_s % 10 == 0 {
            (difference, one_s) = (difference / 10, one_s / 10);
        }
        difference as f64 / one_s as f64
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn since(text: &str, start: &str) -> Option<f64> {
        Some(ExactTime::parse(text)?.seconds_since(ExactTime::parse(start)?, 1))
    }

    #[test]
    fn large_stamps_lose_nothing() {
        let nanoseconds = since("1700000000500000001", "1700000000000000000");
        assert_eq!(nanoseconds, Some(500_000_001.0));
        let seconds = since("1700000000.000000100", "1700000000.0");
        assert_eq!(seconds, Some(1e-7));
        let exponent = since("1.7000000005e18", "1.700000000e+18");
        assert_eq!(exponent, Some(5e8));
        assert_eq!(since("5e-1", "-.5"), Some(1.0));
        assert_eq!(since("0.0000000000005", "0"), Some(1e-12));
    }

    #[test]
    fn what_is_no_number_is_none() {
        for text in [
            "",
            ".",
            "-",
            "1,5",
            "0x1",
            "nan",
            "inf",
            "1e",
            "e5",
            "1e99",
            "1e2147483647",
            "1 2",
        ] {
            assert_eq!(ExactTime::parse(text), None, "{text}");
        }
        assert_eq!(since("0e99", "0"), Some(0.0));
        assert_eq!(since("1e-2147483647", "0"), Some(0.0));
    }

    proptest! {
        #[test]
        fn agrees_with_the_nearest_double(value in -1e9..1e9_f64) {
            let exact = ExactTime::parse(&format!("{value:.9}")).unwrap();
            let zero = ExactTime::parse("0").unwrap();
            prop_assert!((exact.seconds_since(zero, 1) - value).abs() <= 1e-6);
        }

        #[test]
        fn never_panics(text in "[-+0-9.eE]{0,60}") {
            let _ = ExactTime::parse(&text);
        }
    }
}
