//! What is recorded.

use super::about::AxisNaming;
use super::event::Happening;
use super::sample::Sample;
use super::wire_frame::WireFrame;

/// One thing to record.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Item {
    /// A cycle.
    Cycle(Sample),
    /// A frame.
    Frame(WireFrame),
    /// An event.
    Event(Happening),
    /// The motion begins with the cycle of this number.
    MotionBegins { at_us: u64, number: u64 },
    /// A stream names its axes, in the order of the columns.
    Naming(Vec<AxisNaming>),
}
