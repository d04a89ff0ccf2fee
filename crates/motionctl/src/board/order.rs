//! `motionctl board stop`, `halt`, `disable` and `clear`: one order to a board, and how it is afterwards.

use core::fmt;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use board_link::message::{BoardState, Request, Snapshot};
use board_link::segment::StreamPhase;
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::PortOptions;
use super::error::BoardError;
use super::info::AxisReport;
use super::session::Session;
use super::words::table;
use crate::exit;
use crate::output::{print, print_json};

/// Below the help of each.
pub(super) const HELP: &str = "\
Examples:
  motionctl board stop --port /dev/ttyACM0          slow down along the path; the drives stay enabled
  motionctl board halt --port /dev/ttyACM0          end all set-points at once; the drives hold, and follow nothing until they are enabled again
  motionctl board disable --port /dev/ttyACM0       slow down, then switch the drives off: what they held may fall
  motionctl board clear --port /dev/ttyACM0 --json  forget faults whose cause is gone; nothing is switched on

A board stops and halts for everybody; drives are switched off and faults forgotten for the host that commands it alone. With a fault nobody says whether the drives have power: clear it, then disable. None of this is an
emergency stop: that is the stop circuit, in hardware.

Exit status: 0 done, 1 not done within 10 s, or the board refuses, 3 no board answers.";

/// Time for axes to slow down, for drives to be off, and for faults to be gone.
const MOST_TIME: Duration = Duration::from_secs(10);

/// Options of an order.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    port: PortOptions,
    /// Print how the board is afterwards as JSON.
    #[arg(long)]
    json: bool,
}

/// Drives whose faults were forgotten are checked anew, and one that still has its fault says so within this time. Drives behind an open stop
/// circuit are off half a second after it has opened.
const CHECK_TIME: Duration = Duration::from_secs(1);

/// What a board is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    /// Slow down along the path.
    Stop,
    /// End all set-points at once.
    Halt,
    /// Slow down and switch the drives off.
    Disable,
    /// Forget faults.
    Clear,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Report {
    /// What was ordered: stop, halt, disable or clear.
    order: &'static str,
    /// Whether the board is as it was ordered to be.
    done: bool,
    state: &'static str,
    axes: Vec<AxisReport>,
}

/// Gives the order, waits for what comes of it, and shows that.
pub(super) fn run(order: Order, arguments: &Arguments) -> Result<ExitCode, BoardError> {
    let mut session = Session::open(&arguments.port, false)?;
    if order == Order::Disable {
        // Along the path first: the order itself slows each axis down for itself.
        give(&mut session, Order::Stop)?;
    }
    if order.needs_command() {
        session.take_command()?;
    }
    let snapshot = give(&mut session, order)?;
    if order.needs_command() {
        session.leave()?;
    }
    let settings = session.settings()?;
    let drives: Vec<u8> = settings
        .iter()
        .flat_map(|settings| settings.axes.iter().map(|axis| axis.drive))
        .collect();
    let report = Report {
        order: order.name(),
        done: order.is_done(&snapshot),
        state: snapshot.state.text(),
        axes: AxisReport::of(&snapshot, &drives),
    };
    if arguments.json {
        print_json(&report).map_err(BoardError::Print)?;
    } else {
        print(&report).map_err(BoardError::Print)?;
    }
    Ok(if report.done {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(exit::BROKEN_PROMISE)
    })
}

/// The state at the end of the time, or as soon as it is done for good.
fn give(session: &mut Session, order: Order) -> Result<Snapshot, BoardError> {
    session.ask(order.what(), order.request())?;
    let mut done_since = Instant::now();
    let until = done_since + MOST_TIME;
    loop {
        let snapshot = session.snapshot()?;
        let now = Instant::now();
        if !order.is_done(&snapshot) {
            done_since = now;
        } else if now - done_since >= order.holds_for(&snapshot) {
            return Ok(snapshot);
        }
        if now >= until {
            return Ok(snapshot);
        }
    }
}

impl Order {
    const fn request(self) -> Request {
        match self {
            Self::Stop => Request::Stop,
            Self::Halt => Request::Halt,
            Self::Disable => Request::Disable,
            Self::Clear => Request::Clear,
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Stop => "stop",
            Self::Halt => "halt",
            Self::Disable => "disable",
            Self::Clear => "clear",
        }
    }

    const fn what(self) -> &'static str {
        match self {
            Self::Stop => "stop its axes",
            Self::Halt => "halt its axes",
            Self::Disable => "disable its drives",
            Self::Clear => "clear its faults",
        }
    }

    /// A board stops for everybody; the rest it does for the host that commands it.
    const fn needs_command(self) -> bool {
        matches!(self, Self::Disable | Self::Clear)
    }

    /// How long it must have been done.
    fn holds_for(self, snapshot: &Snapshot) -> Duration {
        match self {
            Self::Clear => CHECK_TIME,
            Self::Disable if snapshot.state == BoardState::StopOpen => CHECK_TIME,
            Self::Disable | Self::Stop | Self::Halt => Duration::ZERO,
        }
    }

    fn is_done(self, snapshot: &Snapshot) -> bool {
        let is = snapshot.state;
        match self {
            Self::Stop | Self::Halt => {
                let phase = snapshot.player.phase;
                let plays = matches!(
                    phase,
                    StreamPhase::Waiting | StreamPhase::Moving | StreamPhase::Dry
                );
                // Drives that are on their way come up all the same.
                let is_under_way = matches!(
                    is,
                    BoardState::Homing | BoardState::Stopping | BoardState::GettingReady
                );
                !plays && !is_under_way
            }
            // A fault says nothing of the power.
            Self::Disable => matches!(
                is,
                BoardState::Off
                    | BoardState::NoSettings
                    | BoardState::StopOpen
                    | BoardState::EnableInactive
            ),
            Self::Clear => {
                is != BoardState::Faulted && snapshot.axes.iter().all(|axis| axis.fault == 0)
            }
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let outcome = if self.done {
            String::new()
        } else {
            format!(
                ": not done within {} s, look at the board",
                MOST_TIME.as_secs()
            )
        };
        write!(f, "{}{outcome}; state: {}", self.order, self.state)?;
        if !self.axes.is_empty() {
            write!(f, "\n{}", table(&self.axes))?;
        }
        Ok(())
    }
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<Report>()
}
