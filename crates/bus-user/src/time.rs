//! Time as the caller tells it.

use core::fmt;
use core::ops::Add;

/// A point in time: microseconds since a start that the caller chooses.
///
/// Nothing in this crate reads a clock. 64 bits of microseconds do not wrap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Instant(u64);

impl Instant {
    /// A point in time from microseconds.
    #[inline]
    #[must_use]
    pub const fn from_us(us: u64) -> Self {
        Self(us)
    }

    /// Microseconds since the start.
    #[inline]
    #[must_use]
    pub const fn as_us(self) -> u64 {
        self.0
    }

    /// Microseconds since an earlier point, 0 for a later one.
    #[inline]
    #[must_use]
    pub const fn us_since(self, earlier: Self) -> u64 {
        self.0.saturating_sub(earlier.0)
    }
}

impl Add<u32> for Instant {
    type Output = Self;

    /// A point in time so many microseconds later.
    #[inline]
    fn add(self, us: u32) -> Self {
        Self(self.0.wrapping_add(us as u64))
    }
}

impl fmt::Display for Instant {
    /// Seconds with six decimals.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{:06}", self.0 / 1_000_000, self.0 % 1_000_000)
    }
}
