//! Which drives are on the bus, and in which revision.

use dyn_can::{Address, Dialect, DriveId, Request, Revision};
use heapless::Vec;

use crate::{Exchange, Heard, LISTEN_US, Script};

/// A drive that answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FoundDrive {
    /// Its id.
    pub drive: DriveId,
    /// Its revision, by the length of its Read_Param_Group3 reply (D62); `None` when that reply did not come.
    pub revision: Option<Revision>,
}

/// The drives found, in ascending order of id.
pub type ScanResult = Vec<FoundDrive, 63>;

/// Asks every id from 1 to 63 for its parameter group 3, which is harmless in both revisions.
#[derive(Debug)]
pub struct Scan {
    found: ScanResult,
    asked: Option<DriveId>,
    listen_us: u32,
}

impl Default for Scan {
    /// Listens longer to each id than any response that was measured (D65).
    fn default() -> Self {
        Self::listening(LISTEN_US)
    }
}

impl Scan {
    /// Listens to each id for so many microseconds: for adapters that hold replies back.
    #[must_use]
    pub const fn listening(listen_us: u32) -> Self {
        Self {
            found: Vec::new(),
            asked: None,
            listen_us,
        }
    }

    /// The id that is asked at the moment, for a progress bar; `None` before the first.
    #[must_use]
    pub const fn position(&self) -> Option<DriveId> {
        self.asked
    }
}

impl Script for Scan {
    type Result = ScanResult;

    fn next(&mut self, heard: Heard) -> Result<Exchange, ScanResult> {
        if let (Some(drive), Some(reply)) = (self.asked, heard.reply_frame) {
            let revision = Revision::from_group3_reply_len(usize::from(reply.len()));
            // There is room for every id.
            let _ = self.found.push(FoundDrive { drive, revision });
        }
        let next = self.asked.map_or(1, |drive| i32::from(drive.get()) + 1);
        let Ok(drive) = DriveId::new(next) else {
            return Err(self.found.clone());
        };
        self.asked = Some(drive);
        let ask = Exchange::ask(
            Request::ReadParamGroup3,
            Address::Drive(drive),
            &Dialect::V1_6A,
        );
        let listen_us = self.listen_us;
        ask.map(|ask| ask.listening(listen_us))
            .ok_or_else(|| self.found.clone())
    }

    fn dialect(&self) -> &Dialect {
        &Dialect::V1_6A
    }
}
