//! DYN drives: which side sent a frame, and what it means.
//!
//! Requests and replies share identifiers (1.6A section 4; D5, D6), and the reply to General_Read does not say whether it is a position or a
//! torque (D31). Both follow from the conversation alone:
//!
//! - a function without a reply is a request, Drive_Error is from a drive;
//! - while a request is open, what decodes as its reply is its reply, otherwise it is asked again;
//! - without an open request, what decodes as a request is a request; the rest is a reply that came late or twice, or whose
//!   request is not in the log, and the message says which.
//!
//! A drive's revision is recognised by the length of its Read_Param_Group3 reply (D62).

mod message;
mod values;
mod words;

use dyn_can::{
    Address, DataFrame, DecodeError, Dialect, DynFrame, FunctionCode, Reply, ReplyKind, Request,
    Revision, ZeroAddress,
};

use crate::conversation::{Conversation, Direction, since};
use crate::frame::Frame;
pub use message::{Content, Message, Note};
pub use words::Said;

/// How to listen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// The revision of every drive; `None` to recognise it, and to read 1.6A until then.
    pub revision: Option<Revision>,
    /// A data byte on requests that need none (D11): when some master on the bus sends it.
    pub read_dummy: Option<u8>,
    /// How long a request stays open. The documents lost their figure (D65); this is the master's default.
    pub reply_window_ns: u64,
    /// The same frame again within this time was probably repeated by CAN itself. Its end comes one error frame and one frame later:
    /// about 100 bits, more when others get in between. Shorter than the shortest cycle.
    pub repeat_window_ns: u64,
}

impl Settings {
    /// Recognise the revision, no dummy bytes, 10 ms for a reply, 200 us for a repetition.
    pub const DEFAULT: Self = Self {
        revision: None,
        read_dummy: None,
        reply_window_ns: 10_000_000,
        repeat_window_ns: 200_000,
    };
}

impl Default for Settings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What is remembered of one identifier.
#[derive(Debug, Clone, Copy, Default)]
struct Slot {
    /// The request that waits for its reply, and when it ended.
    open: Option<(ReplyKind, Option<u64>)>,
    /// What was awaited last: the kind of a reply that comes late or twice.
    kind: Option<ReplyKind>,
    /// The latest frame and when it ended.
    last: Option<(DataFrame, Option<u64>)>,
}

/// The conversation with all DYN drives on a bus.
#[derive(Debug, Clone)]
pub struct DynDrives {
    settings: Settings,
    /// The recognised revision of each drive id.
    revisions: [Option<Revision>; 64],
    /// One for each 11-bit identifier.
    slots: Vec<Slot>,
}

impl Default for DynDrives {
    fn default() -> Self {
        Self::new(Settings::DEFAULT)
    }
}

impl DynDrives {
    /// A conversation of which nothing has been heard yet.
    #[must_use]
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            revisions: [None; 64],
            slots: vec![Slot::default(); 1 << 11],
        }
    }

    /// The revision of a drive as far as it is known.
    fn revision(&self, address: Address) -> Option<Revision> {
        let recognised = || {
            let drive = address.drive()?;
            *self.revisions.get(usize::from(drive.get()))?
        };
        self.settings.revision.or_else(recognised)
    }

    /// How a monitor reads: whatever can be read, since refusing protects nobody here.
    fn dialect(&self, frame: &DataFrame) -> Dialect {
        let function = frame.function();
        let revision = self.revision(frame.address()).unwrap_or_else(|| {
            // Until the revision is known, a function that only one of them has tells it.
            if function.admit_request(Revision::V1_6A).is_err() {
                Revision::V1_2A
            } else {
                Revision::V1_6A
            }
        });
        Dialect {
            read_dummy: self.settings.read_dummy,
            accept_beyond_28_bit: true,
            zero_address: ZeroAddress::LoneFreshDrive,
            allow_assign_zero: true,
            ..Dialect::of(revision)
        }
    }

    fn recognise(&mut self, frame: &DataFrame) {
        if self.settings.revision.is_some() || frame.function() != FunctionCode::ReadParamGroup3 {
            return;
        }
        let drive = frame.address().drive().map_or(0, dyn_can::DriveId::get);
        let revision = Revision::from_group3_reply_len(usize::from(frame.len()));
        if let (Some(place), Some(_)) = (self.revisions.get_mut(usize::from(drive)), revision) {
            *place = revision;
        }
    }

    fn slot(&mut self, frame: &DataFrame) -> &mut Slot {
        // An identifier has 11 bits, and there is a slot for each.
        &mut self.slots[usize::from(frame.id() & 0x7FF)]
    }

    fn read(&mut self, at_ns: Option<u64>, frame: &DataFrame) -> (Content, Option<Note>) {
        self.recognise(frame);
        let dialect = self.dialect(frame);
        let settings = self.settings;
        let slot = self.slot(frame);
        let repeated = slot
            .last
            .filter(|(last, _)| last == frame)
            .and_then(|(_, last_ns)| since(at_ns, last_ns))
            .filter(|after_ns| *after_ns < settings.repeat_window_ns)
            .map(|after_ns| Note::Repeated { after_ns });
        let content = match frame.function() {
            FunctionCode::DriveError => (reply(frame, None, &dialect, None), None),
            function if function.admit_reply(dialect.revision).is_err() => {
                (request(frame, &dialect), None)
            }
            _ => slot.read_two_way(at_ns, frame, &dialect, &settings, repeated.is_some()),
        };
        slot.last = Some((*frame, at_ns));
        (content.0, repeated.or(content.1))
    }
}

impl Slot {
    /// A function whose requests and replies share this identifier.
    fn read_two_way(
        &mut self,
        at_ns: Option<u64>,
        frame: &DataFrame,
        dialect: &Dialect,
        settings: &Settings,
        is_repeated: bool,
    ) -> (Content, Option<Note>) {
        let is_open = self.open.is_some();
        let asked_ago_ns = self.open.and_then(|(_, asked_ns)| since(at_ns, asked_ns));
        let is_late = asked_ago_ns.is_some_and(|ago_ns| ago_ns > settings.reply_window_ns);
        if is_open && !is_late && Reply::decode(frame, self.kind, dialect).is_ok() {
            self.open = None;
            return (reply(frame, self.kind, dialect, asked_ago_ns), None);
        }
        if let Ok((_, asked)) = Request::decode(frame, dialect) {
            let note = is_open.then_some(Note::NoReply {
                after_ns: asked_ago_ns,
            });
            self.kind = asked.reply_kind();
            self.open = self.kind.map(|kind| (kind, at_ns));
            return (Content::Request(asked), note);
        }
        self.open = None;
        let note = match asked_ago_ns {
            Some(after_ns) if is_late => Some(Note::Late { after_ns }),
            _ if is_open => None,
            _ => Some(Note::Unasked),
        };
        // Without its request a reading may be either, even when an earlier one was asked for.
        let kind = self.kind.filter(|_| is_open || is_repeated);
        (reply(frame, kind, dialect, asked_ago_ns), note)
    }
}

fn request(frame: &DataFrame, dialect: &Dialect) -> Content {
    match Request::decode(frame, dialect) {
        Ok((_, request)) => Content::Request(request),
        Err(error) => Content::Undecodable {
            direction: Direction::ToDrive,
            error,
        },
    }
}

fn reply(
    frame: &DataFrame,
    kind: Option<ReplyKind>,
    dialect: &Dialect,
    response_ns: Option<u64>,
) -> Content {
    match Reply::decode(frame, kind, dialect) {
        Ok((_, reply)) => Content::Reply { reply, response_ns },
        Err(DecodeError::SelectorUnknown) => reading_of_either_kind(frame, dialect),
        Err(error) => Content::Undecodable {
            direction: Direction::FromDrive,
            error,
        },
    }
}

/// A General_Read reply whose request nobody saw (D31).
fn reading_of_either_kind(frame: &DataFrame, dialect: &Dialect) -> Content {
    match Reply::decode(frame, Some(ReplyKind::Position), dialect) {
        Ok((_, Reply::Position(value))) => Content::PositionOrTorque { value },
        Ok(_) => Content::Undecodable {
            direction: Direction::FromDrive,
            error: DecodeError::SelectorUnknown,
        },
        Err(error) => Content::Undecodable {
            direction: Direction::FromDrive,
            error,
        },
    }
}

impl Conversation for DynDrives {
    type Message = Message;

    fn hear(&mut self, at_ns: Option<u64>, frame: &Frame) -> Option<Message> {
        let frame = DataFrame::from_parts(
            frame.id(),
            frame.is_extended(),
            frame.is_remote(),
            frame.data(),
        )
        .ok()?;
        let (content, note) = self.read(at_ns, &frame);
        Some(Message {
            address: frame.address(),
            function: frame.function(),
            content,
            note,
        })
    }
}

#[cfg(test)]
mod tests;
