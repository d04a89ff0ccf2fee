//! What a board says unasked.

use serde::{Deserialize, Serialize};

use crate::segment::{OfAxes, PlayerState, StreamPhase};

/// Where the machine is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum BoardState {
    /// Without settings it moves nothing.
    #[default]
    NoSettings,
    /// The firmware failed; the board must be switched off and on.
    Locked,
    /// The stop circuit is open.
    StopOpen,
    /// The enable input is not active.
    EnableInactive,
    /// The drives are off.
    Off,
    /// The drives are on their way to be enabled.
    GettingReady,
    /// The drives are enabled and stand, or follow a stream.
    Enabled,
    /// The axes find their origins.
    Homing,
    /// The axes slow down.
    Stopping,
    /// An axis has a fault.
    Faulted,
    /// All set-points were ended, and the drives hold with power until they are enabled again or disabled.
    Halted,
}

impl BoardState {
    /// By their numbers.
    const ALL: [Self; 11] = [
        Self::NoSettings,
        Self::Locked,
        Self::StopOpen,
        Self::EnableInactive,
        Self::Off,
        Self::GettingReady,
        Self::Enabled,
        Self::Homing,
        Self::Stopping,
        Self::Faulted,
        Self::Halted,
    ];

    /// The state with this number, as refusals have it.
    #[must_use]
    #[inline]
    pub fn with_number(number: i64) -> Option<Self> {
        Self::ALL.get(usize::try_from(number).ok()?).copied()
    }

    /// In words.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::NoSettings => "no settings",
            Self::Locked => "locked by a failure of its firmware",
            Self::StopOpen => "the stop circuit is open",
            Self::EnableInactive => "the enable input is not active",
            Self::Off => "off",
            Self::GettingReady => "getting ready",
            Self::Enabled => "enabled",
            Self::Homing => "homing",
            Self::Stopping => "stopping",
            Self::Faulted => "faulted",
            Self::Halted => "halted, the drives hold",
        }
    }
}

const _: () = {
    let mut number = 0;
    while number < BoardState::ALL.len() {
        assert!(BoardState::ALL[number] as usize == number);
        number += 1;
    }
};

/// How everything is.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Snapshot {
    /// The cycle.
    pub cycle: u64,
    /// Where the machine is.
    pub state: BoardState,
    /// The stream that was begun last.
    pub stream: u32,
    /// What becomes of it.
    pub player: PlayerState,
    /// Its next segment.
    pub next_segment: u32,
    /// So many segments may be sent from that one on.
    pub credit: u32,
    /// The number of the next event: a host that has fewer asks for them.
    pub events: u32,
    /// The axes.
    pub axes: OfAxes<AxisSnapshot>,
}

/// An axis, in command counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct AxisSnapshot {
    /// Its set-point.
    pub target: i32,
    /// Its position.
    pub position: i32,
    /// Its following error.
    pub error: i32,
    /// The application's number of its fault; 0 for none.
    pub fault: u16,
}

/// What the positions of an axis count from. All positions on the link are counts of the drive: the place of the axis is that less its origin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Origin {
    /// The zero of its drive: its settings ask for no homing.
    #[default]
    OfDrive,
    /// Its settings ask for a homing, and it was not homed since its drive follows set-points. It takes no segment.
    Unknown,
    /// It was homed.
    Found {
        /// What the drive counts at the zero of the axis.
        counts: i32,
        /// By how much that may be off, as far as it can be seen, in counts.
        uncertainty: u32,
    },
}

impl Origin {
    /// What the drive counts at the zero of the axis; `None` where that is not known.
    #[must_use]
    pub const fn counts(self) -> Option<i32> {
        match self {
            Self::OfDrive => Some(0),
            Self::Unknown => None,
            Self::Found { counts, .. } => Some(counts),
        }
    }
}

/// Something that has happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Event {
    /// The machine is in another state.
    State(BoardState),
    /// A stream is in another phase.
    Stream {
        /// Its number.
        stream: u32,
        /// Its phase.
        phase: StreamPhase,
        /// Segments that were played to their end.
        finished: u32,
    },
    /// A fault.
    Fault {
        /// The axis, where it is about one.
        axis: Option<u8>,
        /// The application's number of the fault.
        code: u16,
        /// What else is known of it.
        detail: i32,
    },
    /// A session has the command.
    Claimed {
        /// Its number.
        session: u32,
    },
    /// A session has given the command back.
    Released {
        /// Its number.
        session: u32,
    },
    /// The host that commands was silent for too long: the axes stop, and nobody commands.
    SilentHost {
        /// The number of the session.
        session: u32,
    },
    /// An axis has found its origin.
    Homed {
        /// The axis.
        axis: u8,
        /// What its drive counts there.
        counts: i32,
        /// By how much that may be off, in counts.
        uncertainty: u32,
    },
}
