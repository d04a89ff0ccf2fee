//! Where the axes are in each cycle, and at which rate the time of the set-points runs.

use trajectory::curve::Share;
use trajectory::{Position, TimeScaleError};

use crate::buffer::{Phase, SetPointBuffer};
use crate::rate::ONE;

impl<const AXES: usize, const POINTS: usize> SetPointBuffer<AXES, POINTS> {
    /// One cycle later: writes the positions of the axes and says what they do.
    pub fn advance(&mut self, positions: &mut [Position]) -> Phase {
        if matches!(self.phase, Phase::Waiting | Phase::Dry) {
            self.start();
        }
        if self.phase == Phase::Moving {
            self.go_on();
        }
        self.write(positions);
        self.phase
    }

    /// Slows down to a standstill on the way, and waits.
    pub const fn pause(&mut self) {
        self.is_paused = true;
    }

    /// Goes on.
    pub const fn resume(&mut self) {
        self.is_paused = false;
    }

    /// Whether it is paused.
    #[must_use]
    pub const fn is_paused(&self) -> bool {
        self.is_paused
    }

    /// Slows down to a standstill on the way, and ends; no set-point is taken any more.
    pub fn stop(&mut self) {
        self.is_stopping = true;
        if matches!(self.phase, Phase::Waiting | Phase::Dry) {
            self.phase = Phase::Stopped;
        }
    }

    /// Another speed than that of the sender's clock. Where the limits of an axis allow less, it is held to that:
    /// [`Self::highest_percent`].
    ///
    /// # Errors
    /// [`TimeScaleError::Override`] above 200 %.
    pub fn set_override(&mut self, percent: u16) -> Result<(), TimeScaleError> {
        if percent > trajectory::TimeScale::MOST_PERCENT {
            return Err(TimeScaleError::Override {
                actual_percent: percent,
            });
        }
        self.override_rate = i64::from(percent) * ONE / 100;
        Ok(())
    }

    /// Percent of the speed of the sender's clock.
    #[must_use]
    pub fn percent(&self) -> f32 {
        100.0 * self.rate.value()
    }

    /// The highest percentage that the limits allow for the set-points that are buffered.
    #[must_use]
    pub fn highest_percent(&self) -> f32 {
        100.0 * self.highest_rate as f32 / ONE as f32
    }

    fn start(&mut self) {
        let has_motion = self.knots.len() > self.place.saturating_add(1);
        let complete = self.complete_until();
        let has_lead = complete.since(self.time) >= self.config.lead;
        // Whoever has no credit sends nothing that could be waited for.
        if has_motion && (has_lead || self.is_ended || self.credit() == 0) {
            self.phase = Phase::Moving;
            self.enter();
        } else if self.is_ended && !self.is_late {
            // One set-point alone, which is where the axes stand.
            self.phase = Phase::Complete;
        }
    }

    /// The time until which the curve is complete: the last set-point may still be its end.
    fn complete_until(&self) -> trajectory::Time {
        let before_last = self.last_place().checked_sub(1);
        let knot = before_last.and_then(|place| self.knot(place));
        knot.map_or(self.time, |knot| knot.time)
    }

    fn go_on(&mut self) {
        let goal = self.goal();
        self.time = self.time.after(self.rate.advance(goal));
        while let Some((time, rests)) = self
            .knot(self.place.saturating_add(1))
            .map(|knot| (knot.time, knot.rests))
            && self.time >= time
        {
            self.place = self.place.saturating_add(1);
            if rests {
                self.time = time;
                self.arrive();
                return;
            }
            self.enter();
        }
        if self.is_stopping && self.rate.is_standing() {
            self.phase = Phase::Stopped;
        }
    }

    /// The rate to go to.
    fn goal(&mut self) -> i64 {
        if self.is_paused || self.is_stopping || self.override_rate == 0 {
            return 0;
        }
        let goal = self.override_rate.min(self.highest_rate);
        if self.place.saturating_add(1) >= self.last_place() {
            return goal;
        }
        // As long as more may come, anything may come: then it slows down to a standstill.
        let is_last = self.is_ended || self.knots.back().is_some_and(|last| last.rests);
        let floor = if is_last { self.last_rate } else { 0 };
        let left = self.complete_until().since(self.time).cycles();
        let way = self.rate.way_down_after_a_rise_to(floor);
        self.is_short |= way >= left && left > 0.0;
        if !self.is_short {
            return goal;
        }
        if !is_last && self.rate.is_standing() {
            self.give_up_waiting();
            return goal.min(self.last_rate);
        }
        goal.min(floor)
    }

    /// The curve from the knot at the present place.
    fn enter(&mut self) {
        if self.place.saturating_add(1) == self.last_place() {
            self.give_up_waiting();
        }
        for axis in 0..self.axes {
            if let (Some(stretch), Some(piece)) =
                (self.stretch(self.place, axis), self.pieces.get_mut(axis))
            {
                *piece = stretch.piece();
            }
        }
        self.forget_old();
        self.find_highest_rate();
    }

    /// Nothing has come behind the last set-point in time, so the axes come to rest there.
    fn give_up_waiting(&mut self) {
        let (before, rate) = (self.last_place().saturating_sub(1), self.last_rate);
        if self.knots.back().is_none_or(|last| last.rests) {
            return;
        }
        if let Some(knot) = self.knots.get_mut(before) {
            knot.highest_rate = rate;
        }
        if let Some(last) = self.knots.back_mut() {
            last.rests = true;
        }
        if !self.is_ended {
            self.counters.dry = self.counters.dry.saturating_add(1);
            self.is_late = !self.waits_when_dry();
        }
    }

    /// At rest at a knot.
    fn arrive(&mut self) {
        // Velocity and acceleration of the curve are zero here, whatever the rate.
        self.rate.stand();
        if let Some(knot) = self.knot(self.place) {
            self.stand = knot.positions;
        }
        let has_more = self.place < self.last_place();
        self.phase = if self.is_stopping {
            Phase::Stopped
        } else if self.is_late {
            Phase::DriedUp
        } else if self.is_ended && !has_more {
            Phase::Complete
        } else {
            Phase::Dry
        };
        self.pieces = self
            .stand
            .map(|stand| trajectory::curve::Piece::line(stand, stand));
    }

    fn write(&self, positions: &mut [Position]) {
        let (from, to) = (
            self.knot(self.place),
            self.knot(self.place.saturating_add(1)),
        );
        let share = match (from, to) {
            (Some(from), Some(to)) => Share::of(
                self.time.since(from.time).ticks(),
                to.time.since(from.time).ticks(),
            ),
            _ => Share::of(0, 1),
        };
        for (position, piece) in positions.iter_mut().zip(&self.pieces).take(self.axes) {
            *position = piece.at(share);
        }
    }

    /// Forgets set-points that neither the curve nor the means need.
    pub(crate) fn forget_old(&mut self) {
        while self.place > 0
            && let (Some(second), Some(last)) = (self.knot(1), self.knots.back())
            && last.time.since(second.time) >= twice(self.config.window)
        {
            self.knots.pop_front();
            self.place -= 1;
        }
    }

    pub(crate) fn find_highest_rate(&mut self) {
        // The last stretch counts as soon as the motion is in it; before that it is braked for.
        let end = self
            .last_place()
            .saturating_sub(1)
            .max(self.place.saturating_add(1));
        let ahead = (self.place..end).filter_map(|place| self.knot(place));
        self.highest_rate = ahead.map(|knot| knot.highest_rate).min().unwrap_or(ONE);
    }
}

fn twice(time: trajectory::Time) -> trajectory::Time {
    time.after(time)
}
