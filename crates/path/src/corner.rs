//! Where two pieces meet: straight on, through a blend, or at rest.

use crate::length;
use crate::order::Order as _;
use crate::roots::square_root;
use crate::shape::{Direction, difference, norm};

/// How one piece follows another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Corner {
    /// Tangent and curvature are the same.
    Smooth,
    /// A blend takes the place of `reach` of either piece.
    Blend { reach: i64 },
    /// No curve is within the tolerance.
    Rest,
}

/// Tangents and curvatures that differ by no more are the same: what floats of 24 bits can tell.
const SAME_TANGENT: f32 = 1.0 / 1_048_576.0;
const SAME_CURVATURE: f32 = 1.0 / 65_536.0;
/// A corner that turns back is not blended: the tool would miss it by less than the tolerance, and nobody means that. 160 degrees.
const TURNS_BACK: f32 = 1.969_6;
/// Shortest and longest reach of a blend, in units.
const SHORTEST: f32 = 1.0 / 64.0;
const LONGEST: f32 = 8_192.0;
/// Largest angle that an arc turns by within the reach, in radians.
const MOST_TURN: f32 = 0.5;

/// What a blend of reach `d` is away from the corner at most: this times `d` and the difference of the tangents, and this times `d²` and the
/// difference of the curvatures.
const TANGENT_SHARE: f32 = 0.1875;
const CURVATURE_SHARE: f32 = 0.012;
/// For what the terms of higher order add.
const TOLERANCE_SHARE: f32 = 0.95;

/// The corner between the end of a piece and the start of the next one, which have these whole lengths. Either may give up half of it.
pub(crate) fn corner<const S: usize>(
    (end, before): (&Direction<S>, i64),
    (start, after): (&Direction<S>, i64),
    tolerance: f32,
) -> Corner {
    let bend = norm(&difference(&start.tangent, &end.tangent));
    let curve = norm(&difference(&start.curvature, &end.curvature));
    let tightest = norm(&start.curvature).higher(norm(&end.curvature));
    if bend <= SAME_TANGENT && curve <= SAME_CURVATURE * tightest {
        return Corner::Smooth;
    }
    let room = length::units(before.min(after)) * 0.5;
    let reach = reach(bend, curve, TOLERANCE_SHARE * tolerance)
        .lower(room)
        .lower(LONGEST)
        .lower(MOST_TURN / tightest);
    // Not for what is no number either.
    if bend > TURNS_BACK || reach.is_nan() || reach < SHORTEST {
        return Corner::Rest;
    }
    let reach = length::from_units(reach).min(before / 2).min(after / 2);
    Corner::Blend { reach }
}

/// The reach of a blend that is as far from the corner as a tolerance allows.
fn reach(bend: f32, curve: f32, tolerance: f32) -> f32 {
    let (linear, square) = (TANGENT_SHARE * bend, CURVATURE_SHARE * curve);
    2.0 * tolerance / (linear + square_root(linear * linear + 4.0 * square * tolerance))
}
