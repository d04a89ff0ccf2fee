//! How far a jog goes: as told, or to a place of an axis that was homed.

use dyn_can::units;

use super::{Arguments, MOST_TURNS};
use crate::drives::{Drives, DrivesError};
use crate::origins::Origins;

/// The turns to go. With a file of origins the axis was looked at, and its travel was kept.
pub(super) fn turns(arguments: &Arguments, drives: &mut dyn Drives) -> Result<f64, DrivesError> {
    let Some(path) = &arguments.origins else {
        // The command line has one of the two, and the other one needs a file.
        return Ok(arguments.turns.unwrap_or_default());
    };
    let mut origins = Origins::read(path).map_err(DrivesError::Origins)?;
    let fault = |reason: String| DrivesError::Fault {
        drive: arguments.drive,
        reason,
    };
    let Some(drive) = arguments.drive.drive_id() else {
        return Err(DrivesError::NoIdOnCan);
    };
    let life = drives.life(arguments.drive)?;
    let axis = origins.take(drive, &life).map_err(DrivesError::Origins)?;
    let turn = f64::from(units::command_counts_per_turn(life.gear));
    let here = axis.frame().to_axis(life.position_counts);
    let target = match (arguments.to, arguments.turns) {
        (Some(to), _) => to * turn,
        (None, turns) => here as f64 + turns.unwrap_or_default() * turn,
    };
    // The ranges of the options are far within 32 bits.
    axis.frame()
        .to_drive(target.round() as i32)
        .map_err(|error| DrivesError::OutsideTravel { drive, error })?;
    let turns = (target.round() - here as f64) / turn;
    if turns.abs() > MOST_TURNS {
        return Err(fault(format!(
            "the way is {turns:.3} turns, a jog goes at most {MOST_TURNS}: go in steps. Nothing has moved"
        )));
    }
    Ok(turns)
}
