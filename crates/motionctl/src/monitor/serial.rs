//! `motionctl monitor --serial`: one question at a time, to one drive after the other.

use std::process::ExitCode;
use std::time::{Duration, Instant};

use dyn_can::DriveId;

use super::{Ages, Arguments, Line};
use crate::drives::{DriveState, DrivesError, SerialDrives};
use crate::interrupt;
use crate::output::Printed;

/// Longest sleep before Ctrl-C is looked at.
const NAP: Duration = Duration::from_millis(20);

/// Prints the states until the user asks to stop.
pub(super) fn run(
    arguments: &Arguments,
    drives: &[DriveId],
    mut line: SerialDrives,
) -> Result<ExitCode, DrivesError> {
    interrupt::listen().map_err(DrivesError::Interrupt)?;
    let start = Instant::now();
    let period = Duration::from_millis(arguments.every_ms.into());
    let mut latest: Vec<Option<Instant>> = vec![None; drives.len()];
    let (mut lines, mut next) = (0, start + period);
    while interrupt::requests() == 0 && arguments.count.is_none_or(|count| lines < count) {
        for (drive, latest) in drives.iter().zip(&mut latest) {
            let state = state_of(&mut line, *drive)?;
            if state.is_some() {
                *latest = Some(Instant::now());
            }
            if line_of(*drive, state, *latest, start).print(arguments)? == Printed::NobodyReads {
                return Ok(ExitCode::SUCCESS);
            }
        }
        lines += 1;
        if arguments.count.is_none_or(|count| lines < count) {
            wait_until(next);
        }
        // A line that is slower than the period does not run after it.
        next = Instant::now().max(next) + period;
    }
    Ok(ExitCode::SUCCESS)
}

/// `None` when the drive does not answer.
fn state_of(line: &mut SerialDrives, drive: DriveId) -> Result<Option<DriveState>, DrivesError> {
    match line.state(drive.into()) {
        Ok(state) => Ok(Some(state)),
        Err(
            DrivesError::NoAnswer { .. }
            | DrivesError::OnlyEchoes { .. }
            | DrivesError::Incomplete { .. }
            | DrivesError::Fault { .. },
        ) => Ok(None),
        Err(error) => Err(error),
    }
}

fn line_of(
    drive: DriveId,
    state: Option<DriveState>,
    latest: Option<Instant>,
    start: Instant,
) -> Line {
    let age_ms = latest.map(|at| u64::try_from(at.elapsed().as_millis()).unwrap_or(u64::MAX));
    Line {
        time_s: start.elapsed().as_secs_f64(),
        drive: drive.get(),
        answers: state.is_some(),
        state: state.unwrap_or_default(),
        ages: Ages {
            status_ms: age_ms,
            position_ms: age_ms,
            // The protocol has no speed, and its torque no scale.
            torque_ms: None,
            speed_ms: None,
        },
    }
}

fn wait_until(at: Instant) {
    while let Some(left) = at
        .checked_duration_since(Instant::now())
        .filter(|left| !left.is_zero() && interrupt::requests() == 0)
    {
        std::thread::sleep(left.min(NAP));
    }
}
