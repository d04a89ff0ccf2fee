//! A page with pictures of a run: one HTML file that loads nothing.
//!
//! All numbers stand in one block of the page, which its script draws and puts into the tables: curves, velocities, path, histogram,
//! every frame. Nothing is drawn here, so a picture and a table cannot differ.

mod data;
mod pack;

use std::io;
use std::path::{Path, PathBuf};

use crate::output::tell;
use crate::recording::{Outcome, Recorded, Recording};

const TEMPLATE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/page.css");
/// In the order in which they need each other.
const SCRIPTS: [&str; 7] = [
    include_str!("page/unpack.js"),
    include_str!("page/chart.js"),
    include_str!("page/charts.js"),
    include_str!("page/xy.js"),
    include_str!("page/table.js"),
    include_str!("page/strip.js"),
    include_str!("page/main.js"),
];

/// Writes `index.html` into a folder that is there.
///
/// # Errors
/// With the path that cannot be written.
pub(crate) fn write(
    folder: &Path,
    recording: &Recording,
    outcome: &Outcome,
) -> Result<PathBuf, (PathBuf, io::Error)> {
    let page = folder.join("index.html");
    match std::fs::write(&page, text(recording, outcome)) {
        Ok(()) => Ok(page),
        Err(source) => Err((page, source)),
    }
}

/// Writes the page of a motion on a real bus, when one is wanted, and says where it is or why there is none.
///
/// False when a page was wanted and there is none.
pub(crate) fn write_and_tell(
    folder: Option<&Path>,
    recorded: &Recorded,
    outcome: &Outcome,
) -> bool {
    let Some(folder) = folder else {
        return true;
    };
    let Some(recording) = &recorded.recording else {
        tell("the page is not written: its numbers are not whole");
        return false;
    };
    match write(folder, recording, outcome) {
        Ok(page) => {
            tell(format_args!("report: {}", page.display()));
            true
        }
        Err((path, source)) => {
            tell(format_args!("cannot write {}: {source}", path.display()));
            false
        }
    }
}

/// The whole page.
fn text(recording: &Recording, outcome: &Outcome) -> String {
    let data = data::data(recording, outcome).to_string();
    let parts = [
        ("style", STYLE.to_owned()),
        // The block must not end the element that it stands in.
        ("data", data.replace('<', "\\u003c")),
        ("script", SCRIPTS.join("\n")),
    ];
    fill(&parts)
}

/// Puts each part at its place in the template, once: a part is never searched for places.
fn fill(parts: &[(&str, String)]) -> String {
    let mut pieces = TEMPLATE.split("{{");
    let mut page = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let (name, rest) = piece.split_once("}}").unwrap_or((piece, ""));
        let part = parts.iter().find(|(other, _)| *other == name);
        page.push_str(part.map_or("", |(_, text)| text));
        page.push_str(rest);
    }
    page
}

#[cfg(test)]
mod tests;
