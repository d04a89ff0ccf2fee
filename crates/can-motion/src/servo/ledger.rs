//! The ledger of one servo axis: what is wanted, what was handed to the bus, and what is still owed.
//!
//! `Go_Relative_Pos_PD` is relative, so one lost or doubled frame is a permanent position error. The ledger holds absolute counts; a
//! step is counted when the controller has accepted its frame and taken back when the controller returns that frame unsent.
//!
//! What one frame cannot carry, or could not carry because its cycle was missed, is caught up within the limits of the axis: the
//! velocity changes by one `max_step_change` a cycle at most, starting from 0 after a missed cycle, and never leads past the target.
//! Set-points of an application that keeps the limits are not changed.

use dyn_can::PdStep;

use crate::core::ramp::{Ramp, cycles_to_stop};
use crate::servo::config::Limits;

/// Fraction of a count in which velocities are kept while something is caught up.
const FRACTION: i64 = 256;

/// Target and sent position of one axis, in command counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Ledger {
    target_counts: i32,
    sent_counts: i32,
    /// The target when the latest frame was accepted, or its cycle missed: what was wanted by then and not sent is left over.
    due_counts: i32,
    /// The step of the latest frame, which is the velocity in counts per cycle.
    last_step: i16,
    /// Velocity while something is caught up, in 1/256 counts per cycle.
    catch_up_velocity: Option<i32>,
    ramp: Option<Ramp>,
    /// What the frame that is being offered carries.
    offered: Offered,
}

/// A step, and the velocity that it leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Offered {
    step: i16,
    catch_up_velocity: Option<i32>,
}

impl Ledger {
    /// Target and sent position agree with a position that was read back: nothing is owed, nothing moves.
    pub(crate) fn anchor(&mut self, position_counts: i32) {
        *self = Self {
            target_counts: position_counts,
            sent_counts: position_counts,
            due_counts: position_counts,
            ..Self::default()
        };
    }

    /// Forgets what is owed: the axis stays where the frames sent so far take it.
    pub(crate) fn end_motion(&mut self) {
        self.anchor(self.sent_counts);
    }

    pub(crate) fn set_target(&mut self, counts: i32) {
        self.target_counts = counts;
    }

    pub(crate) const fn target_counts(&self) -> i32 {
        self.target_counts
    }

    pub(crate) const fn sent_counts(&self) -> i32 {
        self.sent_counts
    }

    pub(crate) const fn backlog_counts(&self) -> i32 {
        self.target_counts.wrapping_sub(self.sent_counts)
    }

    /// The step that the next frame carries.
    pub(crate) fn offer(&mut self, limits: &Limits) -> PdStep {
        self.offered = if self.due_counts == self.sent_counts && self.catch_up_velocity.is_none() {
            let step = PdStep::toward(self.backlog_counts(), limits.max_step);
            Offered {
                step: step.get(),
                catch_up_velocity: None,
            }
        } else {
            self.catch_up(limits)
        };
        PdStep::toward(i32::from(self.offered.step), limits.max_step)
    }

    /// Towards the moving target as fast as the limits allow, so that it is met without going past it.
    fn catch_up(&self, limits: &Limits) -> Offered {
        let change = i64::from(limits.max_step_change.per_256_cycles());
        let owed = i64::from(self.backlog_counts());
        let left_over = i64::from(self.due_counts.wrapping_sub(self.sent_counts));
        let target_velocity = (owed - left_over) * FRACTION;
        // Extra velocity from which the left-over counts are enough to slow down again: r (r + a) = 2 a left.
        let left = left_over.unsigned_abs() * FRACTION as u64;
        let radicand = (change * change) as u64 + 8 * change as u64 * left;
        let extra = (radicand.isqrt() as i64 - change) / 2;
        // At least a count in a cycle, and never more than is left.
        let extra = extra.max(FRACTION).min(left as i64);
        let wanted = target_velocity + extra * left_over.signum();
        let before = match self.catch_up_velocity {
            Some(velocity) => i64::from(velocity),
            None => i64::from(self.last_step) * FRACTION,
        };
        let most = i64::from(limits.max_step.get()) * FRACTION;
        // In place of `clamp`, which panics where its bounds could be the wrong way round.
        let velocity = wanted.max(before - change).min(before + change);
        let velocity = velocity.max(-most).min(most);
        let step = (velocity / FRACTION).max(owed.min(0)).min(owed.max(0));
        let is_met = step == owed && step * FRACTION == target_velocity;
        let kept = if step == velocity / FRACTION {
            velocity
        } else {
            step * FRACTION
        };
        Offered {
            // At most `max_step` and at most 2^22 in size.
            step: step as i16,
            catch_up_velocity: (!is_met).then_some(kept as i32),
        }
    }

    /// The controller accepted the frame that was offered; returns its step.
    pub(crate) fn accepted(&mut self) -> i16 {
        let Offered {
            step,
            catch_up_velocity,
        } = self.offered;
        self.sent_counts = self.sent_counts.wrapping_add(i32::from(step));
        self.last_step = step;
        self.due_counts = self.target_counts;
        self.catch_up_velocity = catch_up_velocity;
        step
    }

    /// The frame of the cycle was not accepted: the axis stands, and goes on from there.
    pub(crate) fn missed(&mut self) {
        self.last_step = 0;
        self.due_counts = self.target_counts;
        self.catch_up_velocity = (self.backlog_counts() != 0).then_some(0);
    }

    /// The controller returned a frame with this step unsent.
    pub(crate) fn returned(&mut self, step: PdStep) {
        self.sent_counts = self.sent_counts.wrapping_sub(i32::from(step.get()));
    }

    /// Slows down from the present velocity in so many cycles; what is owed is forgotten.
    pub(crate) fn begin_ramp(&mut self, cycles: u32) {
        let ramp = self.ramp_in(cycles);
        self.end_motion();
        self.ramp = Some(ramp);
    }

    const fn ramp_in(&self, cycles: u32) -> Ramp {
        Ramp::new(self.sent_counts, self.last_step as i32, cycles)
    }

    /// A cycle begins: a ramp goes on.
    pub(crate) fn begin_cycle(&mut self) {
        if let Some(ramp) = &mut self.ramp {
            self.target_counts = ramp.next_target();
        }
    }

    /// Cycles in which the axis can stop within its acceleration.
    pub(crate) fn cycles_to_stop(&self, limits: &Limits) -> u32 {
        let change = limits.max_step_change.per_256_cycles();
        cycles_to_stop(i32::from(self.last_step) * FRACTION as i32, change)
    }

    /// Where the axis stands when it stops in so many cycles.
    pub(crate) const fn end_of_ramp(&self, cycles: u32) -> i32 {
        self.ramp_in(cycles).end()
    }

    /// The ramp is through and nothing is owed.
    pub(crate) fn has_stopped(&self) -> bool {
        self.ramp.is_none_or(|ramp| ramp.is_done()) && self.backlog_counts() == 0
    }
}

#[cfg(test)]
mod tests;
