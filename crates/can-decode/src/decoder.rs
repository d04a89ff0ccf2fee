//! Asks the protocols on a bus in turn.

use core::fmt;

use dyn_can::FrameError;
use serde::Serialize;

use crate::conversation::Conversation;
use crate::dyn_drives::{self, DynDrives};
use crate::frame::Frame;

/// Everything that is followed on one bus.
#[derive(Debug, Clone, Default)]
pub struct Decoder {
    dyn_drives: DynDrives,
}

/// What a frame means.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "protocol", rename_all = "snake_case")]
pub enum Meaning {
    /// A message of the DYN drives' protocol.
    Dyn(dyn_drives::Message),
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
            dyn_drives: DynDrives::new(settings),
        }
    }

    /// Reads a frame that ended at `at_ns`; see [`Conversation::hear`].
    pub fn hear(&mut self, at_ns: u64, frame: &Frame) -> Meaning {
        match self.dyn_drives.hear(at_ns, frame) {
            Some(message) => Meaning::Dyn(message),
            None => Meaning::Foreign {
                error: foreign(frame),
            },
        }
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
            Self::Foreign { .. } => true,
        }
    }

    /// Whether someone who looks for trouble wants to see it: it does not decode, came twice, late or unasked, asks again for what was
    /// not answered, or is an alarm or a data error.
    #[must_use]
    pub fn is_remarkable(&self) -> bool {
        match self {
            Self::Dyn(message) => message.is_remarkable(),
            Self::Foreign { .. } => true,
        }
    }

    /// The drive that sent or gets it; `None` for a message to all and a foreign frame.
    #[must_use]
    pub fn drive(&self) -> Option<u8> {
        match self {
            Self::Dyn(message) => message.address.drive().map(dyn_can::DriveId::get),
            Self::Foreign { .. } => None,
        }
    }

    /// The function by the name in the documents; empty for a foreign frame.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Dyn(message) => message.function.name(),
            Self::Foreign { .. } => "",
        }
    }

    /// Time from the request to this reply in nanoseconds.
    #[must_use]
    pub fn response_ns(&self) -> Option<u64> {
        match self {
            Self::Dyn(message) => message.response_ns(),
            Self::Foreign { .. } => None,
        }
    }
}

impl fmt::Display for Meaning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dyn(message) => message.fmt(f),
            Self::Foreign { error } => write!(f, "not of a DYN drive: {error}"),
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
            "not of a DYN drive: expected an 11-bit identifier, got the 29-bit identifier 0x00012345"
        );
        assert_eq!(
            text(Frame::remote(0x029, false, 0)),
            "not of a DYN drive: expected a data frame, got a remote frame for 0x029"
        );
    }
}
