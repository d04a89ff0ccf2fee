//! The moving average that makes a profile with a limit of the acceleration one with a limit of the jerk.
//!
//! An average over `n` cycles of a velocity, whose change in a cycle is at most `a`, is never above the velocity, changes by at most `a`, and
//! its change changes by at most `2 a / n`.

use crate::length::LENGTH_BITS;

/// Longest average, in cycles.
pub(crate) const LONGEST: usize = 256;

/// The velocities of the latest cycles, with [`LENGTH_BITS`] behind the point.
#[derive(Debug, Clone)]
pub(crate) struct Average {
    velocities: [u32; LONGEST],
    next: usize,
    cycles: usize,
    sum: u64,
}

impl Average {
    /// Over 1 to [`LONGEST`] cycles, at rest.
    pub(crate) const fn new(cycles: usize) -> Self {
        Self {
            velocities: [0; LONGEST],
            next: 0,
            cycles,
            sum: 0,
        }
    }

    /// The velocity of another cycle; returns the sum of the latest ones.
    pub(crate) fn add(&mut self, velocity: u32) -> u64 {
        if let Some(oldest) = self.velocities.get_mut(self.next) {
            self.sum = self.sum + u64::from(velocity) - u64::from(*oldest);
            *oldest = velocity;
        }
        self.next += 1;
        if self.next >= self.cycles {
            self.next = 0;
        }
        self.sum
    }

    pub(crate) const fn cycles(&self) -> usize {
        self.cycles
    }

    /// Whether every velocity is 0.
    pub(crate) const fn is_at_rest(&self) -> bool {
        self.sum == 0
    }

    /// Units per cycle.
    pub(crate) fn velocity(&self) -> f32 {
        self.sum as f32 / (self.cycles as f32 * (1_u64 << LENGTH_BITS) as f32)
    }
}
