//! What each axis of a segment must keep.

use trajectory::{Position, TimeScale};

use super::border::{Edge, check_needs, nearest_units, pass, slopes};
use super::{AxisSegment, Segment};
use crate::config::AxisLimits;
use crate::polynomial::{Needs, Polynomial, share_of};
use crate::rate::ONE;
use crate::reason::Reason;
use crate::refused::Refused;

pub(super) fn override_rate(percent: u16) -> Result<i64, Refused> {
    let most = TimeScale::MOST_PERCENT;
    if percent > most {
        return Err(Reason::Override.because(most.into(), percent.into()));
    }
    Ok(i64::from(percent) * ONE / 100)
}

pub(super) fn inside(axis: usize, actual: Position, limits: &AxisLimits) -> Result<(), Refused> {
    let nearest = actual.clamp(limits.lowest, limits.highest.max(limits.lowest));
    if nearest == actual {
        return Ok(());
    }
    Err(Reason::Travel.at(axis, nearest.units(), actual.units()))
}

/// The same for a place on the way, or where a way was stopped.
pub(super) fn passes_inside(
    axis: usize,
    actual: Position,
    limits: &AxisLimits,
) -> Result<(), Refused> {
    if limits.admit_on_the_way(actual) {
        return Ok(());
    }
    inside(axis, actual, limits)
}

/// The whole way of one axis. The edge becomes that of the new segment, but for its position; returns the highest rate.
// Inlined into the generic code of a board it would be compiled with it, for speed.
#[inline(never)]
pub(super) fn check_axis(
    axis: usize,
    part: &AxisSegment,
    segment: &Segment,
    limits: &AxisLimits,
    edge: &mut Edge,
) -> Result<f32, Refused> {
    let from = edge.position;
    inside(axis, Position::from_units(part.end), limits)?;
    if !part.fits(from) {
        let most = nearest_units(limits.velocity());
        return Err(Reason::Velocity.at(axis, most, i64::MAX));
    }
    let piece = part.piece(from);
    let counts = |units: i64| units as f32 / Position::UNITS as f32;
    let coefficients = piece.coefficients().map(counts);
    let polynomial = Polynomial::new(coefficients, segment.time().cycles());
    let needs = polynomial.needs();
    check_needs(axis, &needs, limits)?;
    for &turn in &polynomial.turns() {
        passes_inside(axis, piece.at(share_of(turn)), limits)?;
    }
    let [leaving, arriving] = slopes(part, from, segment);
    let (with_step, step) = pass(axis, edge, leaving, needs, limits)?;
    (edge.slope, edge.needs) = (arriving, needs);
    let [one, two, _] = edge.steps;
    edge.steps = [step, one, two];
    let cycles = segment.time().cycles();
    edge.steps.iter_mut().for_each(|step| step.ago += cycles);
    let most = Needs {
        velocity: limits.velocity(),
        acceleration: limits.acceleration(),
        jerk: limits.jerk(),
    };
    Ok(with_step.highest_rate(&most))
}
