//! The bit rates of the `S` command.

/// Bit rates in kbit/s of `S0` to `S8`.
const KBIT_PER_S: [u32; 9] = [10, 20, 50, 100, 125, 250, 500, 800, 1000];

/// The bit rate in kbit/s that a digit after `S` sets.
pub(crate) fn kbit_per_s(digit: u8) -> Option<u32> {
    let code = usize::from(digit.checked_sub(b'0')?);
    KBIT_PER_S.get(code).copied()
}

/// The digit after `S` that sets a bit rate; `None` when no digit does.
pub(crate) fn bit_rate_code(kbit_per_s: u32) -> Option<char> {
    let code = KBIT_PER_S.iter().position(|&rate| rate == kbit_per_s)?;
    char::from_digit(u32::try_from(code).ok()?, 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nine_digits_have_a_bit_rate() {
        assert_eq!(kbit_per_s(b'0'), Some(10));
        assert_eq!(kbit_per_s(b'7'), Some(800));
        assert_eq!(kbit_per_s(b'8'), Some(1000));
        assert_eq!((kbit_per_s(b'9'), kbit_per_s(b'/')), (None, None));
        assert_eq!(
            (bit_rate_code(1000), bit_rate_code(125)),
            (Some('8'), Some('4'))
        );
        assert_eq!(bit_rate_code(333), None);
    }
}
