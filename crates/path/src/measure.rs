//! Lengths of pieces, for shares of them without a division.

use trajectory::fixed::part_of;

/// A length above 0, and what shares of it need.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Measure {
    pub(crate) length: i64,
    /// Leading zeros of the length.
    pub(crate) scale: u32,
    inverse: Inverse,
}

impl Measure {
    pub(crate) const NONE: Self = Self {
        length: 0,
        scale: 0,
        inverse: Inverse(0),
    };

    pub(crate) fn of(length: i64) -> Self {
        let scale = length.leading_zeros();
        Self {
            length,
            scale,
            inverse: Inverse::of(length, scale),
        }
    }

    /// A value per length becomes one per next power of two; for values below 2^61.
    pub(crate) const fn times(&self, value: i64) -> i64 {
        self.inverse.times(value)
    }
}

/// A power of two divided by a length: from one to two, less one, as a share with 64 bits behind the point, to 2^-45.
#[derive(Debug, Clone, Copy)]
struct Inverse(u64);

impl Inverse {
    /// Of a length above 0 and its leading zeros.
    fn of(length: i64, scale: u32) -> Self {
        // From a half to below 1.
        let share = length.cast_unsigned().wrapping_shl(scale);
        let first = 1.0 / ((share >> 40) as i32 as f32 / 16_777_216.0);
        let first = (first * (1_u32 << 29) as f32) as u32;
        // One step of Newton: 1 - share * first, with 60 bits behind the point.
        let (high, low) = (share >> 32, share & 0xFFFF_FFFF);
        let product = ((high * u64::from(first)) >> 1).wrapping_add((low * u64::from(first)) >> 33);
        let error = (1_u64 << 60).wrapping_sub(product).cast_signed();
        // The error is below 2^38, so eight of its bits are spare.
        let step = ((error >> 8) * i64::from(first)) >> 21;
        let inverse = (u64::from(first) << 31).wrapping_add_signed(step);
        let more_than_one = inverse.saturating_sub(1 << 60);
        // Two, of a length that is a power of two, is the largest share.
        Self(if more_than_one >> 60 == 0 {
            more_than_one << 4
        } else {
            u64::MAX
        })
    }

    /// For values below 2^61.
    const fn times(&self, value: i64) -> i64 {
        value.wrapping_add(part_of(value, self.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inverse_is_right_to_45_bits() {
        let mut length = 4_096_i64;
        while length < 1 << 49 {
            for length in [length, length + 1, length - 1, length * 3 / 2] {
                let scale = length.leading_zeros();
                let power = 1_i128 << (64 - scale);
                let value = 1_i64 << 55;
                let exact = i128::from(value) * power / i128::from(length);
                let error = i128::from(Inverse::of(length, scale).times(value)) - exact;
                assert!(error.abs() < 1 << 11, "{length}: {error}");
            }
            length += length / 7 + 1;
        }
    }
}
