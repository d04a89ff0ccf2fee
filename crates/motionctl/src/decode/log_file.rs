//! A log file, or the standard input, as a source of frames.

use std::fs::File;
use std::io::{BufRead, BufReader, IsTerminal, Read};
use std::path::Path;

use can_decode::log::LogReader;
use indicatif::{ProgressBar, ProgressStyle};

use super::error::DecodeError;
use super::source::{Damage, Heard, Source};

/// No line of any format is longer; a file that is no text may have no line ends at all.
const LONGEST_LINE: u64 = 4_096;
/// Lines without any format after which the file is no log.
const LINES_WITHOUT_FORMAT: u64 = 20;

/// Reads a log line by line.
pub(super) struct LogFile {
    name: String,
    /// Whether it is the standard input, which may be written while it is read.
    is_stdin: bool,
    input: BufReader<Box<dyn Read>>,
    reader: LogReader,
    bytes: Vec<u8>,
    line: u64,
    /// Lines that could not be read before any line told the format.
    without_format: u64,
}

impl LogFile {
    /// Opens a file; `-` is the standard input.
    pub(super) fn open(path: &Path) -> Result<Self, DecodeError> {
        let is_stdin = path.as_os_str() == "-";
        let (name, input): (_, Box<dyn Read>) = if is_stdin {
            ("standard input".to_owned(), Box::new(std::io::stdin()))
        } else {
            let read_error = |source| DecodeError::Read {
                path: path.display().to_string(),
                source,
            };
            let file = File::open(path).map_err(read_error)?;
            let size = file.metadata().map_err(read_error)?.len();
            let input = progress_bar(size).wrap_read(file);
            (path.display().to_string(), Box::new(input))
        };
        Ok(Self {
            name,
            is_stdin,
            input: BufReader::new(input),
            reader: LogReader::new(),
            bytes: Vec::new(),
            line: 0,
            without_format: 0,
        })
    }

    /// Reads the next line into `bytes`; false at the end.
    fn read_line(&mut self) -> Result<bool, DecodeError> {
        self.bytes.clear();
        let read = (&mut self.input)
            .take(LONGEST_LINE)
            .read_until(b'\n', &mut self.bytes);
        let count = read.map_err(|source| DecodeError::Read {
            path: self.name.clone(),
            source,
        })?;
        self.line += 1;
        Ok(count > 0)
    }

    fn no_log(&self) -> DecodeError {
        DecodeError::NoLog {
            path: self.name.clone(),
        }
    }
}

/// Shown while a log is decoded into a file, never between lines on a terminal.
fn progress_bar(bytes: u64) -> ProgressBar {
    if std::io::stdout().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(bytes);
    match ProgressStyle::with_template("{bar:40} {bytes}/{total_bytes}, {eta} left") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

impl Source for LogFile {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn may_wait(&self) -> bool {
        self.is_stdin && self.input.buffer().is_empty()
    }

    fn next(&mut self) -> Result<Option<Heard<'_>>, DecodeError> {
        if !self.read_line()? {
            return match self.reader.format() {
                None if self.without_format > 0 => Err(self.no_log()),
                _ => Ok(None),
            };
        }
        let what = match core::str::from_utf8(&self.bytes) {
            Ok(text) => self.reader.line(text).map_err(Damage::Line),
            Err(_) => Err(Damage::NotText),
        };
        if what.is_err() && self.reader.format().is_none() {
            self.without_format += 1;
            if self.without_format == LINES_WITHOUT_FORMAT {
                return Err(self.no_log());
            }
        }
        Ok(Some(Heard {
            line: self.line,
            what,
        }))
    }
}
