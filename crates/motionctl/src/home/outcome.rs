//! The result of a homing.

use core::fmt;
use std::path::Path;

use homing::{Frame, Home};
use schemars::JsonSchema;
use serde::Serialize;

use super::options::SearchOptions;
use crate::origins::AfterPowerLoss;

/// Whose axis it is: a servo drive by its id, or a hub motor by its node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Whose {
    Drive(u8),
    Node(u8),
}

impl fmt::Display for Whose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drive(id) => write!(f, "drive {id}"),
            Self::Node(node) => write!(f, "node {node}"),
        }
    }
}

/// What was kept.
#[derive(Debug)]
pub(crate) struct Kept {
    pub(crate) frame: Frame,
    /// Where the drive was seen last.
    pub(crate) position_counts: i32,
    pub(crate) after_power_loss: AfterPowerLoss,
    pub(crate) enabled: bool,
    /// The drive counts from where it rests.
    pub(crate) in_drive: bool,
    pub(crate) eeprom_writes: u8,
    /// Counts of a turn.
    pub(crate) turn_counts: f64,
}

/// What was found. Counts are command counts of the drive.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Outcome {
    #[serde(flatten)]
    whose: Whose,
    method: &'static str,
    found: bool,
    /// Why not.
    reason: Option<String>,
    /// The drive is still enabled, as it was before.
    enabled: bool,
    #[serde(flatten)]
    place: Option<Place>,
}

#[derive(Debug, Serialize, JsonSchema)]
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
    pub(crate) fn found(
        whose: Whose,
        search: &SearchOptions,
        origins: Option<&Path>,
        home: &Home,
        kept: &Kept,
    ) -> Self {
        let permille = home.contact_permille;
        Self {
            whose,
            method: search.method.word(),
            found: true,
            reason: None,
            enabled: kept.enabled,
            place: Some(Place {
                found_counts: home.found_counts,
                origin_counts: kept.frame.origin_counts(),
                uncertainty_counts: home.uncertainty_counts,
                contact_torque_percent: permille.map(|permille| f64::from(permille) / 10.0),
                axis_turns: kept.frame.to_axis(kept.position_counts) as f64 / kept.turn_counts,
                travel_turns: search.travel,
                in_drive: kept.in_drive,
                eeprom_writes: kept.eeprom_writes,
                origins: origins.map(|path| path.display().to_string()),
                after_power_loss: kept.after_power_loss,
            }),
        }
    }

    pub(crate) fn failed(
        whose: Whose,
        search: &SearchOptions,
        reason: String,
        enabled: bool,
    ) -> Self {
        Self {
            whose,
            method: search.method.word(),
            found: false,
            reason: Some(reason),
            enabled,
            place: None,
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let whose = self.whose;
        let state = if self.enabled {
            "stays enabled, as it was before"
        } else {
            "is disabled"
        };
        let Some(place) = &self.place else {
            let reason = self.reason.as_deref().unwrap_or("no reason");
            return write!(
                f,
                "{whose} has no reference: {reason}. It {state}, and no origin was kept"
            );
        };
        write!(
            f,
            "{whose} was at its reference at {} counts (within {}), so its zero is where it reports {}. It rests at {:.4} turns and {state}",
            place.found_counts, place.uncertainty_counts, place.origin_counts, place.axis_turns
        )?;
        if let Some(percent) = place.contact_torque_percent {
            write!(f, "; contact at {percent:.1} % of peak torque")?;
        }
        match (place.in_drive, place.eeprom_writes) {
            (false, _) => {}
            (true, 0) => f.write_str(". The drive counts from where it rests")?,
            (true, writes) => write!(
                f,
                ". It has stored where it rests as its own zero. EEPROM writes: {writes}"
            )?,
        }
        match &place.origins {
            Some(file) => write!(f, ". Kept in {file}: ")?,
            None => f.write_str(". Kept nowhere (--origins): ")?,
        }
        f.write_str(place.after_power_loss.words())
    }
}
