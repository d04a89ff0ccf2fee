//! The result of a homing.

use core::fmt;

use homing::Home;
use serde::Serialize;

use super::arguments::Arguments;
use super::plan::Plan;
use super::store::Kept;
use crate::origins::AfterPowerLoss;

/// What was found. Counts are command counts of the drive.
#[derive(Debug, Serialize)]
pub(super) struct Outcome {
    drive: u8,
    method: &'static str,
    found: bool,
    /// Why not.
    reason: Option<String>,
    /// The drive is still enabled, as it was before.
    enabled: bool,
    #[serde(flatten)]
    place: Option<Place>,
}

#[derive(Debug, Serialize)]
struct Place {
    /// What the drive reported at the reference.
    found_counts: i32,
    /// What it reports at the zero of the axis, now.
    origin_counts: i32,
    uncertainty_counts: u32,
    contact_torque_percent: Option<f64>,
    /// Where the axis rests, in turns from its zero.
    axis_turns: f64,
    /// Where the axis may be; `None` where no --travel was given.
    travel_turns: Option<(f64, f64)>,
    in_drive: bool,
    eeprom_writes: u8,
    origins: Option<String>,
    after_power_loss: AfterPowerLoss,
}

impl Outcome {
    pub(super) fn found(arguments: &Arguments, plan: &Plan, home: &Home, kept: Kept) -> Self {
        let permille = home.contact_permille;
        Self {
            drive: arguments.drive.get(),
            method: arguments.method.word(),
            found: true,
            reason: None,
            enabled: kept.enabled,
            place: Some(Place {
                found_counts: home.found_counts,
                origin_counts: kept.frame.origin_counts(),
                uncertainty_counts: home.uncertainty_counts,
                contact_torque_percent: permille.map(|permille| f64::from(permille) / 10.0),
                axis_turns: plan.turns(kept.frame.to_axis(kept.position_counts)),
                travel_turns: arguments.travel,
                in_drive: arguments.in_drive,
                eeprom_writes: u8::from(arguments.in_drive),
                origins: arguments
                    .origins
                    .as_ref()
                    .map(|path| path.display().to_string()),
                after_power_loss: kept.after_power_loss,
            }),
        }
    }

    pub(super) fn failed(arguments: &Arguments, reason: String, enabled: bool) -> Self {
        Self {
            drive: arguments.drive.get(),
            method: arguments.method.word(),
            found: false,
            reason: Some(reason),
            enabled,
            place: None,
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let drive = self.drive;
        let state = if self.enabled {
            "stays enabled, as it was before"
        } else {
            "is disabled"
        };
        let Some(place) = &self.place else {
            let reason = self.reason.as_deref().unwrap_or("no reason");
            return write!(
                f,
                "drive {drive} has no reference: {reason}. It {state}, and no origin was kept"
            );
        };
        write!(
            f,
            "drive {drive} was at its reference at {} counts (within {}), so its zero is where it reports {}. It rests at {:.4} turns and {state}",
            place.found_counts, place.uncertainty_counts, place.origin_counts, place.axis_turns
        )?;
        if let Some(percent) = place.contact_torque_percent {
            write!(f, "; contact at {percent:.1} % of peak torque")?;
        }
        if place.in_drive {
            write!(
                f,
                ". It has stored where it rests as its own zero. EEPROM writes: 1"
            )?;
        }
        match &place.origins {
            Some(file) => write!(f, ". Kept in {file}: ")?,
            None => f.write_str(". Kept nowhere (--origins): ")?,
        }
        f.write_str(place.after_power_loss.words())
    }
}
