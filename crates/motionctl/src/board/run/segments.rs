//! A motion as the segments that a board plays: with the same set-points as the table of the motion.

use board_link::message::Refused;
use board_link::segment::{Begin, Segment, SegmentConfig, SegmentQueue};
use board_link::{AxisLimits, WhenDry};
use schemars::JsonSchema;
use serde::Serialize;
use trajectory::Position;

use super::fit::{Tolerance, fit};
use crate::board::error::BoardError;
use crate::board::motion::{place, units};
use crate::trajectory::Plan;

/// Segments that a board keeps, and one place more.
const QUEUE: usize = 57;
/// Most axes of a board.
const AXES: usize = board_link::segment::MOST_AXES;
/// So much must fit the memory of the board, in cycles: it slows down where less is ahead.
const AHEAD_CYCLES: u64 = 600;
const CYCLE: u64 = 1 << 32;

/// The segments of a motion, for the axes that move, from the position 0 on.
pub(super) fn segments(plan: &Plan) -> Result<Vec<Segment>, BoardError> {
    if let Some(pieces) = plan.pieces()
        && suffices(&pieces)
    {
        return Ok(pieces);
    }
    let rows = plan.exact_rows().map_err(BoardError::Program)?;
    let exact = fit(&rows, Tolerance::None);
    if suffices(&exact) {
        return Ok(exact);
    }
    Ok(fit(&rows, Tolerance::OneCount))
}

/// Whether enough of the motion fits the memory of the board everywhere, and no segment is too short for it.
fn suffices(segments: &[Segment]) -> bool {
    let is_long = segments.iter().all(|segment| segment.duration >= CYCLE / 2);
    let window = |part: &[Segment]| part.iter().map(|segment| segment.duration).sum::<u64>();
    let all_ahead = segments.windows(QUEUE - 1).map(window).min();
    is_long && all_ahead.is_none_or(|least| least >= AHEAD_CYCLES * CYCLE)
}

/// The begin of a stream from where the axes stand.
pub(super) fn begin(stream: u32, from: &[i32]) -> Begin {
    Begin {
        stream,
        start: None,
        when_dry: WhenDry::Wait,
        percent: 100,
        from: units(from),
    }
}

/// What a motion would be on the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub(super) struct Played {
    /// Cycles with set-points.
    pub(super) cycles: u64,
    /// Largest difference of a set-point from the table of the motion.
    #[serde(rename = "differs_by_counts")]
    pub(super) worst_counts: u32,
}

/// A segment that the board would refuse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Refusal {
    pub(super) segment: u32,
    /// Its begin.
    pub(super) at_cycles: f64,
    pub(super) refused: Refused,
}

/// Plays the segments as the board will, with its own checks, and compares each set-point with the table.
///
/// # Errors
/// The segment that it would refuse.
pub(super) fn preview(
    segments: &[Segment],
    limits: &[AxisLimits],
    (places, from): (&[usize], &[i32]),
    cycle_us: u32,
    mut expected: impl FnMut(usize) -> Vec<i32>,
) -> Result<Played, Refusal> {
    let mut queue = Box::new(SegmentQueue::<AXES, QUEUE>::new());
    let config = SegmentConfig::with_cycles_per_second(1_000_000 / cycle_us);
    let mut played = Played::default();
    let Some((mut admission, mut player)) = queue.split(limits, config) else {
        return Ok(played);
    };
    let (mut sent, mut ticks) = (0, 0);
    let at = |segment: usize, ticks: u64| {
        move |refused: Refused| Refusal {
            segment: segment as u32,
            at_cycles: ticks as f64 / CYCLE as f64,
            refused,
        }
    };
    let stand: Vec<Position> = from.iter().copied().map(Position::from_counts).collect();
    let begun = admission.begin(&begin(1, from), &stand, 0);
    begun.map_err(at(0, 0))?;
    let mut set_points = stand.clone();
    for cycle in 1.. {
        while sent < segments.len() && admission.credit() > 0 {
            let segment = place(&segments[sent], places, from);
            let taken = admission.push(1, sent as u32, &segment);
            taken.map_err(at(sent, ticks))?;
            (sent, ticks) = (sent + 1, ticks + segment.duration);
            if sent == segments.len() {
                admission.end(1).map_err(at(sent - 1, ticks))?;
            }
        }
        if player.advance(cycle, &stand, &mut set_points) {
            let row = expected(played.cycles as usize);
            for (counts, &place) in row.iter().zip(places) {
                let relative = set_points[place].counts().wrapping_sub(from[place]);
                played.worst_counts = played.worst_counts.max(relative.abs_diff(*counts));
            }
            played.cycles += 1;
        }
        if !player.phase().is_active() {
            break;
        }
    }
    Ok(played)
}

#[cfg(test)]
mod tests;
