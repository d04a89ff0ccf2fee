//! What a board is asked for in several pieces.

use board_link::frame::checksum;
use board_link::message::{Answer, Chunk, Counters, FaultEntry, Request};
use board_settings::{LONGEST, Settings};

use super::error::BoardError;
use super::session::Session;

const READ: &str = "read the settings";
const WRITE: &str = "take the settings";

impl Session {
    /// The settings of the board as bytes; empty without settings.
    ///
    /// # Errors
    /// [`BoardError`].
    pub(super) fn settings_bytes(&mut self) -> Result<Vec<u8>, BoardError> {
        let mut all = Vec::new();
        loop {
            let request = Request::ReadSettings {
                offset: all.len() as u32,
            };
            let Answer::Settings {
                length,
                checksum: expected,
                offset,
                bytes,
            } = self.ask(READ, request)?
            else {
                return Err(BoardError::Unexpected { what: READ });
            };
            if length == 0 {
                return Ok(Vec::new());
            }
            let fits = offset as usize == all.len() && !bytes.is_empty();
            if !fits || length as usize > LONGEST.max(1 << 16) {
                return Err(BoardError::Unexpected { what: READ });
            }
            all.extend_from_slice(&bytes);
            if all.len() >= length as usize {
                if all.len() > length as usize || checksum(&all) != expected {
                    return Err(BoardError::Unexpected { what: READ });
                }
                return Ok(all);
            }
        }
    }

    /// The settings of the board, where it has some.
    ///
    /// # Errors
    /// [`BoardError`].
    pub(super) fn settings(&mut self) -> Result<Option<Settings>, BoardError> {
        let bytes = self.settings_bytes()?;
        if bytes.is_empty() {
            return Ok(None);
        }
        let settings = Settings::read(&bytes);
        settings.map(Some).map_err(BoardError::UnreadableSettings)
    }

    /// Brings settings to the board, which checks them. They are not stored yet.
    ///
    /// # Errors
    /// [`BoardError::Refused`] with the reason.
    pub(super) fn stage(&mut self, bytes: &[u8]) -> Result<(), BoardError> {
        let mut offset = 0;
        for piece in bytes.chunks(Chunk::new().capacity()) {
            let mut chunk = Chunk::new();
            // It is no longer than the capacity.
            let _ = chunk.extend_from_slice(piece);
            let request = Request::WriteSettings {
                offset,
                bytes: chunk,
            };
            self.ask(WRITE, request)?;
            offset += piece.len() as u32;
        }
        let (length, checksum) = (offset, checksum(bytes));
        self.ask(WRITE, Request::CheckSettings { length, checksum })
            .map(drop)
    }

    /// Lets the board store what it has got.
    ///
    /// # Errors
    /// [`BoardError::Refused`] with the reason: a drive is enabled, for instance.
    pub(super) fn commit(&mut self, bytes: &[u8]) -> Result<(), BoardError> {
        let (length, checksum) = (bytes.len() as u32, checksum(bytes));
        let request = Request::CommitSettings { length, checksum };
        self.ask("store the settings", request).map(drop)
    }

    /// What came in at its port.
    ///
    /// # Errors
    /// [`BoardError`].
    pub(super) fn counters(&mut self) -> Result<Counters, BoardError> {
        const WHAT: &str = "read the counters";
        match self.ask(WHAT, Request::ReadCounters)? {
            Answer::Counters(counters) => Ok(counters),
            _ => Err(BoardError::Unexpected { what: WHAT }),
        }
    }

    /// The fault log, latest first.
    ///
    /// # Errors
    /// [`BoardError`].
    pub(super) fn faults(&mut self, most: u32) -> Result<Vec<FaultEntry>, BoardError> {
        const WHAT: &str = "read the fault log";
        let count = self.info().faults.min(most);
        let mut entries = Vec::new();
        for index in 0..count {
            match self.ask(WHAT, Request::ReadFault { index })? {
                Answer::Fault(entry) => entries.push(entry),
                _ => return Err(BoardError::Unexpected { what: WHAT }),
            }
        }
        Ok(entries)
    }
}
