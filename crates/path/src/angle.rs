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

/// The series of the sine of an eighth of a turn times x, divided by x, in powers of x². The bits behind the point are 30 of the first
/// coefficient, and one more of each that follows: see [`horner`].
const SINE: [i32; 5] = [843_314_857, -173_399_668, 10_696_164, -314_184, 5_376];
/// The same of the cosine.
const COSINE: [i32; 6] = [ONE, -662_337_940, 68_093_892, -2_800_248, 61_696, -832];

/// The upper half of a product is half of it with 31 bits behind the point: one instruction of the processor, where the whole of it takes four.
fn horner<const N: usize>(square: i32, coefficients: &[i32; N]) -> i32 {
    let sum = |sum, coefficient: &i32| upper(sum, square).wrapping_add(*coefficient);
    coefficients.iter().rev().fold(0, sum)
}

const fn upper(a: i32, b: i32) -> i32 {
    ((a as i64 * b as i64) >> 32) as i32
}

const fn times(a: i32, b: i32) -> i32 {
    ((a as i64 * b as i64) >> 31) as i32
}

/// From the centre of a circle to a place on it: the upper 30 bits of the larger part, which is 2^-29 of the radius.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Radius {
    parts: [i32; 2],
    /// Bits that the parts were shifted by to the right, less than 30.
    places: u32,
}

impl Radius {
    pub(crate) const NONE: Self = Self {
        parts: [0; 2],
        places: 0,
    };
    const BITS: u32 = 30;

    /// Of parts below 2^59.
    pub(crate) const fn of([first, second]: [i64; 2]) -> Self {
        let size = first.unsigned_abs() | second.unsigned_abs();
        let places = (u64::BITS - Self::BITS).saturating_sub(size.leading_zeros());
        Self {
            parts: [(first >> places) as i32, (second >> places) as i32],
            places,
        }
    }

    pub(crate) const fn parts(&self) -> [i64; 2] {
        let [first, second] = self.parts;
        [
            (first as i64) << self.places,
            (second as i64) << self.places,
        ]
    }

    /// What its end moves by when it turns by a phase, in 2^-32 turns.
    pub(crate) fn turned(&self, phase: u32) -> [i64; 2] {
        let (sine, cosine) = sine_cosine(phase);
        let (sine, less) = (i64::from(sine), i64::from(cosine - ONE));
        let [first, second] = self.parts.map(i64::from);
        let places = Self::BITS.wrapping_sub(self.places);
        [
            (first * less - second * sine).wrapping_shr(places),
            (second * less + first * sine).wrapping_shr(places),
        ]
    }
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
    fn a_radius_turns_as_in_double_precision() {
        for size in [1_i64 << 18, 12_345_678_901, 1 << 51, (1 << 52) - 1] {
            for radial in [
                [size, 0],
                [-size / 3, size],
                [size / 1_000, -size],
                [-size, -size],
            ] {
                let radius = Radius::of(radial);
                let [first, second] = radial.map(|part| part as f64);
                let length = first.hypot(second);
                for step in 0..1_000_u32 {
                    let phase = step.wrapping_mul(4_294_967);
                    let angle = f64::from(phase) / 2_f64.powi(32) * core::f64::consts::TAU;
                    let (sine, less) = (angle.sin(), angle.cos() - 1.0);
                    let exact = [first * less - second * sine, second * less + first * sine];
                    for (turned, exact) in radius.turned(phase).into_iter().zip(exact) {
                        let error = turned as f64 - exact;
                        assert!(error.abs() < length * 2_f64.powi(-27) + 2.0, "{radial:?}");
                    }
                }
                assert_eq!(radius.turned(0), [0, 0]);
            }
        }
    }
}
