//! Sine and cosine of a share of a turn, with integers: 24 bits are not enough for an arc of millions of counts.

/// 1 of a sine.
pub(crate) const ONE: i32 = 1 << 30;

/// Sine and cosine with 30 bits behind the point, to 2^-28, of an angle in 2^-32 turns.
pub(crate) fn sine_cosine(phase: u32) -> (i32, i32) {
    // The nearest quarter, and up to an eighth of a turn from it, with 31 bits behind the point of an eighth.
    let quarter = phase.wrapping_add(1 << 29) >> 30;
    let t = (phase.wrapping_sub(quarter << 30) << 2) as i32;
    let square = times(t, t);
    let sine = times(horner(square, &SINE), t);
    let cosine = horner(square, &COSINE);
    match quarter {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// The series of the sine of an eighth of a turn times x, divided by x, in powers of x², with 30 bits behind the point.
const SINE: [i32; 5] = [843_314_857, -86_699_834, 2_674_041, -39_273, 336];
/// The same of the cosine.
const COSINE: [i32; 6] = [ONE, -331_168_970, 17_023_473, -350_031, 3_856, -26];

fn horner<const N: usize>(square: i32, coefficients: &[i32; N]) -> i32 {
    let sum = |sum, coefficient: &i32| times(sum, square).wrapping_add(*coefficient);
    coefficients.iter().rev().fold(0, sum)
}

const fn times(a: i32, b: i32) -> i32 {
    ((a as i64 * b as i64) >> 31) as i32
}

/// `value * factor`, which has 30 bits behind the point.
pub(crate) const fn part(value: i64, factor: i32) -> i64 {
    let high = (value >> 32).wrapping_mul(factor as i64);
    let low = (value as u32 as i64 * factor as i64) >> 30;
    (high << 2).wrapping_add(low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_those_of_double_precision() {
        for step in 0..100_000_u32 {
            let phase = step.wrapping_mul(42_949).wrapping_add(step);
            let angle = f64::from(phase) / 2_f64.powi(32) * core::f64::consts::TAU;
            let (sine, cosine) = sine_cosine(phase);
            for (actual, expected) in [(sine, angle.sin()), (cosine, angle.cos())] {
                let error = f64::from(actual) / f64::from(ONE) - expected;
                assert!(error.abs() < 2_f64.powi(-28), "{phase}: {error}");
            }
        }
        assert_eq!(sine_cosine(0), (0, ONE));
    }

    #[test]
    fn parts_are_products() {
        for value in [0, 1, -1, 1 << 50, -(1 << 51) - 12_345, 0xFFFF_FFFF] {
            for factor in [ONE, -ONE, 1, -1, 123_456_789, -987_654_321] {
                let exact = (i128::from(value) * i128::from(factor)) >> 30;
                assert!((i128::from(part(value, factor)) - exact).abs() <= 1);
            }
        }
    }
}
