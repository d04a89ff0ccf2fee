//! What the client tells its caller.

use core::fmt;

use crate::address::DriveId;
use crate::error::{DecodeError, EncodeError};
use crate::packet::Packet;
use crate::reply::Reply;

/// What to do next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[must_use]
pub enum Poll {
    /// Nothing is asked.
    Idle,
    /// Write these bytes now. The client counts them as sent.
    Transmit(Packet),
    /// Come back with received bytes, or at this time.
    Wait {
        /// In microseconds.
        until_us: u64,
    },
    /// The request is done; the client is idle again.
    Done(Result<Answer, Failure>),
}

/// How a request ended well.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Answer {
    /// A command was handed over; its bytes may still be on their way. Nothing says whether a drive obeyed.
    Sent,
    /// A read was answered.
    Reply {
        /// By this drive.
        from: DriveId,
        /// With this.
        reply: Reply,
    },
}

/// How a request ended badly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Failure {
    /// Nothing that belongs to the request came in time.
    NoReply {
        /// How often it was sent.
        attempts: u8,
    },
    /// A reply came with the right function and id, and with wrong data; the last one of these.
    BadReply {
        /// How often the request was sent.
        attempts: u8,
        /// What was wrong.
        error: DecodeError,
    },
    /// Every packet that reads as the reply also reads as a request that was sent before and comes back, and the line was too disturbed
    /// to tell which it is. Nothing is known of the drive.
    Doubtful {
        /// How often the request was sent.
        attempts: u8,
    },
    /// The port took no more than a part of the request; a drive hears a packet that is cut short.
    NotTaken {
        /// Bytes that it took.
        taken: usize,
    },
    /// The line was never quiet for long enough, and nothing was sent.
    NotQuiet {
        /// How long the client waited.
        waited_us: u32,
    },
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoReply { attempts } => {
                write!(f, "expected a reply, got none in {attempts} attempts")
            }
            Self::BadReply { attempts, error } => {
                write!(f, "bad reply in {attempts} attempts: {error}")
            }
            Self::Doubtful { attempts } => write!(
                f,
                "expected a reply, got in {attempts} attempts only what may be the echo of a request sent before: is the line two-wire, or is noise on it?"
            ),
            Self::NotTaken { taken } => write!(
                f,
                "expected the port to take a whole packet, it took {taken} bytes"
            ),
            Self::NotQuiet { waited_us } => write!(
                f,
                "expected a quiet line, got bytes for {waited_us} us: is another host on it?"
            ),
        }
    }
}

impl core::error::Error for Failure {}

/// A request was not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Busy {
    /// Another one is not done.
    Outstanding,
    /// It cannot be sent at all.
    Encode(EncodeError),
}

impl fmt::Display for Busy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Outstanding => f.write_str("expected no outstanding request, got one"),
            Self::Encode(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for Busy {}

/// What came in beside the awaited replies, counted; a count stops at its largest value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Traffic {
    /// Replies to the outstanding request.
    pub replies: u32,
    /// Packets that were sent: the line brings them back, or a chain passed them all around.
    pub echoes: u32,
    /// Packets that are not the reply that is awaited: late, from another drive, of another function.
    pub unexpected: u32,
    /// Packets that read as the awaited reply, and as one that was sent before.
    pub doubtful: u32,
    /// Awaited replies with a wrong number of data bytes.
    pub wrong_length: u32,
    /// Awaited replies with a number out of range.
    pub out_of_range: u32,
    /// Requests sent again.
    pub retries: u32,
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;
    use crate::function::RequestFunction;

    #[test]
    fn what_went_wrong_is_told_with_what_was_expected() {
        let error = DecodeError::ReplyFromAll;
        let golden = [
            (
                Failure::NoReply { attempts: 3 },
                "expected a reply, got none in 3 attempts",
            ),
            (
                Failure::BadReply { attempts: 2, error },
                "bad reply in 2 attempts: expected a reply from one drive, got one from the general id 127",
            ),
            (
                Failure::Doubtful { attempts: 1 },
                "expected a reply, got in 1 attempts only what may be the echo of a request sent before: is the line two-wire, or is noise on it?",
            ),
            (
                Failure::NotTaken { taken: 3 },
                "expected the port to take a whole packet, it took 3 bytes",
            ),
            (
                Failure::NotQuiet { waited_us: 100_000 },
                "expected a quiet line, got bytes for 100000 us: is another host on it?",
            ),
        ];
        for (failure, text) in golden {
            assert_eq!(failure.to_string(), text);
        }
        let function = RequestFunction::ReadDriveId;
        let error = EncodeError::Broadcast { function };
        assert_eq!(Busy::Encode(error).to_string(), error.to_string());
        assert_eq!(
            Busy::Outstanding.to_string(),
            "expected no outstanding request, got one"
        );
    }
}
