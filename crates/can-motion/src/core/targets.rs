//! The ledger of a drive that takes absolute values: its target, the value of the latest frame, and the way down to a stop.

use trajectory::whole_counts::RampDown;

/// What the values mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ValueKind {
    /// Positions: a stop lets their change fall to 0.
    #[default]
    Position,
    /// Speeds: a stop lets themselves fall to 0.
    Speed,
}

/// Limits of the values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ValueLimits {
    /// Smallest value.
    pub min: i32,
    /// Largest value.
    pub max: i32,
    /// Largest change from one cycle to the next, 1 ..= 1,000,000.
    pub max_step: u32,
    /// Largest change of that change while a position slows down, 1 ..= 1,000,000.
    pub max_step_change: u32,
}

impl ValueLimits {
    /// Limits of values from `min` to `max`.
    #[must_use]
    pub const fn new(min: i32, max: i32, max_step: u32, max_step_change: u32) -> Self {
        Self {
            min,
            max,
            max_step,
            max_step_change,
        }
    }
}

/// Target and value sent. Values are absolute: a lost frame costs a cycle and no position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AbsoluteLedger {
    kind: ValueKind,
    target: i32,
    sent: i32,
    /// The values before it, newest first: a controller may give as many frames back.
    before: [i32; 3],
    /// Nobody has set a target since the values came to rest.
    rests: bool,
    /// Change of the value from the frame before to the latest.
    last_step: i32,
    /// The value of the frame that is being offered.
    offered: i32,
    ramp: Option<RampDown>,
}

impl AbsoluteLedger {
    /// A ledger whose values are all 0.
    #[must_use]
    pub fn new(kind: ValueKind) -> Self {
        Self {
            kind,
            ..Self::default()
        }
    }

    /// Nothing is owed and nothing changes.
    pub fn anchor(&mut self, value: i32) {
        *self = Self {
            target: value,
            sent: value,
            before: [value; 3],
            rests: true,
            ..Self::new(self.kind)
        };
    }

    /// Set-points end: the value stays, and what is owed is forgotten.
    pub fn end_motion(&mut self) {
        let before = self.before;
        self.anchor(self.sent);
        self.before = before;
    }

    /// The target.
    #[must_use]
    pub const fn target(&self) -> i32 {
        self.target
    }

    /// The value of the latest accepted frame.
    #[must_use]
    pub const fn sent(&self) -> i32 {
        self.sent
    }

    /// Sets the target; false, and no change, when it is outside the limits.
    #[must_use]
    pub fn accept_target(&mut self, target: i32, limits: &ValueLimits) -> bool {
        let is_inside = target >= limits.min && target <= limits.max;
        self.target = if is_inside { target } else { self.target };
        self.rests &= !is_inside;
        is_inside
    }

    /// The value of the next frame: towards the target by one step at most.
    pub fn offer(&mut self, limits: &ValueLimits) -> i32 {
        let most = i64::from(limits.max_step);
        let step = i64::from(self.target) - i64::from(self.sent);
        // Between two values of 32 bits.
        self.offered = (i64::from(self.sent) + step.max(-most).min(most)) as i32;
        self.offered
    }

    /// The controller accepted the frame that was offered.
    pub fn accepted(&mut self) {
        let [newest, older, _] = self.before;
        self.before = [self.sent, newest, older];
        self.last_step = self.offered.wrapping_sub(self.sent);
        self.sent = self.offered;
    }

    /// The controller gave the frame with this value back unsent, up to three of the latest ones: the drive stays at the value before
    /// it, or goes to the one behind it.
    pub fn returned(&mut self, value: i32) {
        let [newest, older, oldest] = self.before;
        self.last_step = 0;
        if value == self.sent {
            self.sent = newest;
            self.before = [older, oldest, oldest];
        } else if value == newest {
            self.before = [older, oldest, oldest];
        } else if value == older {
            self.before = [newest, oldest, oldest];
        }
        // A speed at rest stays 0.
        if self.rests && self.kind == ValueKind::Position {
            self.target = self.sent;
        }
    }

    /// Slows down from the present value in so many cycles.
    pub fn begin_ramp(&mut self, cycles: u32) {
        let ramp = match self.kind {
            ValueKind::Speed => RampDown::new(0, self.sent, cycles),
            ValueKind::Position => self.ramp_in(cycles),
        };
        self.target = self.sent;
        self.rests = false;
        self.ramp = Some(ramp);
    }

    const fn ramp_in(&self, cycles: u32) -> RampDown {
        RampDown::new(self.sent, self.last_step, cycles)
    }

    /// A cycle begins: a ramp goes on.
    pub fn begin_cycle(&mut self) {
        if let Some(ramp) = &mut self.ramp {
            ramp.advance();
            self.target = match self.kind {
                ValueKind::Speed => ramp.velocity(),
                ValueKind::Position => ramp.set_point(),
            };
        }
    }

    /// Cycles that the axis needs to stop within its limits.
    #[must_use]
    pub fn cycles_to_stop(&self, limits: &ValueLimits) -> u32 {
        match self.kind {
            ValueKind::Speed => RampDown::cycles_to_stop(self.sent, limits.max_step),
            ValueKind::Position => RampDown::cycles_to_stop(self.last_step, limits.max_step_change),
        }
    }

    /// Whether a position stays within the limits when it stops in so many cycles; a speed always ends at 0.
    #[must_use]
    pub const fn can_stop_in(&self, cycles: u32, limits: &ValueLimits) -> bool {
        match self.kind {
            ValueKind::Speed => true,
            ValueKind::Position => {
                let end = self.ramp_in(cycles).end();
                end >= limits.min && end <= limits.max
            }
        }
    }

    /// The ramp is through and nothing is owed.
    #[must_use]
    pub fn has_stopped(&self) -> bool {
        self.ramp.is_none_or(|ramp| ramp.is_done()) && self.target == self.sent
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn speeds_fall_in_proportion() {
        let ramp = |start| {
            let mut ledger = AbsoluteLedger::new(ValueKind::Speed);
            ledger.anchor(start);
            ledger.begin_ramp(4);
            [(); 5].map(|()| {
                ledger.begin_cycle();
                ledger.target()
            })
        };
        assert_eq!(ramp(100), [75, 50, 25, 0, 0]);
        assert_eq!(ramp(-40), [-30, -20, -10, 0, 0]);
    }

    #[test]
    fn a_returned_frame_does_not_let_the_next_one_carry_two_steps() {
        let limits = ValueLimits::new(0, 1_000, 10, 1);
        let mut ledger = AbsoluteLedger::new(ValueKind::Position);
        assert!(ledger.accept_target(500, &limits));
        assert_eq!(ledger.offer(&limits), 10);
        ledger.accepted();
        ledger.returned(10);
        assert_eq!(ledger.offer(&limits), 10);
        assert!(!ledger.accept_target(1_001, &limits) && !ledger.accept_target(-1, &limits));
        assert_eq!(ledger.target(), 500);
    }

    #[test]
    fn what_comes_back_after_the_end_of_motion_is_not_sent_in_one_step() {
        let limits = ValueLimits::new(0, 1_000, 10, 1);
        let mut ledger = AbsoluteLedger::new(ValueKind::Position);
        assert!(ledger.accept_target(500, &limits));
        for value in [10, 20, 30] {
            assert_eq!(ledger.offer(&limits), value);
            ledger.accepted();
        }
        ledger.end_motion();
        ledger.returned(30);
        ledger.returned(20);
        assert_eq!((ledger.sent(), ledger.target()), (10, 10));
        assert!(ledger.accept_target(500, &limits));
        assert_eq!(ledger.offer(&limits), 20);
        ledger.accepted();
        // One from the middle: the drive goes on to the latest.
        ledger.returned(10);
        assert_eq!(ledger.sent(), 20);
    }

    fn limits(min: i32, max: i32) -> ValueLimits {
        ValueLimits::new(min, max, 10, 4)
    }

    /// A ledger of positions that was anchored at a value and has sent so many frames towards a target.
    fn under_way(from: i32, target: i32, frames: usize) -> AbsoluteLedger {
        let mut ledger = AbsoluteLedger::new(ValueKind::Position);
        ledger.anchor(from);
        assert!(ledger.accept_target(target, &limits(-500, 500)));
        for _ in 0..frames {
            ledger.offer(&limits(-500, 500));
            ledger.accepted();
        }
        ledger
    }

    #[test]
    fn an_anchor_is_target_and_value_and_what_was_before() {
        let mut ledger = AbsoluteLedger::new(ValueKind::Position);
        ledger.anchor(70);
        assert_eq!((ledger.target(), ledger.sent()), (70, 70));
        assert_eq!(ledger.offer(&limits(0, 100)), 70);
        ledger.returned(70);
        assert_eq!((ledger.target(), ledger.sent()), (70, 70));
        assert!(ledger.has_stopped());
    }

    #[test]
    fn what_comes_back_in_motion_leaves_the_target() {
        let mut ledger = under_way(0, 400, 1);
        ledger.returned(10);
        assert_eq!((ledger.sent(), ledger.target()), (0, 400));
        assert!(!ledger.has_stopped());
    }

    #[test]
    fn up_to_three_frames_come_back_in_any_order() {
        let rests_at = |values: &[i32]| {
            let mut ledger = under_way(0, 400, 4);
            for value in values {
                ledger.returned(*value);
            }
            ledger.sent()
        };
        assert_eq!(rests_at(&[40]), 30);
        assert_eq!(rests_at(&[40, 30, 20]), 10);
        assert_eq!(rests_at(&[30]), 40);
        assert_eq!(rests_at(&[30, 40]), 20);
        assert_eq!(rests_at(&[20]), 40);
        assert_eq!(rests_at(&[20, 40]), 30);
        assert_eq!(rests_at(&[20, 40, 30]), 10);
        assert_eq!(rests_at(&[7]), 40);
        assert_eq!(rests_at(&[7, 40]), 30);
    }

    #[test]
    fn at_rest_the_target_of_a_position_follows_and_a_speed_stays() {
        let mut position = under_way(0, 400, 2);
        position.end_motion();
        // A target that is refused does not end the rest.
        assert!(!position.accept_target(501, &limits(-500, 500)));
        position.returned(20);
        assert_eq!((position.sent(), position.target()), (10, 10));
        let mut speed = AbsoluteLedger::new(ValueKind::Speed);
        assert!(speed.accept_target(20, &limits(-500, 500)));
        for _ in 0..2 {
            speed.offer(&limits(-500, 500));
            speed.accepted();
        }
        speed.end_motion();
        speed.returned(20);
        assert_eq!((speed.sent(), speed.target()), (10, 20));
    }

    #[test]
    fn a_stop_ends_within_the_limits_or_is_not_possible() {
        for (direction, bounds) in [(1, [(0, 30), (0, 29)]), (-1, [(-30, 0), (-29, 0)])] {
            let ledger = under_way(0, 400 * direction, 1);
            // Steps of 8, 6, 4, 2 and 0.
            let fits = bounds.map(|(min, max)| ledger.can_stop_in(5, &limits(min, max)));
            assert_eq!(fits, [true, false]);
            assert_eq!(ledger.cycles_to_stop(&limits(0, 30)), 3);
        }
        let mut speed = AbsoluteLedger::new(ValueKind::Speed);
        speed.anchor(-35);
        assert_eq!(speed.cycles_to_stop(&limits(0, 1)), 4);
        assert!(speed.can_stop_in(1, &limits(0, 1)));
    }

    #[test]
    fn a_ramp_is_through_when_its_last_value_is_sent() {
        let mut ledger = under_way(0, 400, 1);
        ledger.begin_ramp(5);
        let mut sent = [0; 5];
        for value in &mut sent {
            assert!(!ledger.has_stopped());
            ledger.begin_cycle();
            *value = ledger.offer(&limits(0, 500));
            ledger.accepted();
        }
        assert_eq!(sent, [18, 24, 28, 30, 30]);
        assert!(ledger.has_stopped());
        // One that has nothing to slow down takes its time all the same.
        let mut ledger = under_way(50, 50, 1);
        ledger.begin_ramp(2);
        assert!(!ledger.has_stopped());
        ledger.begin_cycle();
        ledger.begin_cycle();
        assert!(ledger.has_stopped());
        assert!(ledger.accept_target(60, &limits(0, 500)));
        assert!(!ledger.has_stopped());
    }

    proptest! {
        #[test]
        fn no_frame_changes_more_than_a_step(from in any::<i32>(), target in any::<i32>(), step in 1..=u32::MAX) {
            let mut ledger = AbsoluteLedger::new(ValueKind::Speed);
            ledger.anchor(from);
            let limits = ValueLimits::new(i32::MIN, i32::MAX, step, 1);
            prop_assert!(ledger.accept_target(target, &limits));
            let next = ledger.offer(&limits);
            prop_assert!(next.abs_diff(from) <= step);
            prop_assert!(next.abs_diff(target) <= from.abs_diff(target));
            prop_assert!(next == target || next.abs_diff(from) == step);
        }
    }
}
