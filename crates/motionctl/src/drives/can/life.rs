//! Whether a drive has lived on since it was last looked at: its diagnostic counter, and where it stands.

use can_motion::{Fault, PollPeriods};
use dyn_can::{DriveId, GearNumber};

use super::procedure::answering_station;
use crate::drives::DrivesError;
use crate::link::Link;
use crate::station::{AxisOptions, look};

/// The counter is read as fast as the drive answers, and nothing else but the position.
const POLLS: PollPeriods = PollPeriods {
    position_us: Some(20_000),
    counter_us: Some(20_000),
    ..PollPeriods::OFF
};
/// Values that a drive which starts again does not reach by a few reads: a counter is read on until it is one of them.
const TELLING: core::ops::RangeInclusive<u8> = 16..=239;
/// Time for the counter to get there.
const LIMIT_US: u64 = 20_000_000;

/// What a drive tells of its life.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Life {
    pub(crate) gear: GearNumber,
    /// The counter when it was first read now.
    pub(crate) first_counter: u8,
    /// The counter when it was last read now.
    pub(crate) last_counter: u8,
    /// In command counts.
    pub(crate) position_counts: i32,
    /// Its configuration byte has absolute mode.
    pub(crate) is_absolute: bool,
}

/// Reads the counter of a drive, and leaves it at a value that tells the next look whether the drive has started again.
pub(crate) fn life(
    link: &mut Link,
    axes: AxisOptions,
    drive: DriveId,
) -> Result<Life, DrivesError> {
    let seen = look(link, axes, &[drive]).map_err(DrivesError::Look)?;
    let incomplete = DrivesError::Incomplete {
        drive: drive.into(),
    };
    let Some(gear) = seen.first().map(|seen| seen.gear) else {
        return Err(incomplete);
    };
    let mut station = answering_station(link, axes, drive, gear, POLLS)?;
    let start = station.now();
    let mut first_counter = None;
    while station.now().us_since(start) < LIMIT_US {
        station.cycle(|_, _| {})?;
        let Some(axis) = station.master().snapshot(0) else {
            break;
        };
        if axis.fault == Some(Fault::Lost) {
            return Err(DrivesError::NoAnswer {
                drive: drive.into(),
            });
        }
        let read = axis.feedback;
        let (Some(counter), Some(position), Some(config)) =
            (read.counter, read.position, read.config)
        else {
            continue;
        };
        let first_counter = *first_counter.get_or_insert(counter.value);
        let counts = axes.scale(gear).to_command_counts(position.value);
        if let Some(position_counts) = counts.filter(|_| TELLING.contains(&counter.value)) {
            return Ok(Life {
                gear,
                first_counter,
                last_counter: counter.value,
                position_counts,
                is_absolute: config.absolute_mode(),
            });
        }
    }
    Err(incomplete)
}
