//! `motionctl monitor`: the state of drives, again and again, until Ctrl-C.

mod serial;

use core::fmt;
use std::process::ExitCode;

use can_motion::{AxisSnapshot, Fault, Feedback, Instant, PollPeriods};
use dyn_can::{DriveId, GearNumber};
use schemars::JsonSchema;
use serde::Serialize;

use crate::drive_ids::drive_ids;
use crate::drives::{DriveState, DrivesError, DrivesOptions, state_of};
use crate::interrupt;
use crate::output::{Printed, print};
use crate::station::{AxisOptions, GROUP, Station};

/// Shortest cycle: requests go out once a cycle.
const CYCLE_US: u32 = 1_000;
/// Readings of each kind between two lines.
const POLLS_A_LINE: u32 = 2;
/// An older value, or one from before the last two lines, is not shown: it says nothing of the present.
const FRESH_US: u64 = 500_000;

const EXAMPLES: &str = "\
Examples:
  motionctl monitor --slcan /dev/ttyACM0 --drives 1-3
  motionctl monitor --can can0 --drives 4 --every-ms 50 --count 100 --json > states.jsonl
  motionctl monitor --serial /dev/ttyUSB0 --drives 3

Nothing is changed and nothing moves. A drive that does not answer is asked again; a value that is too old is
shown as `?`, with its age.

Exit status: 0 ended by Ctrl-C or --count, 3 the link failed.";

/// Options of `motionctl monitor`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    link: DrivesOptions,
    /// Ids of the drives: numbers and ranges, as in 1,2,5-7.
    #[arg(long, value_name = "IDS", value_parser = drive_ids)]
    drives: std::vec::Vec<DriveId>,
    /// Time from one line of a drive to the next, in milliseconds.
    #[arg(long, value_name = "MS", default_value_t = 500, value_parser = clap::value_parser!(u32).range(20..=60_000))]
    every_ms: u32,
    /// End after so many lines of each drive.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    count: Option<u64>,
    /// Print one JSON object a line.
    #[arg(long)]
    json: bool,
}

/// One line.
#[derive(Debug, Serialize, JsonSchema)]
struct Line {
    /// Since the start.
    time_s: f64,
    drive: u8,
    answers: bool,
    #[serde(flatten)]
    state: DriveState,
    ages: Ages,
}

/// How long ago each value was read, in milliseconds; `None` when it never was.
#[derive(Debug, Serialize, JsonSchema)]
struct Ages {
    status_ms: Option<u64>,
    position_ms: Option<u64>,
    torque_ms: Option<u64>,
    speed_ms: Option<u64>,
}

impl Line {
    fn print(&self, arguments: &Arguments) -> Result<Printed, DrivesError> {
        let text = if arguments.json {
            serde_json::to_string(self).map_err(|error| DrivesError::Print(error.into()))?
        } else if self.answers {
            format!(
                "{:9.3} s  drive {:2}: {}; {}",
                self.time_s, self.drive, self.state, self.ages
            )
        } else {
            self.silence()
        };
        print(text).map_err(DrivesError::Print)
    }

    /// In place of values that say nothing of the present.
    fn silence(&self) -> String {
        let last = self.ages.status_ms.map_or_else(
            || "it never did".to_owned(),
            |ms| format!("its latest status is {ms} ms old"),
        );
        format!(
            "{:9.3} s  drive {:2}: does not answer, {last}",
            self.time_s, self.drive
        )
    }
}

impl Ages {
    fn of(read: &Feedback, now: Instant) -> Self {
        let ms = |at: Option<Instant>| at.map(|at| now.us_since(at) / 1_000);
        Self {
            status_ms: ms(read.status.map(|read| read.at)),
            position_ms: ms(read.position.map(|read| read.at)),
            torque_ms: ms(read.torque.map(|read| read.at)),
            speed_ms: ms(read.speed_rpm.map(|read| read.at)),
        }
    }
}

impl fmt::Display for Ages {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let age = |ms: Option<u64>| ms.map_or_else(|| "never".to_owned(), |ms| format!("{ms} ms"));
        write!(
            f,
            "age of status {}, position {}, speed {}, torque {}",
            age(self.status_ms),
            age(self.position_ms),
            age(self.speed_ms),
            age(self.torque_ms)
        )
    }
}

/// Prints the states until the user asks to stop.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, DrivesError> {
    let mut drives = arguments.drives.clone();
    drives.sort_unstable();
    let line = arguments.link.open_serial(AxisOptions::default());
    if let Some(line) = line.map_err(DrivesError::Open)? {
        return serial::run(arguments, &drives, line);
    }
    let mut link = arguments.link.open_can().map_err(DrivesError::Open)?;
    interrupt::listen().map_err(DrivesError::Interrupt)?;
    let period_us = Some(arguments.every_ms * 1_000 / POLLS_A_LINE);
    let polls = PollPeriods {
        status_us: period_us,
        position_us: period_us,
        torque_us: period_us,
        speed_us: period_us,
        counter_us: None,
    };
    // Any gear number: nothing moves.
    let axis = |&drive| AxisOptions::default().still(drive, GearNumber::MIN, polls);
    let axes: Vec<_> = drives.iter().map(axis).collect();
    let mut station =
        Station::unhurried(&mut link, &axes, CYCLE_US).map_err(DrivesError::Config)?;
    let mut lines = 0;
    while interrupt::requests() == 0 && arguments.count.is_none_or(|count| lines < count) {
        wait(&mut station, arguments.every_ms)?;
        if print_lines(&mut station, arguments)? == Printed::NobodyReads {
            break;
        }
        lines += 1;
    }
    Ok(ExitCode::SUCCESS)
}

fn wait(station: &mut Station<'_>, ms: u32) -> Result<(), DrivesError> {
    let until = station.now() + ms * 1_000;
    while until.us_since(station.now()) > 0 && interrupt::requests() == 0 {
        station.cycle(|_, _| {})?;
        // Nothing is enabled, so no event needs an answer.
        while station.next_event().is_some() {}
    }
    Ok(())
}

fn print_lines(station: &mut Station<'_>, arguments: &Arguments) -> Result<Printed, DrivesError> {
    let now = station.now();
    let max_age_us = FRESH_US.max(u64::from(arguments.every_ms) * 2_000);
    let mut is_one_lost = false;
    let mut printed = Printed::Read;
    let axes: Vec<AxisSnapshot> = station.snapshots().collect();
    for axis in axes {
        let line = line_of(&axis, now, max_age_us);
        is_one_lost |= axis.fault == Some(Fault::Lost);
        printed = line.print(arguments)?;
    }
    if is_one_lost {
        // The group has an axis; while the bus is off there is nobody to ask.
        let _ = station.master().clear(now, GROUP);
    }
    Ok(printed)
}

fn line_of(axis: &AxisSnapshot, now: Instant, max_age_us: u64) -> Line {
    let oldest = Instant::from_us(now.as_us().saturating_sub(max_age_us));
    let state = state_of(axis, oldest);
    Line {
        time_s: now.as_us() as f64 / 1e6,
        drive: axis.drive.get(),
        answers: state.enabled.is_some() && axis.fault != Some(Fault::Lost),
        state,
        ages: Ages::of(&axis.feedback, now),
    }
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<Line>()
}
