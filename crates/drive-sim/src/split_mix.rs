//! A small deterministic generator of random numbers.
//!
//! Specification: the same seed gives the same numbers on every machine; nothing here reads a clock or the operating system.

/// SplitMix64 (Steele, Lea, Flood 2014): 64 bits of state, period 2^64. Good for test inputs, not for secrets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SplitMix64 {
    state: u64,
}

impl SplitMix64 {
    /// A generator that starts from `seed`.
    pub const fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// The next number, evenly spread over 64 bits.
    pub const fn next_u64(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.state ^ self.state >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    /// The next number in 0 ..= `max`. Its bias is below `max` / 2^64.
    pub const fn up_to(&mut self, max: u64) -> u64 {
        let product = self.next_u64() as u128 * (max as u128 + 1);
        (product >> 64) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_sequence_of_seed_1234567() {
        let mut random = SplitMix64::new(1_234_567);
        let golden = [
            6_457_827_717_110_365_317,
            3_203_168_211_198_807_973,
            9_817_491_932_198_370_423,
        ];
        assert_eq!(golden.map(|_| random.next_u64()), golden);
    }

    #[test]
    fn both_ends_are_drawn_and_nothing_beyond() {
        let mut random = SplitMix64::new(0);
        let mut seen = [0; 3];
        (0..300).for_each(|_| seen[random.up_to(2) as usize] += 1);
        assert!(seen.iter().all(|count| *count > 50));
        assert_eq!(random.up_to(0), 0);
        random.up_to(u64::MAX);
    }
}
