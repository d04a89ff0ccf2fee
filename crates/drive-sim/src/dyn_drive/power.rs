//! Power of a drive.
//!
//! Specification: without power, and for the power-on delay after it came back, a drive hears nothing, does nothing and says nothing; the motor is
//! free. Then it starts from its EEPROM with the servo on, where the shaft is (DYN2 manual A1.8 section 4), or moves to its zero in
//! absolute mode (1.6A section 6, #0).

use dyn_can::Alarm;

use super::DynDrive;
use super::settings::PositionAfterPower;

/// Whether the drive works.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Power {
    On,
    Down {
        /// When it starts to work.
        ready_ns: u64,
        /// Whether an incremental position is lost meanwhile.
        loses_position: bool,
    },
}

impl DynDrive {
    /// Power-on of a new drive at 0 ns: its position is the configured one.
    pub(super) fn first_power_on(&mut self) {
        self.power = Power::Down {
            ready_ns: self.config.power_on_delay_ns,
            loses_position: false,
        };
        self.start_if_ready(0);
    }

    pub(super) fn cut_power(&mut self, now_ns: u64, off_ns: u64) {
        self.motion.release();
        self.outbox.clear();
        self.serial.clear();
        self.alarm = Alarm::None;
        self.last_alarm_frame_ns = None;
        self.power = Power::Down {
            ready_ns: now_ns
                .saturating_add(off_ns)
                .saturating_add(self.config.power_on_delay_ns),
            loses_position: self.config.position_after_power == PositionAfterPower::Zero,
        };
    }

    /// Starts the drive if its power-on delay is over at `now_ns`.
    pub(super) fn start_if_ready(&mut self, now_ns: u64) {
        let Power::Down {
            ready_ns,
            loses_position,
        } = self.power
        else {
            return;
        };
        if ready_ns > now_ns {
            return;
        }
        self.power = Power::On;
        self.motion.advance_to(ready_ns);
        self.registers.power_on();
        self.wave = Default::default();
        self.update_limits();
        let absolute = self.registers.ram.config.absolute_mode();
        if loses_position && !absolute {
            self.origin_counts = self.motion.position();
        }
        if self.config.enabled_after_power_on && !self.registers.ram.config.servo_free() {
            self.lock();
            if absolute && self.takes_position_commands() {
                self.motion.go_to(self.origin_counts);
            }
        }
    }

    pub(super) fn is_up(&self) -> bool {
        self.power == Power::On
    }
}
