//! Random draws for scenarios.

use drive_sim::SplitMix64;

/// A source of draws: the same seed draws the same scenario on every machine.
#[derive(Debug, Clone)]
pub(super) struct Draw(SplitMix64);

impl Draw {
    /// A source that starts from `seed`.
    pub(super) fn new(seed: u64) -> Self {
        Self(SplitMix64::new(seed))
    }

    /// A number in `low..=high`.
    pub(super) fn between(&mut self, low: u64, high: u64) -> u64 {
        low + self.0.up_to(high - low)
    }

    /// A number in `low..=high` that fits 32 bits.
    pub(super) fn between_u32(&mut self, low: u32, high: u32) -> u32 {
        low + self.0.up_to(u64::from(high - low)) as u32
    }

    /// A number in `low..=high` with the resolution of a 20-bit fraction.
    pub(super) fn real(&mut self, low: f64, high: f64) -> f64 {
        const STEPS: u64 = 1 << 20;
        low + (high - low) * self.0.up_to(STEPS) as f64 / STEPS as f64
    }

    /// True in `percent` of 100 draws.
    pub(super) fn chance(&mut self, percent: u64) -> bool {
        self.0.up_to(99) < percent
    }

    /// One of several equals.
    pub(super) fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.0.up_to(choices.len() as u64 - 1) as usize]
    }

    /// A seed for another source.
    pub(super) fn seed(&mut self) -> u64 {
        self.0.next_u64()
    }
}
