//! One question to one drive.

use dyn_can::{Address, Dialect, DriveId, Reply, Request};

use crate::{Exchange, Heard, LISTEN_US, Script};

/// Asks a drive once; for what must be known of a drive that a master refuses.
#[derive(Debug)]
pub struct Ask {
    drive: DriveId,
    request: Request,
    dialect: Dialect,
    listen_us: u32,
    is_asked: bool,
}

impl Ask {
    /// A request that is answered. One that is not has no answer, and is not sent.
    #[must_use]
    pub const fn new(drive: DriveId, request: Request, dialect: Dialect) -> Self {
        Self {
            drive,
            request,
            dialect,
            listen_us: LISTEN_US,
            is_asked: false,
        }
    }

    /// Listens for so many microseconds: for adapters that hold replies back.
    #[must_use]
    pub const fn listening(self, listen_us: u32) -> Self {
        Self { listen_us, ..self }
    }
}

impl Script for Ask {
    /// `None` without an answer that decodes.
    type Result = Option<Reply>;

    fn next(&mut self, heard: Heard) -> Result<Exchange, Self::Result> {
        if core::mem::replace(&mut self.is_asked, true) || self.request.reply_kind().is_none() {
            return Err(heard.reply);
        }
        Exchange::ask(self.request, Address::Drive(self.drive), &self.dialect)
            .map(|ask| ask.listening(self.listen_us))
            .ok_or(None)
    }

    fn dialect(&self) -> &Dialect {
        &self.dialect
    }
}
