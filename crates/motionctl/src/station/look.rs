//! What the drives say of themselves before anything is switched or moved.

use core::fmt;

use can_motion::{AxisSnapshot, ConfigError, Fault, PollPeriods};
use dyn_can::{DriveId, GearNumber};

use super::axis_options::AxisOptions;
use super::fault_text::fault_text;
use super::pc_master::Station;
use crate::interrupt;
use crate::link::{Link, LinkFault};

/// Time for every drive to tell.
const LIMIT_US: u64 = 10_000_000;
/// Shortest cycle.
const CYCLE_US: u32 = 1_000;
/// Readings ten times a second.
const POLLS: PollPeriods = PollPeriods {
    status_us: Some(100_000),
    position_us: Some(100_000),
    ..PollPeriods::OFF
};

/// What a drive said of itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Seen {
    pub(crate) drive: DriveId,
    pub(crate) gear: GearNumber,
    pub(crate) position_counts: i32,
}

/// Why it is not known what the drives say.
#[derive(Debug)]
pub(crate) enum LookError {
    /// The link failed.
    Link(LinkFault),
    /// The master refuses the configuration.
    Config(ConfigError),
    /// The user asked to stop.
    Interrupted,
    /// A drive has a fault.
    Fault { drive: DriveId, fault: Fault },
    /// A drive did not tell everything in time.
    Incomplete { drive: DriveId },
}

impl From<LinkFault> for LookError {
    fn from(fault: LinkFault) -> Self {
        Self::Link(fault)
    }
}

impl fmt::Display for LookError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Link(fault) => write!(f, "the link failed: {fault}"),
            Self::Config(error) => error.fmt(f),
            Self::Interrupted => f.write_str("stopped by the user"),
            Self::Fault { drive, fault } => f.write_str(&fault_text(*drive, *fault)),
            Self::Incomplete { drive } => write!(
                f,
                "drive {drive} did not answer all requests in time: try again, or look for a second master"
            ),
        }
    }
}

/// Reads gear number, state and position of these drives, given in ascending order. Nothing is switched.
///
/// # Errors
/// [`LookError`] when one does not tell, or has a fault.
pub(crate) fn look(
    link: &mut Link,
    options: AxisOptions,
    drives: &[DriveId],
) -> Result<Vec<Seen>, LookError> {
    // Any gear number: a difference is what is looked for.
    let axis = |&drive| options.still(drive, GearNumber::MIN, POLLS);
    let axes: Vec<_> = drives.iter().map(axis).collect();
    let mut station = Station::unhurried(link, &axes, CYCLE_US).map_err(LookError::Config)?;
    let start = station.now();
    loop {
        station.cycle(|_, _| {})?;
        let mut seen = Vec::new();
        let mut missing = None;
        let axes: Vec<AxisSnapshot> = station.snapshots().collect();
        for axis in axes {
            match seen_of(&axis, options) {
                Ok(Some(drive)) => seen.push(drive),
                Ok(None) => missing = missing.or(Some(axis.drive)),
                Err(fault) => {
                    let drive = axis.drive;
                    return Err(LookError::Fault {
                        drive,
                        fault: station.named(drive, fault),
                    });
                }
            }
        }
        match missing {
            None => return Ok(seen),
            Some(drive) if station.now().us_since(start) >= LIMIT_US => {
                return Err(LookError::Incomplete { drive });
            }
            Some(_) if interrupt::requests() > 0 => return Err(LookError::Interrupted),
            Some(_) => {}
        }
    }
}

/// `None` until the drive has told everything.
fn seen_of(axis: &AxisSnapshot, options: AxisOptions) -> Result<Option<Seen>, Fault> {
    if let Some(fault) = axis.fault
        && !matches!(
            fault,
            Fault::Group
                | Fault::Gear {
                    actual: Some(_),
                    ..
                }
        )
    {
        return Err(fault);
    }
    let read = &axis.feedback;
    let (Some(group3), Some(position), Some(status)) = (read.group3, read.position, read.status)
    else {
        return Ok(None);
    };
    // The checks stop at the gear number, which comes first.
    if status.value.alarm().is_alarm() {
        return Err(Fault::AlarmStatus(status.value.alarm()));
    }
    let gear = group3.gear_number;
    let Some(position_counts) = options.scale(gear).to_command_counts(position.value) else {
        return Err(Fault::PositionRange {
            read_back: position.value,
        });
    };
    Ok(Some(Seen {
        drive: axis.drive,
        gear,
        position_counts,
    }))
}
