//! Drives on CAN: the master's own scripts and procedures, over a link.

mod jog;
mod procedure;
mod read;
mod write;

use can_motion::PollPeriods;
use dyn_can::{DriveId, GearNumber, Revision, StoredDriveId};
use dyn_commission::{Commissioner, Scan};

use super::{Drives, DrivesError, FoundDrive, Jog, JogEnd, Parameter, Readings, Setting, WriteEnd};
use crate::link::Link;
use crate::station::{AxisOptions, Clock, StallWatch, serve_until};
use procedure::answering_station;
pub(crate) use read::state_of;
use write::write;

/// How often the scan is told that time passes, in microseconds.
const TICK_US: u32 = 1_000;

/// How long each id has to answer: adapters on USB hold bytes back for up to 16 ms, and the system lets a program wait.
const LISTEN_US: u32 = 50_000;

/// Drives behind a link to a CAN bus.
pub(super) struct CanDrives {
    link: Link,
    axes: AxisOptions,
}

impl CanDrives {
    pub(super) fn new(link: Link, axes: AxisOptions) -> Self {
        Self { link, axes }
    }
}

impl Drives for CanDrives {
    fn scan(&mut self, on_id: &mut dyn FnMut(u8)) -> Result<Vec<FoundDrive>, DrivesError> {
        let clock = Clock::start();
        let mut scan = Commissioner::new(Scan::listening(LISTEN_US));
        let mut told = None;
        let mut watch = StallWatch::new(None, clock.now());
        loop {
            if let Some(found) = scan.result() {
                let drives = found.iter();
                return Ok(drives
                    .map(|found| found_drive(found.drive, found.revision))
                    .collect());
            }
            let asked = scan.script().position();
            if let Some(id) = asked.filter(|_| asked != told) {
                on_id(id.get());
                told = asked;
            }
            let until = clock.now() + TICK_US;
            serve_until(&mut scan, &mut self.link, &clock, until)?;
            scan.tick(clock.now());
            if watch.stalls_at(asked, clock.now()) {
                return Err(DrivesError::NothingGetsOut);
            }
        }
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
        let drive = on_can(drive)?;
        let gear = self.gear(drive)?;
        let mut station =
            answering_station(&mut self.link, self.axes, drive, gear, PollPeriods::OFF)?;
        // With another gear number the drive is not the one that was checked any more.
        let (gear, others): (Vec<Setting>, Vec<Setting>) = settings
            .iter()
            .partition(|setting| setting.parameter == Parameter::GearNumber);
        for setting in others.into_iter().chain(gear) {
            on_end(setting, write(&mut station, drive, setting)?);
        }
        Ok(())
    }

    fn jog(&mut self, drive: StoredDriveId, jog: Jog) -> Result<JogEnd, DrivesError> {
        jog::jog(&mut self.link, self.axes, on_can(drive)?, jog)
    }
}

impl CanDrives {
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
