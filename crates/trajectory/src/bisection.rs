//! Bisection over all floating-point numbers of a range.

/// The largest number from `low` to `high`, both not negative, for which `holds` is true, when it is true below some number and false
/// above; `low` when it never is. At most 32 calls, whatever the range: the numbers are halved, not the distance.
pub(crate) fn last_not_beyond(low: f32, high: f32, holds: impl Fn(f32) -> bool) -> f32 {
    // Numbers that are not negative have the order of their bits.
    let (mut low, mut high) = (low.to_bits(), high.to_bits());
    while low < high {
        let middle = high - (high - low) / 2;
        if holds(f32::from_bits(middle)) {
            low = middle;
        } else {
            high = middle - 1;
        }
    }
    f32::from_bits(low)
}

#[cfg(test)]
mod tests {
    use core::cell::Cell;

    use super::*;

    #[test]
    fn finds_the_last_number_that_holds() {
        for border in [0.0, 1e-30, 0.1, 2.0 / 3.0, 1.0, 7e5, 1e6] {
            assert_eq!(last_not_beyond(0.0, 1e6, |x| x <= border), border);
        }
        assert_eq!(last_not_beyond(2.0, 3.0, |_| false), 2.0);
        assert_eq!(last_not_beyond(2.0, 3.0, |_| true), 3.0);
        assert_eq!(last_not_beyond(3.0, 2.0, |_| true), 3.0);
    }

    #[test]
    fn needs_at_most_32_calls() {
        let calls = Cell::new(0);
        last_not_beyond(0.0, f32::MAX, |x| {
            calls.set(calls.get() + 1);
            x <= 1.234
        });
        assert!(calls.get() <= 32, "{}", calls.get());
    }
}
