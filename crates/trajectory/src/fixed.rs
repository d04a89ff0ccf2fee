//! Between floating-point shapes and exact positions: powers of two, multiplications, no division.

/// Bits behind the binary point of a position.
pub(crate) const FRACTION_BITS: u32 = 24;
/// Bits behind the binary point of a time in cycles.
pub(crate) const TIME_BITS: u32 = 32;

const MANTISSA_BITS: i32 = 23;
const MANTISSA: u32 = (1 << MANTISSA_BITS) - 1;
const EXPONENT_OFFSET: i32 = 127;

/// `value * 2^exponent`, rounded to the nearest integer, a half upward. Means nothing for what is no number or not below 2^62.
#[must_use]
pub fn scaled(value: f32, exponent: i32) -> i64 {
    let (mantissa, places) = parts(value);
    let places = places + exponent;
    let signed = if (value.to_bits() as i32) < 0 {
        -mantissa
    } else {
        mantissa
    };
    if places < 0 {
        // One place less first, and half a unit, so that the shift rounds to nearest. A mantissa has 24 places.
        let places = (-1 - places).min(MANTISSA_BITS + 2);
        i64::from(((signed >> places) + 1) >> 1)
    } else if places < 31 {
        // One multiplication, where a shift of 64 bits takes ten instructions.
        i64::from(signed) * i64::from(1_i32 << places)
    } else {
        // What fits has at most 38 places, so the first shift keeps every bit.
        i64::from(signed << (places - 31).min(7)) << 31
    }
}

/// Exact way at a constant velocity: position units after a time, wrapping beyond 64 bits; 0 for a velocity that is no number.
pub(crate) fn travelled(velocity: f32, ticks: u64) -> i64 {
    if !velocity.is_finite() {
        return 0;
    }
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

/// `value * share` for a share of 0 to below 1 with 64 bits behind the point: at most four units less than its floor, at most one more. The
/// value is below 2^62.
///
/// Digits of 31 bits make every product one signed multiplication of the processor. What is left out: the product of the lowest digits, below
/// 2; the last bit of the value, below 1; the last two bits of the share, within 0.375 of either sign; what the last shift cuts off, below 1.
#[must_use]
pub const fn part_of(value: i64, share: u64) -> i64 {
    let (high, low) = (value >> 32, (value as u32 >> 1) as i64);
    let (share_high, share_low) = (
        (share >> 33) as i64,
        ((share >> 2) as u32 & 0x7FFF_FFFF) as i64,
    );
    ((high * share_high) << 1) + ((high * share_low + low * share_high) >> 30)
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

/// A finite number as `mantissa * 2^places`, without its sign. What is too small for a full mantissa is 0.
fn parts(value: f32) -> (i32, i32) {
    let bits = value.to_bits();
    let exponent = (bits >> MANTISSA_BITS) & 0xFF;
    let mantissa = if exponent == 0 {
        0
    } else {
        (bits & MANTISSA) | (MANTISSA + 1)
    };
    (
        mantissa as i32,
        exponent as i32 - EXPONENT_OFFSET - MANTISSA_BITS,
    )
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn scaling_rounds_to_nearest() {
        for (value, exponent, expected) in [
            (1.0, 0, 1),
            (-1.5, 1, -3),
            (0.5, 0, 1),
            (0.499_999_97, 0, 0),
            (-0.75, 0, -1),
            (-0.5, 0, 0),
            (-2.5, 0, -2),
            (-8_388_608.0, -24, 0),
            (-8_388_609.0, -24, -1),
            (3.0, 40, 3 << 40),
            (-1.0, 61, -(1 << 61)),
            (-1.999_999_9, 61, -0xFF_FFFF << 38),
            (8_388_608.0, 7, 1 << 30),
            (1.0, 53, 1 << 53),
            (1.0, 54, 1 << 54),
            (1.0, -200, 0),
            (1.0, -1, 1),
            (1.0, -2, 0),
            (0.0, 100, 0),
            (f32::MIN_POSITIVE / 2.0, 100, 0),
        ] {
            assert_eq!(scaled(value, exponent), expected, "{value} * 2^{exponent}");
        }
    }

    #[test]
    fn a_part_is_rounded_down() {
        const HALF: u64 = 1 << 63;
        for (value, share, expected) in [
            (10, 0, 0),
            (10 << 20, HALF, 5 << 20),
            (-10 << 20, HALF, -5 << 20),
            (-11, HALF, -6),
            (1 << 61, HALF, 1 << 60),
            (1 << 61, HALF >> 20, 1 << 40),
            (1 << 40, 1 << 33, 1 << 9),
        ] {
            assert_eq!(part_of(value, share), expected, "{value} {share}");
        }
    }

    #[test]
    fn a_constant_velocity_is_exact_for_days() {
        let ten_days = 864_000_000_u64 << TIME_BITS;
        assert_eq!(
            travelled(512.0, ten_days) >> FRACTION_BITS,
            512 * 864_000_000
        );
        assert_eq!(
            travelled(-0.125, ten_days) >> FRACTION_BITS,
            -864_000_000 / 8
        );
        assert_eq!(travelled(1e-30, ten_days), 0);
        assert_eq!(travelled(f32::NAN, 1 << 40), 0);
    }

    /// Units by which a part is less than the floor of the exact product.
    fn missing(value: i64, share: u64) -> i128 {
        let exact = (i128::from(value) * i128::from(share)) >> 64;
        exact - i128::from(part_of(value, share))
    }

    #[test]
    fn a_part_comes_to_its_bounds() {
        assert_eq!(
            missing(2_094_769_156_391_615_127, 16_405_787_562_610_426_643),
            4
        );
        assert_eq!(missing(-1 << 61, 3), -1);
    }

    proptest! {
        #[test]
        fn a_part_is_that_of_exact_arithmetic(value in any::<i64>(), share in any::<u64>()) {
            let missing = missing(value >> 2, share);
            prop_assert!((-1..=4).contains(&missing), "{}", missing);
        }

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
            prop_assert!((actual - exact).abs() <= 1e-5, "{actual} {exact}");
        }
    }
}
