//! `motionctl board faults`: what a board remembers.

use core::fmt;
use std::process::ExitCode;

use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::PortOptions;
use super::error::BoardError;
use super::session::Session;
use super::words;
use crate::output::{print, print_json};

const EXAMPLES: &str = "\
Examples:
  motionctl board faults --port /dev/ttyACM0
  motionctl board faults --port /dev/ttyACM0 --last 3 --json

Latest first. The time is that since the start of the firmware in which it happened.

Exit status: 0 shown, 3 no board answers.";

/// Options of `motionctl board faults`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    port: PortOptions,
    /// So many at most.
    #[arg(long, value_name = "N", default_value_t = u32::MAX, hide_default_value = true)]
    last: u32,
    /// Print them as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Entry {
    /// Counts the faults of the board for ever.
    number: u32,
    uptime_s: f64,
    firmware: String,
    axis: Option<u8>,
    drive: Option<u8>,
    code: u16,
    detail: i32,
    text: String,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Report {
    faults: Vec<Entry>,
}

/// Reads and shows.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, BoardError> {
    let mut session = Session::open(&arguments.port, false)?;
    let settings = session.settings()?;
    let drive = |axis: u8| {
        let axes = settings.as_ref().map(|settings| &settings.axes)?;
        axes.get(usize::from(axis)).map(|axis| axis.drive)
    };
    let entries = session.faults(arguments.last)?;
    let entry = |entry: board_link::message::FaultEntry| Entry {
        number: entry.number,
        uptime_s: f64::from(entry.uptime_ms) / 1_000.0,
        firmware: entry.firmware.to_string(),
        axis: entry.axis,
        drive: entry.axis.and_then(drive),
        code: entry.code,
        detail: entry.detail,
        text: words::entry(&entry),
    };
    let report = Report {
        faults: entries.into_iter().map(entry).collect(),
    };
    if arguments.json {
        print_json(&report).map_err(BoardError::Print)?;
    } else {
        print(&report).map_err(BoardError::Print)?;
    }
    Ok(ExitCode::SUCCESS)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.faults.is_empty() {
            return f.write_str("the board remembers no fault");
        }
        for (place, entry) in self.faults.iter().enumerate() {
            if place > 0 {
                writeln!(f)?;
            }
            let who = match (entry.drive, entry.axis) {
                (Some(drive), _) => format!("drive {drive}: "),
                (None, Some(axis)) => format!("axis {axis}: "),
                (None, None) => String::new(),
            };
            write!(
                f,
                "#{} after {:.3} s, firmware {}: {who}{}",
                entry.number, entry.uptime_s, entry.firmware, entry.text
            )?;
        }
        Ok(())
    }
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<Report>()
}
