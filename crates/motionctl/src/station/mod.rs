//! A motion master on this computer: the master of the firmware, a link to a bus, and the clock on the wall.
//!
//! A PC keeps time as well as it can. A cycle that begins late is counted, cycles that never began are counted, and their
//! steps are merged into the next one: the target always follows the clock, and the master owes the difference.
//!
//! What a station switches on it switches off again, whatever happens; what it found on stays on.

mod axis_options;
mod bring_up;
mod clock;
mod fault_text;
mod look;
mod motion_limits;
mod pace;
mod pc_master;
mod recording;
mod shut_down;
mod stall;
#[cfg(test)]
mod tests;

pub(crate) use axis_options::{AxisOptions, ReplyOptions};
pub(crate) use bring_up::BringUpError;
pub(crate) use clock::{Clock, serve_until};
pub(crate) use fault_text::fault_text;
pub(crate) use look::{LookError, Seen, look};
pub(crate) use motion_limits::{LimitError, MotionLimits, Needs};
pub(crate) use pace::{Pace, PaceCounts};
pub(crate) use pc_master::{GROUP, Station};
pub(crate) use recording::{BusRecorder, CycleFacts, StationRecorder};
pub(crate) use shut_down::{End, found_on, left_on, unconfirmed_warning};
pub(crate) use stall::StallWatch;
