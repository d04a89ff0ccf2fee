//! `motionctl probe`: which byte of a number comes first.

use std::process::ExitCode;

use dyn_can::{Amplitude, FrequencyHz, Request, ServoSwitch, StoredDriveId};

use crate::confirm::confirm;
use crate::drive_ids::stored_id;
use crate::drives::{DrivesError, DrivesOptions, Frames, Step, When};
use crate::dry_run;
use crate::exit;
use crate::output::{print, print_json};
use crate::station::AxisOptions;

/// Read with the most significant byte first these are 4097, which no drive accepts, and 272; read the other way round it is the other.
const OFFERED: [[u8; 2]; 2] = [[0x10, 0x01], [0x01, 0x10]];
/// Function code of Square_Wave.
const SQUARE_WAVE: u16 = 0x0B;

const EXAMPLES: &str = "\
Examples:
  motionctl probe --slcan /dev/ttyACM0 --drive 3
  motionctl probe --can can0 --drive 3 --yes --json

The documents do not settle in which order the bytes of a number go. With the servo off and the frequency of its built-in wave at 0,
so that nothing can move, the drive is offered two amplitudes of which one is out of range in each order. Gear and line number
of parameter group 3 are read in both orders. The drive must be disabled, with a free shaft. Nothing is stored. The serial protocol has
no such doubt.

Exit status: 0 the order of numbers is known, 1 it is not, or the drive does not answer, 2 it is enabled or nobody confirmed, 3 the
link failed.";

/// Options of `motionctl probe`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    drives: DrivesOptions,
    /// Id of the drive.
    #[arg(long, value_name = "ID", value_parser = stored_id)]
    drive: StoredDriveId,
    /// Probe without asking.
    #[arg(long)]
    yes: bool,
    /// Show the frames and send nothing.
    #[arg(long)]
    dry_run: bool,
    /// Print the orders as JSON.
    #[arg(long)]
    json: bool,
}

/// Asks and probes.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, DrivesError> {
    let drive = arguments.drive;
    if arguments.drives.is_serial() {
        return Err(DrivesError::NotOnSerial {
            what: "doubt of its byte order to probe",
        });
    }
    if arguments.dry_run {
        let steps = frames(drive).ok_or(DrivesError::NoIdOnCan)?;
        dry_run::show(steps, arguments.json).map_err(DrivesError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    let question = format!(
        "Drive {drive}, which must be disabled, is offered two wave amplitudes, one of which it refuses. Is its shaft free, and nobody near it?"
    );
    confirm(&question, arguments.yes).map_err(DrivesError::NotConfirmed)?;
    let mut drives = arguments
        .drives
        .open(AxisOptions::default())
        .map_err(DrivesError::Open)?;
    drives.require_one(drive)?;
    let end = drives.probe(drive)?;
    if arguments.json {
        print_json(&end).map_err(DrivesError::Print)?;
    } else {
        print(&end).map_err(DrivesError::Print)?;
    }
    Ok(if end.numbers.is_some() {
        ExitCode::SUCCESS
    } else {
        exit::BROKEN_PROMISE.into()
    })
}

fn frames(drive: StoredDriveId) -> Option<Vec<Step>> {
    let id = drive.drive_id()?;
    let offer = |[first, second]: [u8; 2]| Step {
        when: When::Always,
        hex: format!(
            "{:03X}#{first:02X}{second:02X}",
            u16::from(id.get()) * 32 + SQUARE_WAVE
        ),
        words: format!(
            "to drive {id}    Square_Wave: amplitude {}, or {} with the least significant byte first",
            u16::from_be_bytes([first, second]),
            u16::from_le_bytes([first, second])
        ),
    };
    let step = |when, request| Frames::on_can(when, id, request);
    let steps = [
        step(When::Before, Request::ReadDriveId),
        step(When::Before, Request::ReadDriveStatus),
        step(When::Before, Request::ReadMotorSpeed),
        step(When::Before, Request::ReadParamGroup3),
        step(When::Always, Request::ServoDisable(ServoSwitch::Disable)),
        step(When::Always, Request::SsFrequency(FrequencyHz::MIN)),
        Some(offer(OFFERED[0])),
        Some(offer(OFFERED[1])),
        step(When::Always, Request::SquareWave(Amplitude::ZERO)),
    ];
    Some(steps.into_iter().flatten().collect())
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<crate::drives::ProbeEnd>()
}
