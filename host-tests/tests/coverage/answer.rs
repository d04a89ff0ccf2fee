//! What a cell answers: names of things that exist, `not yet`, or `no:` with the reason.

use crate::page::{Cell, Complaint, Place};

/// The answer of one cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Answer<'a> {
    /// It is there, under these names.
    Here(Vec<Name<'a>>),
    /// It is planned and missing; the words in brackets.
    NotYet(&'a str),
    /// It is not there, for a reason.
    No,
}

/// A name in backticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Name<'a> {
    pub(crate) text: &'a str,
    pub(crate) place: Place,
}

const GRAMMAR: &str = "a cell is `name`, `name` (note) | partly: `name` (what is missing) | not yet | not yet (note) | no: reason";

/// Reads a cell.
///
/// # Errors
/// What is wrong with it, and where.
pub(crate) fn answer<'a>(cell: &Cell<'a>) -> Result<Answer<'a>, Complaint> {
    let wrong = |what: &str| {
        let text = format!("{what}, found \"{}\": {GRAMMAR}", cell.text);
        Err(Complaint::new(cell.place, text))
    };
    if let Some(reason) = cell.text.strip_prefix("no:") {
        return match reason
            .strip_prefix(' ')
            .is_some_and(|words| words.len() > 3)
        {
            true => Ok(Answer::No),
            false => wrong("expected a reason behind \"no: \""),
        };
    }
    if let Some(rest) = cell.text.strip_prefix("not yet") {
        let words = if rest.is_empty() {
            Some("")
        } else {
            note(rest)
        };
        return match words {
            Some(words) => Ok(Answer::NotYet(words)),
            None => wrong("expected nothing or (note) behind \"not yet\""),
        };
    }
    let (is_part, mut rest) = match cell.text.strip_prefix("partly: ") {
        Some(rest) => (true, rest),
        None => (false, cell.text),
    };
    let mut names = Vec::new();
    loop {
        let Some((name, behind)) = rest.strip_prefix('`').and_then(|rest| rest.split_once('`'))
        else {
            return wrong("expected an answer");
        };
        names.push(Name {
            text: name,
            place: place_of(cell, name),
        });
        match behind.strip_prefix(", ") {
            Some(more) => rest = more,
            None if behind.is_empty() && is_part => {
                return wrong("expected (what is missing) behind \"partly:\"");
            }
            None if behind.is_empty() || note(behind).is_some() => return Ok(Answer::Here(names)),
            None => return wrong("expected \", `name`\" or \" (note)\" behind a name"),
        }
    }
}

/// The words of ` (words)`.
fn note(text: &str) -> Option<&str> {
    let words = text.strip_prefix(" (")?.strip_suffix(')')?;
    (words.trim().len() > 2).then_some(words)
}

/// `name` is a part of the text of `cell`.
fn place_of(cell: &Cell<'_>, name: &str) -> Place {
    let bytes = name.as_ptr() as usize - cell.text.as_ptr() as usize;
    let characters = cell.text[..bytes].chars().count();
    Place {
        column: cell.place.column + characters,
        ..cell.place
    }
}
