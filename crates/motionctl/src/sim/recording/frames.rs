//! The frames on the wire with what they mean, in little memory: every text is kept once.

use std::collections::HashMap;
use std::collections::VecDeque;

use can_decode::dyn_drives::Content;
use can_decode::{Decoder, Frame, Meaning};
use drive_sim::{Outcome, Record};
use dyn_can::{FunctionCode, Reply};

/// Frames that are kept; older ones go. About half a minute of a full bus, some megabytes of page.
const MOST: usize = 300_000;

/// One attempt on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Sighting {
    pub(crate) start_ns: u64,
    /// From the start to the end of the last EOF bit, or of the bit in which the error was seen.
    pub(crate) bits: u32,
    /// Which of the texts.
    pub(crate) text: usize,
}

/// The newest frames of a run.
#[derive(Debug, Default)]
pub(crate) struct Frames {
    decoder: Decoder,
    sightings: VecDeque<Sighting>,
    texts: Vec<String>,
    numbers: HashMap<String, usize>,
    forgotten: u64,
}

impl Frames {
    pub(crate) fn push(&mut self, record: &Record, bit_ns: u64) {
        let Some(frame) = Frame::from_can(&record.frame) else {
            return;
        };
        let text = self.words(record, &frame);
        let text = match self.numbers.get(&text) {
            Some(&number) => number,
            None => {
                self.texts.push(text.clone());
                self.numbers.insert(text, self.texts.len() - 1);
                self.texts.len() - 1
            }
        };
        if self.sightings.len() == MOST {
            self.sightings.pop_front();
            self.forgotten += 1;
        }
        self.sightings.push_back(Sighting {
            start_ns: record.start_ns,
            bits: ((record.end_ns - record.start_ns) / bit_ns) as u32,
            text,
        });
    }

    /// `p|03C FF 88|to drive 1 ...`: the class by which the strip colours it, the frame, what it says.
    fn words(&mut self, record: &Record, frame: &Frame) -> String {
        let failure = failure(record.outcome);
        if !record.outcome.is_received() {
            return format!("e|{frame}|{}", failure.unwrap_or("not received"));
        }
        let meaning = self.decoder.hear(record.end_ns, frame);
        let said = match &meaning {
            Meaning::Dyn(message) => message.said().to_string(),
            other => other.to_string(),
        };
        let class = if failure.is_some() {
            'e'
        } else {
            class_of(&meaning)
        };
        match failure {
            Some(failure) => format!("{class}|{frame}|{said} [{failure}]"),
            None => format!("{class}|{frame}|{said}"),
        }
    }

    pub(crate) fn sightings(&self) -> impl ExactSizeIterator<Item = &Sighting> {
        self.sightings.iter()
    }

    pub(crate) fn texts(&self) -> &[String] {
        &self.texts
    }

    /// Frames that were on the wire before the oldest one that is kept.
    pub(crate) fn forgotten(&self) -> u64 {
        self.forgotten
    }
}

/// How an attempt failed.
const fn failure(outcome: Outcome) -> Option<&'static str> {
    match outcome {
        Outcome::Delivered => None,
        Outcome::EofError => {
            Some("received, but repeated by its sender after an error in its last bit")
        }
        Outcome::BitError => Some("destroyed by a bit error"),
        Outcome::Collision => Some("destroyed by a frame with the same identifier"),
        Outcome::AckError => Some("acknowledged by nobody"),
        Outcome::Interrupted => Some("cut off: its sender left the bus"),
        _ => Some("not received"),
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
