//! Text logs of CAN traffic, line by line.
//!
//! | Format | Written by |
//! |---|---|
//! | candump | `candump -L`, `-l`, `candump -t a` (also with `-x` and `-a`), python-can's `.log` |
//! | ASC | Vector tools, python-can's `.asc` |
//! | CSV | python-can's `.csv` |
//! | Printer | python-can's `.txt` and its logger on the terminal |
//! | TRC | PEAK tools, python-can's `.trc`, versions 1.0 and 2.1 |
//!
//! The first line that belongs to a format decides for the whole log; after that a line of another kind is an error, which does not
//! stop the reader.

mod asc;
mod candump;
mod error;
mod fields;
mod printer;
mod python_csv;
mod trc;

use core::fmt;

use crate::frame::Frame;
pub use error::LineError;

/// One entry of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry<'a> {
    /// Time in nanoseconds, from the start that the log chose: 1970, the start of the log, or of the machine.
    pub at_ns: u64,
    /// The interface or channel, as the log names it.
    pub interface: &'a str,
    /// What was there.
    pub event: Event,
}

/// What a log tells of one moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// A classic data or remote frame.
    Frame(Frame),
    /// The controller reported an error on the bus.
    ErrorFrame,
    /// A CAN FD frame, which a classic bus and its drives cannot carry.
    FdFrame,
}

/// The text formats that are recognised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Linux candump.
    Candump,
    /// Vector ASC.
    Asc,
    /// python-can CSV.
    Csv,
    /// python-can Printer.
    Printer,
    /// PEAK TRC.
    Trc,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Candump => "candump",
            Self::Asc => "ASC",
            Self::Csv => "python-can CSV",
            Self::Printer => "python-can text",
            Self::Trc => "TRC",
        })
    }
}

/// Reads the lines of one log in order.
#[derive(Debug, Clone, Default)]
pub struct LogReader {
    format: Option<Format>,
    asc: asc::Header,
    trc: trc::Header,
}

impl LogReader {
    /// A reader that has not seen a line.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The format, once a line has told it.
    #[must_use]
    pub fn format(&self) -> Option<Format> {
        self.format
    }

    /// Reads one line, with or without its line end; `None` for headers, comments and empty lines.
    ///
    /// # Errors
    /// [`LineError`] when the line does not belong to the format; the next line can be read as if nothing had been.
    pub fn line<'a>(&mut self, line: &'a str) -> Result<Option<Entry<'a>>, LineError> {
        let line = line.trim_ascii();
        if line.is_empty() {
            return Ok(None);
        }
        let format = match self.format {
            Some(format) => format,
            None => {
                let format = recognise(line).ok_or_else(|| LineError::no_format(line))?;
                self.format = Some(format);
                format
            }
        };
        match format {
            Format::Candump => candump::read(line).map(Some),
            Format::Asc => self.asc.read(line),
            Format::Csv => python_csv::read(line),
            Format::Printer => printer::read(line).map(Some),
            Format::Trc => self.trc.read(line),
        }
    }
}

/// The format to which a first line belongs.
fn recognise(line: &str) -> Option<Format> {
    if line.starts_with('(') {
        Some(Format::Candump)
    } else if line.starts_with(python_csv::HEADER) {
        Some(Format::Csv)
    } else if line.starts_with("Timestamp:") {
        Some(Format::Printer)
    } else if line.starts_with(';') {
        Some(Format::Trc)
    } else if line.starts_with("date ") || line.starts_with("base ") || line.starts_with("//") {
        Some(Format::Asc)
    } else {
        None
    }
}

#[cfg(test)]
mod tests;
