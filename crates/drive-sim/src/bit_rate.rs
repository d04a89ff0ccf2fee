//! Bit rates.
//!
//! Law: virtual time counts whole nanoseconds, and each of these rates has a whole number of nanoseconds a bit, so no rounding ever enters.

use core::fmt;

/// Bit rate of a bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum BitRate {
    /// 10 kbit/s.
    Kbit10,
    /// 20 kbit/s.
    Kbit20,
    /// 50 kbit/s.
    Kbit50,
    /// 125 kbit/s.
    Kbit125,
    /// 250 kbit/s.
    Kbit250,
    /// 500 kbit/s.
    Kbit500,
    /// 800 kbit/s.
    Kbit800,
    /// 1 Mbit/s.
    Kbit1000,
}

impl BitRate {
    /// The rate of `kbit_per_s` kbit/s.
    ///
    /// # Errors
    /// [`UnsupportedBitRate`] unless it is one of 10, 20, 50, 125, 250, 500, 800, 1000.
    pub const fn from_kbit_per_s(kbit_per_s: u32) -> Result<Self, UnsupportedBitRate> {
        Ok(match kbit_per_s {
            10 => Self::Kbit10,
            20 => Self::Kbit20,
            50 => Self::Kbit50,
            125 => Self::Kbit125,
            250 => Self::Kbit250,
            500 => Self::Kbit500,
            800 => Self::Kbit800,
            1000 => Self::Kbit1000,
            _ => return Err(UnsupportedBitRate { kbit_per_s }),
        })
    }

    /// Rate in kbit/s.
    pub const fn kbit_per_s(self) -> u32 {
        match self {
            Self::Kbit10 => 10,
            Self::Kbit20 => 20,
            Self::Kbit50 => 50,
            Self::Kbit125 => 125,
            Self::Kbit250 => 250,
            Self::Kbit500 => 500,
            Self::Kbit800 => 800,
            Self::Kbit1000 => 1000,
        }
    }

    /// Duration of one bit in nanoseconds.
    pub const fn bit_ns(self) -> u64 {
        1_000_000 / self.kbit_per_s() as u64
    }
}

/// The bit rate is none that the bus can time in whole nanoseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnsupportedBitRate {
    /// What was asked for, in kbit/s.
    pub kbit_per_s: u32,
}

impl fmt::Display for UnsupportedBitRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} kbit/s is not supported; use 10, 20, 50, 125, 250, 500, 800 or 1000 kbit/s",
            self.kbit_per_s
        )
    }
}

impl core::error::Error for UnsupportedBitRate {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_whole_nanoseconds() {
        let golden = [
            (10, 100_000),
            (20, 50_000),
            (50, 20_000),
            (125, 8_000),
            (250, 4_000),
            (500, 2_000),
            (800, 1_250),
            (1000, 1_000),
        ];
        for (kbit_per_s, bit_ns) in golden {
            let rate = BitRate::from_kbit_per_s(kbit_per_s).unwrap();
            assert_eq!((rate.kbit_per_s(), rate.bit_ns()), (kbit_per_s, bit_ns));
        }
    }

    #[test]
    fn other_rates_are_refused() {
        for kbit_per_s in [0, 100, 300, 1001] {
            assert_eq!(
                BitRate::from_kbit_per_s(kbit_per_s),
                Err(UnsupportedBitRate { kbit_per_s })
            );
        }
    }
}
