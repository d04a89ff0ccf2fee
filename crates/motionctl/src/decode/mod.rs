//! `motionctl decode`: the frames of a log, or of any other source, in plain words.

mod arguments;
mod bus;
mod error;
mod live;
mod log_file;
mod output;
mod source;
mod table;

use std::path::Path;
use std::process::ExitCode;

use can_decode::Decoder;
use can_decode::dyn_drives::Settings;
use can_decode::log::Entry;

use crate::exit;
use crate::interrupt;
use crate::link::{listen_to_interface, listen_to_slcan};
pub(crate) use arguments::Arguments;
use arguments::ProtocolOption;
use bus::{Bus, Said};
use error::DecodeError;
use live::LiveBus;
use log_file::LogFile;
use output::Output;
use source::{Damage, Heard, Source};

/// Reads a log to its end, or listens to a bus until Ctrl-C.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, DecodeError> {
    let live = match (&arguments.can, &arguments.slcan) {
        (Some(interface), _) => Some((
            interface,
            listen_to_interface(interface, arguments.bit_rate),
        )),
        (None, Some(port)) => Some((port, listen_to_slcan(port, arguments.bit_rate))),
        (None, None) => None,
    };
    if let Some((name, link)) = live {
        let mut bus = LiveBus::new(name, link)?;
        interrupt::listen().map_err(DecodeError::Interrupt)?;
        return follow(arguments, &mut bus);
    }
    let log = arguments.log.as_deref().unwrap_or(Path::new("-"));
    follow(arguments, &mut LogFile::open(log)?)
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
        Ok(()) if listener.damaged > 0 => Ok(exit::DAMAGED_LOG.into()),
        Ok(()) => Ok(ExitCode::SUCCESS),
    }
}

struct Listener<'a> {
    arguments: &'a Arguments,
    settings: Settings,
    /// In the order in which they were first heard; nearly always one.
    buses: Vec<Bus>,
    output: Output,
    /// Lines that cannot be read, or whose time goes back.
    damaged: u64,
}

impl<'a> Listener<'a> {
    fn new(arguments: &'a Arguments, source_name: String) -> Self {
        Self {
            arguments,
            settings: Settings {
                revision: arguments.revision.map(Into::into),
                reply_window_ns: u64::from(arguments.reply_ms) * 1_000_000,
                ..Settings::DEFAULT
            },
            buses: Vec::new(),
            output: Output::new(arguments.json, source_name),
            damaged: 0,
        }
    }

    fn follow(&mut self, source: &mut dyn Source) -> Result<(), DecodeError> {
        while let Some(Heard { line, what }) = source.next()? {
            match what {
                Ok(Some(entry)) => self.hear(line, &entry)?,
                Ok(None) => {}
                Err(damage) => self.damaged(line, &damage)?,
            }
            if source.may_wait() {
                self.output.flush()?;
            }
        }
        Ok(())
    }

    fn hear(&mut self, line: u64, entry: &Entry<'_>) -> Result<(), DecodeError> {
        let known = self
            .buses
            .iter()
            .position(|bus| bus.interface == entry.interface);
        let place = known.unwrap_or_else(|| {
            let decoder = match self.arguments.protocol {
                ProtocolOption::Dyn => Decoder::new(self.settings),
                ProtocolOption::Canopen => Decoder::canopen(),
            };
            self.buses.push(Bus::new(entry.interface, decoder));
            self.buses.len() - 1
        });
        let bus = &mut self.buses[place];
        let before = bus.goes_back_from(entry.at_ns);
        let said = bus.hear(entry);
        if let Some(before_ns) = before {
            let at_ns = entry.at_ns;
            self.damaged(line, &Damage::TimeGoesBack { before_ns, at_ns })?;
        }
        match said {
            Said::Frame(frame, meaning) if self.arguments.shows(&meaning) => {
                self.output.frame(entry, frame, &meaning)?;
            }
            Said::Other(text) if self.arguments.shows_bus() => self.output.other(entry, text)?,
            Said::Frame(..) | Said::Other(_) => {}
        }
        Ok(())
    }

    fn damaged(&mut self, line: u64, damage: &Damage) -> Result<(), DecodeError> {
        self.damaged += 1;
        self.output.damaged(line, damage)?;
        Ok(())
    }

    fn finish(&mut self) -> Result<(), DecodeError> {
        for bus in &self.buses {
            self.output.statistics(bus, self.arguments.bit_rate)?;
        }
        self.output.end(self.damaged)?;
        Ok(())
    }
}
