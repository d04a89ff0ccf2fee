//! `motionctl board info`: what a board is, how it is, and what it has received.

use core::fmt;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use board_link::host::Incoming;
use board_link::message::{Request, Snapshot};
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::PortOptions;
use super::error::BoardError;
use super::session::Session;
use super::words::phase;
use crate::output::{print, print_json};

const EXAMPLES: &str = "\
Examples:
  motionctl board info --port /dev/ttyACM0
  motionctl board info --port tcp:7002 --json

It only reads, also while another program commands the board and its axes move.

Exit status: 0 shown, 3 no board answers.";

/// Time for a snapshot.
const SNAPSHOT_TIME: Duration = Duration::from_secs(1);

/// Options of `motionctl board info`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    port: PortOptions,
    /// Print it as JSON.
    #[arg(long)]
    json: bool,
}

/// An axis at a moment, in command counts.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(super) struct AxisReport {
    pub(super) drive: Option<u8>,
    pub(super) target_counts: i32,
    pub(super) position_counts: i32,
    pub(super) error_counts: i32,
    pub(super) fault: Option<String>,
}

impl AxisReport {
    /// The axes of a snapshot, with their drives as far as they are known.
    pub(super) fn of(snapshot: &Snapshot, drives: &[u8]) -> Vec<Self> {
        let drives = drives.iter().copied().map(Some);
        let axes = snapshot
            .axes
            .iter()
            .zip(drives.chain(core::iter::repeat(None)));
        axes.map(|(axis, drive)| Self {
            drive,
            target_counts: axis.target,
            position_counts: axis.position,
            error_counts: axis.error,
            fault: (axis.fault != 0).then(|| super::words::fault_name(axis.fault)),
        })
        .collect()
    }
}

#[derive(Debug, Serialize, JsonSchema)]
struct Report {
    port: String,
    board: String,
    firmware: String,
    name: Option<String>,
    cycle_us: u32,
    uptime_s: f64,
    /// Number of the start.
    start: u32,
    segments: u16,
    faults: u32,
    state: String,
    stream: String,
    axes: Vec<AxisReport>,
    /// Messages of this computer and of hosts before it at this port.
    messages: u32,
    lost_messages: u32,
    refused_requests: u32,
    silent_hosts: u32,
    late_cycles: u32,
}

/// Reads and shows.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, BoardError> {
    let mut session = Session::open(&arguments.port, false)?;
    let info = session.info();
    let settings = session.settings()?;
    let drives: Vec<u8> = settings
        .iter()
        .flat_map(|settings| settings.axes.iter().map(|axis| axis.drive))
        .collect();
    let counters = session.counters()?;
    let snapshot = session.snapshot()?;
    let losses = counters.losses;
    let report = Report {
        port: session.name().to_owned(),
        board: info.board.to_string(),
        firmware: info.firmware.to_string(),
        name: settings.map(|settings| settings.name.to_string()),
        cycle_us: info.cycle_us,
        uptime_s: info.uptime as f64 * f64::from(info.cycle_us) * 1e-6,
        start: info.boot,
        segments: info.segments,
        faults: info.faults,
        state: snapshot.state.text().to_owned(),
        stream: phase(snapshot.player.phase).to_owned(),
        axes: AxisReport::of(&snapshot, &drives),
        messages: counters.frames,
        lost_messages: losses.length
            + losses.stuffing
            + losses.checksum
            + losses.version
            + losses.body,
        refused_requests: counters.refused,
        silent_hosts: counters.silent_hosts,
        late_cycles: counters.late_cycles,
    };
    if arguments.json {
        print_json(&report).map_err(BoardError::Print)?;
    } else {
        print(&report).map_err(BoardError::Print)?;
    }
    Ok(ExitCode::SUCCESS)
}

impl Session {
    /// How everything is now.
    ///
    /// # Errors
    /// [`BoardError`].
    pub(super) fn snapshot(&mut self) -> Result<Snapshot, BoardError> {
        const WHAT: &str = "read the state";
        self.ask(WHAT, Request::Snapshots { period: 10 })?;
        let until = Instant::now() + SNAPSHOT_TIME;
        while Instant::now() < until {
            if let Some(Incoming::Snapshot(snapshot)) =
                self.next_or_earlier(Duration::from_millis(10))?
            {
                self.ask(WHAT, Request::Snapshots { period: 0 })?;
                return Ok(snapshot);
            }
        }
        Err(BoardError::Unexpected { what: WHAT })
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.name.as_deref().unwrap_or_default();
        let called = if name.is_empty() {
            String::new()
        } else {
            format!(" \"{name}\"")
        };
        writeln!(
            f,
            "{}{called} at {}, firmware {}, cycle {} us, up for {:.1} s",
            self.board, self.port, self.firmware, self.cycle_us, self.uptime_s
        )?;
        writeln!(f, "state: {}; stream: {}", self.state, self.stream)?;
        if !self.axes.is_empty() {
            writeln!(f, "{}", super::words::table(&self.axes))?;
        }
        write!(
            f,
            "{} messages, {} lost, {} requests refused, silent hosts: {}, late cycles: {}, faults remembered: {}",
            self.messages,
            self.lost_messages,
            self.refused_requests,
            self.silent_hosts,
            self.late_cycles,
            self.faults
        )
    }
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<Report>()
}
