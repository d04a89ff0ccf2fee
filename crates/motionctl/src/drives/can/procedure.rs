//! One procedure of the master, from its start to its end.

use can_motion::{
    AxisState, Confirmation, EventKind, Fault, PollPeriods, Procedure, ProcedureEnd, ProcedureError,
};
use dyn_can::{DriveId, GearNumber, ParamGroup2, Reply};

use crate::drives::DrivesError;
use crate::link::Link;
use crate::station::{AxisOptions, Station};

/// Time for a drive to be probed and anchored.
const START_UP_LIMIT_US: u64 = 10_000_000;
/// Time for one procedure, the distance between two writes included.
const PROCEDURE_LIMIT_US: u64 = 10_000_000;
/// Shortest cycle of the commissioning commands that stream nothing.
const CYCLE_US: u32 = 1_000;

/// A station with one axis, whose drive has answered: it was checked, or it has a fault that does not keep it from being read.
pub(super) fn answering_station(
    link: &mut Link,
    axes: AxisOptions,
    drive: DriveId,
    gear: GearNumber,
    polls: PollPeriods,
) -> Result<Station<'_>, DrivesError> {
    let axis = axes.still(drive, gear, polls);
    let mut station = Station::unhurried(link, &[axis], CYCLE_US).map_err(DrivesError::Config)?;
    let start = station.now();
    while station.now().us_since(start) < START_UP_LIMIT_US {
        station.cycle(|_, _| {})?;
        let Some(axis) = station.master().snapshot(0) else {
            break;
        };
        match (axis.state, axis.fault) {
            (_, Some(Fault::Lost)) => {
                return Err(DrivesError::NoAnswer {
                    drive: drive.into(),
                });
            }
            (AxisState::Ready | AxisState::FoundOn | AxisState::Faulted, _) => return Ok(station),
            _ => {}
        }
    }
    Err(DrivesError::Incomplete {
        drive: drive.into(),
    })
}

/// The speed and acceleration that a drive uses by itself.
pub(crate) fn read_curve(
    link: &mut Link,
    axes: AxisOptions,
    drive: DriveId,
    gear: GearNumber,
) -> Result<ParamGroup2, DrivesError> {
    let mut station = answering_station(link, axes, drive, gear, PollPeriods::OFF)?;
    match perform(&mut station, drive, Procedure::ReadGroup2)? {
        ProcedureEnd::Read(Reply::ParamGroup2(group)) => Ok(group),
        _ => Err(DrivesError::Incomplete {
            drive: drive.into(),
        }),
    }
}

/// Runs a procedure to its end. It waits while the master is not ready for it, as after another write.
pub(super) fn perform(
    station: &mut Station<'_>,
    drive: DriveId,
    procedure: Procedure,
) -> Result<ProcedureEnd, DrivesError> {
    let start = station.now();
    let mut refusal = start_procedure(station, procedure).err();
    let mut bad_reply = None;
    while station.now().us_since(start) < PROCEDURE_LIMIT_US {
        station.cycle(|_, _| {})?;
        while let Some(event) = station.next_event() {
            match event.kind {
                EventKind::BadReply(error) => bad_reply = Some(error),
                EventKind::Procedure(end) => {
                    let is_over = matches!(end, ProcedureEnd::NoReply);
                    return match bad_reply.filter(|_| is_over) {
                        Some(error) => Err(DrivesError::BadReply {
                            drive: drive.into(),
                            error,
                        }),
                        None => Ok(end),
                    };
                }
                EventKind::Fault(Fault::Lost) => {
                    return Err(DrivesError::NoAnswer {
                        drive: drive.into(),
                    });
                }
                _ => {}
            }
        }
        match refusal {
            None => {}
            Some(
                ProcedureError::Busy
                | ProcedureError::State { .. }
                | ProcedureError::WearInterval { .. },
            ) => refusal = start_procedure(station, procedure).err(),
            Some(error) => return Err(DrivesError::Procedure(error)),
        }
    }
    Err(refusal.map_or(
        DrivesError::Incomplete {
            drive: drive.into(),
        },
        DrivesError::Procedure,
    ))
}

fn start_procedure(station: &mut Station<'_>, procedure: Procedure) -> Result<(), ProcedureError> {
    let now = station.now();
    station
        .master()
        .start(now, 0, procedure, Confirmation::Given)
}
