//! The ledger of one servo axis: what is wanted, what was handed to the bus, and what is still owed.
//!
//! `Go_Relative_Pos_PD` is relative, so one lost or doubled frame is a permanent position error. The ledger holds absolute counts; a
//! step is counted when the controller has accepted its frame and taken back when the controller returns that frame unsent.
//!
//! What one frame cannot carry, or could not carry because its cycle was missed, is caught up within the limits of the axis: the
//! velocity changes by one `max_step_change` a cycle at most, starting from 0 after a missed cycle, and never leads past the target.
//! Set-points of an application that keeps the limits are not changed.

use dyn_can::PdStep;
use trajectory::whole_counts::{FRACTION, Lag, RampDown, StepLimits};

use crate::servo::config::Limits;

/// Target and sent position of one axis, in command counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Ledger {
    target_counts: i32,
    sent_counts: i32,
    /// The target when the latest frame was accepted, or its cycle missed: what was wanted by then and not sent is left over.
    due_counts: i32,
    /// The step of the latest frame, which is the velocity in counts per cycle.
    last_step: i16,
    catch_up: CatchUp,
    /// Of the frame that is being offered.
    offered_catch_up: CatchUp,
    /// What the frame that is being offered carries.
    offered_step: PdStep,
    /// The ramp counts.
    ramps: bool,
    ramp: RampDown,
}

/// A step, and the velocity that it leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Offered {
    step: PdStep,
    catch_up: CatchUp,
}

/// Velocity while something is caught up, in 1/256 counts per cycle: at most 2^22. In half the room of an `Option`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct CatchUp(i32);

impl CatchUp {
    /// Nothing is caught up.
    const NONE: Self = Self(i32::MIN);

    const fn velocity(self) -> Option<i32> {
        match self {
            Self::NONE => None,
            Self(velocity) => Some(velocity),
        }
    }
}

impl Ledger {
    /// Nothing is owed, nothing moves, at the origin.
    pub(crate) const NEW: Self = Self::at(0);

    const fn at(counts: i32) -> Self {
        Self {
            target_counts: counts,
            sent_counts: counts,
            due_counts: counts,
            last_step: 0,
            catch_up: CatchUp::NONE,
            offered_catch_up: CatchUp::NONE,
            offered_step: PdStep::ZERO,
            ramps: false,
            ramp: RampDown::new(counts, 0, 0),
        }
    }

    /// Target and sent position agree with a position that was read back: nothing is owed, nothing moves.
    pub(crate) fn anchor(&mut self, position_counts: i32) {
        *self = Self::at(position_counts);
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

    /// Where the set-points before the latest have taken the axis.
    pub(crate) fn sent_before(&self) -> i32 {
        self.sent_counts.wrapping_sub(self.last_step.into())
    }

    pub(crate) const fn backlog_counts(&self) -> i32 {
        self.target_counts.wrapping_sub(self.sent_counts)
    }

    /// The step that the next frame carries.
    #[inline]
    pub(crate) fn offer(&mut self, limits: &Limits) -> PdStep {
        let Offered { step, catch_up } =
            if self.due_counts == self.sent_counts && self.catch_up == CatchUp::NONE {
                Offered {
                    step: PdStep::toward(self.backlog_counts(), limits.max_step),
                    catch_up: CatchUp::NONE,
                }
            } else {
                self.caught_up(limits)
            };
        (self.offered_step, self.offered_catch_up) = (step, catch_up);
        step
    }

    /// Towards the moving target as fast as the limits allow, so that it is met without going past it.
    #[inline(never)]
    fn caught_up(&self, limits: &Limits) -> Offered {
        let lag = Lag {
            owed_counts: self.backlog_counts(),
            left_over_counts: self.due_counts.wrapping_sub(self.sent_counts),
            velocity_256ths: self
                .catch_up
                .velocity()
                .unwrap_or(i32::from(self.last_step) * FRACTION),
        };
        let step = lag.step(&StepLimits {
            most_counts: limits.max_step.get(),
            change_256ths: limits.max_step_change.per_256_cycles(),
        });
        Offered {
            step: PdStep::toward(step.counts, limits.max_step),
            catch_up: if step.is_met {
                CatchUp::NONE
            } else {
                CatchUp(step.velocity_256ths)
            },
        }
    }

    /// The controller accepted the frame that was offered; returns its step.
    #[inline(always)]
    pub(crate) fn accepted(&mut self) -> i16 {
        let step = self.offered_step.get();
        self.sent_counts = self.sent_counts.wrapping_add(i32::from(step));
        self.last_step = step;
        self.due_counts = self.target_counts;
        self.catch_up = self.offered_catch_up;
        step
    }

    /// The frame of the cycle was not accepted: the axis stands, and goes on from there.
    pub(crate) fn missed(&mut self) {
        self.last_step = 0;
        self.due_counts = self.target_counts;
        self.catch_up = if self.backlog_counts() == 0 {
            CatchUp::NONE
        } else {
            CatchUp(0)
        };
    }

    /// The controller returned a frame with this step unsent.
    pub(crate) fn returned(&mut self, step: PdStep) {
        self.sent_counts = self.sent_counts.wrapping_sub(i32::from(step.get()));
    }

    /// Slows down from the present velocity in so many cycles; what is owed is forgotten.
    pub(crate) fn begin_ramp(&mut self, cycles: u32) {
        let ramp = self.ramp_in(cycles);
        self.end_motion();
        (self.ramp, self.ramps) = (ramp, true);
    }

    const fn ramp_in(&self, cycles: u32) -> RampDown {
        RampDown::new(self.sent_counts, self.last_step as i32, cycles)
    }

    /// A cycle begins: a ramp goes on.
    pub(crate) fn begin_cycle(&mut self) {
        if self.ramps {
            self.ramp.advance();
            self.target_counts = self.ramp.set_point();
        }
    }

    /// Cycles in which the axis can stop within its acceleration.
    pub(crate) fn cycles_to_stop(&self, limits: &Limits) -> u32 {
        let change = limits.max_step_change.per_256_cycles();
        RampDown::cycles_to_stop(i32::from(self.last_step) * FRACTION, change)
    }

    /// Where the axis stands when it stops in so many cycles.
    pub(crate) const fn end_of_ramp(&self, cycles: u32) -> i32 {
        self.ramp_in(cycles).end()
    }

    /// The ramp is through and nothing is owed.
    pub(crate) fn has_stopped(&self) -> bool {
        (!self.ramps || self.ramp.is_done()) && self.backlog_counts() == 0
    }
}

#[cfg(test)]
mod tests;
