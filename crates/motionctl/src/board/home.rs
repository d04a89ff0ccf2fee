//! `motionctl board home`: the axes of a board find their origins, as its settings say.

use core::fmt;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use board_link::host::{Incoming, RequestError};
use board_link::message::{Answer, BoardState, Event, Origin, Request, Snapshot};
use board_settings::{AxisSettings, HomingDirection, HomingMethod, Settings};
use comfy_table::Table;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use dyn_can::units::command_counts_per_turn;
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::PortOptions;
use super::error::BoardError;
use super::session::Session;
use super::words::{self, refusal};
use crate::confirm::confirm;
use crate::exit;
use crate::interrupt;
use crate::output::{print, print_json, tell};
use crate::table::align_numbers;

const EXAMPLES: &str = "\
Examples:
  motionctl board home --port /dev/ttyACM0
  motionctl board home --port /dev/ttyACM0 --yes --json

Which axes are homed, and how, the settings of the board say: homing = \"stop\", \"switch\" or \"here\" and what belongs to it. The drives are enabled,
and the axes are homed one after the other. The drives stay enabled then: the board knows the origins as long as they are. When an axis finds none,
drives that had no power before are switched off again. Ctrl-C slows down and ends it, a second one ends all set-points at once.

Exit status: 0 every axis is homed, 1 one is not, or the board refuses, 2 the settings ask for no homing, or nobody agreed, 3 no board answers, 130
stopped on request.";

/// Time for the drives to be enabled.
const ENABLE_TIME: Duration = Duration::from_secs(10);
/// Time for them to slow down and to be off.
const DISABLE_TIME: Duration = Duration::from_secs(5);
const POLL: Duration = Duration::from_millis(2);
/// Cycles from one snapshot to the next.
const SNAPSHOT_CYCLES: u32 = 50;
const WHAT: &str = "home its axes";

/// Options of `motionctl board home`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    port: PortOptions,
    /// Do not ask before the motors move.
    #[arg(long)]
    yes: bool,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

/// An axis, in command counts.
#[derive(Debug, Serialize, JsonSchema)]
struct AxisReport {
    drive: u8,
    /// How its settings want it to be homed; none where its positions are those of its drive.
    method: Option<&'static str>,
    homed: bool,
    /// What its drive counts at the zero of the axis.
    origin_counts: Option<i32>,
    /// By how much that may be off, as far as it can be seen.
    uncertainty_counts: Option<u32>,
    /// Where it stands, in turns of its motor from its zero.
    axis_turns: Option<f64>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Report {
    homed: bool,
    /// Why not.
    reason: Option<String>,
    /// The number of the board for it.
    refusal: Option<u16>,
    axes: Vec<AxisReport>,
    /// Whether the drives are enabled now, or may be.
    enabled: bool,
}

/// Asks, enables, homes, shows.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, BoardError> {
    let mut session = Session::open(&arguments.port, false)?;
    let port = session.name().to_owned();
    let settings = session.settings()?;
    let settings = settings.ok_or(BoardError::NoSettings { port })?;
    let question = question(&settings).ok_or(BoardError::NoHoming)?;
    confirm(&question, arguments.yes).map_err(BoardError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(BoardError::Interrupt)?;
    session.take_command()?;
    let mut homing = Homing {
        session,
        settings,
        latest: Snapshot::default(),
        is_told: !arguments.json,
    };
    let report = match homing.run() {
        Err(BoardError::NotReady { .. }) if interrupt::requests() > 0 => {
            tell("stopped before the drives were enabled: nothing was homed");
            return Ok(ExitCode::from(exit::INTERRUPTED));
        }
        report => report?,
    };
    let was_asked_to_stop = interrupt::requests() > 0 && !report.homed;
    let code = match (report.homed, was_asked_to_stop) {
        (true, _) => ExitCode::SUCCESS,
        (false, true) => ExitCode::from(exit::INTERRUPTED),
        (false, false) => ExitCode::from(exit::BROKEN_PROMISE),
    };
    if arguments.json {
        print_json(&report).map_err(BoardError::Print)?;
    } else {
        print(&report).map_err(BoardError::Print)?;
    }
    Ok(code)
}

/// What will happen; `None` when nothing is to be homed.
fn question(settings: &Settings) -> Option<String> {
    let mut axes: Vec<&AxisSettings> = settings
        .axes
        .iter()
        .filter(|axis| axis.homing.is_some())
        .collect();
    // As the board does: axes of the same order stay in theirs.
    axes.sort_by_key(|axis| axis.homing.as_ref().map(|homing| homing.order));
    let ways: Vec<String> = axes.iter().filter_map(|axis| way(axis)).collect();
    (!ways.is_empty()).then(|| {
        format!(
            "All drives of the board will be enabled. {}. Is everybody clear of the machine?",
            ways.join(", then ")
        )
    })
}

fn way(axis: &AxisSettings) -> Option<String> {
    let drive = axis.drive;
    let homing = axis.homing.as_ref()?;
    let Some(search) = homing.method.search() else {
        return Some(format!("Drive {drive} stands at its reference"));
    };
    let towards = match search.direction {
        HomingDirection::Positive => "larger",
        HomingDirection::Negative => "smaller",
    };
    let what = match homing.method {
        HomingMethod::Stop {
            torque_permille, ..
        } => format!(
            "AGAINST A STOP with {:.1} % of its peak torque or more",
            f64::from(torque_permille) / 10.0
        ),
        _ => "to a switch".to_owned(),
    };
    Some(format!(
        "The motor of drive {drive} will TURN towards {towards} counts, {what}, by up to {:.2} turns at {} r/min",
        f64::from(search.way_millidegrees) / 360_000.0,
        search.speed_rpm
    ))
}

const fn method(homing: &HomingMethod) -> &'static str {
    match homing {
        HomingMethod::Here => "here",
        HomingMethod::Stop { .. } => "stop",
        HomingMethod::Switch { .. } => "switch",
    }
}

struct Homing {
    session: Session,
    settings: Settings,
    latest: Snapshot,
    is_told: bool,
}

impl Homing {
    fn run(&mut self) -> Result<Report, BoardError> {
        // Drives that hold after a halt keep their power, too: a load may hang on them.
        let before = self.session.snapshot()?.state;
        let was_enabled = matches!(before, BoardState::Enabled | BoardState::Halted);
        let period = SNAPSHOT_CYCLES;
        self.session
            .ask("send snapshots", Request::Snapshots { period })?;
        let result = self.enable().and_then(|()| self.home());
        let refused = match result {
            Ok(()) => None,
            Err(BoardError::Refused { refused, .. }) => Some(refused),
            Err(error) => {
                // Whoever waits for its end must know what the drives do; the first error is the reason.
                if let Err(second) = self.leave(was_enabled) {
                    tell(second);
                }
                return Err(error);
            }
        };
        let told = self.stand();
        let left = if refused.is_none() && told.is_ok() {
            self.session.leave().map(|()| true)
        } else {
            self.leave(was_enabled)
        };
        let enabled = match left {
            Ok(enabled) => enabled,
            // Why an axis is not homed says more; the drives may be enabled.
            Err(error) if refused.is_some() => {
                tell(error);
                true
            }
            Err(error) => return Err(error),
        };
        let (origins, stand) = match (told, refused) {
            (Ok(told), _) => told,
            (Err(second), Some(refused)) => {
                tell(second);
                let what = WHAT;
                return Err(BoardError::Refused { what, refused });
            }
            (Err(error), None) => return Err(error),
        };
        let axes = self.settings.axes.iter().zip(&origins).enumerate();
        Ok(Report {
            homed: refused.is_none(),
            reason: refused.as_ref().map(refusal),
            refusal: refused.map(|refused| refused.number),
            axes: axes
                .map(|(place, (axis, origin))| axis_report(axis, *origin, place, &stand))
                .collect(),
            enabled,
        })
    }

    /// What the axes count from, and how they stand.
    fn stand(&mut self) -> Result<(Vec<Origin>, Snapshot), BoardError> {
        let origins = self.session.origins(self.settings.axes.len())?;
        let stand = self.session.snapshot()?;
        // The one before may be of a moment at which it went on.
        self.latest.state = stand.state;
        Ok((origins, stand))
    }

    /// Takes what has come in within a moment; the reply to a ticket.
    fn take(&mut self, ticket: Option<u16>) -> Result<Option<Reply>, BoardError> {
        match self.session.next_or_earlier(POLL)? {
            Some(Incoming::Snapshot(snapshot)) => self.latest = snapshot,
            Some(Incoming::Event { event, .. }) => self.tell(&event),
            Some(Incoming::Disconnected | Incoming::Connected { .. }) => {
                return Err(BoardError::Reset { what: WHAT });
            }
            Some(Incoming::Reply { ticket: of, result }) if Some(of) == ticket => {
                return Ok(Some(result));
            }
            _ => {}
        }
        Ok(None)
    }

    fn tell(&self, event: &Event) {
        let drives = |axis: u8| self.settings.axes.get(usize::from(axis));
        if self.is_told && matches!(event, Event::Homed { .. } | Event::Fault { .. }) {
            tell(words::event(event, |axis| {
                drives(axis).map(|axis| axis.drive)
            }));
        }
    }

    fn enable(&mut self) -> Result<(), BoardError> {
        const ENABLE: &str = "enable its drives";
        match self.session.ask(ENABLE, Request::Enable) {
            Ok(_)
            | Err(BoardError::Request {
                source: RequestError::TimedOut { .. },
                ..
            }) => {}
            Err(error) => return Err(error),
        }
        let until = Instant::now() + ENABLE_TIME;
        while self.latest.state != BoardState::Enabled {
            self.take(None)?;
            if Instant::now() >= until || interrupt::requests() > 0 {
                let state = self.latest.state;
                return Err(BoardError::NotReady { state });
            }
        }
        Ok(())
    }

    /// From the command to its end, however long that takes.
    fn home(&mut self) -> Result<(), BoardError> {
        let error = |source| BoardError::Request { what: WHAT, source };
        let ticket = self.session.client().request(Request::Home);
        let ticket = ticket.map_err(error)?;
        let mut ordered = 0;
        loop {
            match self.take(Some(ticket))? {
                Some(Ok(_)) => return Ok(()),
                Some(Err(RequestError::Refused(refused))) => {
                    return Err(BoardError::Refused {
                        what: WHAT,
                        refused,
                    });
                }
                Some(Err(RequestError::Lost)) => return Err(BoardError::Reset { what: WHAT }),
                Some(Err(source)) => return Err(error(source)),
                None => {}
            }
            if interrupt::requests() > ordered {
                let request = if ordered == 0 {
                    Request::Stop
                } else {
                    Request::Halt
                };
                ordered += u32::from(self.session.client().request(request).is_ok());
            }
        }
    }

    /// Switches off what was off before, and gives the command back; whether the drives are enabled, or may be.
    fn leave(&mut self, was_enabled: bool) -> Result<bool, BoardError> {
        if !was_enabled {
            self.session.ask("disable its drives", Request::Disable)?;
            let period = SNAPSHOT_CYCLES;
            self.session
                .ask("send snapshots", Request::Snapshots { period })?;
            let until = Instant::now() + DISABLE_TIME;
            self.latest.state = BoardState::Stopping;
            while Instant::now() < until
                && matches!(
                    self.latest.state,
                    BoardState::Stopping
                        | BoardState::Enabled
                        | BoardState::Homing
                        | BoardState::Halted
                )
            {
                self.take(None)?;
            }
        }
        self.session.leave()?;
        // Only these say that the drives are off: a fault, for one, says nothing of the power.
        Ok(!matches!(
            self.latest.state,
            BoardState::Off
                | BoardState::NoSettings
                | BoardState::StopOpen
                | BoardState::EnableInactive
        ))
    }
}

type Reply = Result<Answer, RequestError>;

impl Session {
    /// What the positions of so many axes count from. A board that never homes says nothing of it: they are those of its drives.
    ///
    /// # Errors
    /// [`BoardError`].
    pub(super) fn origins(&mut self, axes: usize) -> Result<Vec<Origin>, BoardError> {
        const READ: &str = "tell the origins of its axes";
        let mut origins = vec![Origin::OfDrive; axes];
        for (axis, origin) in origins.iter_mut().enumerate() {
            let axis = axis as u8;
            *origin = match self.ask(READ, Request::ReadOrigin { axis }) {
                Ok(Answer::Origin(origin)) => origin,
                Ok(_) => return Err(BoardError::Unexpected { what: READ }),
                // One of before does not know the question.
                Err(BoardError::Refused { refused, .. }) if words::is_unknown(&refused) => break,
                Err(error) => return Err(error),
            };
        }
        Ok(origins)
    }
}

fn axis_report(axis: &AxisSettings, origin: Origin, place: usize, stand: &Snapshot) -> AxisReport {
    let turn = dyn_can::GearNumber::new(axis.gear.into()).map(command_counts_per_turn);
    let position = stand.axes.get(place).map(|axis| axis.position);
    let at = |counts: i32| {
        let way = f64::from(position?) - f64::from(counts);
        Some(way / f64::from(*turn.as_ref().ok()?))
    };
    let homing = axis.homing.as_ref();
    let (counts, uncertainty) = match origin {
        Origin::Found {
            counts,
            uncertainty,
        } => (Some(counts), Some(uncertainty)),
        Origin::OfDrive | Origin::Unknown => (None, None),
    };
    AxisReport {
        drive: axis.drive,
        method: homing.map(|homing| method(&homing.method)),
        homed: counts.is_some(),
        origin_counts: counts,
        uncertainty_counts: uncertainty,
        axis_turns: origin.counts().and_then(at),
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = Table::new();
        table.load_style(UTF8_BORDERS_ONLY).set_header([
            "drive",
            "homing",
            "zero at\ncounts",
            "within\ncounts",
            "stands at\nturns",
        ]);
        for axis in &self.axes {
            let or_none = |text: Option<String>| text.unwrap_or_default();
            table.add_row([
                axis.drive.to_string(),
                axis.method.unwrap_or("none").to_owned(),
                or_none(axis.origin_counts.map(|counts| counts.to_string())),
                or_none(axis.uncertainty_counts.map(|counts| counts.to_string())),
                or_none(axis.axis_turns.map(|turns| format!("{turns:.4}"))),
            ]);
        }
        align_numbers(&mut table);
        writeln!(f, "{table}")?;
        match (&self.reason, self.enabled) {
            (None, _) => f.write_str(
                "Every axis is homed. The drives stay enabled: the board forgets the origins when they are not.",
            ),
            (Some(reason), true) => {
                write!(f, "Not every axis is homed: {reason}. The drives are enabled, or may be.")
            }
            (Some(reason), false) => {
                write!(f, "Not every axis is homed: {reason}. The drives are off.")
            }
        }
    }
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<Report>()
}
