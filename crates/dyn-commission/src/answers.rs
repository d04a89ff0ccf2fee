//! How many drives answer to one id.

use dyn_can::{Address, Dialect, DriveId, Request};

use crate::{Exchange, Heard, LISTEN_US, Script};

/// Two drives that answer in the same moment look like one, and their delays differ from time to time (D65).
pub(crate) const ASKED: u8 = 3;

/// How many drives answer to an id.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AnswerCount {
    /// No drive.
    None,
    /// One drive, as far as can be seen from outside.
    One,
    /// A request was answered more than once.
    Several,
}

/// Asks a drive for its id several times and counts what comes back.
#[derive(Debug)]
pub struct CountAnswers {
    drive: DriveId,
    listen_us: u32,
    left: u8,
    most: u8,
}

impl CountAnswers {
    /// Counts the answers of an id, listening longer than any response that was measured (D65).
    #[must_use]
    pub const fn of(drive: DriveId) -> Self {
        Self {
            drive,
            listen_us: LISTEN_US,
            left: ASKED,
            most: 0,
        }
    }

    /// The same with a window of so many microseconds: for adapters that hold replies back.
    #[must_use]
    pub const fn listening(self, listen_us: u32) -> Self {
        Self { listen_us, ..self }
    }

    const fn count(&self) -> AnswerCount {
        match self.most {
            0 => AnswerCount::None,
            1 => AnswerCount::One,
            _ => AnswerCount::Several,
        }
    }
}

impl Script for CountAnswers {
    type Result = AnswerCount;

    fn next(&mut self, heard: Heard) -> Result<Exchange, AnswerCount> {
        self.most = self.most.max(heard.answers);
        if self.left == 0 {
            return Err(self.count());
        }
        self.left = self.left.saturating_sub(1);
        let to = Address::Drive(self.drive);
        Exchange::ask(Request::ReadDriveId, to, self.dialect())
            .map(|ask| ask.counting_answers().listening(self.listen_us))
            .ok_or(AnswerCount::None)
    }

    fn dialect(&self) -> &Dialect {
        &Dialect::V1_6A
    }
}
