//! What a host asks of a board.

use serde::{Deserialize, Serialize};

use super::Chunk;
use crate::segment::{Begin, Segment};

/// A message of a host.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ToBoard {
    /// The reply has the same number. A request that is repeated has the same bytes, so it is answered again and not carried out again.
    pub number: u16,
    /// The session that claimed the command; 0 for a host that only reads.
    pub session: u32,
    /// What is asked for.
    pub request: Request,
}

/// What a host asks for. The first group reads, and is answered to everybody; [`Self::Stop`] and [`Self::Halt`] are taken from everybody,
/// too; all others need the session that commands.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap, and each lives for one call"
)]
pub enum Request {
    /// Who is there? Answer: [`Answer::Info`](super::Answer::Info).
    Hello,
    /// What time is it? Answer: [`Answer::Time`](super::Answer::Time).
    TimeSync {
        /// Comes back in the answer.
        host_us: u64,
    },
    /// A piece of the settings. Answer: [`Answer::Settings`](super::Answer::Settings).
    ReadSettings {
        /// From this byte on.
        offset: u32,
    },
    /// An entry of the fault log. Answer: [`Answer::Fault`](super::Answer::Fault).
    ReadFault {
        /// 0 is the latest.
        index: u32,
    },
    /// What came in and what was lost. Answer: [`Answer::Counters`](super::Answer::Counters).
    ReadCounters,
    /// Snapshots to this host from now on.
    Snapshots {
        /// Cycles from one to the next; 0 for none.
        period: u32,
    },
    /// Events again, from this number on, as far as they are kept. Answer: [`Answer::Events`](super::Answer::Events).
    Events {
        /// The first one.
        from: u32,
    },
    /// Slow down along the path and stand.
    Stop,
    /// End all set-points at once. The drives keep their power, and follow nothing until they are enabled again.
    Halt,
    /// Take over the command, as the session of the message: any number but 0 that was not used before. Answer:
    /// [`Answer::Claimed`](super::Answer::Claimed).
    Claim,
    /// Give the command back: as a stop, if something moves.
    Release,
    /// The host lives. Answer: [`Answer::Alive`](super::Answer::Alive).
    Heartbeat,
    /// Switch the drives on.
    Enable,
    /// Slow down and switch the drives off.
    Disable,
    /// Forget faults whose cause is gone.
    Clear,
    /// Find the origins: each axis whose settings ask for it, one after the other. The reply comes when they are found, or says why not.
    Home,
    /// Begin a stream of segments.
    Begin(Begin),
    /// The next segment of it. Answer: [`Answer::Taken`](super::Answer::Taken).
    Segment {
        /// [`Begin::stream`].
        stream: u32,
        /// From 0.
        index: u32,
        /// The segment.
        segment: Segment,
    },
    /// No segment follows.
    End {
        /// [`Begin::stream`].
        stream: u32,
    },
    /// Slow down along the path, stand, and wait.
    Pause,
    /// Go on.
    Resume,
    /// Another speed.
    Override {
        /// 0 to 200.
        percent: u16,
    },
    /// A piece of new settings, in order. Answer: [`Answer::Staged`](super::Answer::Staged).
    WriteSettings {
        /// Where it belongs; 0 begins anew.
        offset: u32,
        /// Its bytes.
        bytes: Chunk,
    },
    /// Are the new settings complete, and do they make a board that works?
    CheckSettings {
        /// Their length in bytes.
        length: u32,
        /// Their [`checksum`](crate::frame::checksum).
        checksum: u32,
    },
    /// Check them, and store them for the next start.
    CommitSettings {
        /// Their length in bytes.
        length: u32,
        /// Their [`checksum`](crate::frame::checksum).
        checksum: u32,
    },
    /// What do the positions of an axis count from? Answer: [`Answer::Origin`](super::Answer::Origin).
    ReadOrigin {
        /// The axis, from 0.
        axis: u8,
    },
}

impl Request {
    /// Whether it is answered to everybody, and changes nothing but what the board reports to that host.
    #[must_use]
    pub const fn is_reading(&self) -> bool {
        matches!(
            self,
            Self::Hello
                | Self::TimeSync { .. }
                | Self::ReadSettings { .. }
                | Self::ReadFault { .. }
                | Self::ReadCounters
                | Self::Snapshots { .. }
                | Self::Events { .. }
                | Self::ReadOrigin { .. }
        )
    }

    /// Whether it only makes the axes stand, and is taken from everybody.
    #[must_use]
    pub const fn is_stopping(&self) -> bool {
        matches!(self, Self::Stop | Self::Halt)
    }
}
