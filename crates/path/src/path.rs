//! The path: pieces go in, set-points come out.

use trajectory::fixed::part_of;
use trajectory::{Limits, Position};

use crate::bounds::{Pace, pace};
use crate::corner::{Corner, corner};
use crate::error::PathError;
use crate::filter::{Average, LONGEST};
use crate::front::{Front, SEARCH_CYCLES};
use crate::length;
use crate::machine::Machine;
use crate::order::Order as _;
use crate::queue::{Piece, Ring, Room};
use crate::shape::{self, Point, Shape};

/// Pieces that are planned anew in a cycle; more where a queue is long, fewer where the front has
/// had much to do.
const PLANNED_IN_A_CYCLE: usize = 3;
/// Cycles that limits are in force before and behind what the average needs: set-points are compared over three cycles.
const EDGE_CYCLES: f32 = 3.0;

/// Cycles of the front that it may be behind a border when it learns of it.
const BEHIND: f32 = 1.5 + SEARCH_CYCLES as f32;

/// How a piece follows the one before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Join {
    /// At rest, unless tangent and curvature are the same: the tool passes every corner exactly.
    Exact,
    /// Through a curve that is nowhere further than this many units from the corner; at rest where no curve is, or where it would
    /// turn back.
    Blend(f32),
    /// At rest.
    Rest,
}

/// An arc of a circle in a plane of two coordinates; with an end elsewhere in the others it is a helix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Arc<const SPACE: usize> {
    /// The two coordinates of its plane, counted from 0.
    pub plane: (usize, usize),
    /// Its centre in that plane.
    pub centre: [Position; 2],
    /// Its sweep in 2^-32 turns, positive from the first coordinate to the second. Any number of turns.
    pub sweep: i64,
    /// Its end.
    pub end: [Position; SPACE],
}

/// A path in a space of `SPACE` coordinates, for a machine of `AXES` axes, with a queue of `QUEUE` pieces; a blend is one of them.
///
/// See the [crate](crate) for an example.
#[derive(Debug, Clone)]
pub struct Path<M, const SPACE: usize, const AXES: usize, const QUEUE: usize> {
    machine: M,
    limits: [Limits; AXES],
    ring: Ring<SPACE, QUEUE>,
    front: Front,
    average: Average,
    /// One over the cycles of the average, 64 bits behind the point.
    share: u64,
    /// The piece of the tool, and its way in it times the cycles of the average.
    tool: usize,
    tool_way: i64,
    /// Where the tool is, and where the known path ends.
    place: Point<SPACE>,
    end: Point<SPACE>,
    /// The piece to be planned anew, and the place before which the front must be able to stop until that has been done.
    plan: Option<usize>,
    guard: Option<Guard>,
    /// The same of pieces that have come since the planning began.
    later: Option<Guard>,
    rate: f32,
    most_rate: f32,
    is_paused: bool,
    is_stopping: bool,
}

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
    /// [`PathError::Far`].
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
        let cycles = (cycles as usize + 1).min(LONGEST);
        Ok(Self {
            machine,
            limits,
            ring: Ring::new(),
            front: Front::START,
            average: Average::new(cycles),
            share: u64::MAX.checked_div(cycles as u64).unwrap_or(u64::MAX),
            tool: 0,
            tool_way: 0,
            place: start,
            end: start,
            plan: None,
            guard: None,
            later: None,
            rate: 1.0,
            most_rate: 1.0,
            is_paused: false,
            is_stopping: false,
        })
    }

    /// Pieces that are planned from now on can be passed at up to this share of their feeds, in percent: 100 unless this is called. With
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
        self.front.is_at_rest() && self.average.is_at_rest()
    }

    /// Whether the tool stands at the end of everything that is known.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.is_at_rest() && self.front.piece + 1 >= self.ring.end() && {
            let piece = self.ring.get(self.front.piece);
            piece.is_none_or(|piece| self.front.place >= piece.end())
        }
    }

    /// Whether there is room for any piece, and for the blend before it.
    #[must_use]
    pub const fn has_room(&self) -> bool {
        self.ring.free() >= 2
    }

    /// The place of the tool.
    #[must_use]
    pub fn place(&self) -> [Position; SPACE] {
        self.place.map(Position::from_units)
    }

    /// Where the known path ends.
    #[must_use]
    pub fn end(&self) -> [Position; SPACE] {
        self.end.map(Position::from_units)
    }

    /// The velocity of the tool along the path, in units per cycle.
    #[must_use]
    pub fn velocity(&self) -> f32 {
        self.average.velocity()
    }

    /// A straight line from the end of the path, at a feed in units per cycle. A line shorter than 2^-8 units is left out.
    ///
    /// # Errors
    /// [`PathError`]; the path is then what it was.
    #[inline(never)]
    pub fn line(&mut self, end: [Position; SPACE], feed: f32, join: Join) -> Result<(), PathError> {
        let end = self.check(end, feed, join)?;
        let mut way = end;
        for (way, from) in way.iter_mut().zip(self.end) {
            *way -= from;
        }
        let length = length::from_units(shape::norm(&way.map(shape::coordinate)));
        if length < SHORTEST {
            return Ok(());
        }
        let shape = Shape::line(self.end, way, length);
        self.append(shape, length, end, feed, join)
    }

    /// An arc from the end of the path, at a feed in units per cycle.
    ///
    /// # Errors
    /// [`PathError`]; the path is then what it was.
    #[inline(never)]
    pub fn arc(&mut self, arc: &Arc<SPACE>, feed: f32, join: Join) -> Result<(), PathError> {
        let end = self.check(arc.end, feed, join)?;
        let plane = arc.plane;
        let (Some(first), Some(second)) = (self.end.get(plane.0), self.end.get(plane.1)) else {
            return Err(PathError::Plane { actual: plane });
        };
        if plane.0 == plane.1 {
            return Err(PathError::Plane { actual: plane });
        }
        let [c1, c2] = inside(arc.centre)?;
        let radial = [first - c1, second - c2];
        let radius = shape::radius(radial);
        if !(radius >= LEAST_RADIUS && radius <= Self::FARTHEST as f32) {
            return Err(PathError::Radius { actual: radius });
        }
        let length = self.arc_length(arc, end, radial, radius)?;
        if length < SHORTEST {
            return Ok(());
        }
        let shape = Shape::arc(self.end, end, plane, radial, arc.sweep, length);
        self.append(shape, length, end, feed, join)
    }

    fn arc_length(
        &self,
        arc: &Arc<SPACE>,
        end: Point<SPACE>,
        radial: [i64; 2],
        radius: f32,
    ) -> Result<i64, PathError> {
        let turned = shape::turned(radial, arc.sweep as u32);
        let (mut missed, mut across) = ([0.0; 2], 0.0);
        for (place, (end, from)) in end.iter().zip(self.end).enumerate() {
            let way = end - from;
            if place == arc.plane.0 {
                missed[0] = shape::coordinate(way - turned[0]);
            } else if place == arc.plane.1 {
                missed[1] = shape::coordinate(way - turned[1]);
            } else {
                across += shape::coordinate(way) * shape::coordinate(way);
            }
        }
        let (actual, most) = (shape::norm(&missed), radius / 64.0);
        if actual > most {
            return Err(PathError::End { actual, most });
        }
        let turns = length::to_float(arc.sweep, 32);
        let round = turns * core::f32::consts::TAU * radius;
        let length = crate::roots::square_root(round * round + across);
        if length > LONGEST_PIECE {
            return Err(PathError::Radius { actual: radius });
        }
        Ok(length::from_units(length))
    }

    fn check(
        &self,
        end: [Position; SPACE],
        feed: f32,
        join: Join,
    ) -> Result<Point<SPACE>, PathError> {
        if self.is_stopping {
            return Err(PathError::Stopping);
        }
        if !self.has_room() {
            return Err(PathError::Full);
        }
        let tolerance = match join {
            Join::Blend(tolerance) => tolerance,
            Join::Exact | Join::Rest => 1.0,
        };
        for number in [feed, tolerance] {
            if !(number > 0.0 && number < f32::MAX) {
                return Err(PathError::NotPositive { actual: number });
            }
        }
        inside(end)
    }

    /// A piece at the end, and the blend before it.
    fn append(
        &mut self,
        shape: Shape<SPACE>,
        length: i64,
        end: Point<SPACE>,
        feed: f32,
        join: Join,
    ) -> Result<(), PathError> {
        let pace = self.pace(&shape, feed);
        if !(pace.velocity > 0.0 && pace.acceleration > LEAST_ACCELERATION) {
            return Err(PathError::Limits);
        }
        let piece = Piece {
            shape,
            length,
            velocity: pace.velocity,
            feed,
            acceleration: pace.acceleration,
            ..Piece::EMPTY
        };
        if !self.continue_with(&piece, join) {
            self.start_with(piece);
        }
        self.end = end;
        Ok(())
    }

    fn pace(&self, shape: &Shape<SPACE>, feed: f32) -> Pace {
        let fastest = (feed * self.most_rate).lower(length::FASTEST);
        let cycles = self.average.cycles() as f32;
        pace(shape, &self.machine, &self.limits, fastest, cycles)
    }

    /// From rest, where the path ends now.
    fn start_with(&mut self, piece: Piece<SPACE>) {
        let last = self.ring.end().checked_sub(1);
        let start = match last.and_then(|last| self.ring.get(last)) {
            Some(last) => last.end(),
            None => self.front.place,
        };
        let piece = Piece {
            start,
            enter: start,
            alone: start,
            shared: piece.acceleration,
            entry: 0.0,
            from_rest: true,
            ..piece
        };
        let is_first = last.is_none_or(|last| self.ring.get(last).is_none());
        self.ring.push(self.limited(piece));
        if is_first {
            self.begin(self.ring.end() - 1);
        }
    }

    /// Follows the last piece without a rest, if the front is not too near for that.
    fn continue_with(&mut self, piece: &Piece<SPACE>, join: Join) -> bool {
        let Some(place) = self.ring.end().checked_sub(1) else {
            return false;
        };
        let Some(&last) = self.ring.get(place) else {
            return false;
        };
        // The whole shape, of which a blend may have taken the first half.
        let whole = last.begin + last.length;
        let corner = match join {
            Join::Rest => Corner::Rest,
            Join::Exact => match corner((&last.shape, whole), (&piece.shape, piece.length), 0.0) {
                Corner::Smooth => Corner::Smooth,
                Corner::Blend { .. } | Corner::Rest => Corner::Rest,
            },
            Join::Blend(tolerance) => corner(
                (&last.shape, whole),
                (&piece.shape, piece.length),
                tolerance,
            ),
        };
        match corner {
            Corner::Rest => false,
            Corner::Smooth => {
                let next = self.following(&last, *piece);
                self.connect(place, last, next, None)
            }
            Corner::Blend { shape, reach } => {
                let feed = last.feed.lower(piece.feed);
                let pace = self.pace(&shape, feed);
                if !(pace.velocity > 0.0 && pace.acceleration > LEAST_ACCELERATION) {
                    return false;
                }
                let shortened = Piece {
                    length: last.length - reach,
                    ..last
                };
                let blend = Piece {
                    shape,
                    length: 2 * reach,
                    velocity: pace.velocity,
                    feed,
                    acceleration: pace.acceleration,
                    ..Piece::EMPTY
                };
                let blend = self.following(&shortened, blend);
                let rest = Piece {
                    begin: reach,
                    length: piece.length - reach,
                    ..*piece
                };
                let rest = self.following(&blend, rest);
                self.connect(place, shortened, blend, Some(rest))
            }
        }
    }

    /// Where the limits of a piece are in force that follows another one without a rest.
    fn following(&self, before: &Piece<SPACE>, piece: Piece<SPACE>) -> Piece<SPACE> {
        let cycles = self.average.cycles() as f32;
        // A cycle must not pass more than a few pieces.
        let piece = Piece {
            velocity: piece.velocity.lower(4.0 * length::units(piece.length)),
            start: before.end(),
            ..piece
        };
        let way = piece.velocity.lower(before.velocity) * (0.5 * cycles + EDGE_CYCLES);
        let enter = before.enter.max(before.end() - length::from_units(way));
        // What is in force until the one before it leaves.
        let alone = left(before, cycles) + length::from_units(BEHIND * before.velocity);
        let alone = before.alone.max(alone);
        let shared = if before.alone > enter {
            before.shared.lower(before.acceleration)
        } else {
            before.acceleration
        };
        Piece {
            enter,
            leave: left(&piece, cycles),
            alone,
            shared: shared.lower(piece.acceleration),
            entry: 0.0,
            from_rest: false,
            ..piece
        }
    }

    fn limited(&self, piece: Piece<SPACE>) -> Piece<SPACE> {
        Piece {
            leave: left(&piece, self.average.cycles() as f32),
            ..piece
        }
    }

    /// Puts pieces behind the last one, if the front can still do what they ask for.
    fn connect(
        &mut self,
        place: usize,
        last: Piece<SPACE>,
        next: Piece<SPACE>,
        rest: Option<Piece<SPACE>>,
    ) -> bool {
        let mut acceleration = next.shared.lower(last.shared).lower(last.acceleration);
        if let Some(rest) = &rest {
            acceleration = acceleration.lower(rest.shared);
        }
        for piece in self.ring.range(self.front.piece, place) {
            acceleration = acceleration.lower(piece.shared);
        }
        let mut guard = Guard {
            place: next.enter,
            acceleration,
        };
        let later = guard.and(self.later);
        guard = later.and(self.guard);
        let room = guard.place - self.front.place;
        if room < 0 || length::units(room) < self.front.stopping_distance(guard.acceleration) {
            return false;
        }
        if let Some(slot) = self.ring.get_mut(place) {
            if last.length == 0 && self.front.piece < place {
                *slot = next;
            } else {
                *slot = Piece {
                    leave: left(&last, self.average.cycles() as f32),
                    ..last
                };
                self.ring.push(next);
            }
        }
        if let Some(rest) = rest {
            self.ring.push(rest);
        }
        self.guard = Some(guard);
        if self.plan.is_some() {
            self.later = Some(later);
        } else {
            self.plan = self.ring.end().checked_sub(1);
        }
        true
    }

    /// The next cycle: the positions of the axes in counts.
    pub fn advance(&mut self) -> [Position; AXES] {
        let rate = if self.is_paused || self.is_stopping {
            0.0
        } else {
            self.rate
        };
        let guard = self.guard.map(|guard| guard.room(self.front.place));
        let effort = self.front.advance(&self.ring, rate, guard);
        self.plan_some(effort);
        let way = self.average.add(self.front.velocity);
        if way != 0 {
            self.move_tool(way);
        } else if self.front.is_at_rest() {
            self.rest();
        }
        self.machine.axes(self.place.map(Position::from_units))
    }

    /// The tool a cycle further: the average of the places of the front.
    fn move_tool(&mut self, way: u64) {
        let cycles = self.average.cycles() as i64;
        self.tool_way += way.cast_signed();
        while let Some(piece) = self.ring.get(self.tool) {
            let whole = piece.length * cycles;
            if self.tool_way <= whole || self.tool >= self.front.piece {
                break;
            }
            self.tool_way -= whole;
            self.tool += 1;
        }
        if let Some(piece) = self.ring.get(self.tool) {
            let at = part_of(self.tool_way, self.share).min(piece.length).max(0);
            self.place = piece.shape.point(piece.begin + at);
        }
        self.forget();
    }

    /// Pieces that the tool has passed and that are not in force any more.
    fn forget(&mut self) {
        let first = self.ring.first();
        if first < self.tool
            && let Some(piece) = self.ring.get(first)
            && piece.leave <= self.front.place
        {
            self.ring.retire(first + 1);
        }
    }

    /// Front and tool stand.
    fn rest(&mut self) {
        if self.is_stopping {
            self.ring.clear();
            self.guard = None;
            self.later = None;
            self.plan = None;
            self.end = self.place;
            self.is_stopping = false;
            self.tool_way = 0;
            self.tool = self.ring.end();
            return;
        }
        self.ring.retire(self.tool);
        self.front.forget_the_past(&self.ring);
        let next = self.front.piece + 1;
        if let (Some(piece), Some(following)) =
            (self.ring.get(self.front.piece), self.ring.get(next))
            && following.from_rest
            && self.front.place >= piece.end()
        {
            self.begin(next);
        }
    }

    /// Front and tool at the start of a piece, from rest.
    fn begin(&mut self, place: usize) {
        if let Some(piece) = self.ring.get(place) {
            self.front.begin(place, piece);
            self.place = piece.shape.from;
        }
        self.tool = place;
        self.tool_way = 0;
        self.ring.retire(place);
    }

    /// Plans backward from the end: how fast each piece may be entered.
    fn plan_some(&mut self, effort: usize) {
        let count = PLANNED_IN_A_CYCLE.saturating_sub(effort);
        for _ in 0..count.max(if QUEUE > 64 { QUEUE / 8 } else { 0 }) {
            let Some(place) = self.plan else {
                return;
            };
            if place <= self.front.piece {
                self.finish_plan();
                return;
            }
            let Some(piece) = self.ring.get(place) else {
                self.finish_plan();
                return;
            };
            let entry = piece.entry_before(piece.goal(self.ring.get(place + 1)));
            if let Some(piece) = self.ring.get_mut(place)
                && !piece.from_rest
            {
                piece.entry = entry;
            }
            self.plan = Some(place - 1);
        }
    }

    /// Everything is planned, or what has come since then is next.
    fn finish_plan(&mut self) {
        self.guard = self.later.take();
        self.plan = match self.guard {
            Some(_) => self.ring.end().checked_sub(1),
            None => None,
        };
    }
}

/// Until pieces are planned that were added behind it, the front must be able to stop before a place.
#[derive(Debug, Clone, Copy)]
struct Guard {
    place: i64,
    acceleration: f32,
}

impl Guard {
    /// Both.
    fn and(self, other: Option<Self>) -> Self {
        other.map_or(self, |other| Self {
            place: self.place.min(other.place),
            acceleration: self.acceleration.lower(other.acceleration),
        })
    }

    fn room(&self, front: i64) -> Room {
        Room::before_rest(self.place - front, self.acceleration)
    }
}

/// Where the front is at the latest when the tool leaves a piece.
fn left<const S: usize>(piece: &Piece<S>, cycles: f32) -> i64 {
    piece.end() + length::from_units(piece.velocity * (0.5 * cycles + EDGE_CYCLES))
}

/// Shortest piece, with 20 bits behind the point: 2^-8 units.
const SHORTEST: i64 = 1 << 12;
/// Longest piece, in units.
const LONGEST_PIECE: f32 = 536_870_912.0;
const LEAST_RADIUS: f32 = 1.0 / 64.0;
/// What the velocity of the front can still be changed by.
const LEAST_ACCELERATION: f32 = 1.0 / 262_144.0;

fn inside<const N: usize>(place: [Position; N]) -> Result<[i64; N], PathError> {
    for (coordinate, position) in place.iter().enumerate() {
        let units = position.units();
        if units.unsigned_abs() > (1 << 28) << shape::COORDINATE_BITS {
            return Err(PathError::Far {
                coordinate,
                actual: units >> shape::COORDINATE_BITS,
            });
        }
    }
    Ok(place.map(|position| position.units()))
}
