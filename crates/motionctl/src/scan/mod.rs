//! `motionctl scan`: which drives are there.

use std::process::ExitCode;

use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use crate::drives::{DrivesError, DrivesOptions, FoundDrive};
use crate::exit;
use crate::station::AxisOptions;

/// Ids that are asked.
const IDS: u64 = 63;

const EXAMPLES: &str = "\
Examples:
  motionctl scan --slcan /dev/ttyACM0
  motionctl scan --can can0 --json
  motionctl scan --serial /dev/ttyUSB0

Every id from 1 to 63 is asked for its parameter group 3, over --serial every id from 0 to 63 for its id.
This changes nothing and moves nothing.

Exit status: 0 at least one drive answered, 1 none did, 3 the link failed.";

/// Options of `motionctl scan`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    drives: DrivesOptions,
    /// Print the drives as JSON, and no progress.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Found {
    drives: Vec<FoundDrive>,
}

/// Asks every id and prints what answered.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, DrivesError> {
    let mut drives = arguments
        .drives
        .open(AxisOptions::default())
        .map_err(DrivesError::Open)?;
    let bar = progress_bar(!arguments.json);
    let found = Found {
        drives: drives.scan(&mut |id| bar.set_position(id.into()))?,
    };
    bar.finish_and_clear();
    if arguments.json {
        let text = serde_json::to_string_pretty(&found).map_err(DrivesError::Json)?;
        println!("{text}");
    } else if found.drives.is_empty() {
        println!(
            "no drive answers: check power, wiring, termination and bit rate; a fresh drive has no id on CAN yet, and is drive 0 on its serial port"
        );
    }
    for found in found.drives.iter().filter(|_| !arguments.json) {
        println!("drive {:2}  {}", found.drive, found.protocol);
    }
    Ok(if found.drives.is_empty() {
        exit::BROKEN_PROMISE.into()
    } else {
        ExitCode::SUCCESS
    })
}

fn progress_bar(show: bool) -> ProgressBar {
    if !show {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(IDS);
    match ProgressStyle::with_template("{bar:40} id {pos}/{len}") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
