//! What becomes of an origin: the drive's own zero, and the file.

use homing::Home;

use super::arguments::Arguments;
use super::error::HomeError;
use super::outcome::Kept;
use super::plan::Plan;
use crate::drives::{CanDrives, Drives as _, DrivesError};
use crate::link::Link;
use crate::origins::{AfterPowerLoss, HomedAxis, Origins, now};

/// A free shaft may move by so many counts meanwhile.
const STILL_COUNTS: u32 = 16;

/// Makes the drive take its own zero where that is wanted, and writes the file.
pub(super) fn keep(
    arguments: &Arguments,
    link: Link,
    plan: &Plan,
    home: Home,
    enabled: bool,
    origins: Option<Origins>,
) -> Result<Kept, HomeError> {
    let drive = arguments.drive;
    let mut drives = CanDrives::new(link, arguments.axes);
    let mut life = drives.life(drive.into())?;
    let mut frame = home.frame;
    if arguments.in_drive {
        if enabled {
            return Err(DrivesError::Enabled {
                drive: drive.into(),
            }
            .into());
        }
        let before = life.position_counts;
        let again = drives.life(drive.into())?;
        if again.position_counts.abs_diff(before) > STILL_COUNTS {
            return Err(DrivesError::Fault {
                drive: drive.into(),
                reason: format!(
                    "expected a motor that stands, its position went from {before} to {} counts: stop it; nothing was written",
                    again.position_counts
                ),
            }
            .into());
        }
        drives.set_origin(drive.into())?;
        life = drives.life(drive.into())?;
        if life.position_counts.unsigned_abs() > STILL_COUNTS {
            return Err(HomeError::NotZero {
                drive: drive.get(),
                actual_counts: life.position_counts,
            });
        }
        frame = frame.with_drive_zero(again.position_counts, life.position_counts);
    }
    let after_power_loss = AfterPowerLoss::of(life.is_absolute);
    if let Some(mut origins) = origins {
        let travel = frame.travel();
        origins
            .put(HomedAxis {
                drive: drive.get(),
                gear_number: i32::from(plan.gear.get()),
                method: arguments.search.method.word().to_owned(),
                homed: now(),
                origin_counts: frame.origin_counts(),
                uncertainty_counts: home.uncertainty_counts,
                min_counts: travel.min_counts,
                max_counts: travel.max_counts,
                after_power_loss,
                position_counts: life.position_counts,
                counter: life.last_counter,
            })
            .map_err(HomeError::Origins)?;
    }
    Ok(Kept {
        frame,
        position_counts: life.position_counts,
        after_power_loss,
        enabled,
        in_drive: arguments.in_drive,
        eeprom_writes: u8::from(arguments.in_drive),
        turn_counts: plan.turn_counts,
    })
}
