//! What becomes of an origin: the zero of the drive, the mark, and the file.

use homing::Home;
use zlac8030l::{SdoRequest, dictionary, objects};

use super::arguments::Arguments;
use super::plan::Plan;
use crate::home::{HomeError, Kept};
use crate::hub::bus::Bus;
use crate::hub::error::HubError;
use crate::hub::object::{MARK, ObjectSetting};
use crate::hub::origin::clearing;
use crate::hub::store::{protect, request};
use crate::origins::{AfterPowerLoss, HomedWheel, Origins, WheelLife, now};

/// A free shaft may move by so many counts meanwhile.
const STILL_COUNTS: u32 = 16;

/// Clears the position of the drive where that is wanted, and writes mark and file.
///
/// # Errors
/// What the drive did not do, or the file.
pub(super) fn keep(
    arguments: &Arguments,
    bus: &mut Bus,
    plan: &Plan,
    home: &Home,
    origins: Option<Origins>,
) -> Result<Kept, HubError> {
    let node = plan.node;
    let mut frame = home.frame;
    let mut position_counts = bus.read(node, objects::ACTUAL_POSITION)?;
    if arguments.in_drive {
        let before = position_counts;
        for request in clearing() {
            bus.write(node, request)?;
        }
        position_counts = bus.read(node, objects::ACTUAL_POSITION)?;
        if position_counts.unsigned_abs() > STILL_COUNTS {
            return Err(HubError::NotTaken {
                node,
                address: objects::ACTUAL_POSITION.address(),
                expected: 0,
                actual: position_counts.into(),
            });
        }
        frame = frame.with_drive_zero(before, position_counts);
    }
    let after_power_loss = AfterPowerLoss::of(false);
    if let Some(mut origins) = origins {
        let mark = write_mark(bus, plan)?;
        let travel = frame.travel();
        let wheel = HomedWheel {
            node: node.get(),
            turn_counts: plan.turn_counts as u32,
            method: arguments.search.method.word().to_owned(),
            homed: now(),
            origin_counts: frame.origin_counts(),
            uncertainty_counts: home.uncertainty_counts,
            min_counts: travel.min_counts,
            max_counts: travel.max_counts,
            after_power_loss,
            mark,
        };
        origins.put_wheel(wheel).map_err(HomeError::Origins)?;
    }
    Ok(Kept {
        frame,
        position_counts,
        after_power_loss,
        enabled: false,
        in_drive: arguments.in_drive,
        eeprom_writes: 0,
        turn_counts: plan.turn_counts,
    })
}

/// Another number than the one that is there, and never 0, which a drive has after its power-on.
fn write_mark(bus: &mut Bus, plan: &Plan) -> Result<u8, HubError> {
    let node = plan.node;
    protect(bus, node)?;
    let before = bus.read_number(node, MARK)?;
    let clock = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let any = clock.map_or(1, |since| since.subsec_nanos() % 254);
    let mut mark = any as u8 + 1;
    if i64::from(mark) == before {
        mark = mark % 255 + 1;
    }
    let unmarked = |error: HubError| match error {
        HubError::Refused { .. } | HubError::NotTaken { .. } => HubError::Input(format!(
            "the reference was found, and the origin was not kept: node {node} does not take a number at 1803h:04, so that nobody could see when it has lost its power ({error}). `--in-drive` without --origins makes it count from there"
        )),
        error => error,
    };
    bus.write(node, mark_request(mark)?).map_err(unmarked)?;
    let actual = bus.read_number(node, MARK)?;
    if actual == i64::from(mark) {
        return Ok(mark);
    }
    Err(unmarked(HubError::NotTaken {
        node,
        address: MARK,
        expected: mark.into(),
        actual,
    }))
}

/// The write of a mark.
///
/// # Errors
/// None for a number of 8 bits.
pub(super) fn mark_request(mark: u8) -> Result<SdoRequest, HubError> {
    let entry = dictionary::find(MARK);
    let entry = entry.ok_or_else(|| HubError::Input("no object 1803h:04".to_owned()))?;
    request(&ObjectSetting {
        entry,
        value: mark.into(),
    })
}

/// What tells whether an origin still holds.
///
/// # Errors
/// As [`Bus::read`].
pub(in crate::hub) fn life(
    bus: &mut Bus,
    node: zlac8030l::NodeId,
    counts_per_turn: f64,
) -> Result<WheelLife, HubError> {
    Ok(WheelLife {
        turn_counts: counts_per_turn as u32,
        position_counts: bus.read(node, objects::ACTUAL_POSITION)?,
        mark: u8::try_from(bus.read_number(node, MARK)?).unwrap_or(0),
    })
}
