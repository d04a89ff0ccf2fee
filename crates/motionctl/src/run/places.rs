//! A motion on axes that were homed: it begins where they stand, and stays within their travel.

use std::path::Path;

use dyn_can::units;

use super::Axis;
use super::arguments::Arguments;
use super::error::RunError;
use crate::drives::life_of;
use crate::link::Link;
use crate::origins::Origins;

/// An axis may stand so far from the first position of its motion.
const AT_START_COUNTS: f64 = 32.0;

/// Looks at every drive, and refuses a motion that begins somewhere else or leaves the travel.
pub(super) fn check(
    arguments: &Arguments,
    link: &mut Link,
    axes: &[Axis],
    path: &Path,
) -> Result<(), RunError> {
    let mut origins = Origins::read(path).map_err(RunError::Origins)?;
    for axis in axes {
        let drive = axis.drive;
        let life = life_of(link, arguments.axes, drive).map_err(RunError::Life)?;
        let homed = origins.take(drive, &life).map_err(RunError::Origins)?;
        let frame = homed.frame();
        let here = frame.to_axis(life.position_counts);
        let turn = f64::from(units::command_counts_per_turn(life.gear));
        if (here as f64 - axis.first_counts).abs() > AT_START_COUNTS {
            return Err(RunError::Start {
                drive,
                expected_turns: axis.first_counts / turn,
                actual_turns: here as f64 / turn,
            });
        }
        for turns in [axis.needs.min_turns, axis.needs.max_turns] {
            let end = (here as f64 + turns * turn).round();
            // A motion has at most 28 bits.
            frame
                .to_drive(end as i32)
                .map_err(|error| RunError::OutsideTravel { drive, error })?;
        }
    }
    Ok(())
}
