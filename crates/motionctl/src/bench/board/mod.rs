//! A simulated motion board on the bus of the bench, with a serial port that hosts open: the protocol and the master of the firmware, in the
//! time of the bus.
//!
//! [`rules`] is what the inputs let happen, [`machine`] the cycle, [`application`] what the protocol asks of both, [`store`] the flash,
//! [`inputs`] what is at the terminals of the board, [`fault_log`] what it remembers. None of it is code of the firmware.

mod application;
mod fault_log;
mod inputs;
mod machine;
mod options;
mod report;
mod rules;
mod seat;
mod store;

pub(super) use options::BoardOptions;
pub(super) use report::BoardReport;
pub(super) use seat::{Running, Seat};

/// Most axes, as on the boards.
const AXES: usize = board_link::segment::MOST_AXES;
/// Segments that wait, and one place more: as on the boards.
const SEGMENTS: usize = 57;

/// The memory of a stream, anew with each start.
pub(super) type Queue = board_link::segment::SegmentQueue<AXES, SEGMENTS>;
