//! The geometry of a piece of a path: positions, directions and curvatures at a length from its start.
//!
//! A coordinate is a number with 24 bits behind the point of a unit ([`Position::units`](trajectory::Position::units)). Lines and arcs are
//! computed in fixed point, because 24 bits of a float are not enough near the end of a long one. A blend is small, and a polynomial of
//! floats from its start.

use trajectory::fixed::part_of;

use crate::angle::{self, Radius, sine_cosine};
use crate::length;
use crate::measure::Measure;
use crate::roots::square_root;

/// Bits behind the point of a coordinate.
pub(crate) const COORDINATE_BITS: i32 = 24;
/// Bits behind the point of what a blend moves by: a blend is at most 2^15 units wide.
const BLEND_BITS: i32 = 16;
/// Of a sine.
const SINE_UNIT: f32 = 1.0 / angle::ONE as f32;

pub(crate) type Point<const S: usize> = [i64; S];
pub(crate) type Vector<const S: usize> = [f32; S];

/// How a path passes a place: unit tangent, and curvature as the change of the tangent per unit of length.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Direction<const S: usize> {
    pub(crate) tangent: Vector<S>,
    pub(crate) curvature: Vector<S>,
}

impl<const S: usize> Direction<S> {
    pub(crate) const NONE: Self = Self {
        tangent: [0.0; S],
        curvature: [0.0; S],
    };
}

/// What an arc has and a line has not.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Round {
    /// The two coordinates of its plane.
    pub(crate) plane: (usize, usize),
    /// From the centre to the start.
    pub(crate) radial: [i64; 2],
    /// In 2^-32 turns, positive from the first coordinate to the second.
    pub(crate) sweep: i64,
}

impl Round {
    pub(crate) const NONE: Self = Self {
        plane: (0, 0),
        radial: [0; 2],
        sweep: 0,
    };
}

/// A place of a path, and how it is passed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Passage<const S: usize> {
    pub(crate) point: Point<S>,
    pub(crate) direction: Direction<S>,
}

impl<const S: usize> Passage<S> {
    pub(crate) const NONE: Self = Self {
        point: [0; S],
        direction: Direction::NONE,
    };
}

/// A piece, whose length is `scale` bits short of 64.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shape<const S: usize> {
    pub(crate) from: Point<S>,
    pub(crate) kind: Kind<S>,
    /// A length shifted left by this is a share, 64 bits behind the point, of the next power of two above the whole length.
    scale: u32,
}

/// What is given per length is given for the whole power of two, so a share needs no division.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Kind<const S: usize> {
    Line {
        way: Point<S>,
    },
    Arc {
        way: Point<S>,
        /// The two coordinates of the plane, and what goes from the centre to the start in it.
        plane: (usize, usize),
        radius: Radius,
        /// Angle in 2^-32 turns.
        turn: i64,
        /// Radians per unit of length.
        rate: f32,
    },
    Blend {
        /// Of the powers 1 to 5 of the share, in units with [`BLEND_BITS`].
        coefficients: [[f32; 5]; S],
        /// The share of the length of one, per share with 31 bits behind the point.
        whole: f32,
        /// 1 / length.
        inverse: f32,
    },
}

impl<const S: usize> Shape<S> {
    /// Nothing; never sampled.
    pub(crate) const EMPTY: Self = Self::resting([0; S]);

    /// A piece of length 0.
    pub(crate) const fn resting(from: Point<S>) -> Self {
        Self {
            from,
            kind: Kind::Line { way: [0; S] },
            scale: 0,
        }
    }

    /// A straight line of a length, which is that between its ends to 24 bits.
    pub(crate) fn line(from: Point<S>, end: Point<S>, measure: &Measure) -> Self {
        let way = difference_of_points(&end, &from);
        Self {
            from,
            kind: Kind::Line {
                way: way.map(|way| measure.times(way)),
            },
            scale: measure.scale,
        }
    }

    /// An arc of a length. What the end differs from the end of the arc, in the other coordinates too, is spread over the length.
    pub(crate) fn arc(
        (from, end): (Point<S>, Point<S>),
        round: &Round,
        (radius, turned): (Radius, [i64; 2]),
        measure: &Measure,
    ) -> Self {
        let Round { plane, sweep, .. } = *round;
        let mut way = [0; S];
        for (place, (way, (end, from))) in way.iter_mut().zip(end.iter().zip(from)).enumerate() {
            let rest = end - from - of_plane(plane, turned, place);
            *way = measure.times(rest);
        }
        let turns = length::to_float(sweep, 32);
        Self {
            from,
            kind: Kind::Arc {
                way,
                plane,
                radius,
                turn: measure.times(sweep),
                rate: turns * core::f32::consts::TAU / length::units(measure.length),
            },
            scale: measure.scale,
        }
    }

    /// The curve of least degree from one passage to another, position, tangent and curvature alike.
    pub(crate) fn blend(start: &Passage<S>, end: &Passage<S>, length: i64) -> Self {
        let scale = length.leading_zeros();
        let h = length::units(length);
        let mut coefficients = [[0.0; 5]; S];
        let ends = start.point.iter().zip(end.point);
        let (first, last) = (&start.direction, &end.direction);
        let tangents = first.tangent.iter().zip(last.tangent);
        let curvatures = first.curvature.iter().zip(last.curvature);
        let coordinates = ends.zip(tangents).zip(curvatures);
        for (to, (((from, end), (t0, t1)), (k0, k1))) in coefficients.iter_mut().zip(coordinates) {
            let (one, two) = (h * t0, 0.5 * h * h * k0);
            let way = coordinate(end - from) - one - two;
            let slope = h * t1 - one - 2.0 * two;
            let bend = h * h * k1 - 2.0 * two;
            *to = [
                one,
                two,
                10.0 * way - 4.0 * slope + 0.5 * bend,
                -15.0 * way + 7.0 * slope - bend,
                6.0 * way - 3.0 * slope + 0.5 * bend,
            ];
        }
        // A share of 2^(64 - scale) of the length's smallest steps, as a share of the length.
        let whole = length::units(1_i64.wrapping_shl(63 - scale)) * 2.0 / h / 2_147_483_648.0;
        Self {
            from: start.point,
            kind: Kind::Blend {
                coefficients,
                whole,
                inverse: 1.0 / h,
            },
            scale,
        }
    }

    pub(crate) const fn is_round(&self) -> bool {
        matches!(self.kind, Kind::Arc { .. })
    }

    /// The point at a length from the start.
    pub(crate) fn point(&self, at: i64) -> Point<S> {
        let mut point = [0; S];
        self.put_point(at, &mut point);
        point
    }

    /// The same, written to a place.
    pub(crate) fn put_point(&self, at: i64, point: &mut Point<S>) {
        let share = at.cast_unsigned().wrapping_shl(self.scale);
        match &self.kind {
            Kind::Line { way } => self.put_straight(way, share, point),
            Kind::Arc {
                way,
                plane,
                radius,
                turn,
                ..
            } => {
                self.put_straight(way, share, point);
                let [first, second] = radius.turned(part_of(*turn, share) as u32);
                if let Some(point) = point.get_mut(plane.0) {
                    *point += first;
                }
                if let Some(point) = point.get_mut(plane.1) {
                    *point += second;
                }
            }
            Kind::Blend {
                coefficients,
                whole,
                ..
            } => {
                let u = (share >> 33) as i32 as f32 * whole;
                let coordinates = point.iter_mut().zip(&self.from).zip(coefficients);
                for ((point, from), [one, two, three, four, five]) in coordinates {
                    let moved = ((((five * u + four) * u + three) * u + two) * u + one) * u;
                    let moved = (moved * (1_u32 << BLEND_BITS) as f32) as i32;
                    *point = from + (i64::from(moved) << (COORDINATE_BITS - BLEND_BITS));
                }
            }
        }
    }

    fn put_straight(&self, way: &Point<S>, share: u64, point: &mut Point<S>) {
        for ((point, from), way) in point.iter_mut().zip(&self.from).zip(way) {
            *point = from + part_of(*way, share);
        }
    }

    /// The direction at a length from the start. Not of a blend: nothing is blended with one.
    pub(crate) fn direction(&self, at: i64) -> Direction<S> {
        let mut tangent = [0.0; S];
        let mut curvature = [0.0; S];
        if let Kind::Line { way } | Kind::Arc { way, .. } = &self.kind {
            // Per smallest step of a length, of which a unit has 2^20, a coordinate 2^24.
            let places = self.scale as i32 - 64 + 20 - COORDINATE_BITS;
            let unit = f32::from_bits(((127 + places).clamp(1, 254).cast_unsigned()) << 23);
            for (tangent, way) in tangent.iter_mut().zip(way) {
                *tangent = length::to_float(*way, 0) * unit;
            }
        }
        if let Kind::Arc {
            plane,
            radius,
            turn,
            rate,
            ..
        } = &self.kind
        {
            let share = at.cast_unsigned().wrapping_shl(self.scale);
            let (sine, cosine) = sine_cosine(part_of(*turn, share) as u32);
            let (sine, cosine) = (sine as f32 * SINE_UNIT, cosine as f32 * SINE_UNIT);
            let [first, second] = radius.parts().map(coordinate);
            let (first, second) = (
                first * cosine - second * sine,
                second * cosine + first * sine,
            );
            for (place, ahead, back) in [(plane.0, -second, first), (plane.1, first, second)] {
                if let Some(tangent) = tangent.get_mut(place) {
                    *tangent += ahead * rate;
                }
                if let Some(curvature) = curvature.get_mut(place) {
                    *curvature = -back * rate * rate;
                }
            }
        }
        Direction { tangent, curvature }
    }
}

/// The coordinate in units, to 24 bits.
pub(crate) fn coordinate(coordinate: i64) -> f32 {
    length::to_float(coordinate, COORDINATE_BITS as u32)
}

pub(crate) fn norm<const S: usize>(vector: &Vector<S>) -> f32 {
    square_root(vector.iter().map(|part| part * part).sum())
}

pub(crate) fn difference<const S: usize>(to: &Vector<S>, from: &Vector<S>) -> Vector<S> {
    let mut difference = *to;
    for (part, from) in difference.iter_mut().zip(from) {
        *part -= from;
    }
    difference
}

pub(crate) fn difference_of_points<const S: usize>(to: &Point<S>, from: &Point<S>) -> Point<S> {
    let mut difference = *to;
    for (part, from) in difference.iter_mut().zip(from) {
        *part -= from;
    }
    difference
}

fn of_plane(plane: (usize, usize), [first, second]: [i64; 2], place: usize) -> i64 {
    if place == plane.0 {
        first
    } else if place == plane.1 {
        second
    } else {
        0
    }
}
