//! Reads everything that a drive tells.

use can_motion::{AxisSnapshot, Fault, Instant, PollPeriods, Procedure, ProcedureEnd, Stamped};
use dyn_can::{DriveId, GearNumber, Reply};

use super::procedure::{answering_station, perform};
use crate::drives::{DriveState, DrivesError, Parameter, Readings};
use crate::link::Link;
use crate::station::AxisOptions;

/// Every reading of the state that a poll can bring, 50 times a second.
const EVERYTHING: PollPeriods = PollPeriods {
    torque_us: Some(20_000),
    speed_us: Some(20_000),
    ..PollPeriods::DEFAULT
};
/// How often a parameter group is read at most: a reply may be lost, and a PC may be busy for a while.
const ATTEMPTS: u32 = 3;
/// An older value says nothing of the present.
const FRESH_US: u64 = 500_000;
/// Time for the polls to bring one reading of each kind.
const POLL_LIMIT_US: u64 = 3_000_000;

/// Reads the state and every parameter of a drive, with a fault or without.
pub(super) fn read(
    link: &mut Link,
    axes: AxisOptions,
    drive: DriveId,
) -> Result<Readings, DrivesError> {
    // Any gear number: a drive that has another one is read all the same.
    let mut station = answering_station(link, axes, drive, GearNumber::MIN, EVERYTHING)?;
    let mut parameters = Vec::new();
    for procedure in [
        Procedure::ReadConfig,
        Procedure::ReadGroup1,
        Procedure::ReadGroup2,
        Procedure::ReadGroup3,
    ] {
        let mut end = perform(&mut station, drive, procedure)?;
        for _ in 1..ATTEMPTS {
            if end == ProcedureEnd::NoReply {
                end = perform(&mut station, drive, procedure)?;
            }
        }
        match end {
            ProcedureEnd::Read(reply) => parameters.extend(parameters_of(&reply)),
            _ => {
                return Err(DrivesError::Incomplete {
                    drive: drive.into(),
                });
            }
        }
    }
    let start = station.now();
    loop {
        let Some(axis) = station.master().snapshot(0) else {
            return Err(DrivesError::Incomplete {
                drive: drive.into(),
            });
        };
        if axis.fault == Some(Fault::Lost) {
            return Err(DrivesError::NoAnswer {
                drive: drive.into(),
            });
        }
        let now = station.now().as_us();
        let oldest = Instant::from_us(now.saturating_sub(FRESH_US));
        let is_complete = has_every_reading(&axis);
        if is_complete || station.now().us_since(start) > POLL_LIMIT_US {
            let revision = axis.feedback.revision;
            let protocol =
                revision.map_or_else(|| "CAN".to_owned(), |revision| format!("CAN {revision}"));
            return Ok(
                Readings::new(drive.get(), protocol, state_of(&axis, oldest), parameters)
                    .of_revision(revision),
            );
        }
        station.cycle(|_, _| {})?;
    }
}

fn has_every_reading(axis: &AxisSnapshot) -> bool {
    let read = &axis.feedback;
    read.status.is_some()
        && read.position.is_some()
        && read.torque.is_some()
        && read.speed_rpm.is_some()
}

/// The state that the latest readings show; those from before `oldest` are left out.
pub(crate) fn state_of(axis: &AxisSnapshot, oldest: Instant) -> DriveState {
    let read = &axis.feedback;
    let status = since(oldest, read.status);
    let torque = since(oldest, read.torque);
    DriveState {
        enabled: status.map(|status| !status.is_disabled()),
        on_position: status.map(|status| status.on_position()),
        busy: status.map(|status| status.motion_busy()),
        alarm: status
            .map(|status| status.alarm())
            .filter(|alarm| alarm.is_alarm())
            .map(|alarm| alarm.to_string()),
        position_counts: since(oldest, read.position),
        speed_rpm: since(oldest, read.speed_rpm).map(i32::from),
        torque_share: torque.map(|torque| torque.of_peak()),
        torque_in_doubt: torque.is_some_and(|torque| torque.is_beyond_scale()),
    }
}

fn since<T>(oldest: Instant, reading: Option<Stamped<T>>) -> Option<T> {
    reading
        .filter(|reading| reading.at >= oldest)
        .map(|reading| reading.value)
}

/// The parameters in a reply.
pub(super) fn parameters_of(reply: &Reply) -> Vec<(Parameter, i32)> {
    match reply {
        Reply::DriveConfig(byte) => vec![(Parameter::Config, byte.to_byte().into())],
        Reply::ParamGroup1(group) => vec![
            (Parameter::MainGain, group.main_gain.get().into()),
            (Parameter::SpeedGain, group.speed_gain.get().into()),
            (
                Parameter::IntegrationGain,
                group.integration_gain.get().into(),
            ),
            (Parameter::TorqueFilter, group.torque_filter.get().into()),
        ],
        Reply::ParamGroup2(group) => vec![
            (Parameter::MaxSpeed, group.max_speed.get().into()),
            (
                Parameter::MaxAcceleration,
                group.max_acceleration.get().into(),
            ),
        ],
        Reply::ParamGroup3(group) => {
            let line = group
                .line_number
                .map(|line| (Parameter::LineNumber, line.get().into()));
            let mut parameters = vec![
                (Parameter::OnPositionRange, group.on_pos_range.get().into()),
                (Parameter::GearNumber, group.gear_number.get().into()),
            ];
            parameters.extend(line);
            parameters
        }
        _ => Vec::new(),
    }
}
