//! What has been asked for and is not prepared yet.

use trajectory::Position;

use crate::error::PathError;
use crate::length;
use crate::roots::square_root;
use crate::shape::{self, Point, Round};

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
    /// Its sweep in 2^-32 turns, positive from the first coordinate to the second: up to 2^28 turns.
    pub sweep: i64,
    /// Its end.
    pub end: [Position; SPACE],
}

/// A piece that is known to be possible.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Request<const S: usize> {
    pub(crate) from: Point<S>,
    pub(crate) end: Point<S>,
    /// Of an arc.
    pub(crate) round: Option<Round>,
    pub(crate) feed: f32,
    pub(crate) join: Join,
}

/// Shortest and longest piece, in units.
const SHORTEST: f32 = 1.0 / 256.0;
const LONGEST_PIECE: f32 = 536_870_912.0;
/// Smallest and largest radius, in units.
pub(crate) const LEAST_RADIUS: f32 = 1.0 / 64.0;
const MOST_RADIUS: f32 = 268_435_456.0;
/// Largest sweep, in 2^-32 turns.
const MOST_SWEEP: u64 = 1 << 60;
/// Slowest feed, in units per cycle: velocities have steps of 2^-20.
pub(crate) const LEAST_FEED: f32 = 1.0 / 65_536.0;

/// Coordinates that a path can have.
pub(crate) fn inside<const N: usize>(place: [Position; N]) -> Result<[i64; N], PathError> {
    for (coordinate, position) in place.iter().enumerate() {
        let units = position.units();
        if units.unsigned_abs() > (1 << 28) << shape::COORDINATE_BITS {
            return Err(PathError::Far {
                coordinate,
                actual: units >> shape::COORDINATE_BITS,
            });
        }
    }
    Ok(place.map(Position::units))
}

impl<const S: usize> Request<S> {
    /// A line; `None` for one that is too short.
    pub(crate) fn line(
        from: Point<S>,
        end: [Position; S],
        feed: f32,
        join: Join,
    ) -> Result<Option<Self>, PathError> {
        check(feed, join)?;
        let end = inside(end)?;
        let mut square = 0.0;
        for (end, from) in end.iter().zip(from) {
            let way = shape::coordinate(end - from);
            square += way * way;
        }
        if square < SHORTEST * SHORTEST {
            return Ok(None);
        }
        Ok(Some(Self {
            from,
            end,
            round: None,
            feed,
            join,
        }))
    }

    /// An arc; `None` for one that is too short.
    pub(crate) fn arc(
        from: Point<S>,
        arc: &Arc<S>,
        feed: f32,
        join: Join,
    ) -> Result<Option<Self>, PathError> {
        check(feed, join)?;
        let end = inside(arc.end)?;
        let plane = arc.plane;
        let (Some(first), Some(second)) = (from.get(plane.0), from.get(plane.1)) else {
            return Err(PathError::Plane { actual: plane });
        };
        if plane.0 == plane.1 {
            return Err(PathError::Plane { actual: plane });
        }
        if arc.sweep.unsigned_abs() > MOST_SWEEP {
            return Err(PathError::Sweep { actual: arc.sweep });
        }
        let [c1, c2] = inside(arc.centre)?;
        let radial = [first - c1, second - c2];
        let round = round(arc, from, end, radial)?;
        if round.square < SHORTEST * SHORTEST {
            return Ok(None);
        }
        Ok(Some(Self {
            from,
            end,
            round: Some(round),
            feed,
            join,
        }))
    }

    /// Length of the piece.
    pub(crate) fn length(&self) -> i64 {
        let length = match self.round {
            Some(round) => square_root(round.square),
            None => {
                let way = shape::difference_of_points(&self.end, &self.from);
                shape::norm(&way.map(shape::coordinate))
            }
        };
        length::from_units(length)
    }
}

fn check(feed: f32, join: Join) -> Result<(), PathError> {
    let tolerance = match join {
        Join::Blend(tolerance) => tolerance,
        Join::Exact | Join::Rest => 1.0,
    };
    for number in [feed, tolerance] {
        if !(number > 0.0 && number < f32::MAX) {
            return Err(PathError::NotPositive { actual: number });
        }
    }
    if feed < LEAST_FEED {
        return Err(PathError::Slow { actual: feed });
    }
    Ok(())
}

/// What is known of an arc that is possible. Squares are compared: no root is needed.
fn round<const S: usize>(
    arc: &Arc<S>,
    from: Point<S>,
    end: Point<S>,
    radial: [i64; 2],
) -> Result<Round, PathError> {
    let [first, second] = radial.map(shape::coordinate);
    let radius = first * first + second * second;
    if !(LEAST_RADIUS * LEAST_RADIUS..=MOST_RADIUS * MOST_RADIUS).contains(&radius) {
        let actual = square_root(radius);
        return Err(PathError::Radius { actual });
    }
    let turned = shape::turned(radial, arc.sweep as u32);
    let (mut missed, mut across) = (0.0, 0.0);
    for (place, (end, from)) in end.iter().zip(from).enumerate() {
        let way = end - from;
        if place == arc.plane.0 || place == arc.plane.1 {
            let way = way - turned[usize::from(place == arc.plane.1)];
            missed += shape::coordinate(way) * shape::coordinate(way);
        } else {
            across += shape::coordinate(way) * shape::coordinate(way);
        }
    }
    if missed * 4_096.0 > radius {
        let (actual, most) = (square_root(missed), square_root(radius) / 64.0);
        return Err(PathError::End { actual, most });
    }
    let angle = length::to_float(arc.sweep, 32) * core::f32::consts::TAU;
    let length = angle * angle * radius + across;
    if length > LONGEST_PIECE * LONGEST_PIECE {
        let actual = square_root(length);
        return Err(PathError::Long { actual });
    }
    Ok(Round {
        plane: arc.plane,
        radial,
        sweep: arc.sweep,
        turned,
        square: length,
    })
}

/// Requests in their order.
#[derive(Debug, Clone)]
pub(crate) struct Inbox<const S: usize> {
    requests: [Option<Request<S>>; PLACES],
    first: usize,
    count: usize,
}

/// Requests that wait at most.
const PLACES: usize = 8;

impl<const S: usize> Inbox<S> {
    pub(crate) const EMPTY: Self = Self {
        requests: [None; PLACES],
        first: 0,
        count: 0,
    };

    pub(crate) const fn is_empty(&self) -> bool {
        self.count == 0
    }

    pub(crate) const fn has_room(&self) -> bool {
        self.count < PLACES
    }

    pub(crate) fn first(&self) -> Option<&Request<S>> {
        self.requests.get(self.first % PLACES)?.as_ref()
    }

    pub(crate) fn push(&mut self, request: Request<S>) {
        let place = (self.first + self.count) % PLACES;
        if self.has_room()
            && let Some(slot) = self.requests.get_mut(place)
        {
            *slot = Some(request);
            self.count += 1;
        }
    }

    /// Forgets the first one.
    pub(crate) fn pop(&mut self) {
        if self.count == 0 {
            return;
        }
        if let Some(slot) = self.requests.get_mut(self.first % PLACES) {
            *slot = None;
        }
        self.first = (self.first + 1) % PLACES;
        self.count -= 1;
    }

    pub(crate) fn clear(&mut self) {
        *self = Self::EMPTY;
    }
}
