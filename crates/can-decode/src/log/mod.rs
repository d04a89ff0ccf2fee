//! Text logs of CAN traffic, line by line.
//!
//! | Format | Written by |
//! |---|---|
//! | candump | `candump` with `-L`, `-l`, `-t a`, `-t A`, `-t z`, `-t d` or no times, `-a`, `-c`, `-e`, `-i`, `-S`, `-x`, `-8`; python-can's `.log` |
//! | ASC | Vector tools, python-can's `.asc` |
//! | CSV | python-can's `.csv` |
//! | GVRET | SavvyCAN's `.csv` |
//! | Printer | python-can's `.txt` and its logger on the terminal, versions 3 and 4 |
//! | TRC | PEAK tools, python-can's `.trc`, versions 1.0 to 2.1 |
//!
//! The first line that belongs to a format decides for the whole log; after that a line of another kind is an error, which does not
//! stop the reader. A header that names unknown columns or an unknown version does: [`LineError::ends_log`].

mod asc;
mod candump;
mod error;
mod fields;
mod gvret;
mod header;
mod printer;
mod python_csv;
mod stamps;
mod trc;

use core::fmt;

use crate::frame::Frame;
pub use error::LineError;
pub use stamps::Stamps;

const BYTE_ORDER_MARK: char = '\u{feff}';

/// One entry of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry<'a> {
    /// Time in nanoseconds, from the start that the log chose: 1970, the start of the log, or of the machine. `None` in a log
    /// without times, where the order is all there is.
    pub at_ns: Option<u64>,
    /// The interface or channel, as the log names it.
    pub interface: &'a str,
    /// What was there.
    pub event: Event,
}

/// What a log tells of one moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Event {
    /// A classic data or remote frame.
    Frame(Frame),
    /// The controller reported an error on the bus.
    ErrorFrame,
    /// A node asked for a pause between two frames.
    OverloadFrame,
    /// The controller told its state: active, warned, passive, off the bus.
    ControllerState,
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
    /// SavvyCAN CSV.
    Gvret,
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
            Self::Gvret => "SavvyCAN CSV",
            Self::Printer => "python-can text",
            Self::Trc => "TRC",
        })
    }
}

/// Reads the lines of one log in order.
#[derive(Debug, Clone, Default)]
pub struct LogReader {
    format: Option<Format>,
    is_begun: bool,
    candump: candump::Candump,
    asc: asc::Asc,
    csv: python_csv::PythonCsv,
    gvret: gvret::Gvret,
    trc: trc::Trc,
}

impl LogReader {
    /// A reader that has not seen a line.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A reader that knows how to read times of candump that count from the first frame or from the frame before.
    #[must_use]
    pub fn with_stamps(stamps: Stamps) -> Self {
        let mut reader = Self::default();
        reader.candump.clock.stamps = Some(stamps);
        reader
    }

    /// Looks at lines that will be read later, before the first is read: whether the times of candump are differences shows only
    /// when one of them is smaller than the one before. What [`Self::with_stamps`] was told stays.
    pub fn look_ahead<'a>(&mut self, lines: impl Iterator<Item = &'a str>) {
        if self.candump.clock.stamps.is_none() {
            let lines = lines.map(|line| line.trim_start_matches(BYTE_ORDER_MARK));
            self.candump.clock.look_ahead(lines);
        }
    }

    /// How times that count from the first frame or from the frame before are read, once it is known.
    #[must_use]
    pub fn stamps(&self) -> Option<Stamps> {
        self.candump.clock.stamps
    }

    /// Whether lines that were looked at have times that are taken for times from the first frame, because none of them is smaller
    /// than the one before: a few differences may look the same.
    #[must_use]
    pub fn assumes_zero(&self) -> bool {
        self.candump.clock.assumes_zero
    }

    /// The format, once a line has told it.
    #[must_use]
    pub fn format(&self) -> Option<Format> {
        self.format
    }

    /// Reads one line, with or without its line end; `None` for headers, comments and empty lines.
    ///
    /// # Errors
    /// [`LineError`] when the line does not belong to the format; unless it [ends the log](LineError::ends_log), the next line
    /// can be read as if nothing had been.
    pub fn line<'a>(&mut self, line: &'a str) -> Result<Option<Entry<'a>>, LineError> {
        let line = if core::mem::replace(&mut self.is_begun, true) {
            line
        } else {
            line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(line)
        };
        let is_indented = line.starts_with('\t');
        let line = line.trim_ascii();
        if line.is_empty() {
            return Ok(None);
        }
        let format = match self.format {
            Some(format) => format,
            None => self.recognise(line)?,
        };
        match format {
            Format::Candump => self.candump.read(line, is_indented),
            Format::Asc => self.asc.read(line),
            Format::Csv => self.csv.read(line),
            Format::Gvret => self.gvret.read(line),
            Format::Printer => printer::read(line).map(Some),
            Format::Trc => self.trc.read(line),
        }
    }

    /// The format to which a first line belongs.
    fn recognise(&mut self, line: &str) -> Result<Format, LineError> {
        let plain = fields::without_colours(line);
        let format = if plain.starts_with('(') || candump::is_screen_line(line) {
            Format::Candump
        } else if let Some(csv) = python_csv::PythonCsv::of_header(line) {
            self.csv = csv;
            Format::Csv
        } else if let Some(gvret) = gvret::Gvret::of_header(line) {
            self.gvret = gvret;
            Format::Gvret
        } else if line.starts_with("Timestamp:") {
            Format::Printer
        } else if line.starts_with(';') {
            Format::Trc
        } else if asc::is_heading(line) {
            Format::Asc
        } else {
            return Err(LineError::no_format(line));
        };
        self.format = Some(format);
        Ok(format)
    }
}

#[cfg(test)]
mod tests;
