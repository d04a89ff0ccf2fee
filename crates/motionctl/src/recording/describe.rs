//! What a frame says, and what kind of frame it is.

use can_decode::dyn_drives::Content;
use can_decode::{Decoder, Meaning};
use dyn_can::{FunctionCode, Reply};

use super::wire_frame::WireFrame;

/// A frame in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Description {
    /// `p` set-point, `q` request, `r` reply, `a` alarm or data error, `e` destroyed or not decoded.
    pub(crate) class: char,
    pub(crate) text: String,
}

/// Follows the conversation on the bus.
#[derive(Debug, Default)]
pub(crate) struct Describer {
    decoder: Decoder,
}

impl Describer {
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
    let Meaning::Dyn(message) = meaning else {
        return 'e';
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
