//! A page with pictures of a run: one HTML file that loads nothing.
//!
//! Curves are drawn here as SVG, thinned so that every spike survives; every frame of the wire goes into the page in a compact block, and a
//! small script draws it at any zoom. Colours are names until the style sheet gives them a light or a dark value.

mod charts;
mod frame_block;
mod histogram;
mod page;
mod palette;
mod thin;

use std::path::{Path, PathBuf};

use super::error::SimError;
use super::recording::Recording;
use super::summary::Summary;

/// Makes the folder of a report, before a run for which there would be no place.
pub(super) fn make_folder(folder: &Path) -> Result<(), SimError> {
    std::fs::create_dir_all(folder).map_err(|source| SimError::Write {
        path: folder.to_owned(),
        source,
    })
}

/// Writes `index.html` into a folder, with the picture of a path if there is one.
pub(super) fn write(
    folder: &Path,
    recording: &Recording,
    summary: &Summary,
    path: Option<&str>,
) -> Result<PathBuf, SimError> {
    let page = folder.join("index.html");
    let text = page::page(recording, summary, path).map_err(SimError::Picture)?;
    match std::fs::write(&page, text) {
        Ok(()) => Ok(page),
        Err(source) => Err(SimError::Write { path: page, source }),
    }
}

#[cfg(test)]
mod tests;
