//! What has been asked for and is not prepared yet.

use trajectory::Position;

use crate::error::PathError;
use crate::length;
use crate::measure::Measure;
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
    pub(crate) is_round: bool,
    /// Of an arc.
    pub(crate) round: Round,
    /// Square of its length in units.
    square: f32,
    pub(crate) feed: f32,
    pub(crate) join: Join,
}

/// Shortest and longest piece, in units.
const SHORTEST: f32 = 1.0 / 256.0;
const LONGEST_PIECE: f32 = 536_870_912.0;
/// Smallest and largest radius, in units.
pub(crate) const LEAST_RADIUS: f32 = 1.0 / 64.0;
const MOST_RADIUS: f32 = 268_435_456.0;
/// Upper half of the largest coordinate.
const MOST_UPPER: i32 = 1 << (28 + shape::COORDINATE_BITS - 32);
/// The share of the radius by which an arc may miss its end.
const MOST_MISSED: f32 = 1.0 / 64.0;
/// Turns of an arc that are too many.
const MOST_TURNS: i32 = 1 << 28;
/// Slowest feed, in units per cycle: velocities have steps of 2^-20.
pub(crate) const LEAST_FEED: f32 = 1.0 / 65_536.0;

/// Coordinates that a path can have.
pub(crate) fn inside<const N: usize>(place: [Position; N]) -> Result<[i64; N], PathError> {
    for (coordinate, position) in place.iter().enumerate() {
        check_coordinate(coordinate, position.units())?;
    }
    Ok(place.map(Position::units))
}

const fn check_coordinate(coordinate: usize, units: i64) -> Result<(), PathError> {
    // The upper half says it of nearly all.
    let upper = (units >> 32) as i32;
    let is_inside = upper >= -MOST_UPPER && upper < MOST_UPPER;
    if is_inside || units == (MOST_UPPER as i64) << 32 {
        return Ok(());
    }
    Err(PathError::Far {
        coordinate,
        actual: units >> shape::COORDINATE_BITS,
    })
}

impl<const S: usize> Request<S> {
    pub(crate) const NONE: Self = Self {
        from: [0; S],
        end: [0; S],
        is_round: false,
        round: Round::NONE,
        square: 0.0,
        feed: 0.0,
        join: Join::Rest,
    };

    /// A line. Tells whether it is long enough to be one.
    pub(crate) fn line(&mut self, from: &Point<S>, end: &[Position; S]) -> Result<bool, PathError> {
        self.end_at(end)?;
        let mut square = 0.0;
        for (end, from) in self.end.iter().zip(from) {
            let way = shape::coordinate(end - from);
            square += way * way;
        }
        self.from = *from;
        self.is_round = false;
        self.square = square;
        Ok(square >= SHORTEST * SHORTEST)
    }

    /// An arc. Tells whether it is long enough to be one.
    pub(crate) fn arc(&mut self, from: &Point<S>, arc: &Arc<S>) -> Result<bool, PathError> {
        self.end_at(&arc.end)?;
        let plane = arc.plane;
        let (Some(first), Some(second)) = (from.get(plane.0), from.get(plane.1)) else {
            return Err(PathError::Plane { actual: plane });
        };
        if plane.0 == plane.1 {
            return Err(PathError::Plane { actual: plane });
        }
        let turns = (arc.sweep >> 32) as i32;
        if !(-MOST_TURNS..MOST_TURNS).contains(&turns) {
            return Err(PathError::Sweep { actual: arc.sweep });
        }
        // A centre that is too far away makes a radius that is too large, also where the difference wraps.
        let [c1, c2] = arc.centre.map(Position::units);
        self.round = Round {
            plane,
            radial: [first.wrapping_sub(c1), second.wrapping_sub(c2)],
            sweep: arc.sweep,
        };
        self.square = square_of_arc(&self.round, from, &self.end)?;
        self.from = *from;
        self.is_round = true;
        Ok(self.square >= SHORTEST * SHORTEST)
    }

    fn end_at(&mut self, end: &[Position; S]) -> Result<(), PathError> {
        for (coordinate, (to, end)) in self.end.iter_mut().zip(end).enumerate() {
            *to = end.units();
            check_coordinate(coordinate, *to)?;
        }
        Ok(())
    }

    /// Its length.
    pub(crate) fn measure(&self) -> Measure {
        Measure::of(length::from_units(square_root(self.square)))
    }
}

/// The square of the length of an arc that is possible. Squares are compared: no root is needed.
fn square_of_arc<const S: usize>(
    arc: &Round,
    from: &Point<S>,
    end: &Point<S>,
) -> Result<f32, PathError> {
    let radial = arc.radial.map(shape::coordinate);
    let radius = radial[0] * radial[0] + radial[1] * radial[1];
    if !(LEAST_RADIUS * LEAST_RADIUS..=MOST_RADIUS * MOST_RADIUS).contains(&radius) {
        let actual = square_root(radius);
        return Err(PathError::Radius { actual });
    }
    let turned = turned_about(radial, arc.sweep as u32);
    let (mut ways, mut square) = ([0.0; S], 0.0);
    for (way, (end, from)) in ways.iter_mut().zip(end.iter().zip(from)) {
        *way = shape::coordinate(end - from);
        square += *way * *way;
    }
    let way = |place: usize| ways.get(place).copied().unwrap_or(0.0);
    let [first, second] = [way(arc.plane.0), way(arc.plane.1)];
    let missed = [first - turned[0], second - turned[1]];
    let missed = missed[0] * missed[0] + missed[1] * missed[1];
    let across = square - first * first - second * second;
    if missed > MOST_MISSED * MOST_MISSED * radius {
        let (actual, most) = (square_root(missed), MOST_MISSED * square_root(radius));
        return Err(PathError::End { actual, most });
    }
    let angle = length::to_float(arc.sweep, 32) * core::f32::consts::TAU;
    let length = angle * angle * radius + across;
    if length > LONGEST_PIECE * LONGEST_PIECE {
        let actual = square_root(length);
        return Err(PathError::Long { actual });
    }
    Ok(length)
}

/// What the end of a radius moves by when it turns by a phase, to a thousandth of the radius: enough to refuse an end that is elsewhere.
fn turned_about([first, second]: [f32; 2], phase: u32) -> [f32; 2] {
    let sine = sine_about(phase);
    let cosine = sine_about(phase.wrapping_add(1 << 30));
    [
        first * (cosine - 1.0) - second * sine,
        second * (cosine - 1.0) + first * sine,
    ]
}

/// The sine of an angle in 2^-32 turns, to a thousandth: a parabola, and a share of its square that makes it rounder.
fn sine_about(phase: u32) -> f32 {
    let half_turns = phase.cast_signed() as f32 * (1.0 / 2_147_483_648.0);
    let parabola = 4.0 * half_turns * (1.0 - half_turns.abs());
    parabola + 0.225 * (parabola * parabola.abs() - parabola)
}
