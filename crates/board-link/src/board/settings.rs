//! New settings arrive in pieces, are checked as a whole, and are stored by the application.

use super::application::Application;
use super::shared::Board;
use crate::frame::checksum;
use crate::message::{Answer, Chunk};
use crate::reason::Reason;
use crate::refused::Refused;

impl<A: Application, const AXES: usize> Board<'_, A, AXES> {
    /// The piece that begins at a byte.
    pub(super) fn read_settings(&self, offset: u32) -> Result<Answer, Refused> {
        let all = self.app.settings();
        let length = all.len() as u32;
        let Some(rest) = all.get(offset as usize..) else {
            return Err(Reason::Chunk.because(length.into(), offset.into()));
        };
        let mut bytes = Chunk::new();
        let piece = rest.get(..bytes.capacity()).unwrap_or(rest);
        // It is no longer than the capacity.
        let _ = bytes.extend_from_slice(piece);
        Ok(Answer::Settings {
            length,
            checksum: checksum(all),
            offset,
            bytes,
        })
    }

    pub(super) fn write_settings(&mut self, offset: u32, bytes: &[u8]) -> Result<Answer, Refused> {
        self.check_free()?;
        let end = offset as usize + bytes.len();
        let is_there = offset > 0 && end <= self.staged as usize;
        if offset != 0 && offset != self.staged && !is_there {
            return Err(Reason::Chunk.because(self.staged.into(), offset.into()));
        }
        if !is_there {
            let staging = self.app.staging();
            let room = staging.len() as i64;
            let Some(place) = staging.get_mut(offset as usize..end) else {
                return Err(Reason::Length.because(room, end as i64));
            };
            place
                .iter_mut()
                .zip(bytes)
                .for_each(|(place, byte)| *place = *byte);
            self.staged = end as u32;
        }
        Ok(Answer::Staged {
            received: self.staged,
        })
    }

    /// Complete, as announced, and a board that works.
    pub(super) fn check_settings(&mut self, length: u32, expected: u32) -> Result<(), Refused> {
        self.check_free()?;
        let staged = self.staged;
        let all = self.app.staging().get(..length as usize);
        let Some(all) = all.filter(|_| length == staged) else {
            return Err(Reason::Length.because(length.into(), staged.into()));
        };
        let actual = checksum(all);
        if actual != expected {
            return Err(Reason::Checksum.because(expected.into(), actual.into()));
        }
        self.app.check_settings(length)
    }
}
