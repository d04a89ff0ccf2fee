//! Roots.

/// The largest number of which the cube is not above `value`, to one part in a thousand and never above it; 0 for what is not positive.
///
/// `libm` computes it in double precision, which this needs neither for its result nor on a processor without it.
pub(crate) fn cube_root_below(value: f32) -> f32 {
    if !(value > 0.0 && value < f32::MAX) {
        return 0.0;
    }
    // A third of the exponent, which is right to 6 %, then two steps of Newton.
    let guess = f32::from_bits(value.to_bits() / 3 + 0x2A51_7D3C);
    let better = guess - (guess - value / (guess * guess)) / 3.0;
    let root = better - (better - value / (better * better)) / 3.0;
    root * 0.9995
}

/// Of a number, 0 for what is not positive; to 2^-21, in a few instructions: `libm` takes about a hundred on a processor whose instruction for
/// it `core` does not offer.
pub(crate) fn square_root(value: f32) -> f32 {
    if value.is_nan() || value <= f32::MIN_POSITIVE {
        return 0.0;
    }
    // Half of the exponent, which is right to 4 %, then two steps of Newton.
    let mut root = f32::from_bits((value.to_bits() >> 1) + 0x1FBC_F800);
    for _ in 0..2 {
        root = 0.5 * (root + value / root);
    }
    root
}

pub(crate) fn hypotenuse(a: f32, b: f32) -> f32 {
    square_root(a * a + b * b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn square_roots_are_right_to_the_last_bits() {
        let mut value = 1e-36_f32;
        while value < 1e38 {
            let exact = f64::from(value).sqrt();
            let error = f64::from(square_root(value)) / exact - 1.0;
            assert!(error.abs() < 2_f64.powi(-21), "{value}: {error}");
            value *= 1.013;
        }
        assert_eq!(square_root(-1.0), 0.0);
        assert_eq!(square_root(f32::NAN), 0.0);
    }

    #[test]
    fn cube_roots_are_never_above() {
        let mut value = 1e-30_f32;
        while value < 1e30 {
            let root = f64::from(cube_root_below(value));
            let exact = f64::from(value).cbrt();
            assert!(root <= exact && root > 0.998 * exact, "{value}: {root}");
            value *= 1.07;
        }
        assert_eq!(cube_root_below(0.0), 0.0);
        assert_eq!(cube_root_below(f32::NAN), 0.0);
    }
}
