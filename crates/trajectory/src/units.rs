//! Machine units and counts, as exact fractions.
//!
//! Every conversion starts from the absolute value and rounds once, so nothing drifts, however often it is done.
//!
//! ```
//! use trajectory::units::{Ratio, Units};
//!
//! // A spindle of 5 mm pitch behind a gear of 10 : 3, a motor of 65536 counts a turn, mounted the wrong way round.
//! // Micrometres; machine zero is at count 1200.
//! let counts_per_um = Ratio::new(65_536, 1)? // counts per turn of the motor
//!     .times(Ratio::new(10, 3)?)?            // turns of the motor per turn of the spindle
//!     .times(Ratio::new(-1, 5_000)?)?;       // turns of the spindle per micrometre
//! let units = Units::new(counts_per_um, 1_200);
//! assert_eq!(units.to_counts(15_000)?, 1_200 - 655_360);
//! assert_eq!(units.to_units(1_200 - 655_360)?, 15_000);
//! # Ok::<(), trajectory::units::UnitsError>(())
//! ```

use core::fmt;

use crate::limits::{Limits, RangeError};

/// A fraction in lowest terms; its sign is that of the numerator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ratio {
    numerator: i32,
    denominator: u32,
}

/// A fraction or a conversion that is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum UnitsError {
    /// Numerator or denominator is 0.
    Zero,
    /// A product of fractions that does not fit 32 bits, in lowest terms.
    Ratio {
        /// Its numerator.
        numerator: i64,
        /// Its denominator.
        denominator: u64,
    },
    /// A result beyond 32 bits.
    Range {
        /// The result.
        actual: i64,
    },
}

impl fmt::Display for UnitsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Zero => f.write_str("neither part of a ratio can be 0"),
            Self::Ratio {
                numerator,
                denominator,
            } => write!(
                f,
                "the parts of a ratio must fit 32 bits, this one is {numerator} / {denominator}"
            ),
            Self::Range { actual } => write!(f, "positions must fit 32 bits, this one is {actual}"),
        }
    }
}

impl core::error::Error for UnitsError {}

impl Ratio {
    /// `numerator / denominator`.
    ///
    /// # Errors
    /// [`UnitsError::Zero`] when one of them is 0: an axis that never moves, or a division by zero.
    pub const fn new(numerator: i32, denominator: u32) -> Result<Self, UnitsError> {
        Self::reduced(numerator as i64, denominator as u64)
    }

    /// Both one after the other.
    ///
    /// # Errors
    /// [`UnitsError::Ratio`] when the product in lowest terms does not fit 32 bits.
    pub const fn times(self, other: Self) -> Result<Self, UnitsError> {
        Self::reduced(
            self.numerator as i64 * other.numerator as i64,
            self.denominator as u64 * other.denominator as u64,
        )
    }

    /// The numerator, with the sign.
    #[must_use]
    pub const fn numerator(self) -> i32 {
        self.numerator
    }

    /// The denominator.
    #[must_use]
    pub const fn denominator(self) -> u32 {
        self.denominator
    }

    const fn reduced(numerator: i64, denominator: u64) -> Result<Self, UnitsError> {
        let divisor = greatest_common_divisor(numerator.unsigned_abs(), denominator);
        let (Some(size), Some(denominator)) = (
            numerator.unsigned_abs().checked_div(divisor),
            denominator.checked_div(divisor),
        ) else {
            return Err(UnitsError::Zero);
        };
        if size == 0 || denominator == 0 {
            return Err(UnitsError::Zero);
        }
        // Two 32-bit factors, so the size fits.
        let numerator = if numerator < 0 {
            -(size as i64)
        } else {
            size as i64
        };
        if size > i32::MAX as u64 || denominator > u32::MAX as u64 {
            return Err(UnitsError::Ratio {
                numerator,
                denominator,
            });
        }
        Ok(Self {
            numerator: numerator as i32,
            denominator: denominator as u32,
        })
    }

    fn size(self) -> f32 {
        self.numerator.unsigned_abs() as f32 / self.denominator as f32
    }
}

const fn greatest_common_divisor(a: u64, b: u64) -> u64 {
    let (mut a, mut b) = (a, b);
    while let Some(rest) = a.checked_rem(b) {
        (a, b) = (b, rest);
    }
    a
}

/// Machine units of an axis: counts per unit, and the count of machine zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Units {
    counts_per_unit: Ratio,
    zero_counts: i32,
}

impl Units {
    /// Counts per unit, negative for an axis that runs the other way, and the count at which the unit is 0.
    #[must_use]
    pub const fn new(counts_per_unit: Ratio, zero_counts: i32) -> Self {
        Self {
            counts_per_unit,
            zero_counts,
        }
    }

    /// The nearest count of a position in units, a half rounded up.
    ///
    /// # Errors
    /// [`UnitsError::Range`] when it does not fit 32 bits.
    pub const fn to_counts(&self, units: i32) -> Result<i32, UnitsError> {
        let Ratio {
            numerator,
            denominator,
        } = self.counts_per_unit;
        let counts = divided(units as i64 * numerator as i64, denominator);
        // A quotient of 63 bits and a number of 32.
        fitting(counts.saturating_add(self.zero_counts as i64))
    }

    /// The nearest unit of a position in counts, a half rounded up. The way back from [`Self::to_counts`] is exact where a unit has at
    /// least one count.
    ///
    /// # Errors
    /// [`UnitsError::Range`] when it does not fit 32 bits.
    pub const fn to_units(&self, counts: i32) -> Result<i32, UnitsError> {
        let Ratio {
            numerator,
            denominator,
        } = self.counts_per_unit;
        let way = counts as i64 - self.zero_counts as i64;
        let way = if numerator < 0 { -way } else { way };
        // 33 bits and 32 bits with a sign do not fit 64 in the corner that is refused anyway.
        let Some(product) = way.checked_mul(denominator as i64) else {
            return Err(UnitsError::Range {
                actual: if way < 0 { i64::MIN } else { i64::MAX },
            });
        };
        fitting(divided(product, numerator.unsigned_abs()))
    }

    /// Limits in units per second, second² and second³ as limits in counts per cycle. These are magnitudes: without sign, rounded to 24
    /// bits.
    ///
    /// # Errors
    /// [`RangeError`] as in [`Limits::new`].
    pub fn limits(
        &self,
        velocity_per_s: f32,
        acceleration_per_s2: f32,
        jerk_per_s3: f32,
        cycle_us: u32,
    ) -> Result<Limits, RangeError> {
        let (ratio, cycle_s) = (self.counts_per_unit.size(), cycle_us as f32 * 1e-6);
        let velocity = velocity_per_s * ratio * cycle_s;
        let acceleration = acceleration_per_s2 * ratio * cycle_s * cycle_s;
        if jerk_per_s3 == f32::INFINITY {
            return Limits::without_jerk(velocity, acceleration);
        }
        let jerk = jerk_per_s3 * ratio * cycle_s * cycle_s * cycle_s;
        Limits::new(velocity, acceleration, jerk)
    }
}

/// The nearest integer of a quotient, a half rounded up.
const fn divided(dividend: i64, divisor: u32) -> i64 {
    let divisor = divisor as i64;
    let (Some(quotient), Some(rest)) = (
        dividend.checked_div_euclid(divisor),
        dividend.checked_rem_euclid(divisor),
    ) else {
        return 0;
    };
    quotient + (2 * rest >= divisor) as i64
}

const fn fitting(actual: i64) -> Result<i32, UnitsError> {
    if actual == actual as i32 as i64 {
        Ok(actual as i32)
    } else {
        Err(UnitsError::Range { actual })
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use proptest::prelude::*;

    use super::*;

    fn ratio(numerator: i32, denominator: u32) -> Ratio {
        Ratio::new(numerator, denominator).unwrap()
    }

    #[test]
    fn ratios_are_in_lowest_terms() {
        let product = ratio(65_536, 1).times(ratio(-10, 3)).unwrap();
        let product = product.times(ratio(1, 5_000)).unwrap();
        assert_eq!((product.numerator(), product.denominator()), (-16_384, 375));
        assert_eq!(ratio(-6, 4), ratio(-3, 2));
    }

    #[test]
    fn a_ratio_of_nothing_is_refused() {
        for (numerator, denominator) in [(0, 1), (1, 0), (0, 0)] {
            assert_eq!(Ratio::new(numerator, denominator), Err(UnitsError::Zero));
        }
    }

    #[test]
    fn a_ratio_that_does_not_fit_is_refused() {
        let large = ratio(i32::MAX, 1);
        let Err(error) = large.times(large) else {
            panic!("it fits");
        };
        assert_eq!(
            error,
            UnitsError::Ratio {
                numerator: i64::from(i32::MAX) * i64::from(i32::MAX),
                denominator: 1
            }
        );
        assert!(ratio(1, u32::MAX).times(ratio(1, 2)).is_err());
        assert!(Ratio::new(i32::MIN, 1).is_err());
        assert_eq!(ratio(i32::MIN, 2).numerator(), i32::MIN / 2);
    }

    #[test]
    fn positions_are_rounded_to_the_nearest() {
        let thirds = Units::new(ratio(1, 3), 100);
        for (units, counts) in [(0, 100), (1, 100), (2, 101), (3, 101), (-1, 100), (-2, 99)] {
            assert_eq!(thirds.to_counts(units), Ok(counts));
        }
        let halves = Units::new(ratio(1, 2), 0);
        assert_eq!((halves.to_counts(1), halves.to_counts(-1)), (Ok(1), Ok(0)));
        let reversed = Units::new(ratio(-10, 1), -5);
        assert_eq!(reversed.to_counts(3), Ok(-35));
        assert_eq!(reversed.to_units(-35), Ok(3));
        assert_eq!(reversed.to_units(-31), Ok(3));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let units = Units::new(ratio(1_000, 1), 0);
        assert_eq!(
            units.to_counts(i32::MAX),
            Err(UnitsError::Range {
                actual: i64::from(i32::MAX) * 1_000
            })
        );
        let fine = Units::new(ratio(1, u32::MAX), i32::MIN);
        assert_eq!(
            fine.to_units(i32::MAX),
            Err(UnitsError::Range { actual: i64::MAX })
        );
        let fine = Units::new(ratio(-1, u32::MAX), i32::MIN);
        assert_eq!(
            fine.to_units(i32::MAX),
            Err(UnitsError::Range { actual: i64::MIN })
        );
        assert!(
            Units::new(ratio(i32::MAX, 1), i32::MAX)
                .to_counts(i32::MAX)
                .is_err()
        );
    }

    #[test]
    fn limits_per_second_are_limits_per_cycle() {
        // 100 counts per unit, cycles of 2 ms.
        let units = Units::new(ratio(-100, 1), 0);
        let limits = units.limits(50.0, 1_000.0, 20_000.0, 2_000).unwrap();
        assert!((limits.velocity() - 10.0).abs() < 1e-5);
        assert!((limits.acceleration() - 0.4).abs() < 1e-6);
        assert!((limits.jerk() - 0.016).abs() < 1e-8);
        let trapezoid = units.limits(50.0, 1_000.0, f32::INFINITY, 2_000).unwrap();
        assert_eq!(trapezoid.jerk(), f32::INFINITY);
        assert!(units.limits(-1.0, 1.0, 1.0, 2_000).is_err());
    }

    #[test]
    fn errors_say_what_is_wrong() {
        assert!(UnitsError::Zero.to_string().contains('0'));
        assert!(
            UnitsError::Range { actual: 1 << 40 }
                .to_string()
                .contains("1099511627776")
        );
        let error = UnitsError::Ratio {
            numerator: -7,
            denominator: 3,
        };
        assert!(error.to_string().ends_with("-7 / 3"));
    }

    proptest! {
        /// Exact arithmetic in 128 bits says the same, and a unit of at least one count comes back.
        #[test]
        fn conversions_are_those_of_exact_arithmetic(
            numerator in prop_oneof![1..i32::MAX, -i32::MAX..0, 1..100_000],
            denominator in prop_oneof![1..u32::MAX, 1..1_000_u32],
            zero in any::<i32>(),
            position in prop_oneof![any::<i32>(), -1_000..1_000],
        ) {
            let ratio = ratio(numerator, denominator);
            let units = Units::new(ratio, zero);
            let (n, d) = (i128::from(numerator), i128::from(denominator));
            let nearest = |dividend: i128, divisor: i128| (2 * dividend + divisor).div_euclid(2 * divisor);
            let counts = nearest(i128::from(position) * n, d) + i128::from(zero);
            prop_assert_eq!(units.to_counts(position).ok().map(i128::from), i32::try_from(counts).ok().map(i128::from));
            let back = nearest((i128::from(position) - i128::from(zero)) * d * n.signum(), n.abs());
            prop_assert_eq!(units.to_units(position).ok().map(i128::from), i32::try_from(back).ok().map(i128::from));
            if let Ok(counts) = units.to_counts(position)
                && n.abs() >= d
            {
                prop_assert_eq!(units.to_units(counts), Ok(position));
            }
        }
    }
}
