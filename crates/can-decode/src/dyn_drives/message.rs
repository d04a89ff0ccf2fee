//! One message between a master and the DYN drives.

use dyn_can::{Address, DecodeError, FunctionCode, Reply, Request};

use crate::conversation::Direction;

/// A frame in its conversation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Message {
    /// The drive that sent or gets it, or all drives.
    pub address: Address,
    /// The function code.
    pub function: FunctionCode,
    /// What it says.
    pub content: Content,
    /// What is remarkable about it.
    pub note: Option<Note>,
}

/// What a frame says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Content {
    /// From the master.
    Request(Request),
    /// From a drive.
    Reply {
        /// What it says.
        reply: Reply,
        /// Time from the end of its request to its own end, in nanoseconds; `None` when nobody asked.
        response_ns: Option<u64>,
    },
    /// A reply to General_Read whose request was not seen (D31).
    PositionOrTorque {
        /// The number on the wire.
        value: i32,
    },
    /// A frame that is neither a request nor a reply of its function.
    Undecodable {
        /// Which side probably sent it.
        direction: Direction,
        /// Why it does not decode.
        error: DecodeError,
    },
}

/// What is remarkable about a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Note {
    /// The same frame ended just before: CAN repeats a frame after an error in its last bit, and then receivers have it twice.
    Repeated {
        /// Time since then in nanoseconds.
        after_ns: u64,
    },
    /// The same was asked before, and no reply came.
    NoReply {
        /// Time since then in nanoseconds, when it is known.
        after_ns: Option<u64>,
    },
    /// The reply came after the time in which replies are awaited.
    Late {
        /// Time since the request in nanoseconds.
        after_ns: u64,
    },
    /// A reply without a request: it came twice, or its request is not in the log.
    Unasked,
}

impl Message {
    /// Which side sent it.
    #[must_use]
    pub const fn direction(&self) -> Direction {
        match self.content {
            Content::Request(_) => Direction::ToDrive,
            Content::Reply { .. } | Content::PositionOrTorque { .. } => Direction::FromDrive,
            Content::Undecodable { direction, .. } => direction,
        }
    }

    /// Whether the frame is neither a request nor a reply of its function.
    #[must_use]
    pub const fn is_undecodable(&self) -> bool {
        matches!(self.content, Content::Undecodable { .. })
    }

    /// Whether someone who looks for trouble wants to see it.
    #[must_use]
    pub const fn is_remarkable(&self) -> bool {
        self.note.is_some()
            || matches!(
                self.content,
                Content::Undecodable { .. }
                    | Content::PositionOrTorque { .. }
                    | Content::Reply {
                        reply: Reply::DriveError(_),
                        ..
                    }
            )
    }

    /// Time from the request to this reply in nanoseconds; `None` for everything else.
    #[must_use]
    pub const fn response_ns(&self) -> Option<u64> {
        match self.content {
            Content::Reply { response_ns, .. } => response_ns,
            _ => None,
        }
    }
}
