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
