//! Drives on CAN: the master's own scripts and procedures, over a link.

mod assign;
mod jog;
mod life;
mod probe;
mod procedure;
mod read;
mod reset;
mod script;
mod write;

use can_motion::{PollPeriods, Procedure, ProcedureEnd};
use dyn_can::{DriveId, GearNumber, Revision, StoredDriveId};
use dyn_commission::{AnswerCount, CountAnswers, Scan};

use super::{
    AssignEnd, Drives, DrivesError, FoundDrive, Jog, JogEnd, Parameter, ProbeEnd, Readings,
    ResetEnd, Setting, WriteEnd,
};
use crate::interrupt;
use crate::link::Link;
use crate::station::AxisOptions;
pub(crate) use life::{Life, life as life_of};
pub(crate) use procedure::read_curve;
use procedure::{answering_station, perform};
pub(crate) use read::state_of;
use script::LISTEN_US;
pub(crate) use write::request_of;
use write::write;

/// Drives behind a link to a CAN bus.
pub(crate) struct CanDrives {
    link: Link,
    axes: AxisOptions,
}

impl CanDrives {
    pub(crate) fn new(link: Link, axes: AxisOptions) -> Self {
        Self { link, axes }
    }
}

impl Drives for CanDrives {
    fn scan(&mut self, on_id: &mut dyn FnMut(u8)) -> Result<Vec<FoundDrive>, DrivesError> {
        let mut told = None;
        let found = script::run(&mut self.link, Scan::listening(LISTEN_US), |scan| {
            let asked = scan.position();
            if let Some(id) = asked.filter(|_| asked != told) {
                on_id(id.get());
                told = asked;
            }
        })?;
        let drives = found.iter();
        Ok(drives
            .map(|found| found_drive(found.drive, found.revision))
            .collect())
    }

    fn read(&mut self, drive: StoredDriveId) -> Result<Readings, DrivesError> {
        read::read(&mut self.link, self.axes, on_can(drive)?)
    }

    fn write(
        &mut self,
        drive: StoredDriveId,
        settings: &[Setting],
        on_end: &mut dyn FnMut(Setting, WriteEnd),
    ) -> Result<(), DrivesError> {
        self.write_while(on_can(drive)?, settings, on_end, || {
            interrupt::requests() == 0
        })
    }

    fn jog(&mut self, drive: StoredDriveId, jog: Jog) -> Result<JogEnd, DrivesError> {
        jog::jog(&mut self.link, self.axes, on_can(drive)?, jog)
    }

    fn require_one(&mut self, drive: StoredDriveId) -> Result<(), DrivesError> {
        let count = CountAnswers::of(on_can(drive)?).listening(LISTEN_US);
        match script::run(&mut self.link, count, |_| {})? {
            AnswerCount::None => Err(DrivesError::NoAnswer { drive }),
            AnswerCount::One => Ok(()),
            AnswerCount::Several => Err(DrivesError::Several { drive }),
        }
    }

    fn assign_id(&mut self, from: StoredDriveId, to: DriveId) -> Result<AssignEnd, DrivesError> {
        assign::assign(&mut self.link, from, to)
    }

    fn set_origin(&mut self, drive: StoredDriveId) -> Result<(), DrivesError> {
        let id = on_can(drive)?;
        let gear = self.gear(id)?;
        let mut station = answering_station(&mut self.link, self.axes, id, gear, PollPeriods::OFF)?;
        match perform(&mut station, id, Procedure::SetOrigin)? {
            ProcedureEnd::Sent => Ok(()),
            _ => Err(DrivesError::Incomplete { drive }),
        }
    }

    fn reset(&mut self, drive: StoredDriveId) -> Result<ResetEnd, DrivesError> {
        reset::reset(&mut self.link, self.axes, on_can(drive)?)
    }

    fn life(&mut self, drive: StoredDriveId) -> Result<Life, DrivesError> {
        life::life(&mut self.link, self.axes, on_can(drive)?)
    }

    fn probe(&mut self, drive: StoredDriveId) -> Result<ProbeEnd, DrivesError> {
        probe::probe(&mut self.link, on_can(drive)?)
    }
}

impl CanDrives {
    /// The link, for what is no commissioning.
    pub(crate) fn link(&mut self) -> &mut Link {
        &mut self.link
    }

    /// Writes settings whatever the user asks for meanwhile: to bring a drive back to what it was.
    pub(crate) fn write_back(
        &mut self,
        drive: DriveId,
        settings: &[Setting],
        on_end: &mut dyn FnMut(Setting, WriteEnd),
    ) -> Result<(), DrivesError> {
        self.write_while(drive, settings, on_end, || true)
    }

    fn write_while(
        &mut self,
        drive: DriveId,
        settings: &[Setting],
        on_end: &mut dyn FnMut(Setting, WriteEnd),
        goes_on: impl Fn() -> bool,
    ) -> Result<(), DrivesError> {
        let gear = self.gear(drive)?;
        let mut station =
            answering_station(&mut self.link, self.axes, drive, gear, PollPeriods::OFF)?;
        // With another gear number the drive is not the one that was checked any more.
        let (gear, others): (Vec<Setting>, Vec<Setting>) = settings
            .iter()
            .partition(|setting| setting.parameter == Parameter::GearNumber);
        for setting in others.into_iter().chain(gear) {
            if !goes_on() {
                return Err(DrivesError::Interrupted);
            }
            on_end(setting, write(&mut station, drive, setting)?);
        }
        Ok(())
    }

    /// The gear number of a drive.
    fn gear(&mut self, drive: DriveId) -> Result<GearNumber, DrivesError> {
        let any = GearNumber::MIN;
        let mut station =
            answering_station(&mut self.link, self.axes, drive, any, PollPeriods::OFF)?;
        let axis = station.master().snapshot(0);
        let group3 = axis.and_then(|axis| axis.feedback.group3);
        Ok(group3.map_or(any, |group3| group3.gear_number))
    }
}

fn on_can(drive: StoredDriveId) -> Result<DriveId, DrivesError> {
    drive.drive_id().ok_or(DrivesError::NoIdOnCan)
}

fn found_drive(drive: DriveId, revision: Option<Revision>) -> FoundDrive {
    let revision = revision.map_or_else(
        || "of unknown revision".to_owned(),
        |revision| revision.to_string(),
    );
    FoundDrive {
        drive: drive.get(),
        protocol: format!("CAN {revision}"),
    }
}
