//! `motionctl decode`: the frames of a log, or of any other source, in plain words.

mod arguments;
mod binary;
mod bus;
mod error;
mod live;
mod log_file;
mod log_motion;
mod meaning;
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
use crate::output::tell;
use crate::report;
pub(crate) use arguments::Arguments;
use arguments::ProtocolOption;
use bus::{Bus, Said};
pub(crate) use error::DecodeError;
pub(crate) use live::LiveBus;
use log_file::LogFile;
use log_motion::LogMotion;
use output::Output;
use source::Damage;
pub(crate) use source::{Heard, Source};

/// Reads a log to its end, or listens to a bus until Ctrl-C.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, DecodeError> {
    if arguments.report.is_some() && arguments.protocol == ProtocolOption::Canopen {
        return Err(DecodeError::NoPage {
            reason: "--report knows the motion of DYN drives alone, not of CANopen nodes",
        });
    }
    let live = match (&arguments.can, &arguments.slcan) {
        (Some(interface), _) => Some((
            interface,
            listen_to_interface(interface, arguments.bit_rate),
        )),
        (None, Some(port)) => Some((
            port,
            listen_to_slcan(
                port,
                arguments.port,
                arguments.bit_rate,
                arguments.acknowledge,
            ),
        )),
        (None, None) => None,
    };
    if let Some((name, link)) = live {
        let mut bus = LiveBus::new(name, link)?;
        interrupt::listen().map_err(DecodeError::Interrupt)?;
        return follow(arguments, &mut bus);
    }
    let log = arguments.log.as_deref().unwrap_or(Path::new("-"));
    follow(arguments, &mut LogFile::open(log, arguments.stamps())?)
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

/// What a log without times does not tell.
const NO_TIMES: &str = "no times in this log: the order of its frames counts, and nothing is said of intervals, late replies and load";

struct Listener<'a> {
    arguments: &'a Arguments,
    settings: Settings,
    /// In the order in which they were first heard; nearly always one.
    buses: Vec<Bus>,
    output: Output,
    /// Lines that cannot be read, or whose time goes back.
    damaged: u64,
    /// Lines that cannot be read, one after the other.
    in_a_row: Row,
    /// Whether the notes about the log were written.
    is_noted: bool,
}

/// Damaged lines in a row.
#[derive(Default)]
struct Row {
    lines: u64,
    /// The first that was not shown.
    first_hidden: u64,
    last: u64,
}

/// Damaged lines in a row that are shown one by one.
const SHOWN_IN_A_ROW: u64 = 10;
/// Times that go back that are shown on each bus.
const SHOWN_TIMES_BACK: u64 = 3;

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
            in_a_row: Row::default(),
            is_noted: false,
        }
    }

    fn follow(&mut self, source: &mut dyn Source) -> Result<(), DecodeError> {
        self.note(source.note())?;
        while let Some(Heard { line, what }) = source.next()? {
            match what {
                Ok(Some(entry)) => {
                    self.end_row()?;
                    self.note(entry.at_ns.is_none().then_some(NO_TIMES))?;
                    self.hear(line, &entry)?;
                }
                Ok(None) => {}
                Err(damage) => self.damaged_in_a_row(line, &damage)?,
            }
            self.note(source.note())?;
            if source.may_wait() {
                self.output.flush()?;
            }
        }
        self.end_row()
    }

    /// Writes a note about the whole log once.
    fn note(&mut self, note: Option<&'static str>) -> Result<(), DecodeError> {
        if let Some(note) = note.filter(|_| !self.is_noted) {
            self.is_noted = true;
            self.output.note(note)?;
        }
        Ok(())
    }

    /// A line that cannot be read; of many in a row the first are shown.
    fn damaged_in_a_row(&mut self, line: u64, damage: &Damage) -> Result<(), DecodeError> {
        self.in_a_row.lines += 1;
        self.in_a_row.last = line;
        if self.in_a_row.lines <= SHOWN_IN_A_ROW {
            return self.damaged(line, damage);
        }
        if self.in_a_row.lines == SHOWN_IN_A_ROW + 1 {
            self.in_a_row.first_hidden = line;
        }
        self.damaged += 1;
        Ok(())
    }

    fn end_row(&mut self) -> Result<(), DecodeError> {
        let row = core::mem::take(&mut self.in_a_row);
        let hidden = row.lines.saturating_sub(SHOWN_IN_A_ROW);
        if hidden > 0 {
            self.output
                .more_damaged(hidden, row.first_hidden, row.last)?;
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
            let bit_ns = 1_000_000 / u64::from(self.arguments.bit_rate.max(1));
            let motion = || LogMotion::new(entry.interface, bit_ns);
            let mut bus = Bus::new(entry.interface, decoder);
            bus.motion = self.arguments.report.as_ref().map(|_| motion());
            self.buses.push(bus);
            self.buses.len() - 1
        });
        let bus = &mut self.buses[place];
        let before = entry
            .at_ns
            .and_then(|at_ns| Some((bus.goes_back_from(at_ns)?, at_ns)));
        let is_shown = bus.times_back <= SHOWN_TIMES_BACK;
        let said = bus.hear(entry);
        match before {
            Some((before_ns, at_ns)) if is_shown => {
                self.damaged(line, &Damage::TimeGoesBack { before_ns, at_ns })?;
            }
            Some(_) => self.damaged += 1,
            None => {}
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
        if self.buses.is_empty() {
            self.output
                .note("no frame and no error of a bus, so there is nothing to show")?;
        }
        self.output.end(self.damaged)?;
        self.write_pages()
    }

    /// One page for each interface.
    fn write_pages(&mut self) -> Result<(), DecodeError> {
        let Some(folder) = &self.arguments.report else {
            return Ok(());
        };
        let are_several = self.buses.len() > 1;
        for bus in &mut self.buses {
            let Some(motion) = bus.motion.take() else {
                continue;
            };
            let folder = if are_several {
                folder.join(bus.interface.replace(['/', '\\'], "_"))
            } else {
                folder.clone()
            };
            let (recording, outcome) = motion.finish()?;
            let path = folder.clone();
            std::fs::create_dir_all(&folder)
                .map_err(|source| DecodeError::Page { path, source })?;
            let page = report::write(&folder, &recording, &outcome)
                .map_err(|(path, source)| DecodeError::Page { path, source })?;
            tell(format_args!("report: {}", page.display()));
        }
        Ok(())
    }
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<output::Line<'_>>()
}
