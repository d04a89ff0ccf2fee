//! What a frame says, and what kind of frame it is.

use can_decode::dyn_drives::Content;
use can_decode::{Decoder, Direction, Meaning, canopen};
use dyn_can::{FunctionCode, Reply};

use super::about::Quantity;
use super::wire_frame::WireFrame;

/// A frame in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Description {
    /// `p` set-point, `q` request, `r` reply, `a` alarm or data error, `e` destroyed or not decoded.
    pub(crate) class: char,
    pub(crate) text: String,
}

/// Follows the conversation on the bus.
#[derive(Debug)]
pub(crate) struct Describer {
    decoder: Decoder,
}

impl Describer {
    pub(crate) fn new(quantity: Quantity) -> Self {
        Self {
            decoder: quantity.decoder(),
        }
    }

    /// Frames come in the order of the bus.
    pub(crate) fn describe(&mut self, frame: &WireFrame) -> Description {
        if !frame.is_received {
            return Description {
                class: 'e',
                text: frame.failure.unwrap_or("not received").to_owned(),
            };
        }
        let meaning = self.decoder.hear(frame.end_ns, &frame.frame);
        let said = match &meaning {
            Meaning::Dyn(message) => message.said().to_string(),
            other => other.to_string(),
        };
        match frame.failure {
            Some(failure) => Description {
                class: 'e',
                text: format!("{said} [{failure}]"),
            },
            None => Description {
                class: class_of(&meaning),
                text: said,
            },
        }
    }
}

/// Set-point, request, reply or alarm; an error where the frame says nothing.
fn class_of(meaning: &Meaning) -> char {
    let message = match meaning {
        Meaning::Dyn(message) => message,
        Meaning::Canopen(message) => return class_of_canopen(message),
        Meaning::Foreign { .. } => return 'e',
    };
    match message.content {
        Content::Request(_) if message.function == FunctionCode::GoRelativePosPd => 'p',
        Content::Request(_) => 'q',
        Content::Reply {
            reply: Reply::DriveError(_),
            ..
        } => 'a',
        Content::Reply { .. } | Content::PositionOrTorque { .. } => 'r',
        Content::Undecodable { .. } => 'e',
    }
}

/// The same on CANopen, where process data to a drive are its set-points.
fn class_of_canopen(message: &canopen::Message) -> char {
    match (message.name(), message.direction()) {
        _ if message.is_undecodable() => 'e',
        ("RPDO", _) => 'p',
        ("EMCY", _) => 'a',
        (_, Some(Direction::ToDrive)) => 'q',
        (_, Some(Direction::FromDrive)) => 'r',
        (_, None) => 'e',
    }
}
