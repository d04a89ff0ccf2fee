//! Between floating-point shapes and exact positions: powers of two, multiplications, no division.

/// Bits behind the binary point of a position.
pub(crate) const FRACTION_BITS: u32 = 20;
/// Bits behind the binary point of a time in cycles.
pub(crate) const TIME_BITS: u32 = 32;

const MANTISSA_BITS: i32 = 23;
const MANTISSA: u32 = (1 << MANTISSA_BITS) - 1;
const EXPONENT_OFFSET: i32 = 127;
/// More than 63 - 24 places to the left leave 64 bits.
const MOST_LEFT: i32 = 39;

/// `value * 2^exponent`, rounded to the nearest integer; ends at the range of the type, and not-a-number is 0.
pub(crate) fn scaled(value: f32, exponent: i32) -> i64 {
    let (mantissa, places) = parts(value);
    let places = places + exponent;
    let size = if mantissa == 0 {
        0
    } else if places > MOST_LEFT {
        i64::MAX
    } else if places >= 0 {
        mantissa << places
    } else if places > -(i64::BITS as i32) {
        // Half a unit first, so that the shift rounds to nearest.
        (mantissa + (1 << (-places - 1))) >> -places
    } else {
        0
    };
    if value < 0.0 { -size } else { size }
}

/// Exact way at a constant velocity: position units after a time, wrapping beyond 64 bits.
pub(crate) fn travelled(velocity: f32, ticks: u64) -> i64 {
    let (mantissa, places) = parts(velocity);
    let places = places + FRACTION_BITS as i32 - TIME_BITS as i32;
    let product = u128::from(mantissa.unsigned_abs()) * u128::from(ticks);
    let size = if places >= 0 {
        product.wrapping_shl(places.unsigned_abs())
    } else if places > -(u128::BITS as i32) {
        product.wrapping_shr(places.unsigned_abs())
    } else {
        0
    } as i64;
    if velocity < 0.0 {
        size.wrapping_neg()
    } else {
        size
    }
}

/// `value * share` for a share of 0 to 1 with 63 bits behind the point, rounded down.
pub(crate) const fn part_of(value: i64, share: u64) -> i64 {
    ((value as i128 * share as i128) >> 63) as i64
}

/// Position units as counts, for computations that need no more than 24 bits.
pub(crate) fn counts(units: i64) -> f32 {
    units as f32 * POSITION_UNIT
}

/// Ticks as cycles, for computations that need no more than 24 bits.
pub(crate) fn cycles(ticks: u64) -> f32 {
    ticks as f32 * TIME_UNIT
}

const POSITION_UNIT: f32 = 1.0 / (1_u64 << FRACTION_BITS) as f32;
const TIME_UNIT: f32 = 1.0 / (1_u64 << TIME_BITS) as f32;

/// A number as `mantissa * 2^places`, without its sign. What is too small for a full mantissa is 0, what is no number too.
fn parts(value: f32) -> (i64, i32) {
    let bits = value.to_bits();
    let exponent = (bits >> MANTISSA_BITS) & 0xFF;
    let mantissa = match exponent {
        0 => 0,
        0xFF if bits & MANTISSA != 0 => 0,
        _ => (bits & MANTISSA) | (MANTISSA + 1),
    };
    (
        i64::from(mantissa),
        exponent as i32 - EXPONENT_OFFSET - MANTISSA_BITS,
    )
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn scaling_rounds_to_nearest_and_ends_at_the_range() {
        for (value, exponent, expected) in [
            (1.0, 0, 1),
            (-1.5, 1, -3),
            (0.5, 0, 1),
            (0.499_999_97, 0, 0),
            (-0.75, 0, -1),
            (3.0, 40, 3 << 40),
            (1.0, 62, 1 << 62),
            (1.0, 63, i64::MAX),
            (-1.0, 200, -i64::MAX),
            (1.0, -200, 0),
            (1.0, -1, 1),
            (1.0, -2, 0),
            (0.0, 100, 0),
            (f32::MIN_POSITIVE / 2.0, 100, 0),
            (f32::INFINITY, 0, i64::MAX),
            (f32::NEG_INFINITY, 0, -i64::MAX),
            (f32::NAN, 0, 0),
        ] {
            assert_eq!(scaled(value, exponent), expected, "{value} * 2^{exponent}");
        }
    }

    #[test]
    fn a_part_is_rounded_down() {
        assert_eq!(part_of(10, 1 << 63), 10);
        assert_eq!(part_of(-10, 1 << 62), -5);
        assert_eq!(part_of(-11, 1 << 62), -6);
        assert_eq!(part_of(i64::MIN, 1 << 63), i64::MIN);
    }

    #[test]
    fn a_constant_velocity_is_exact_for_days() {
        let ten_days = 864_000_000_u64 << TIME_BITS;
        assert_eq!(
            travelled(8_192.0, ten_days) >> FRACTION_BITS,
            8_192 * 864_000_000
        );
        assert_eq!(
            travelled(-0.125, ten_days) >> FRACTION_BITS,
            -864_000_000 / 8
        );
        assert_eq!(travelled(1e-30, ten_days), 0);
        assert_eq!(travelled(f32::NAN, 1 << 40), 0);
    }

    proptest! {
        #[test]
        fn scaling_is_that_of_exact_arithmetic(value in -1e6_f32..1e6, exponent in -30..20_i32) {
            let exact = f64::from(value) * f64::from(exponent).exp2();
            prop_assert!((scaled(value, exponent) as f64 - exact).abs() <= 0.5);
        }

        #[test]
        fn the_way_is_that_of_exact_arithmetic(velocity in -2e4_f32..2e4, cycles in 0.0..1e6_f64) {
            let ticks = (cycles * (1_u64 << TIME_BITS) as f64) as u64;
            let exact = f64::from(velocity) * cycles;
            let actual = travelled(velocity, ticks) as f64 / (1_u64 << FRACTION_BITS) as f64;
            prop_assert!((actual - exact).abs() <= 2e-5, "{actual} {exact}");
        }
    }
}
