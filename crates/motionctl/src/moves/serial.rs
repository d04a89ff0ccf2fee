//! `motionctl move --serial`: one drive that is enabled already.

use std::process::ExitCode;

use dyn_can::{DriveId, StoredDriveId};

use super::{Arguments, DRY_RUN_GEAR, MoveEnd, Moves, print};
use crate::confirm::confirm;
use crate::drives::{DrivesError, Frames, LineMove, SerialDrives, Step, Way, When};
use crate::interrupt;
use crate::own_moves::counts_of;

/// The one drive that can move over the serial port, and its turns.
pub(super) fn only(wanted: &[(DriveId, f64)]) -> Result<(DriveId, f64), DrivesError> {
    match wanted {
        &[one] => Ok(one),
        many => Err(DrivesError::MoveRefused {
            drive: many.first().map_or(DriveId::MIN, |(drive, _)| *drive),
            reason: format!(
                "over --serial one drive moves at a time, because the protocol has no trigger that starts {} together: use CAN",
                many.len()
            ),
        }),
    }
}

/// Asks, moves, prints where the move has led.
pub(super) fn run(
    arguments: &Arguments,
    (drive, turns): (DriveId, f64),
    mut drives: SerialDrives,
) -> Result<ExitCode, DrivesError> {
    let is_relative = !arguments.by.is_empty();
    let limits = arguments.limits;
    let question = format!(
        "Drive {drive} will MOVE its motor, powered, {}. Is everybody clear of the machine?",
        limits.text()
    );
    confirm(&question, arguments.yes).map_err(DrivesError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(DrivesError::Interrupt)?;
    let way = if is_relative {
        Way::By(turns)
    } else {
        Way::To(turns)
    };
    let wanted = LineMove {
        way,
        max_rpm: limits.max_rpm().into(),
        rpm_option: "--max-rpm",
        max_rpm_per_s: Some(limits.max_acceleration().into()),
        max_turns: limits.max_turns(),
    };
    let (start_counts, end) = drives.go(drive.into(), wanted)?;
    let one = MoveEnd {
        drive: drive.get(),
        start_counts,
        end_counts: start_counts.wrapping_add(end.asked_counts),
        arrived: !end.interrupted,
        read_counts: end
            .read_counts
            .map(|moved| start_counts.wrapping_add(moved)),
        enabled: end.enabled,
    };
    let moves = Moves {
        moves: vec![one],
        interrupted: end.interrupted,
    };
    print(arguments, moves)
}

/// The packets, at the gear number of a drive as it leaves the factory.
pub(super) fn frames(drive: StoredDriveId, turns: f64, is_relative: bool) -> Vec<Step> {
    use dyn_serial::{Counts28, ReadSelector, Request};
    let reads = [
        Request::ReadDriveStatus,
        Request::ReadDriveConfig,
        Request::GeneralRead(ReadSelector::Position),
        Request::ReadHighSpeed,
        Request::ReadHighAccel,
        Request::ReadGearNumber,
    ];
    let mut steps: Vec<Step> = reads
        .iter()
        .filter_map(|request| Frames::on_line(When::Before, drive, request, "read"))
        .collect();
    let gear = dyn_can::GearNumber::new(DRY_RUN_GEAR).unwrap_or(dyn_can::GearNumber::MAX);
    let counts = i32::try_from(counts_of(turns, gear)).ok();
    let command = counts
        .and_then(|counts| Counts28::new(counts).ok())
        .map(|counts| match is_relative {
            true => (Request::GoRelativePos(counts), "move by"),
            false => (Request::GoAbsolutePos(counts), "move to"),
        });
    steps.extend(command.and_then(|(request, does)| {
        let does = format!("{does} {} counts", counts_of(turns, gear));
        Frames::on_line(When::Always, drive, &request, &does)
    }));
    steps
}
