//! `motionctl move`: drives go to positions by themselves.

mod serial;

use std::process::ExitCode;

use can_motion::{AxisConfig, DriveMove};
use dyn_can::{Counts28, DriveId, GearNumber, Request, SyncKind};
use schemars::JsonSchema;
use serde::Serialize;

use crate::confirm::confirm;
use crate::drive_ids::{about, drive_ids};
use crate::drives::{DrivesError, DrivesOptions, Frames, Step, When};
use crate::dry_run;
use crate::exit;
use crate::interrupt;
use crate::output::{print as print_line, print_json, tell};
use crate::own_moves::{OwnLimits, axes_of, counts_of, hold, look_at, refused, until_over};
use crate::station::{AxisOptions, End, Seen, Station};

/// Gear number of the frames that `--dry-run` shows.
const DRY_RUN_GEAR: i32 = 4_096;

const EXAMPLES: &str = "\
Examples:
  motionctl move --slcan /dev/ttyACM0 --drives 3 --by 0.25
  motionctl move --can can0 --drives 3 --to -1.5 --max-rpm 200 --max-acceleration 20000 --yes
  motionctl move --can can0 --drives 1-3 --to 0.5,0,-0.5     start together, by one trigger
  motionctl move --can can0 --drives 3 --by 1 --dry-run
  motionctl move --serial /dev/ttyUSB0 --drives 3 --to 0.5     one drive that is enabled already

The drives make the moves by themselves, with the speed and acceleration of their own parameters: a move that would be faster than
--max-rpm or accelerate more than --max-acceleration is refused, so lower max-speed and max-acceleration with `motionctl write`
first. A drive that is disabled is enabled for it and disabled afterwards: a vertical axis without a brake falls then. One that is
enabled stays enabled. Ctrl-C stops the drives on their way and ends the same way. The serial protocol can neither enable a drive nor
start several together.

Exit status: 0 every motor arrived, 1 one did not, or a drive did not confirm that it is disabled, 2 refused or not confirmed, and
nothing has moved, 3 the link failed or stood still, 130 stopped by Ctrl-C.";

/// Options of `motionctl move`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    link: DrivesOptions,
    #[command(flatten)]
    axes: AxisOptions,
    /// Ids of the drives: numbers and ranges, as in 1,2,5-7.
    #[arg(long, value_name = "IDS", value_parser = drive_ids)]
    drives: std::vec::Vec<DriveId>,
    /// Positions from the origin of each drive, in motor turns, positive clockwise: one for all, or one for each in the order of
    /// --drives.
    #[arg(
        long,
        value_name = "TURNS",
        allow_hyphen_values = true,
        value_delimiter = ',',
        required_unless_present = "by",
        conflicts_with = "by"
    )]
    to: Vec<f64>,
    /// Distances from where the motors stand, in motor turns.
    #[arg(
        long,
        value_name = "TURNS",
        allow_hyphen_values = true,
        value_delimiter = ','
    )]
    by: Vec<f64>,
    #[command(flatten)]
    limits: OwnLimits,
    /// Move without asking.
    #[arg(long)]
    yes: bool,
    /// Show the frames and send nothing.
    #[arg(long)]
    dry_run: bool,
    /// Print where the moves have led as JSON.
    #[arg(long)]
    json: bool,
}

/// Where one move has led.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
struct MoveEnd {
    drive: u8,
    /// Where it began and where it was to end, in command counts from the origin of the drive.
    start_counts: i32,
    end_counts: i32,
    arrived: bool,
    /// What the drive reports, in command counts.
    read_counts: Option<i32>,
    /// The drive is still enabled, as it was before.
    enabled: bool,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Moves {
    moves: Vec<MoveEnd>,
    /// They were stopped by Ctrl-C.
    interrupted: bool,
}

/// Asks, moves, prints where the moves have led.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, DrivesError> {
    let wanted = wanted(arguments)?;
    if arguments.dry_run {
        let steps = frames(arguments, &wanted)?;
        dry_run::show(steps, arguments.json).map_err(DrivesError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    let line = arguments.link.open_serial(arguments.axes);
    if let Some(line) = line.map_err(DrivesError::Open)? {
        return serial::run(arguments, serial::only(&wanted)?, line);
    }
    let mut link = arguments.link.open_can().map_err(DrivesError::Open)?;
    let limits = arguments.limits.text();
    let question = about(
        &arguments.drives,
        &format!("will MOVE its motor, powered, {limits}. Is everybody clear of the machine?"),
        &format!("will MOVE their motors, powered, {limits}. Is everybody clear of the machine?"),
    );
    confirm(&question, arguments.yes).map_err(DrivesError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(DrivesError::Interrupt)?;
    let seen = look_at(&mut link, arguments.axes, &arguments.drives)?;
    let ways = ways(arguments, &wanted, &seen)?;
    let (axes, cycle_us) = axes_of(&mut link, arguments.axes, arguments.limits, &ways)?;
    if !arguments.json {
        tell(about(
            &arguments.drives,
            &format!("is being enabled and moved, {limits}; Ctrl-C stops it"),
            &format!("are being enabled and moved, {limits}; Ctrl-C stops them"),
        ));
    }
    let mut station = Station::new(&mut link, &axes, cycle_us).map_err(DrivesError::Config)?;
    let moved = go(&mut station, arguments, &ways, cycle_us);
    let ((mut moves, interrupted), end) = DrivesError::after_shut_down(moved, &mut station)?;
    note_power(&mut moves, &axes, &end);
    print(arguments, Moves { moves, interrupted })
}

/// What each drive is to do, in ascending order of drives.
fn wanted(arguments: &Arguments) -> Result<Vec<(DriveId, f64)>, DrivesError> {
    let given = if arguments.by.is_empty() {
        &arguments.to
    } else {
        &arguments.by
    };
    let drives = &arguments.drives;
    let mut wanted: Vec<(DriveId, f64)> = match given.as_slice() {
        [one] => drives.iter().map(|drive| (*drive, *one)).collect(),
        many if many.len() == drives.len() => {
            drives.iter().copied().zip(many.iter().copied()).collect()
        }
        many => {
            return Err(DrivesError::MoveRefused {
                drive: drives.first().copied().unwrap_or(DriveId::MIN),
                reason: format!(
                    "give one number of turns, or one for each of the {} drives, not {}",
                    drives.len(),
                    many.len()
                ),
            });
        }
    };
    if let Some((drive, turns)) = wanted.iter().find(|(_, turns)| !turns.is_finite()) {
        return Err(DrivesError::MoveRefused {
            drive: *drive,
            reason: format!("the turns must be a number, got {turns}"),
        });
    }
    wanted.sort_by_key(|(drive, _)| *drive);
    Ok(wanted)
}

/// Start and end of each move.
fn ways(
    arguments: &Arguments,
    wanted: &[(DriveId, f64)],
    seen: &[Seen],
) -> Result<Vec<(Seen, [i64; 2])>, DrivesError> {
    let way = |(seen, (drive, turns)): (&Seen, &(DriveId, f64))| {
        let start = i64::from(seen.position_counts);
        let counts = counts_of(*turns, seen.gear);
        let end = if arguments.by.is_empty() {
            counts
        } else {
            start.saturating_add(counts)
        };
        let most = counts_of(arguments.limits.max_turns(), seen.gear);
        if end.abs_diff(start) > most.unsigned_abs() {
            return Err(DrivesError::MoveRefused {
                drive: *drive,
                reason: format!(
                    "the move leads {} counts away, --max-turns allows {most}",
                    end.abs_diff(start)
                ),
            });
        }
        Ok((*seen, [start, end]))
    };
    seen.iter().zip(wanted).map(way).collect()
}

/// The moves, from drives that hold to drives that hold.
fn go(
    station: &mut Station<'_>,
    arguments: &Arguments,
    ways: &[(Seen, [i64; 2])],
    cycle_us: u32,
) -> Result<(Vec<MoveEnd>, bool), DrivesError> {
    hold(station)?;
    let moves: Vec<(usize, DriveMove)> = ways
        .iter()
        .enumerate()
        .map(|(axis, (_, [start, end]))| {
            // Beyond 32 bits it is refused as beyond the travel, on the side where it is.
            let counts = |value: i64| value.clamp(i32::MIN.into(), i32::MAX.into()) as i32;
            let wanted = match arguments.by.is_empty() {
                true => DriveMove::To(counts(*end)),
                false => DriveMove::By(counts(end - start)),
            };
            (axis, wanted)
        })
        .collect();
    let starts: Vec<i32> = station.snapshots().map(|axis| axis.sent_counts).collect();
    let now = station.now();
    let started = match moves.as_slice() {
        [(axis, wanted)] => station.master().start_move(now, *axis, *wanted),
        many => station.master().start_moves(now, many),
    };
    let seen: Vec<Seen> = ways.iter().map(|(seen, _)| *seen).collect();
    started.map_err(|error| refused(&seen, arguments.limits, cycle_us, (0, error)))?;
    let interrupted = until_over(station, |_| false)?;
    let read = |axis: &can_motion::AxisSnapshot, seen: &Seen| {
        let position = axis.feedback.position?;
        arguments
            .axes
            .scale(seen.gear)
            .to_command_counts(position.value)
    };
    let ends = station.snapshots().zip(ways).zip(&starts).zip(&moves);
    let moves = ends.map(|(((axis, (seen, _)), start), (_, wanted))| {
        let end_counts = match wanted {
            DriveMove::By(counts) => start.wrapping_add(*counts),
            DriveMove::To(counts) => *counts,
            DriveMove::Speed(_) | DriveMove::Wave { .. } => *start,
        };
        MoveEnd {
            drive: axis.drive.get(),
            start_counts: *start,
            end_counts,
            arrived: axis.sent_counts == end_counts && !axis.facts.has_own_move(),
            read_counts: read(&axis, seen),
            enabled: false,
        }
    });
    Ok((moves.collect(), interrupted))
}

fn note_power(moves: &mut [MoveEnd], axes: &[AxisConfig], end: &End) {
    for (one, axis) in moves.iter_mut().zip(axes) {
        one.enabled = end.left_on.contains(&axis.drive);
    }
}

fn print(arguments: &Arguments, moves: Moves) -> Result<ExitCode, DrivesError> {
    if arguments.json {
        print_json(&moves).map_err(DrivesError::Print)?;
    } else {
        for one in &moves.moves {
            let read = one
                .read_counts
                .map_or_else(|| "no position".to_owned(), |counts| counts.to_string());
            let (how, state) = (
                if one.arrived {
                    "arrived"
                } else {
                    "was stopped on its way"
                },
                if one.enabled {
                    "stays enabled, as it was before"
                } else {
                    "is disabled"
                },
            );
            print_line(format_args!(
                "drive {} {how}: from {} to {} counts, it reports {read} and {state}",
                one.drive, one.start_counts, one.end_counts
            ))
            .map_err(DrivesError::Print)?;
        }
    }
    Ok(match &moves {
        Moves {
            interrupted: true, ..
        } => exit::INTERRUPTED.into(),
        _ if moves.moves.iter().all(|one| one.arrived) => ExitCode::SUCCESS,
        _ => exit::BROKEN_PROMISE.into(),
    })
}

/// The frames, at the gear number of a drive as it leaves the factory.
fn frames(arguments: &Arguments, wanted: &[(DriveId, f64)]) -> Result<Vec<Step>, DrivesError> {
    let gear = GearNumber::new(DRY_RUN_GEAR).unwrap_or(GearNumber::MAX);
    let is_relative = !arguments.by.is_empty();
    if arguments.link.is_serial() {
        let (drive, turns) = serial::only(wanted)?;
        return Ok(serial::frames(drive.into(), turns, is_relative));
    }
    let mut steps = Vec::new();
    for (drive, _) in wanted {
        steps.extend(Frames::on_can(
            When::Before,
            *drive,
            Request::ReadParamGroup2,
        ));
        let enable = Request::ServoDisable(dyn_can::ServoSwitch::Enable);
        steps.extend(Frames::on_can(When::IfDifferent, *drive, enable));
    }
    for (drive, turns) in wanted {
        let counts = i32::try_from(counts_of(*turns, gear)).ok();
        let Some(counts) = counts.and_then(|counts| Counts28::new(counts).ok()) else {
            continue;
        };
        let request = match (wanted.len(), is_relative) {
            (1, false) => Request::GoAbsolutePosPtp(counts),
            (1, true) => Request::GoRelativePosPtp(counts),
            (_, false) => Request::GoAbsolutePosSync(counts),
            (_, true) => Request::GoRelativePosSync(counts),
        };
        steps.extend(Frames::on_can(When::Always, *drive, request));
    }
    if wanted.len() > 1 {
        let kind = if is_relative {
            SyncKind::Relative
        } else {
            SyncKind::Absolute
        };
        steps.extend(Frames::to_all(When::Always, Request::SyncTrigger(kind)));
    }
    Ok(steps)
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<Moves>()
}
