//! At the end of a move: is the axis there, and free?

use super::Homing;
use super::settle::Settling;
use crate::abort::Abort;
use crate::inputs::Inputs;

impl Homing {
    /// How far the axis is off the set-point at which it shall rest, as of a position that was read since; `None` while it moves or is
    /// not read.
    pub(super) fn distance_at_rest(
        &self,
        settling: &mut Settling,
        now_us: u64,
        inputs: &Inputs,
    ) -> Option<u32> {
        settling.rests_us(self.mover.is_at_rest(), now_us)?;
        let rested_us = settling.rested_us?;
        let position = inputs
            .position
            .filter(|position| position.at_us > rested_us)?;
        Some(position.value.abs_diff(self.mover.set_point()))
    }

    /// Whether the set-points rest for so long that an axis should have arrived.
    pub(super) fn is_late(&self, settling: &mut Settling, now_us: u64) -> bool {
        settling
            .rests_us(self.mover.is_at_rest(), now_us)
            .is_some_and(|rests_us| rests_us >= u64::from(self.config.watch.settle_us))
    }

    /// Whether the axis has arrived.
    ///
    /// # Errors
    /// [`Abort::NotArrived`] when it has had its time.
    pub(super) fn has_arrived(
        &self,
        settling: &mut Settling,
        now_us: u64,
        inputs: &Inputs,
    ) -> Result<bool, Abort> {
        let limit_counts = self.config.watch.still_counts;
        match self.distance_at_rest(settling, now_us, inputs) {
            Some(counts) if counts <= limit_counts => Ok(true),
            Some(actual_counts) if self.is_late(settling, now_us) => Err(Abort::NotArrived {
                limit_counts,
                actual_counts,
            }),
            _ => Ok(false),
        }
    }
}
