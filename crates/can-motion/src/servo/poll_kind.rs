//! The values that can be polled.

use core::fmt;

use dyn_can::ReplyKind;

/// A value that is read again and again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PollKind {
    /// Status byte.
    Status,
    /// Position.
    Position,
    /// Torque.
    Torque,
    /// Motor speed.
    Speed,
    /// Diagnostic counter.
    Counter,
}

impl PollKind {
    /// Every kind.
    pub const ALL: [Self; 5] = [
        Self::Status,
        Self::Position,
        Self::Torque,
        Self::Speed,
        Self::Counter,
    ];

    /// The reply that answers this poll.
    #[must_use]
    #[inline(always)]
    pub const fn reply_kind(self) -> ReplyKind {
        match self {
            Self::Status => ReplyKind::DriveStatus,
            Self::Position => ReplyKind::Position,
            Self::Torque => ReplyKind::Torque,
            Self::Speed => ReplyKind::MotorSpeed,
            Self::Counter => ReplyKind::DiagnosticCounter,
        }
    }

    /// The poll that a reply answers.
    #[must_use]
    #[inline(always)]
    pub const fn of_reply(reply: ReplyKind) -> Option<Self> {
        Some(match reply {
            ReplyKind::DriveStatus => Self::Status,
            ReplyKind::Position => Self::Position,
            ReplyKind::Torque => Self::Torque,
            ReplyKind::MotorSpeed => Self::Speed,
            ReplyKind::DiagnosticCounter => Self::Counter,
            _ => return None,
        })
    }
}

impl fmt::Display for PollKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Status => "status",
            Self::Position => "position",
            Self::Torque => "torque",
            Self::Speed => "speed",
            Self::Counter => "diagnostic counter",
        })
    }
}
