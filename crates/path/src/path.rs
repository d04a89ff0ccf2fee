//! The path: pieces go in, set-points come out.

use trajectory::{Limits, Position};

use crate::bounds;
use crate::error::PathError;
use crate::filter::LONGEST;
use crate::inbox::Inbox;
use crate::known::Known;
use crate::machine::Machine;
use crate::preparation::{Axes, LEAST_ACCELERATION, Preparation, Progress};
use crate::request::{Arc, Join, LEAST_RADIUS, inside};
use crate::tool::Tool;

/// A path in a space of `SPACE` coordinates, for a machine of `AXES` axes, with a queue of `QUEUE` pieces; a blend is one of them.
///
/// What is added waits until it is prepared, which [`Self::advance`] does step by step: a piece and its blend take 10 to 20 cycles; where
/// the queue has hundreds of pieces, several are prepared in a cycle.
///
/// See the [crate](crate) for an example.
#[derive(Debug, Clone)]
pub struct Path<M, const SPACE: usize, const AXES: usize, const QUEUE: usize> {
    axes: Axes<M, AXES>,
    inbox: Inbox<SPACE>,
    preparation: Preparation<SPACE, AXES>,
    known: Known<SPACE, QUEUE>,
    tool: Tool<SPACE>,
    /// Instructions that pieces have taken since the last cycle.
    spent: u32,
    /// At rest before a piece: the place up to which the path should be known before the front goes on.
    until_known: Option<i64>,
    rate: f32,
    most_rate: f32,
    is_paused: bool,
    is_stopping: bool,
}

/// Instructions of a cycle, about, after which nothing more is prepared in it.
const BUDGET: u32 = 1_110;
/// What a cycle takes that prepares nothing, and what a piece takes that is added.
const CYCLE: u32 = 590;
const LINE: u32 = 250;
const ARC: u32 = 500;
/// What planning a piece takes.
const PLANNED: u32 = 150;
/// What the shortest step of a preparation takes, and planning a piece.
const LEAST_STEP: u32 = 130;
/// More for each piece of a queue of hundreds.
const LONG_QUEUE: usize = 64;
const PER_PIECE: u32 = 64;

impl<M, const SPACE: usize, const AXES: usize, const QUEUE: usize> Path<M, SPACE, AXES, QUEUE>
where
    M: Machine<SPACE, AXES>,
{
    /// Largest coordinate, in units.
    pub const FARTHEST: i64 = 1 << 28;
    /// Largest override, in percent.
    pub const MOST_PERCENT: u16 = 200;

    /// A path that starts at rest at a place, with the limits of each axis in counts per cycle.
    ///
    /// # Errors
    /// [`PathError::Far`]; [`PathError::Limits`] when an axis could not move along the smallest arc.
    pub fn new(
        machine: M,
        limits: [Limits; AXES],
        start: [Position; SPACE],
    ) -> Result<Self, PathError> {
        let start = inside(start)?;
        let cycles = limits.iter().fold(1.0_f32, |cycles, limits| {
            cycles.max(2.0 * limits.acceleration() / limits.jerk())
        });
        // Rounded up; no more than there is room for.
        let count = (cycles as usize + 1).min(LONGEST);
        let cycles = count as f32;
        let (velocity, acceleration) = bounds::least(&machine, &limits, 1.0 / LEAST_RADIUS, cycles);
        if !(velocity > LEAST_ACCELERATION && acceleration > LEAST_ACCELERATION) {
            return Err(PathError::Limits);
        }
        Ok(Self {
            axes: Axes {
                machine,
                limits,
                cycles,
            },
            inbox: Inbox::at(start),
            preparation: Preparation::IDLE,
            known: Known::nothing(count),
            tool: Tool::new(count, start),
            spent: 0,
            until_known: None,
            rate: 1.0,
            most_rate: 1.0,
            is_paused: false,
            is_stopping: false,
        })
    }

    /// Pieces that are prepared from now on can be passed at up to this share of their feeds, in percent: 100 unless this is called. With
    /// more the tool begins to brake earlier.
    pub fn set_most_override(&mut self, percent: u16) {
        self.most_rate = f32::from(percent.clamp(1, Self::MOST_PERCENT)) * 0.01;
    }

    /// The share of their feeds at which the pieces are passed, in percent; more than [`Self::set_most_override`] is that.
    pub fn set_override(&mut self, percent: u16) {
        self.rate = (f32::from(percent) * 0.01).min(self.most_rate);
    }

    /// Brakes along the path, and stands until [`Self::resume`].
    pub const fn pause(&mut self) {
        self.is_paused = true;
    }

    /// Goes on.
    pub const fn resume(&mut self) {
        self.is_paused = false;
    }

    /// Brakes along the path and gives up the rest of it. Once [`Self::is_at_rest`], new pieces start where the tool is then.
    pub const fn stop(&mut self) {
        self.is_stopping = true;
    }

    /// Whether the tool stands.
    #[must_use]
    pub const fn is_at_rest(&self) -> bool {
        self.known.front.is_at_rest() && self.tool.average.is_at_rest()
    }

    /// Whether the tool stands at the end of everything that was added.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.is_at_rest() && self.inbox.is_empty() && self.known.is_at_end()
    }

    /// Whether there is room for another piece.
    #[must_use]
    pub const fn has_room(&self) -> bool {
        self.inbox.has_room()
    }

    /// The place of the tool.
    #[must_use]
    pub fn place(&self) -> [Position; SPACE] {
        self.tool.place.map(Position::from_units)
    }

    /// Where the path ends.
    #[must_use]
    pub fn end(&self) -> [Position; SPACE] {
        self.inbox.end.map(Position::from_units)
    }

    /// The velocity of the tool along the path, in units per cycle.
    #[must_use]
    pub fn velocity(&self) -> f32 {
        self.tool.average.velocity()
    }

    /// A straight line from the end of the path, at a feed in units per cycle. A line shorter than 2^-8 units is left out.
    ///
    /// # Errors
    /// [`PathError`]; the path is then what it was.
    #[inline(never)]
    pub fn line(&mut self, end: [Position; SPACE], feed: f32, join: Join) -> Result<(), PathError> {
        self.take(LINE, |inbox| inbox.line(&end, feed, join))
    }

    /// An arc from the end of the path, at a feed in units per cycle.
    ///
    /// # Errors
    /// [`PathError`]; the path is then what it was.
    #[inline(never)]
    pub fn arc(&mut self, arc: &Arc<SPACE>, feed: f32, join: Join) -> Result<(), PathError> {
        self.take(ARC, |inbox| inbox.arc(arc, feed, join))
    }

    /// What is refused or left out is not counted: whoever asks in every cycle must not take the time of all of them.
    fn take(
        &mut self,
        cost: u32,
        add: impl FnOnce(&mut Inbox<SPACE>) -> Result<bool, PathError>,
    ) -> Result<(), PathError> {
        if self.is_stopping {
            return Err(PathError::Stopping);
        }
        if add(&mut self.inbox)? {
            self.spent = self.spent.saturating_add(cost);
        }
        Ok(())
    }

    /// The next cycle: the positions of the axes in counts.
    pub fn advance(&mut self) -> [Position; AXES] {
        let rate = if self.is_paused || self.is_stopping || self.waits() {
            0.0
        } else {
            self.rate
        };
        let pieces = core::mem::take(&mut self.spent);
        // A long queue has a time of its own.
        let has_time = pieces == 0 || QUEUE > LONG_QUEUE;
        let front = self.known.advance(rate, has_time);
        let moves = self.tool.follow(&self.known.front, &self.known.ring);
        let spent = CYCLE + pieces + front + self.tool.cost();
        if moves {
            if has_time {
                self.known.forget_before(self.tool.piece());
            }
        } else if self.known.front.is_at_rest() {
            self.rest();
        }
        if spent + LEAST_STEP <= BUDGET || QUEUE > LONG_QUEUE {
            self.work(spent);
        }
        self.axes.machine.axes(self.place())
    }

    /// Prepares and plans as much as a cycle has time for.
    #[inline(never)]
    fn work(&mut self, spent: u32) {
        let mut left = BUDGET.saturating_sub(spent);
        if QUEUE > LONG_QUEUE {
            left += QUEUE as u32 * PER_PIECE;
        }
        loop {
            let is_planned = self.known.plan.is_done();
            let cost = if is_planned {
                self.preparation.cost()
            } else {
                PLANNED
            };
            if cost > left {
                return;
            }
            left -= cost;
            if !is_planned {
                self.known.plan_some();
            } else if !self.prepare() {
                return;
            }
        }
    }

    /// A step with the next request, if there is one and room for it and its blend.
    fn prepare(&mut self) -> bool {
        let Some(request) = self.inbox.first() else {
            return false;
        };
        if !self.known.has_room() || self.is_stopping {
            return false;
        }
        let (rate, axes, known) = (self.most_rate, &self.axes, &mut self.known);
        match self.preparation.advance(request, rate, axes, known) {
            Progress::Unfinished => {}
            Progress::Added { is_alone } => {
                self.inbox.pop();
                if is_alone {
                    self.begin(self.known.ring.end() - 1);
                }
            }
        }
        true
    }

    /// Whether more of the path should be known before the front leaves the place where it stands.
    fn waits(&mut self) -> bool {
        let Some(until) = self.until_known else {
            return false;
        };
        if self.inbox.is_empty() || self.known.reaches(until) {
            self.until_known = None;
        }
        self.until_known.is_some()
    }

    /// Front and tool stand.
    fn rest(&mut self) {
        if self.is_stopping {
            self.give_up();
            return;
        }
        if let Some(next) = self.known.rest(self.tool.piece()) {
            self.begin(next);
        }
    }

    /// The rest of the path is forgotten.
    fn give_up(&mut self) {
        self.known.forget();
        self.inbox.restart(self.tool.place);
        self.preparation.restart();
        self.until_known = None;
        self.is_stopping = false;
        self.tool.wait_for(self.known.ring.end());
    }

    /// Front and tool at the start of a piece, from rest.
    fn begin(&mut self, place: usize) {
        if let Some((from, until)) = self.known.begin(place) {
            self.tool.begin(place, from);
            self.until_known = Some(until);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{Cartesian, Scale};

    /// After weeks without an end the way would come to the end of 64 bits: at a rest it is counted anew.
    #[test]
    fn a_path_goes_on_beyond_what_64_bits_hold() {
        let limits = Limits::new(5_000.0, 20.0, 2.0).unwrap();
        let machine = Cartesian {
            scales: [Scale::ONE],
        };
        let mut path = Path::<_, 1, 1, 24>::new(machine, [limits], [Position::ZERO]).unwrap();
        path.known.front.place = (1 << 61) - (1 << 38);
        for stroke in 0..11 {
            let end = if stroke % 2 == 0 { 1 << 19 } else { 0 };
            path.line([Position::from_counts(end)], 4_000.0, Join::Exact)
                .unwrap();
            let mut at = path.place()[0];
            for _ in 0..5_000 {
                let next = path.advance()[0];
                let step = next.distance_from(at).units().unsigned_abs();
                assert!(step <= 4_001 * Position::UNITS as u64, "{step}");
                at = next;
            }
            assert!(path.is_done());
            assert_eq!(path.place()[0].counts(), end);
        }
        assert!(path.known.front.place < 1 << 60);
    }
}
