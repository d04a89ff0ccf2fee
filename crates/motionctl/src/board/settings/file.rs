//! A file of settings, read and checked on this computer.

use std::path::Path;

use board_settings::Board;
use board_settings::file::{SettingsFile, read as read_text};

use crate::board::error::BoardError;

/// Reads a file.
///
/// # Errors
/// With the line and the column of what is wrong.
pub(super) fn read(path: &Path) -> Result<SettingsFile, BoardError> {
    let text = std::fs::read_to_string(path).map_err(|source| BoardError::ReadFile {
        path: path.to_owned(),
        source,
    })?;
    read_text(&text).map_err(|error| BoardError::SettingsFile {
        path: path.to_owned(),
        reason: error.to_string(),
    })
}

/// The board of this name.
///
/// # Errors
/// When this version does not know it.
pub(super) fn built(name: &str) -> Result<Board, BoardError> {
    Board::named(name).ok_or_else(|| BoardError::UnknownBoard {
        board: name.to_owned(),
    })
}

/// Whether the settings make a board that works.
///
/// # Errors
/// With the line and the column of what is refused.
pub(super) fn check(path: &Path, file: &SettingsFile, board: &Board) -> Result<(), BoardError> {
    let refused = file.settings.configs(board).err();
    refused.map_or(Ok(()), |refusal| {
        let place = file.locate(&refusal);
        Err(BoardError::SettingsFile {
            path: path.to_owned(),
            reason: format!("line {}, column {}: {refusal}", place.line, place.column),
        })
    })
}
