//! The latest readings of a drive.

use bus_user::Instant;
use dyn_can::{ConfigByte, DriveStatus, ParamGroup3, Revision, Torque};

use crate::core::snapshot::Stamped;
use crate::servo::poll_kind::PollKind;

/// The latest readings of one drive; `None` before the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Feedback {
    /// Status byte.
    pub status: Option<Stamped<DriveStatus>>,
    /// Position in read-back counts.
    pub position: Option<Stamped<i32>>,
    /// Torque.
    pub torque: Option<Stamped<Torque>>,
    /// Motor speed in rpm.
    pub speed_rpm: Option<Stamped<i16>>,
    /// Diagnostic counter.
    pub counter: Option<Stamped<u8>>,
    /// Configuration byte, read once at the start.
    pub config: Option<ConfigByte>,
    /// Parameter group 3, read once at the start.
    pub group3: Option<ParamGroup3>,
    /// The revision in use, once it is known.
    pub revision: Option<Revision>,
}

impl Feedback {
    /// When a polled value came last.
    #[must_use]
    pub fn polled_at(&self, kind: PollKind) -> Option<Instant> {
        match kind {
            PollKind::Status => self.status.map(|stamped| stamped.at),
            PollKind::Position => self.position.map(|stamped| stamped.at),
            PollKind::Torque => self.torque.map(|stamped| stamped.at),
            PollKind::Speed => self.speed_rpm.map(|stamped| stamped.at),
            PollKind::Counter => self.counter.map(|stamped| stamped.at),
        }
    }
}
