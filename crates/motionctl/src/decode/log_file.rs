//! A log file, or the standard input, as a source of frames.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{BufRead, BufReader, IsTerminal, Read};
use std::path::Path;

use can_decode::log::{LineError, LogReader, Stamps};
use indicatif::{ProgressBar, ProgressStyle};

use super::binary;
use super::error::DecodeError;
use super::source::{Damage, Heard, Source};

/// No line of any format is longer; a file that is no text may have no line ends at all.
const LONGEST_LINE: usize = 4_096;
/// Damaged lines before the first frame after which the file is no log of the format that its first line seemed to have.
const PATIENCE: usize = 5;
/// How much of a file is looked at before it is read.
const LOOK_AHEAD: usize = 1 << 16;

/// Reads a log line by line.
pub(super) struct LogFile {
    name: String,
    /// Whether it is the standard input, which may be written while it is read.
    is_stdin: bool,
    input: BufReader<Box<dyn Read>>,
    reader: LogReader,
    was_looked_at: bool,
    bytes: Vec<u8>,
    /// The line with U+FFFD in the place of what is no UTF-8.
    text: String,
    line: u64,
    is_too_long: bool,
    /// Whether anything of a bus was read.
    has_entry: bool,
    /// Damaged lines before the first entry: it decides whether they belong to a log.
    pending: VecDeque<(u64, Damage)>,
    /// The line at hand was not given out yet.
    is_held: bool,
}

/// What comes next.
enum Step {
    End,
    Damage(u64, Damage),
    /// The line at hand is to be read.
    Line,
}

impl LogFile {
    /// Opens a file; `-` is the standard input.
    pub(super) fn open(path: &Path, stamps: Option<Stamps>) -> Result<Self, DecodeError> {
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
        let mut log = Self {
            name,
            is_stdin,
            input: BufReader::with_capacity(LOOK_AHEAD, input),
            reader: stamps.map_or_else(LogReader::new, LogReader::with_stamps),
            was_looked_at: false,
            bytes: Vec::new(),
            text: String::new(),
            line: 0,
            is_too_long: false,
            has_entry: false,
            pending: VecDeque::new(),
            is_held: false,
        };
        if !is_stdin {
            log.look_ahead()?;
        }
        Ok(log)
    }

    /// Looks at the begin of the file: what is no text is refused, and times that are differences show.
    fn look_ahead(&mut self) -> Result<(), DecodeError> {
        self.was_looked_at = true;
        let bytes = self.input.fill_buf().map_err(|source| DecodeError::Read {
            path: self.name.clone(),
            source,
        })?;
        if let Some(what) = binary::kind_of(bytes) {
            let path = self.name.clone();
            return Err(DecodeError::Binary { path, what });
        }
        let text = String::from_utf8_lossy(bytes);
        self.reader.look_ahead(text.lines());
        Ok(())
    }

    /// Reads the next line; false at the end. Of a line that is too long only the begin is kept.
    fn read_line(&mut self) -> Result<bool, DecodeError> {
        self.bytes.clear();
        self.is_too_long = false;
        let mut is_empty = true;
        loop {
            let part = self.input.fill_buf().map_err(|source| DecodeError::Read {
                path: self.name.clone(),
                source,
            })?;
            if part.is_empty() {
                break;
            }
            is_empty = false;
            let end = part.iter().position(|byte| *byte == b'\n');
            let used = end.map_or(part.len(), |end| end + 1);
            let free = LONGEST_LINE.saturating_sub(self.bytes.len());
            self.is_too_long |= used > free;
            self.bytes.extend_from_slice(&part[..used.min(free)]);
            self.input.consume(used);
            if end.is_some() {
                break;
            }
        }
        self.line += u64::from(!is_empty);
        // Comments may be in any code page.
        if core::str::from_utf8(&self.bytes).is_err() {
            self.text = String::from_utf8_lossy(&self.bytes).into_owned();
        }
        Ok(!is_empty)
    }

    fn step(&mut self) -> Result<Step, DecodeError> {
        if !self.was_looked_at {
            self.look_ahead()?;
        }
        if !self.has_entry && !self.find_first_entry()? {
            return Ok(Step::End);
        }
        if let Some((line, damage)) = self.pending.pop_front() {
            return Ok(Step::Damage(line, damage));
        }
        if core::mem::take(&mut self.is_held) {
            return Ok(Step::Line);
        }
        if !self.read_line()? {
            return Ok(Step::End);
        }
        if self.is_too_long {
            return Ok(Step::Damage(
                self.line,
                Damage::LongLine { most: LONGEST_LINE },
            ));
        }
        Ok(Step::Line)
    }

    /// Reads up to the first line with traffic; false when there is none.
    fn find_first_entry(&mut self) -> Result<bool, DecodeError> {
        while self.read_line()? {
            let mut trial = self.reader.clone();
            let read = if self.is_too_long {
                Err(Damage::LongLine { most: LONGEST_LINE })
            } else {
                let line = line_of(&self.bytes, &self.text);
                trial
                    .line(line)
                    .map(|entry| entry.is_some())
                    .map_err(Damage::Line)
            };
            match read {
                Ok(true) => {
                    // It is read again, in its turn, by the reader that does not know it yet.
                    (self.has_entry, self.is_held) = (true, true);
                    return Ok(true);
                }
                Ok(false) => self.reader = trial,
                Err(Damage::Line(error)) if error.ends_log() => return Err(self.ended(error)),
                Err(damage) => {
                    self.reader = trial;
                    self.pending.push_back((self.line, damage));
                }
            }
            if self.pending.len() >= PATIENCE {
                break;
            }
        }
        match self.pending.pop_front() {
            Some((line, damage)) => Err(DecodeError::NoLog {
                path: self.name.clone(),
                line,
                format: self.reader.format(),
                damage,
            }),
            None => Ok(false),
        }
    }

    /// A header that nobody can read, in the line at hand.
    fn ended(&self, error: LineError) -> DecodeError {
        DecodeError::NoLog {
            path: self.name.clone(),
            line: self.line,
            format: None,
            damage: Damage::Line(error),
        }
    }
}

/// The line as text.
fn line_of<'a>(bytes: &'a [u8], replaced: &'a str) -> &'a str {
    core::str::from_utf8(bytes).unwrap_or(replaced)
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

    fn note(&self) -> Option<&'static str> {
        match self.reader.stamps() {
            Some(Stamps::Delta) => Some(
                "the times are differences from frame to frame, as candump -t d writes them, and are added up; if they are not, give --stamps zero",
            ),
            None if self.reader.assumes_zero() => Some(
                "the times count from the first frame, as candump -t z writes them; if they are differences, give --stamps delta",
            ),
            _ => None,
        }
    }

    fn next(&mut self) -> Result<Option<Heard<'_>>, DecodeError> {
        let what = match self.step()? {
            Step::End => return Ok(None),
            Step::Damage(line, damage) => {
                return Ok(Some(Heard {
                    line,
                    what: Err(damage),
                }));
            }
            Step::Line => self.reader.line(line_of(&self.bytes, &self.text)),
        };
        match what {
            // As `ended`, which cannot be called while a line is lent out.
            Err(error) if error.ends_log() => Err(DecodeError::NoLog {
                path: self.name.clone(),
                line: self.line,
                format: None,
                damage: Damage::Line(error),
            }),
            what => Ok(Some(Heard {
                line: self.line,
                what: what.map_err(Damage::Line),
            })),
        }
    }
}
