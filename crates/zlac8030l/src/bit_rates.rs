//! Bit rates of the drive.

use can_frame::BitRate;

/// The bit rates that the drive knows, in the order of the codes of 200Eh (guide section 9): 0 is 1000 kbit/s, 4 is 100 kbit/s.
pub const BIT_RATES: [BitRate; 5] = [
    BitRate::Kbit1000,
    BitRate::Kbit500,
    BitRate::Kbit250,
    BitRate::Kbit125,
    BitRate::Kbit100,
];

/// The bit rate with which a drive leaves the factory (guide section 3.1).
pub const FACTORY_BIT_RATE: BitRate = BitRate::Kbit500;

/// Whether the drive knows a bit rate.
#[must_use]
pub const fn knows_bit_rate(bit_rate: BitRate) -> bool {
    bit_rate.is_one_of(&BIT_RATES)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_codes_of_200eh_have_their_bit_rates() {
        let known = BIT_RATES.map(BitRate::kbit_per_s);
        assert_eq!(known, [1_000, 500, 250, 125, 100]);
        // The default of 200Eh is 1.
        assert_eq!(BIT_RATES[1], FACTORY_BIT_RATE);
        for bit_rate in BitRate::ALL {
            let expected = matches!(bit_rate.kbit_per_s(), 100 | 125 | 250 | 500 | 1_000);
            assert_eq!(knows_bit_rate(bit_rate), expected);
        }
    }
}
