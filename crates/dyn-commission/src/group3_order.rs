//! Which byte order the reply of parameter group 3 has (D19 to D21): both are tried on one reply. Nothing is written.

use dyn_can::{
    Address, ByteOrder, Dialect, DriveId, Group3ReplyOrder, ParamGroup3, Reply, ReplyKind, Request,
    Revision,
};

use crate::{Exchange, Heard, LISTEN_US, Script};

/// One reply read in both orders.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Group3Readings {
    /// The revision that the length of the reply tells (D62).
    pub revision: Revision,
    /// The values with the most significant byte first; `None` when one is out of its range then.
    pub msb_first: Option<ParamGroup3>,
    /// The values with the least significant byte first; `None` when one is out of its range then.
    pub lsb_first: Option<ParamGroup3>,
}

impl Group3Readings {
    /// The order in which the reply can be read, `None` when both give legal values that differ, or none does.
    #[must_use]
    pub fn order(&self) -> Option<ByteOrder> {
        match (self.msb_first, self.lsb_first) {
            (Some(_), None) => Some(ByteOrder::MsbFirst),
            (None, Some(_)) => Some(ByteOrder::LsbFirst),
            _ => None,
        }
    }
}

/// Reads parameter group 3 once.
#[derive(Debug)]
pub struct Group3Order {
    drive: DriveId,
    listen_us: u32,
    is_asked: bool,
}

impl Group3Order {
    /// Reads the reply of one drive.
    #[must_use]
    pub const fn of(drive: DriveId) -> Self {
        Self {
            drive,
            listen_us: LISTEN_US,
            is_asked: false,
        }
    }

    /// The same with a window of so many microseconds: for adapters that hold replies back.
    #[must_use]
    pub const fn listening(self, listen_us: u32) -> Self {
        Self { listen_us, ..self }
    }
}

impl Script for Group3Order {
    /// `None` without a reply that has the length of a known revision.
    type Result = Option<Group3Readings>;

    fn next(&mut self, heard: Heard) -> Result<Exchange, Self::Result> {
        if core::mem::replace(&mut self.is_asked, true) {
            return Err(readings(&heard));
        }
        let to = Address::Drive(self.drive);
        Exchange::ask(Request::ReadParamGroup3, to, self.dialect())
            .map(|ask| ask.listening(self.listen_us))
            .ok_or(None)
    }

    fn dialect(&self) -> &Dialect {
        &Dialect::V1_6A
    }
}

fn readings(heard: &Heard) -> Option<Group3Readings> {
    let frame = heard.reply_frame?;
    let revision = Revision::from_group3_reply_len(usize::from(frame.len()))?;
    let read = |order| {
        let dialect = Dialect {
            group3_reply_order_1_2a: Group3ReplyOrder::Fixed(order),
            group3_reply_order_1_6a: Group3ReplyOrder::Fixed(order),
            ..Dialect::of(revision)
        };
        match Reply::decode(&frame, Some(ReplyKind::ParamGroup3), &dialect) {
            Ok((_, Reply::ParamGroup3(group))) => Some(group),
            _ => None,
        }
    };
    Some(Group3Readings {
        revision,
        msb_first: read(ByteOrder::MsbFirst),
        lsb_first: read(ByteOrder::LsbFirst),
    })
}
