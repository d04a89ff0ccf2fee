//! Bit rates of the drives.

use can_frame::BitRate;

/// The bit rates that the drives know (1.6A section 1; 1.2A prints the same), ascending. How one is chosen and which a new drive has is
/// not stated.
pub const BIT_RATES: [BitRate; 8] = [
    BitRate::Kbit10,
    BitRate::Kbit20,
    BitRate::Kbit50,
    BitRate::Kbit125,
    BitRate::Kbit250,
    BitRate::Kbit500,
    BitRate::Kbit800,
    BitRate::Kbit1000,
];

/// Whether the drives know a bit rate.
#[must_use]
pub const fn knows_bit_rate(bit_rate: BitRate) -> bool {
    bit_rate.is_one_of(&BIT_RATES)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rate_but_100_is_known() {
        let unknown = BitRate::ALL
            .into_iter()
            .filter(|&rate| !knows_bit_rate(rate));
        assert!(unknown.eq([BitRate::Kbit100]));
    }
}
