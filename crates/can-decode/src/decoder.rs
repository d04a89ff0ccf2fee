//! Asks the protocols on a bus in turn.

use core::fmt;

use dyn_can::FrameError;
use serde::Serialize;

use crate::canopen::{self, Canopen};
use crate::conversation::Conversation;
use crate::dyn_drives::{self, DynDrives};
use crate::frame::Frame;

/// Everything that is followed on one bus.
#[derive(Debug, Clone, Default)]
pub struct Decoder {
    protocol: Protocol,
}

/// A bus speaks one protocol: the two use the same identifiers (D9).
#[derive(Debug, Clone)]
enum Protocol {
    Dyn(Box<DynDrives>),
    Canopen(Box<Canopen>),
}

impl Default for Protocol {
    fn default() -> Self {
        Self::Dyn(Box::default())
    }
}

/// What a frame means.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "protocol", rename_all = "snake_case")]
pub enum Meaning {
    /// A message of the DYN drives' protocol.
    Dyn(dyn_drives::Message),
    /// A message of CANopen.
    Canopen(canopen::Message),
    /// A frame that no drive on this bus sends or hears.
    Foreign {
        /// Why.
        #[serde(serialize_with = "as_text")]
        error: FrameError,
    },
}

fn as_text<S: serde::Serializer>(
    text: &impl fmt::Display,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_str(text)
}

impl Decoder {
    /// A decoder with these settings for the DYN drives.
    #[must_use]
    pub fn new(settings: dyn_drives::Settings) -> Self {
        Self {
            protocol: Protocol::Dyn(Box::new(DynDrives::new(settings))),
        }
    }

    /// A decoder for a bus with CANopen drives.
    #[must_use]
    pub fn canopen() -> Self {
        Self {
            protocol: Protocol::Canopen(Box::default()),
        }
    }

    /// Reads a frame that ended at `at_ns`; see [`Conversation::hear`].
    pub fn hear(&mut self, at_ns: impl Into<Option<u64>>, frame: &Frame) -> Meaning {
        let at_ns = at_ns.into();
        let meaning = match &mut self.protocol {
            Protocol::Dyn(drives) => drives.hear(at_ns, frame).map(Meaning::Dyn),
            Protocol::Canopen(drives) => drives.hear(at_ns, frame).map(Meaning::Canopen),
        };
        meaning.unwrap_or_else(|| Meaning::Foreign {
            error: foreign(frame),
        })
    }
}

fn foreign(frame: &Frame) -> FrameError {
    if frame.is_extended() {
        FrameError::Extended { id: frame.id() }
    } else {
        FrameError::Remote { id: frame.id() }
    }
}

impl Meaning {
    /// Whether the frame could not be read as any message.
    #[must_use]
    pub fn is_undecodable(&self) -> bool {
        match self {
            Self::Dyn(message) => message.is_undecodable(),
            Self::Canopen(message) => message.is_undecodable(),
            Self::Foreign { .. } => true,
        }
    }

    /// Whether someone who looks for trouble wants to see it: it does not decode, came twice, late or unasked, asks again for what was
    /// not answered, or is an alarm or a data error.
    #[must_use]
    pub fn is_remarkable(&self) -> bool {
        match self {
            Self::Dyn(message) => message.is_remarkable(),
            Self::Canopen(message) => message.is_remarkable(),
            Self::Foreign { .. } => true,
        }
    }

    /// The drive that sent or gets it; `None` for a message to all and a foreign frame.
    #[must_use]
    pub fn drive(&self) -> Option<u8> {
        match self {
            Self::Dyn(message) => message.address.drive().map(dyn_can::DriveId::get),
            Self::Canopen(message) => message.node(),
            Self::Foreign { .. } => None,
        }
    }

    /// The function by the name in the documents; empty for a foreign frame.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Dyn(message) => message.function.name(),
            Self::Canopen(message) => message.name(),
            Self::Foreign { .. } => "",
        }
    }

    /// Time from the request to this reply in nanoseconds.
    #[must_use]
    pub fn response_ns(&self) -> Option<u64> {
        match self {
            Self::Dyn(message) => message.response_ns(),
            Self::Canopen(message) => message.response_ns(),
            Self::Foreign { .. } => None,
        }
    }
}

impl fmt::Display for Meaning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dyn(message) => message.fmt(f),
            Self::Canopen(message) => message.fmt(f),
            Self::Foreign { error } => write!(f, "not of a drive: {error}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_that_no_drive_knows_are_named() {
        let mut decoder = Decoder::default();
        let mut text = |frame: Option<Frame>| decoder.hear(0, &frame.unwrap()).to_string();
        assert_eq!(
            text(Frame::new(0x12345, true, &[])),
            "not of a drive: expected an 11-bit identifier, got the 29-bit identifier 0x00012345"
        );
        assert_eq!(
            text(Frame::remote(0x029, false, 0)),
            "not of a drive: expected a data frame, got a remote frame for 0x029"
        );
    }
}
