//! A planned move: position, velocity and acceleration at every time.

use crate::fixed;
use crate::limits::State;
use crate::quantity::{Position, Time};
use crate::segment::Segment;

/// A move of one axis: segments of constant jerk, and behind the last one rest, or a constant velocity for ever.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Profile {
    origin: Position,
    /// Behind the last segment, position units from the origin.
    pub(crate) end_position: i64,
    /// Ticks of the end of the last segment.
    pub(crate) end: u64,
    pub(crate) end_velocity: f32,
    len: u8,
    segments: [Segment; Self::SEGMENTS],
}

/// A stretch of constant jerk, for whoever checks a profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// When it starts.
    pub start: Time,
    /// How long it is.
    pub duration: Time,
    /// State at its start.
    pub state: State,
    /// What is to be added to the velocity: the share of this stretch in what rounding has left over, too small for the float.
    pub velocity_correction: f32,
    /// Counts per cycle³.
    pub jerk: f32,
}

impl Profile {
    /// Every move is shorter: 12 days at 1 kHz.
    pub const LONGEST_CYCLES: u32 = 1 << 30;
    /// Most segments: three to come back inside the limits, three to the highest velocity, one there, three to rest.
    pub(crate) const SEGMENTS: usize = 10;

    /// No move: rest at a count.
    #[must_use]
    pub const fn rest(counts: i32) -> Self {
        Self::starting(Position::from_counts(counts))
    }

    pub(crate) const fn starting(origin: Position) -> Self {
        Self {
            origin,
            end_position: 0,
            end: 0,
            end_velocity: 0.0,
            len: 0,
            segments: [Segment::EMPTY; Self::SEGMENTS],
        }
    }

    /// One segment more; returns its place. The solvers never make more segments than there is room for.
    pub(crate) fn add(&mut self, segment: Segment) -> Option<usize> {
        let place = usize::from(self.len);
        *self.segments.get_mut(place)? = segment;
        self.len += 1;
        Some(place)
    }

    /// Time from the start until it rests, or has reached its velocity.
    #[must_use]
    pub const fn duration(&self) -> Time {
        Time::from_ticks(self.end)
    }

    /// Whether it rests, or has reached its velocity, at this time.
    #[must_use]
    pub const fn is_done(&self, at: Time) -> bool {
        at.ticks() >= self.end
    }

    /// Where it starts.
    #[must_use]
    pub const fn start_position(&self) -> Position {
        self.origin
    }

    /// Where it rests, or reaches its velocity.
    #[must_use]
    pub const fn end_position(&self) -> Position {
        self.origin
            .moved_by(Position::from_units(self.end_position))
    }

    /// The position at a time since the start; the set-point is [`Position::counts`] of it.
    #[must_use]
    pub fn position(&self, at: Time) -> Position {
        let units = match self.segment(at.ticks()) {
            Some((segment, start)) => segment.position_at(
                at.ticks().wrapping_sub(start),
                segment.end.wrapping_sub(start),
            ),
            None => self.behind_the_end(at.ticks()),
        };
        self.origin.moved_by(Position::from_units(units))
    }

    /// The state at a time since the start, for instance to plan anew from there. At the border of two segments it is that of the
    /// later one.
    #[must_use]
    pub fn state(&self, at: Time) -> State {
        let (velocity, acceleration) = match self.segment(at.ticks()) {
            Some((segment, start)) => segment.motion_at(at.ticks().wrapping_sub(start)),
            None => (self.end_velocity, 0.0),
        };
        State {
            position: self.position(at),
            velocity,
            acceleration,
        }
    }

    /// The lowest and the highest position on the way, the ends included, to compare with a travel. Behind the end of a profile that
    /// goes on at a velocity there is no limit.
    #[must_use]
    pub fn extent(&self) -> (Position, Position) {
        let (mut lowest, mut highest) = (0.min(self.end_position), 0.max(self.end_position));
        let mut start = 0;
        for segment in self.used() {
            let duration = segment.end.wrapping_sub(start);
            for turn in turning_points(segment) {
                // Not for what is no number either.
                if turn > 0.0 && turn < fixed::cycles(duration) {
                    let elapsed = fixed::scaled(turn, fixed::TIME_BITS as i32) as u64;
                    let position = segment.position_at(elapsed.min(duration), duration);
                    lowest = lowest.min(position);
                    highest = highest.max(position);
                }
            }
            lowest = lowest.min(segment.position);
            highest = highest.max(segment.position);
            start = segment.end;
        }
        [lowest, highest]
            .map(|units| self.origin.moved_by(Position::from_units(units)))
            .into()
    }

    /// Its stretches of constant jerk in order. Behind the last one the state is that of [`Self::state`] at [`Self::duration`].
    pub fn stretches(&self) -> impl Iterator<Item = Stretch> + '_ {
        self.used().iter().scan(0, |start, segment| {
            let begin = *start;
            *start = segment.end;
            Some(Stretch {
                start: Time::from_ticks(begin),
                duration: Time::from_ticks(segment.end.wrapping_sub(begin)),
                state: State {
                    position: self.origin.moved_by(Position::from_units(segment.position)),
                    velocity: segment.velocity,
                    acceleration: segment.acceleration,
                },
                velocity_correction: segment.correction,
                jerk: segment.jerk,
            })
        })
    }

    fn behind_the_end(&self, ticks: u64) -> i64 {
        if self.end_velocity == 0.0 {
            return self.end_position;
        }
        let way = fixed::travelled(self.end_velocity, ticks.saturating_sub(self.end));
        self.end_position.wrapping_add(way)
    }

    /// The segment at a time, and the ticks at which it starts.
    fn segment(&self, ticks: u64) -> Option<(&Segment, u64)> {
        if ticks >= self.end {
            return None;
        }
        let mut start = 0;
        for segment in self.used() {
            if ticks < segment.end {
                return Some((segment, start));
            }
            start = segment.end;
        }
        None
    }

    pub(crate) fn used_mut(&mut self) -> &mut [Segment] {
        self.segments
            .get_mut(..usize::from(self.len))
            .unwrap_or_default()
    }

    pub(crate) fn used(&self) -> &[Segment] {
        self.segments
            .get(..usize::from(self.len))
            .unwrap_or_default()
    }
}

/// The times at which the velocity is zero, in cycles from the start of the segment; what is no number does not occur.
fn turning_points(segment: &Segment) -> [f32; 2] {
    let v = segment.velocity + segment.correction;
    let (a, j) = (segment.acceleration, segment.jerk);
    let root = libm::sqrtf(a * a - 2.0 * v * j);
    // The root that does not cancel first, the other one from the product of both.
    let sum = if a < 0.0 { root - a } else { -root - a };
    [sum / j, 2.0 * v / sum]
}
