//! Puts segments together and makes their end exact.

use core::fmt;

use crate::fixed;
use crate::limits::{Limits, RangeError, State};
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
    /// The move goes further than 2^34 counts.
    TooFar,
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(error) => error.fmt(f),
            Self::TooLong => f.write_str(
                "the move takes longer than 2^30 cycles: raise the limits or shorten the move",
            ),
            Self::TooFar => f.write_str(
                "the move goes further than 2^34 counts: the start is too fast for the limits",
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
/// A remainder of so many position units, 2^-18 counts, is rounding of the sum, and is not spread.
const ROUNDING: u64 = 64;
/// A velocity of at most this share of its limit stays below the limit whatever is spread.
const ROOM: f32 = 1.0 - 1.0 / 524_288.0;
/// Times that the length of the cruise is refined, or what is left over is spread; each gains about 20 bits.
const REFINEMENTS: u32 = 2;

/// A profile under construction: its end is where the next segment starts.
pub(crate) struct Builder {
    profile: Profile,
    /// The place of the segment at constant velocity whose length is free.
    cruise: Option<usize>,
    /// Below this velocity there is room for what is spread.
    room: f32,
}

impl Builder {
    /// Nothing yet, for a start that is in range.
    pub(crate) fn starting(start: &State, limits: &Limits) -> Result<Self, PlanError> {
        start.check()?;
        Ok(Self {
            profile: Profile::starting(start.position),
            cruise: None,
            room: limits.velocity() * ROOM,
        })
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
        self.add(cycles, velocity, acceleration, jerk).map(drop)
    }

    /// Constant velocity for about this time; [`Self::end_at`] changes it to make the end exact.
    pub(crate) fn push_cruise(&mut self, cycles: f32, velocity: f32) -> Result<(), PlanError> {
        self.cruise = self.add(cycles, velocity, 0.0, 0.0)?;
        Ok(())
    }

    /// Returns the place of the segment.
    fn add(
        &mut self,
        cycles: f32,
        velocity: f32,
        acceleration: f32,
        jerk: f32,
    ) -> Result<Option<usize>, PlanError> {
        if cycles.is_nan() || cycles >= LONGEST {
            return Err(PlanError::TooLong);
        }
        let duration = fixed::scaled(cycles, fixed::TIME_BITS as i32).max(0) as u64;
        if duration == 0 {
            return Ok(None);
        }
        let segment = Segment {
            end: self.profile.end + duration,
            position: self.profile.end_position,
            velocity,
            correction: 0.0,
            acceleration,
            jerk,
        };
        check(&segment, duration)?;
        self.profile.end = segment.end;
        self.profile.end_position = segment.position_at(duration, duration);
        Ok(self.profile.add(segment))
    }

    /// Ends at rest exactly at the target.
    pub(crate) fn end_at(&mut self, target: Position) -> Result<(), PlanError> {
        for _ in 0..REFINEMENTS {
            self.lengthen_cruise(self.remainder(target))?;
        }
        for _ in 0..REFINEMENTS {
            self.spread(self.remainder(target));
        }
        self.profile.end_position += self.remainder(target);
        Ok(())
    }

    /// Goes on with this velocity for ever.
    pub(crate) fn go_on(&mut self, velocity: f32) {
        self.profile.end_velocity = velocity;
    }

    pub(crate) fn finish(self) -> Profile {
        self.profile
    }

    fn remainder(&self, target: Position) -> i64 {
        target.distance_from(self.profile.end_position()).units()
    }

    /// Cruises longer, or shorter but never less than nothing, by the time that a way takes.
    #[inline(never)]
    fn lengthen_cruise(&mut self, way: i64) -> Result<(), PlanError> {
        let Some(place) = self.cruise else {
            return Ok(());
        };
        let start = self.start_of(place);
        let segments = self.profile.used_mut();
        let Some(cruise) = segments.get(place) else {
            return Ok(());
        };
        let before = cruise.end - start;
        let cycles = fixed::counts(way) / cruise.velocity;
        if cycles.is_nan() || cycles.abs() >= LONGEST {
            return Err(PlanError::TooLong);
        }
        let change = fixed::scaled(cycles, fixed::TIME_BITS as i32);
        let duration = before.saturating_add_signed(change);
        let cruise = Segment {
            end: start.saturating_add(duration),
            ..*cruise
        };
        check(&cruise, duration)?;
        for segment in segments.iter_mut().skip(place) {
            segment.end = (segment.end - before).wrapping_add(duration);
        }
        self.recompute(place);
        Ok(())
    }

    /// Gives the segments their shares of what rounding has left over, as a velocity, in proportion to the way that each goes. Those that
    /// are at the limit already, because the start was, get none that would lead beyond it, where there are others.
    #[inline(never)]
    fn spread(&mut self, remainder: i64) {
        if remainder.unsigned_abs() <= ROUNDING {
            return;
        }
        let counts = fixed::counts(remainder);
        let (roomy, all) = self.lengths(counts);
        let (length, room) = if roomy > 0.125 * all {
            (roomy, self.room)
        } else {
            (all, f32::INFINITY)
        };
        // No way at all, to the last digit.
        if length == 0.0 {
            return;
        }
        let share = counts / length;
        let mut start = 0;
        for segment in self.profile.used_mut() {
            let duration = segment.end - start;
            // A cruise may have become nothing.
            if duration > 0 && segment.velocity_towards(counts, duration) <= room {
                let way = fixed::counts(segment.way(duration, duration)).abs();
                segment.correction += share * way / fixed::cycles(duration);
            }
            start = segment.end;
        }
        self.recompute(0);
    }

    /// The way of the segments that have room for a velocity in this direction, and of all.
    fn lengths(&self, direction: f32) -> (f32, f32) {
        let (mut roomy, mut all) = (0.0, 0.0);
        let mut start = 0;
        for segment in self.profile.used() {
            let duration = segment.end - start;
            let way = fixed::counts(segment.way(duration, duration)).abs();
            all += way;
            if segment.velocity_towards(direction, duration) <= self.room {
                roomy += way;
            }
            start = segment.end;
        }
        (roomy, all)
    }

    /// Start positions behind a segment, and the end.
    #[inline(never)]
    fn recompute(&mut self, place: usize) {
        let mut start = self.start_of(place);
        let mut position = None;
        for segment in self.profile.used_mut().iter_mut().skip(place) {
            segment.position = position.unwrap_or(segment.position);
            let duration = segment.end - start;
            position = Some(segment.position_at(duration, duration));
            start = segment.end;
        }
        self.profile.end = start;
        if let Some(position) = position {
            self.profile.end_position = position;
        }
    }

    fn start_of(&self, place: usize) -> u64 {
        place
            .checked_sub(1)
            .and_then(|before| self.profile.used().get(before))
            .map_or(0, |before| before.end)
    }
}

/// Whether a segment may be part of a profile.
fn check(segment: &Segment, duration: u64) -> Result<(), PlanError> {
    if segment.end >= LONGEST_TICKS {
        return Err(PlanError::TooLong);
    }
    if !segment.fits(duration) {
        return Err(PlanError::TooFar);
    }
    Ok(())
}
