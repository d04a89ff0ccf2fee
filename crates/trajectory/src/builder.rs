//! Puts segments together and makes their end exact.

use core::fmt;

use crate::fixed;
use crate::limits::{RangeError, State};
use crate::profile::Profile;
use crate::quantity::Position;
use crate::segment::Segment;

/// Why there is no profile.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum PlanError {
    /// Velocity or acceleration at the start is no number or beyond [`State::LARGEST`], or a velocity is asked for that the limits forbid.
    Range(RangeError),
    /// The move takes longer than [`Profile::LONGEST_CYCLES`].
    TooLong,
    /// The move goes further than 2^38 counts.
    TooFar,
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(error) => error.fmt(f),
            Self::TooLong => f.write_str(
                "the move takes longer than 2^31 cycles: raise the limits or shorten the move",
            ),
            Self::TooFar => f.write_str(
                "the move goes further than 2^38 counts: the start is too fast for the limits",
            ),
        }
    }
}

impl core::error::Error for PlanError {}

impl From<RangeError> for PlanError {
    fn from(error: RangeError) -> Self {
        Self::Range(error)
    }
}

/// Longest segment and longest profile, in cycles.
const LONGEST: f32 = Profile::LONGEST_CYCLES as f32;
const LONGEST_TICKS: u64 = (Profile::LONGEST_CYCLES as u64) << fixed::TIME_BITS;
/// A remainder of so many position units is rounding of the sum, below 2^-16 counts, and is not spread.
const ROUNDING: u64 = 16;
/// Times that the length of the cruise is refined, or what is left over is spread; each gains about 20 bits.
const REFINEMENTS: u32 = 2;

/// A profile under construction.
pub(crate) struct Builder {
    origin: Position,
    segments: [Segment; Profile::SEGMENTS],
    len: usize,
    /// Where the next segment starts: ticks and position units from the start of the profile.
    time: u64,
    position: i64,
    /// The segment at constant velocity whose length is free.
    cruise: Option<usize>,
}

impl Builder {
    pub(crate) const fn new(origin: Position) -> Self {
        Self {
            origin,
            segments: [Segment::EMPTY; Profile::SEGMENTS],
            len: 0,
            time: 0,
            position: 0,
            cruise: None,
        }
    }

    /// Counts from where the next segment starts to a position.
    pub(crate) fn distance_to(&self, target: Position) -> f32 {
        fixed::counts(self.remainder(target))
    }

    /// A segment of constant jerk; none when it is shorter than a tick.
    pub(crate) fn push(
        &mut self,
        cycles: f32,
        velocity: f32,
        acceleration: f32,
        jerk: f32,
    ) -> Result<(), PlanError> {
        if !(cycles <= LONGEST) {
            return Err(PlanError::TooLong);
        }
        let duration = fixed::scaled(cycles, fixed::TIME_BITS as i32).max(0) as u64;
        let segment = Segment {
            end: self.time + duration,
            position: self.position,
            velocity,
            correction: 0.0,
            acceleration,
            jerk,
        };
        if duration == 0 {
            return Ok(());
        }
        if segment.end > LONGEST_TICKS {
            return Err(PlanError::TooLong);
        }
        if !segment.fits(duration) {
            return Err(PlanError::TooFar);
        }
        // The solver never makes more segments than there is room for.
        if let Some(place) = self.segments.get_mut(self.len) {
            *place = segment;
            self.len += 1;
            self.time = segment.end;
            self.position = segment.position_at(duration, duration);
        }
        Ok(())
    }

    /// Constant velocity for about this time; [`Self::end_at`] changes it to make the end exact.
    pub(crate) fn push_cruise(&mut self, cycles: f32, velocity: f32) -> Result<(), PlanError> {
        let place = self.len;
        self.push(cycles, velocity, 0.0, 0.0)?;
        if self.len > place {
            self.cruise = Some(place);
        }
        Ok(())
    }

    /// Ends at rest exactly at the target.
    pub(crate) fn end_at(mut self, target: Position) -> Result<Profile, PlanError> {
        for _ in 0..REFINEMENTS {
            self.lengthen_cruise(self.remainder(target))?;
        }
        for _ in 0..REFINEMENTS {
            self.spread(self.remainder(target));
        }
        Ok(self.profile(target.distance_from(self.origin).units(), 0.0))
    }

    /// Goes on with this velocity for ever.
    pub(crate) fn go_on(self, velocity: f32) -> Profile {
        self.profile(self.position, velocity)
    }

    fn profile(&self, end_position: i64, end_velocity: f32) -> Profile {
        Profile::from_parts(
            self.origin,
            self.segments,
            self.len,
            self.time,
            end_position,
            end_velocity,
        )
    }

    fn remainder(&self, target: Position) -> i64 {
        target
            .distance_from(self.origin)
            .units()
            .wrapping_sub(self.position)
    }

    /// Cruises longer, or shorter but never less than nothing, by the time that a way takes.
    fn lengthen_cruise(&mut self, way: i64) -> Result<(), PlanError> {
        let Some(place) = self.cruise else {
            return Ok(());
        };
        let start = self.start_of(place);
        let Some(cruise) = self.segments.get_mut(place) else {
            return Ok(());
        };
        let before = cruise.end - start;
        let change = fixed::scaled(
            fixed::counts(way) / cruise.velocity,
            fixed::TIME_BITS as i32,
        );
        let duration = before.saturating_add_signed(change);
        if duration > LONGEST_TICKS {
            return Err(PlanError::TooLong);
        }
        if !cruise.fits(duration) {
            return Err(PlanError::TooFar);
        }
        for segment in self.used().iter_mut().skip(place) {
            segment.end = (segment.end - before).wrapping_add(duration);
        }
        self.recompute(place);
        Ok(())
    }

    /// Gives every segment its share of what rounding has left over, as a velocity, in proportion to the way that it goes.
    fn spread(&mut self, remainder: i64) {
        if remainder.unsigned_abs() <= ROUNDING {
            return;
        }
        let mut start = 0;
        let mut length = 0.0;
        for segment in self.used().iter() {
            let duration = segment.end - start;
            length += fixed::counts(segment.way(duration, duration)).abs();
            start = segment.end;
        }
        let share = fixed::counts(remainder) / length;
        start = 0;
        for segment in self.used().iter_mut() {
            let duration = segment.end - start;
            // A cruise may have become nothing.
            if duration > 0 {
                let way = fixed::counts(segment.way(duration, duration)).abs();
                segment.correction += share * way / fixed::cycles(duration);
            }
            start = segment.end;
        }
        self.recompute(0);
    }

    /// Start positions from a segment on, and the end.
    fn recompute(&mut self, place: usize) {
        let mut start = self.start_of(place);
        let mut position = None;
        for segment in self.used().iter_mut().skip(place) {
            segment.position = position.unwrap_or(segment.position);
            let duration = segment.end - start;
            position = Some(segment.position_at(duration, duration));
            start = segment.end;
        }
        self.time = start;
        self.position = position.unwrap_or(self.position);
    }

    fn start_of(&self, place: usize) -> u64 {
        place
            .checked_sub(1)
            .and_then(|before| self.segments.get(before))
            .map_or(0, |before| before.end)
    }

    fn used(&mut self) -> &mut [Segment] {
        self.segments.get_mut(..self.len).unwrap_or_default()
    }
}

impl Builder {
    /// A builder for a start that is in range.
    pub(crate) fn starting(start: &State) -> Result<Self, PlanError> {
        start.check()?;
        Ok(Self::new(start.position))
    }
}
