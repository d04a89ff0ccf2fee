//! What `motionctl board run` and `motionctl board stream` have in common: a motion that a board plays, from enabled to given back.
//!
//! [`axes`] says which axis is which, [`follow`] enables, sends and watches, [`watch`] takes what the board says, [`power`] switches on and
//! off, [`remote`] is the stream for those who give orders, [`recording`] keeps what the snapshots say, [`outcome`] is what came of it.

mod axes;
mod follow;
mod outcome;
mod power;
mod recording;
mod remote;
mod watch;

use board_link::message::Snapshot;
use board_link::segment::{AxisSegment, Begin, OfAxes, Segment, Shape, StreamPhase};
use trajectory::Position;

use super::session::BoardClient;
use crate::recording::AxisNaming;
use crate::set_points::{Order, Speed};
pub(super) use axes::{Axis, OfBoard};
pub(super) use follow::Follow;
pub(super) use outcome::Outcome;
pub(super) use recording::BoardRecording;

/// What a board is to play.
pub(super) trait BoardMotion {
    /// The cycle of the board, in microseconds.
    fn cycle_us(&self) -> u32;

    /// Cycles of the motion, where that is known.
    fn cycles(&self) -> Option<u64>;

    /// The highest speed at which the motion keeps the limits of the user, in per cent: 100 at least. The board keeps those of its settings.
    fn most_percent(&self) -> u16;

    /// The axes are enabled and stand here, in counts; the stream is not begun yet, and will be at this speed. Called again and again.
    fn wait(&mut self, _stand: &[i32], _speed: Speed) {}

    /// The begin of the stream with this number, as soon as it can begin.
    fn begin(&mut self, stream: u32, stand: &[i32]) -> Option<Begin>;

    /// Hands segments to the client of the board, as far as it has room for them, and the end.
    fn feed(&mut self, client: &mut BoardClient);

    /// The board has said how it is; `state` is that of the stream, once it is begun.
    fn watch(&mut self, _state: &StreamState) {}

    /// An order that comes with the motion.
    fn next_order(&mut self) -> Option<Order> {
        None
    }

    /// What the user has to be told, oldest first.
    fn next_notice(&mut self) -> Option<String> {
        None
    }

    /// What the axes are called, when that becomes known on the way.
    fn take_naming(&mut self) -> Option<Vec<AxisNaming>> {
        None
    }

    /// Whether it has an end only because nothing came any more.
    fn has_run_out(&self) -> bool {
        false
    }

    /// Why it was the motion itself that gave the order to stop, if it did.
    fn has_given_up(&self) -> Option<GivenUp> {
        None
    }
}

/// Why a motion stops itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum GivenUp {
    /// Nothing comes any more.
    RanOut,
    /// What comes cannot be played; why.
    Unplayable(String),
}

/// How a stream goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct StreamState {
    pub(super) phase: StreamPhase,
    /// Cycles of the stream that have passed, and segments that were played to their end.
    pub(super) time_cycles: u32,
    pub(super) finished: u32,
    pub(super) speed: Speed,
}

impl StreamState {
    fn of(snapshot: &Snapshot, speed: Speed) -> Self {
        Self {
            phase: snapshot.player.phase,
            time_cycles: snapshot.player.time_cycles,
            finished: snapshot.player.finished,
            speed,
        }
    }
}

/// Where axes stand, in counts, as a segment has it.
pub(super) fn units(counts: &[i32]) -> OfAxes<i64> {
    let units = |counts: &i32| Position::from_counts(*counts).units();
    counts.iter().map(units).collect()
}

/// Puts the axes that move among those of the board, where they stand; the others stand still.
pub(super) fn place(segment: &Segment, places: &[usize], from: &[i32]) -> Segment {
    let stand = |end| AxisSegment {
        end,
        shape: Shape::Line,
    };
    let mut axes: OfAxes<AxisSegment> = units(from).into_iter().map(stand).collect();
    for (way, &place) in segment.axes.iter().zip(places) {
        if let Some(axis) = axes.get_mut(place) {
            *axis = AxisSegment {
                end: axis.end + way.end,
                shape: way.shape,
            };
        }
    }
    Segment {
        duration: segment.duration,
        axes,
    }
}
