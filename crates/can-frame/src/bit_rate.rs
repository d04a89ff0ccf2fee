//! Bit rates, and times in bits.

use core::fmt;

/// Bit rate of a bus that one of the drives knows, each with a whole number of nanoseconds a bit. Which drive knows which:
/// `dyn_can::BIT_RATES` and `zlac8030l::BIT_RATES`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum BitRate {
    /// 10 kbit/s.
    Kbit10,
    /// 20 kbit/s.
    Kbit20,
    /// 50 kbit/s.
    Kbit50,
    /// 100 kbit/s.
    Kbit100,
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
    /// Every rate, ascending.
    pub const ALL: [Self; 9] = [
        Self::Kbit10,
        Self::Kbit20,
        Self::Kbit50,
        Self::Kbit100,
        Self::Kbit125,
        Self::Kbit250,
        Self::Kbit500,
        Self::Kbit800,
        Self::Kbit1000,
    ];

    /// The rate of `kbit_per_s` kbit/s.
    ///
    /// # Errors
    /// [`UnsupportedBitRate`] unless it is one of [`BitRate::ALL`].
    pub const fn from_kbit_per_s(kbit_per_s: u32) -> Result<Self, UnsupportedBitRate> {
        let mut rates: &[Self] = &Self::ALL;
        while let Some((rate, others)) = rates.split_first() {
            if rate.kbit_per_s() == kbit_per_s {
                return Ok(*rate);
            }
            rates = others;
        }
        Err(UnsupportedBitRate { kbit_per_s })
    }

    /// Whether a list has this rate.
    #[must_use]
    pub const fn is_one_of(self, mut rates: &[Self]) -> bool {
        while let Some((rate, others)) = rates.split_first() {
            if rate.kbit_per_s() == self.kbit_per_s() {
                return true;
            }
            rates = others;
        }
        false
    }

    /// The rate in kbit/s.
    #[must_use]
    pub const fn kbit_per_s(self) -> u32 {
        match self {
            Self::Kbit10 => 10,
            Self::Kbit20 => 20,
            Self::Kbit50 => 50,
            Self::Kbit100 => 100,
            Self::Kbit125 => 125,
            Self::Kbit250 => 250,
            Self::Kbit500 => 500,
            Self::Kbit800 => 800,
            Self::Kbit1000 => 1_000,
        }
    }

    /// Duration of one bit in nanoseconds.
    #[must_use]
    pub const fn bit_ns(self) -> u64 {
        1_000_000 / self.kbit_per_s() as u64
    }

    /// The rates above this one, ascending.
    #[must_use]
    pub const fn higher(self) -> &'static [Self] {
        let mut rates: &[Self] = &Self::ALL;
        while let Some((rate, others)) = rates.split_first() {
            rates = others;
            if rate.kbit_per_s() == self.kbit_per_s() {
                break;
            }
        }
        rates
    }

    /// Whole bit times within a time, rounded down.
    #[must_use]
    pub const fn bits_within(self, us: u32) -> u64 {
        us as u64 * self.kbit_per_s() as u64 / 1_000
    }

    /// Whole bit times that cover a time, rounded up.
    #[must_use]
    pub const fn bits_covering(self, us: u32) -> u64 {
        (us as u64 * self.kbit_per_s() as u64).div_ceil(1_000)
    }

    /// Microseconds that cover a number of bit times, rounded up.
    #[must_use]
    pub const fn us_covering(self, bits: u32) -> u32 {
        // A frame has few bits, and the processor divides no more than 32.
        if let Some(thousandths) = bits.checked_mul(1_000) {
            return thousandths.div_ceil(self.kbit_per_s());
        }
        let us = (bits as u64 * 1_000).div_ceil(self.kbit_per_s() as u64);
        if us > u32::MAX as u64 {
            u32::MAX
        } else {
            us as u32
        }
    }
}

/// A bit rate that is none of [`BitRate::ALL`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct UnsupportedBitRate {
    /// What was asked for, in kbit/s.
    pub kbit_per_s: u32,
}

impl fmt::Display for UnsupportedBitRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} kbit/s is not supported; use 10, 20, 50, 100, 125, 250, 500, 800 or 1000 kbit/s",
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
            (100, 10_000),
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
    fn times_are_rounded_to_the_safe_side() {
        // 72 bits at 800 kbit/s are 90 us; 73 bits are 91.25 us.
        assert_eq!(BitRate::Kbit800.us_covering(72), 90);
        assert_eq!(BitRate::Kbit800.us_covering(73), 92);
        assert_eq!(BitRate::Kbit800.bits_within(91), 72);
        assert_eq!(BitRate::Kbit800.bits_covering(91), 73);
        assert_eq!(BitRate::Kbit10.us_covering(u32::MAX), u32::MAX);
        for bits in [0, 1, u32::MAX / 1_000, u32::MAX / 1_000 + 1, u32::MAX] {
            for rate in BitRate::ALL {
                let us = (u64::from(bits) * 1_000).div_ceil(rate.kbit_per_s().into());
                let us = u32::try_from(us).unwrap_or(u32::MAX);
                assert_eq!(rate.us_covering(bits), us, "{bits} bits at {rate:?}");
            }
        }
    }

    #[test]
    fn higher_rates_ascend_and_end() {
        assert_eq!(
            BitRate::Kbit500.higher(),
            [BitRate::Kbit800, BitRate::Kbit1000]
        );
        assert!(BitRate::Kbit1000.higher().is_empty());
    }

    #[test]
    fn a_drive_knows_the_rates_of_its_list() {
        let list = [BitRate::Kbit125, BitRate::Kbit500];
        let known = BitRate::ALL.map(|rate| rate.is_one_of(&list));
        assert_eq!(known, BitRate::ALL.map(|rate| list.contains(&rate)));
        assert!(!BitRate::Kbit500.is_one_of(&[]));
    }

    #[test]
    fn a_refused_rate_names_those_that_are_known() {
        let error = BitRate::from_kbit_per_s(333).unwrap_err();
        assert_eq!(
            std::format!("{error}"),
            "333 kbit/s is not supported; use 10, 20, 50, 100, 125, 250, 500, 800 or 1000 kbit/s"
        );
    }

    #[test]
    fn other_rates_are_refused() {
        for kbit_per_s in [0, 83, 300, 1001] {
            assert_eq!(
                BitRate::from_kbit_per_s(kbit_per_s),
                Err(UnsupportedBitRate { kbit_per_s })
            );
        }
    }
}
