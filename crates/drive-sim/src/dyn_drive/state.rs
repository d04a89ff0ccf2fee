//! What a test may look at.
//!
//! Specification: looking changes nothing. Methods that take `at_ns` tell the state at that instant if nothing happens until then.

use dyn_can::{Alarm, ConfigByte, DriveId, DriveStatus, ParamGroup1, ParamGroup2, ParamGroup3};

use super::books::Books;
use super::config::DynDriveConfig;
use super::registers::EepromWrites;
use super::{DriveFaults, DynDrive};

impl DynDrive {
    /// Its configuration.
    pub fn config(&self) -> &DynDriveConfig {
        &self.config
    }

    /// The id it listens to; `None` for a fresh drive.
    pub fn id(&self) -> Option<DriveId> {
        self.registers.ram.id.drive_id()
    }

    /// What it accepted, refused and sent since it was made.
    pub fn books(&self) -> &Books {
        &self.books
    }

    /// Sum of all Go_Relative_Pos_PD steps accepted since it was made, in command counts.
    pub fn commanded_counts(&self) -> i64 {
        self.books.commanded_counts
    }

    /// Requests that wrote its EEPROM since it was made.
    pub fn eeprom_writes(&self) -> &EepromWrites {
        &self.registers.writes
    }

    /// Faults in force.
    pub fn faults(&self) -> &DriveFaults {
        &self.faults
    }

    /// Faults, to command some.
    pub fn faults_mut(&mut self) -> &mut DriveFaults {
        // Whatever is commanded takes effect at the present instant, and the drive looks for it when it runs.
        self.next_event_ns = Some(0);
        &mut self.faults
    }

    /// Position of the shaft in the drive's coordinates, in command counts without overflow.
    pub fn position_counts(&self, at_ns: u64) -> i64 {
        self.motion.at(at_ns).position() - self.origin_counts
    }

    /// Distance of the shaft from where it stood at 0 ns, in command counts; no origin and no power cycle changes it.
    pub fn travel_counts(&self, at_ns: u64) -> i64 {
        self.motion.at(at_ns).position()
    }

    /// Where the commanded motion ends, in the drive's coordinates and command counts; the position when the servo is off.
    pub fn target_counts(&self, at_ns: u64) -> i64 {
        self.motion.at(at_ns).target() - self.origin_counts
    }

    /// What General_Read reports: the position in the read-back unit, with its overflow.
    pub fn read_back(&self, at_ns: u64) -> i32 {
        let gear = self.registers.ram.group3.gear_number.get();
        let position = self
            .config
            .read_back
            .apply(self.position_counts(at_ns), gear);
        self.config.overflow.apply(position)
    }

    /// Commanded minus actual position, in command counts.
    pub fn following_error_counts(&self, at_ns: u64) -> f64 {
        self.motion.at(at_ns).error()
    }

    /// Speed of the motor in rpm.
    pub fn speed_rpm(&self, at_ns: u64) -> f64 {
        self.motion.at(at_ns).velocity() / self.counts_per_s_of_rpm()
    }

    /// Whether the switch of the mechanics is operated; false where there is none.
    pub fn switch_is_operated(&self, at_ns: u64) -> bool {
        let switch = self.config.mechanics.switch;
        switch.is_some_and(|switch| switch.is_operated(self.travel_counts(at_ns)))
    }

    /// The status byte.
    pub fn status(&self, at_ns: u64) -> DriveStatus {
        self.status_of(&self.motion.at(at_ns))
    }

    /// The latched alarm.
    pub fn alarm(&self) -> Alarm {
        self.alarm
    }

    /// Whether the servo is on.
    pub fn is_enabled(&self) -> bool {
        !self.motion.is_free()
    }

    /// Whether it has power and the power-on delay is over.
    pub fn is_ready(&self) -> bool {
        self.is_up()
    }

    /// The configuration byte in use.
    pub fn config_byte(&self) -> ConfigByte {
        self.registers.ram.config
    }

    /// Parameter group 1 in use.
    pub fn group1(&self) -> ParamGroup1 {
        self.registers.ram.group1
    }

    /// Parameter group 2 in use.
    pub fn group2(&self) -> ParamGroup2 {
        self.registers.ram.group2
    }

    /// Parameter group 3 in use.
    pub fn group3(&self) -> ParamGroup3 {
        self.registers.ram.group3
    }
}
