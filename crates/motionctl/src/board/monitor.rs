//! `motionctl board monitor`: how a board is, again and again, and what happens on it.

use std::process::ExitCode;
use std::time::Duration;

use board_link::host::Incoming;
use board_link::message::{Request, Snapshot};
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::PortOptions;
use super::error::BoardError;
use super::info::AxisReport;
use super::session::Session;
use super::words::{self, phase};
use crate::interrupt;
use crate::output::{Printed, print};

const EXAMPLES: &str = "\
Examples:
  motionctl board monitor --port /dev/ttyACM0
  motionctl board monitor --port /dev/ttyACM0 --rate-hz 50 --json

It only reads, also while another program commands the board. Each line of the JSON is a document of its own. Ctrl-C ends it.

Exit status: 0 ended on request, 3 no board answers or the port failed.";

/// Options of `motionctl board monitor`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    port: PortOptions,
    /// Snapshots in a second.
    #[arg(long, value_name = "HZ", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=1_000))]
    rate_hz: u32,
    /// End after so many.
    #[arg(long, value_name = "N")]
    count: Option<u64>,
    /// Print them as JSON.
    #[arg(long)]
    json: bool,
}

/// A moment, or something that happened.
#[derive(Debug, Serialize, JsonSchema)]
struct Line {
    /// Cycle of the board; none for an event.
    cycle: Option<u64>,
    state: Option<String>,
    stream: Option<String>,
    stream_percent: Option<u16>,
    axes: Vec<AxisReport>,
    event: Option<String>,
}

/// Shows until Ctrl-C.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, BoardError> {
    interrupt::listen().map_err(BoardError::Interrupt)?;
    let mut session = Session::open(&arguments.port, false)?;
    let settings = session.settings()?;
    let drives: Vec<u8> = settings
        .iter()
        .flat_map(|settings| settings.axes.iter().map(|axis| axis.drive))
        .collect();
    let cycles_per_second = 1_000_000 / session.info().cycle_us.max(1);
    let period = (cycles_per_second / arguments.rate_hz).max(1);
    session.ask("send snapshots", Request::Snapshots { period })?;
    let mut count = 0;
    while interrupt::requests() == 0 && arguments.count.is_none_or(|most| count < most) {
        let line = match session.next_or_earlier(Duration::from_millis(50))? {
            Some(Incoming::Snapshot(snapshot)) => {
                count += 1;
                of_snapshot(&snapshot, &drives)
            }
            Some(Incoming::Event { event, .. }) => {
                let drive = |axis: u8| drives.get(usize::from(axis)).copied();
                of_event(words::event(&event, drive))
            }
            Some(Incoming::EventsLost(lost)) => of_event(format!("{lost} events were lost")),
            Some(Incoming::Connected { is_reset: true }) => {
                session.ask("send snapshots", Request::Snapshots { period })?;
                of_event("the board was reset".to_owned())
            }
            Some(Incoming::Disconnected) => of_event("the board does not answer".to_owned()),
            Some(_) | None => continue,
        };
        if show(arguments.json, &line)? == Printed::NobodyReads {
            break;
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn of_snapshot(snapshot: &Snapshot, drives: &[u8]) -> Line {
    Line {
        cycle: Some(snapshot.cycle),
        state: Some(snapshot.state.text().to_owned()),
        stream: Some(phase(snapshot.player.phase).to_owned()),
        stream_percent: Some(snapshot.player.percent),
        axes: AxisReport::of(snapshot, drives),
        event: None,
    }
}

fn of_event(text: String) -> Line {
    Line {
        cycle: None,
        state: None,
        stream: None,
        stream_percent: None,
        axes: Vec::new(),
        event: Some(text),
    }
}

fn show(json: bool, line: &Line) -> Result<Printed, BoardError> {
    if json {
        let text = serde_json::to_string(line).map_err(std::io::Error::other);
        return text.and_then(print).map_err(BoardError::Print);
    }
    let text = match (&line.event, line.cycle) {
        (Some(event), _) => format!("  {event}"),
        (None, cycle) => {
            let axes = line.axes.iter().map(|axis| {
                let drive = axis
                    .drive
                    .map_or_else(|| "?".to_owned(), |id| id.to_string());
                let fault = axis
                    .fault
                    .as_ref()
                    .map_or_else(String::new, |fault| format!(" {fault}"));
                format!(
                    "{drive}: {} ({:+}){fault}",
                    axis.position_counts, axis.error_counts
                )
            });
            let axes: Vec<String> = axes.collect();
            format!(
                "{} {}; stream {}; {}",
                cycle.unwrap_or_default(),
                line.state.as_deref().unwrap_or_default(),
                line.stream.as_deref().unwrap_or_default(),
                axes.join(", ")
            )
        }
    };
    print(text).map_err(BoardError::Print)
}

/// The shape of a line that `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<Line>()
}
