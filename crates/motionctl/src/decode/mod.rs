//! `motionctl decode`: the frames of a log, or of any other source, in plain words.

mod arguments;
mod error;
mod log_file;
mod output;
mod source;
mod table;

use std::process::ExitCode;

use can_decode::dyn_drives::Settings;
use can_decode::log::{Entry, Event};
use can_decode::statistics::Statistics;
use can_decode::{Decoder, Frame};

use crate::exit;
pub(crate) use arguments::Arguments;
use error::DecodeError;
use log_file::LogFile;
use output::Output;
use source::{Damage, Heard, Source};

/// Reads a log to its end.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, DecodeError> {
    let mut source = LogFile::open(&arguments.log)?;
    follow(arguments, &mut source)
}

/// Decodes what a source tells until it ends.
pub(crate) fn follow(
    arguments: &Arguments,
    source: &mut dyn Source,
) -> Result<ExitCode, DecodeError> {
    let mut listener = Listener::new(arguments, source.name());
    let outcome = listener.follow(source);
    match outcome.and_then(|()| listener.finish()) {
        // The reader of our output has seen enough, as `head` does.
        Err(DecodeError::Write(error)) if error.kind() == std::io::ErrorKind::BrokenPipe => {
            Ok(ExitCode::SUCCESS)
        }
        Err(error) => Err(error),
        Ok(()) if listener.totals.damaged > 0 => Ok(exit::DAMAGED_LOG.into()),
        Ok(()) => Ok(ExitCode::SUCCESS),
    }
}

/// What is counted beside the frames.
#[derive(Debug, Clone, Copy, Default)]
struct Totals {
    /// Frames that are no message of any protocol.
    undecodable: u64,
    error_frames: u64,
    fd_frames: u64,
    /// Lines that cannot be read, or whose time goes back.
    damaged: u64,
}

struct Listener<'a> {
    arguments: &'a Arguments,
    decoder: Decoder,
    statistics: Statistics,
    totals: Totals,
    output: Output,
    latest_ns: u64,
}

impl<'a> Listener<'a> {
    fn new(arguments: &'a Arguments, source_name: String) -> Self {
        let settings = Settings {
            revision: arguments.revision.map(Into::into),
            reply_window_ns: u64::from(arguments.reply_ms) * 1_000_000,
            ..Settings::DEFAULT
        };
        Self {
            arguments,
            decoder: Decoder::new(settings),
            statistics: Statistics::default(),
            totals: Totals::default(),
            output: Output::new(arguments.json, source_name),
            latest_ns: 0,
        }
    }

    fn follow(&mut self, source: &mut dyn Source) -> Result<(), DecodeError> {
        let is_live = source.is_live();
        while let Some(Heard { line, what }) = source.next()? {
            match what {
                Ok(Some(entry)) => self.hear(line, &entry)?,
                Ok(None) => {}
                Err(damage) => self.damaged(line, &damage)?,
            }
            if is_live {
                self.output.flush()?;
            }
        }
        Ok(())
    }

    fn hear(&mut self, line: u64, entry: &Entry<'_>) -> Result<(), DecodeError> {
        if entry.at_ns < self.latest_ns {
            let damage = Damage::TimeGoesBack {
                before_ns: self.latest_ns,
                at_ns: entry.at_ns,
            };
            self.damaged(line, &damage)?;
        }
        self.latest_ns = entry.at_ns;
        match &entry.event {
            Event::Frame(frame) => self.frame(entry, frame),
            Event::ErrorFrame => {
                self.totals.error_frames += 1;
                self.other(entry, "error frame: a node saw an error on the bus")
            }
            Event::FdFrame => {
                self.totals.fd_frames += 1;
                self.other(entry, "CAN FD frame: not for a classic bus")
            }
        }
    }

    fn frame(&mut self, entry: &Entry<'_>, frame: &Frame) -> Result<(), DecodeError> {
        let meaning = self.decoder.hear(entry.at_ns, frame);
        self.statistics.count(entry.at_ns, frame, &meaning);
        self.totals.undecodable += u64::from(meaning.is_undecodable());
        if self.arguments.shows(meaning.drive()) {
            self.output.frame(entry, frame, &meaning)?;
        }
        Ok(())
    }

    fn other(&mut self, entry: &Entry<'_>, text: &str) -> Result<(), DecodeError> {
        if self.arguments.shows(None) {
            self.output.other(entry, text)?;
        }
        Ok(())
    }

    fn damaged(&mut self, line: u64, damage: &Damage) -> Result<(), DecodeError> {
        self.totals.damaged += 1;
        self.output.damaged(line, damage)?;
        Ok(())
    }

    fn finish(&mut self) -> Result<(), DecodeError> {
        let bit_rate_kbit = self.arguments.bit_rate;
        self.output
            .statistics(&self.statistics, &self.totals, bit_rate_kbit)?;
        self.output.flush()?;
        Ok(())
    }
}
