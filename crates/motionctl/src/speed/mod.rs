//! `motionctl speed`: motors turn at constant speed.

use std::process::ExitCode;

use can_motion::{AxisState, DriveMove};
use dyn_can::{DriveId, Request, SpeedRpm};
use schemars::JsonSchema;
use serde::Serialize;

use crate::confirm::confirm;
use crate::drive_ids::{about, drive_ids};
use crate::drives::{DrivesError, Frames, Step, When};
use crate::dry_run;
use crate::exit;
use crate::interrupt;
use crate::link::LinkOptions;
use crate::output::{print as print_line, print_json, tell};
use crate::own_moves::{
    OwnLimits, axes_of, counts_of, hold, look_at, refused, until_back, until_over,
};
use crate::station::{AxisOptions, Seen, Station};

const EXAMPLES: &str = "\
Examples:
  motionctl speed --slcan /dev/ttyACM0 --drives 3 --rpm 30
  motionctl speed --can can0 --drives 1,2 --rpm -60 --for 2 --max-acceleration 5000 --yes

The motors turn until Ctrl-C, or the end of --for, and never farther than --max-turns from where they stand. A drive of revision 1.6A
leaves position mode for it: it is switched off afterwards, also where it was enabled before, and its configuration is written back,
which is one write of its EEPROM. Not for an axis whose load can fall.

Exit status: 0 turned and stopped, 1 a drive had a fault or did not confirm that it is disabled, 2 refused or not confirmed, and
nothing has moved, 3 the link failed or stood still, 130 stopped by Ctrl-C where --for was to end it.";

/// Options of `motionctl speed`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    link: LinkOptions,
    #[command(flatten)]
    axes: AxisOptions,
    /// Ids of the drives: numbers and ranges, as in 1,2,5-7.
    #[arg(long, value_name = "IDS", value_parser = drive_ids)]
    drives: std::vec::Vec<DriveId>,
    /// Speed of the motors in r/min, positive clockwise; at most --max-rpm.
    #[arg(long, value_name = "RPM", allow_hyphen_values = true)]
    rpm: i32,
    /// Stop after so many seconds; at Ctrl-C without it.
    #[arg(long = "for", value_name = "SECONDS", value_parser = clap::value_parser!(u32).range(1..))]
    seconds: Option<u32>,
    #[command(flatten)]
    limits: OwnLimits,
    /// Turn without asking.
    #[arg(long)]
    yes: bool,
    /// Show the frames and send nothing.
    #[arg(long)]
    dry_run: bool,
    /// Print where the motors stand as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
struct Turned {
    drive: u8,
    /// What the drive reported last, in command counts from its origin.
    read_counts: Option<i32>,
    /// Its configuration was written back to position mode.
    eeprom_writes: u16,
    /// The drive is still enabled, as it was before.
    enabled: bool,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Ends {
    drives: Vec<Turned>,
    interrupted: bool,
}

/// Asks, turns, stops, prints where the motors stand.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, DrivesError> {
    admit(arguments)?;
    if arguments.dry_run {
        dry_run::show(frames(arguments), arguments.json).map_err(DrivesError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut link = arguments.link.open().map_err(DrivesError::Open)?;
    let (rpm, limits) = (arguments.rpm, arguments.limits.text());
    let question = about(
        &arguments.drives,
        &format!(
            "will TURN its motor at {rpm} r/min, {limits}. Is everybody clear of the machine?"
        ),
        &format!(
            "will TURN their motors at {rpm} r/min, {limits}. Is everybody clear of the machine?"
        ),
    );
    confirm(&question, arguments.yes).map_err(DrivesError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(DrivesError::Interrupt)?;
    let seen = look_at(&mut link, arguments.axes, &arguments.drives)?;
    let way = |seen: &Seen| {
        let (start, turns) = (
            i64::from(seen.position_counts),
            counts_of(arguments.limits.max_turns(), seen.gear),
        );
        (*seen, [start - turns, start + turns])
    };
    let ways: Vec<_> = seen.iter().map(way).collect();
    let (axes, cycle_us) = axes_of(&mut link, arguments.axes, arguments.limits, &ways)?;
    if !arguments.json {
        tell(about(
            &arguments.drives,
            "is being enabled and turned; Ctrl-C stops it",
            "are being enabled and turned; Ctrl-C stops them",
        ));
    }
    let mut station = Station::new(&mut link, &axes, cycle_us).map_err(DrivesError::Config)?;
    let turned = turn(&mut station, arguments, &seen, cycle_us);
    let ((mut drives, interrupted), end) = DrivesError::after_shut_down(turned, &mut station)?;
    for (one, axis) in drives.iter_mut().zip(&axes) {
        one.enabled = end.left_on.contains(&axis.drive);
    }
    print(
        arguments,
        Ends {
            drives,
            interrupted,
        },
    )
}

fn admit(arguments: &Arguments) -> Result<(), DrivesError> {
    let most = arguments.limits.max_rpm();
    if (1..=most).contains(&arguments.rpm.unsigned_abs()) {
        return Ok(());
    }
    Err(DrivesError::MoveRefused {
        drive: arguments.drives.first().copied().unwrap_or(DriveId::MIN),
        reason: format!(
            "--rpm must be 1..={most} in either direction, as --max-rpm says, got {}",
            arguments.rpm
        ),
    })
}

fn turn(
    station: &mut Station<'_>,
    arguments: &Arguments,
    seen: &[Seen],
    cycle_us: u32,
) -> Result<(Vec<Turned>, bool), DrivesError> {
    hold(station)?;
    for axis in 0..seen.len() {
        let now = station.now();
        let wanted = DriveMove::Speed(arguments.rpm);
        let started = station.master().start_move(now, axis, wanted);
        started.map_err(|error| refused(seen, arguments.limits, cycle_us, (axis, error)))?;
    }
    let start = station.now();
    let limit_us = arguments
        .seconds
        .map(|seconds| u64::from(seconds) * 1_000_000);
    let interrupted = until_over(station, |station| {
        limit_us.is_some_and(|limit_us| station.now().us_since(start) >= limit_us)
    })?;
    let positions: Vec<Option<i32>> = station
        .snapshots()
        .map(|axis| axis.feedback.position.map(|read| read.value))
        .collect();
    until_back(station)?;
    let off: Vec<DriveId> = station
        .snapshots()
        .filter(|axis| axis.state == AxisState::Ready)
        .map(|axis| axis.drive)
        .collect();
    for drive in off {
        station.was_switched_off(drive);
    }
    let turned = station.snapshots().zip(seen).zip(positions);
    let turned = turned.map(|((axis, seen), before)| {
        let read = axis.feedback.position.map(|read| read.value).or(before);
        Turned {
            drive: axis.drive.get(),
            read_counts: read
                .and_then(|read| arguments.axes.scale(seen.gear).to_command_counts(read)),
            eeprom_writes: axis.counters.eeprom_writes,
            enabled: false,
        }
    });
    Ok((turned.collect(), interrupted))
}

fn print(arguments: &Arguments, ends: Ends) -> Result<ExitCode, DrivesError> {
    if arguments.json {
        print_json(&ends).map_err(DrivesError::Print)?;
    } else {
        for one in &ends.drives {
            let read = one
                .read_counts
                .map_or_else(|| "no position".to_owned(), |counts| counts.to_string());
            let state = if one.enabled {
                "stays enabled, as it was before"
            } else {
                "is disabled"
            };
            print_line(format_args!(
                "drive {} has stopped, it reports {read} and {state}",
                one.drive
            ))
            .map_err(DrivesError::Print)?;
        }
    }
    Ok(match (ends.interrupted, arguments.seconds) {
        (true, Some(_)) => exit::INTERRUPTED.into(),
        _ => ExitCode::SUCCESS,
    })
}

fn frames(arguments: &Arguments) -> Vec<Step> {
    let mut drives = arguments.drives.clone();
    drives.sort_unstable();
    let mut steps = Vec::new();
    for drive in &drives {
        steps.extend(Frames::on_can(
            When::Before,
            *drive,
            Request::ReadParamGroup2,
        ));
        let enable = Request::ServoDisable(dyn_can::ServoSwitch::Enable);
        steps.extend(Frames::on_can(When::IfDifferent, *drive, enable));
    }
    for rpm in [arguments.rpm, 0] {
        let speed = SpeedRpm::new(rpm).map(Request::TurnConstSpeed);
        for drive in &drives {
            let step = speed
                .ok()
                .and_then(|request| Frames::on_can(When::Always, *drive, request));
            steps.extend(step);
        }
    }
    for drive in &drives {
        steps.extend(Frames::on_can(
            When::Always,
            *drive,
            Request::ReadDriveConfig,
        ));
    }
    steps
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<Ends>()
}
