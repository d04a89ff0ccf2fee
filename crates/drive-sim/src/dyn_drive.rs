//! A simulated DYN2/DYN4 drive.
//!
//! # Why a test against this drive is not circular
//!
//! It shares the codec with the master and nothing else: what the codec makes of bytes is checked elsewhere against vectors of an
//! independent reference, and what a drive does with a request is written here from the documents alone. Where they are silent the
//! behaviour is a field of [`DynDriveConfig`], so that a test can try every reading. The drive keeps exact [`Books`] of what it
//! accepted; they come from the frames on the bus and know nothing of what a master believes to have sent.
//!
//! # Laws
//!
//! - Motion is lazy and advances in fixed ticks; a drive asks to run only when a frame is ready, a power-on delay ends, or the following
//!   error might reach its limit. Results do not depend on how often anybody looks.
//! - Commands that the state forbids (servo off, alarm, another mode) are ignored and are not in the books as accepted.
//! - Positions are in command counts, 4 x gear number a turn. A change of the gear number does not rescale the present position.
//! - Everything addressed to identifier 0 is obeyed, as by a drive that knows no better; replies and errors carry the drive's own id (D8).
//!   A fresh drive has none and answers on identifier 0.
//! - A reply tells the state at the end of its request.
//!
//! # What is not here
//!
//! The real servo loop (see [`ServoLoop`]), supply voltage and temperature, lines and arcs (D56), the brake output.

mod books;
mod config;
mod faults;
mod gains;
mod mechanics;
mod motion;
mod power;
mod reads;
mod reference;
mod registers;
mod replies;
mod requests;
mod serial;
mod servo;
mod settings;
mod state;

use dyn_can::units;
use dyn_can::{Address, Alarm, DataFrame, Dialect, DriveError, Reply, ZeroAddress};
use embedded_can::{Frame as _, Id};

pub use books::Books;
pub use config::{DynDriveConfig, LOST_PHASE_STEPS, POWER_ON_DELAY_NS};
pub use faults::DriveFaults;
pub use gains::ServoLoop;
pub use mechanics::{EndStops, Mechanics, Switch, SwitchSide};
pub use registers::{EepromWrites, STORED_GROUP2_WRITES};
pub use servo::TICK_NS;
pub use settings::{
    CoastDeceleration, DynConfigError, PositionAfterPower, PositionOverflow, RangeErrors, Reaction,
    ReadBackUnit, ResponseDelay, ServoDynamics, ServoLimits,
};

use can_frame::BitRate;

use crate::bench::{Bench, DeviceId};
use crate::bus::Bus;
use crate::controller::ControllerConfig;
use crate::device::Device;
use crate::frame::Frame;
use faults::Action;
use motion::Motion;
use power::Power;
use registers::Registers;
use replies::Outbox;
use requests::WaveRegisters;
use serial::SerialPort;
use servo::Limits;

/// Seconds in a minute, between rpm and counts per second.
const S_PER_MIN: f64 = 60.0;

/// A simulated drive. It is powered on at 0 ns.
///
/// Methods that take `at_ns` tell the state at that instant if nothing happens until then; an instant before the last event of the drive
/// tells the state at that event.
#[derive(Debug, Clone)]
pub struct DynDrive {
    config: DynDriveConfig,
    /// The dialect in which it listens.
    listening: Dialect,
    registers: Registers,
    motion: Motion,
    /// Where the shaft stands, from where it stood at first, when the drive reports 0.
    origin_counts: i64,
    wave: WaveRegisters,
    alarm: Alarm,
    last_alarm_frame_ns: Option<u64>,
    power: Power,
    outbox: Outbox,
    serial: SerialPort,
    faults: DriveFaults,
    books: Books,
    /// When it wants to run. Kept, because a bench asks every drive at every event.
    next_event_ns: Option<u64>,
}

impl DynDrive {
    /// A drive that is powered on at 0 ns and works from the end of its power-on delay.
    pub fn new(config: DynDriveConfig) -> Self {
        let registers = Registers::new(&config);
        let listening = Dialect {
            zero_address: ZeroAddress::LoneFreshDrive,
            allow_assign_zero: true,
            ..config.dialect
        };
        let mut drive = Self {
            listening,
            motion: Motion::new(limits(&config, &registers)),
            registers,
            origin_counts: -config.start_position_counts,
            wave: WaveRegisters::default(),
            alarm: Alarm::None,
            last_alarm_frame_ns: None,
            power: Power::On,
            outbox: Outbox::new(config.response_delay, config.seed),
            serial: SerialPort::default(),
            faults: DriveFaults::default(),
            books: Books::default(),
            next_event_ns: None,
            config,
        };
        drive.first_power_on();
        drive.end_event();
        drive
    }

    fn counts_per_s_of_rpm(&self) -> f64 {
        counts_per_s_of_rpm(&self.registers)
    }

    fn update_limits(&mut self) {
        self.motion
            .set_limits(limits(&self.config, &self.registers));
    }

    fn encode(&self, reply: Reply) -> DataFrame {
        let from = self.id().map_or(Address::Broadcast, Address::Drive);
        reply.encode(from, &self.config.dialect)
    }

    /// Brings the motion to `now_ns`.
    fn sync(&mut self, now_ns: u64) {
        self.motion.advance_to(now_ns);
        if self.motion.take_trip() {
            self.go_into_alarm(now_ns, Alarm::LostPhase);
        }
    }

    fn go_into_alarm(&mut self, now_ns: u64, alarm: Alarm) {
        self.alarm = alarm;
        self.motion.release();
        self.send_alarm(now_ns);
    }

    fn send_alarm(&mut self, now_ns: u64) {
        self.last_alarm_frame_ns = Some(now_ns);
        self.books.alarm_frames += 1;
        let frame = self.encode(Reply::DriveError(DriveError::Alarm));
        self.outbox.at_once(now_ns, frame);
    }

    fn next_alarm_frame_ns(&self) -> Option<u64> {
        Some(
            self.last_alarm_frame_ns?
                .saturating_add(self.faults.alarm_period_ns()?),
        )
    }

    fn apply_faults(&mut self, now_ns: u64) {
        for action in self.faults.take_actions() {
            self.sync(now_ns);
            match action {
                Action::PowerCycle { off_ns } => self.cut_power(now_ns, off_ns),
                // Without power nothing else can go wrong.
                _ if !self.is_up() => {}
                Action::Alarm(Alarm::None) => {}
                Action::Alarm(alarm) => self.go_into_alarm(now_ns, alarm),
                Action::Disable => self.motion.release(),
                Action::Misconfigure(config) => {
                    let was = core::mem::replace(&mut self.registers.ram.config, config);
                    self.follow_config(was);
                }
            }
        }
    }

    /// What must be done first at every event: faults commanded meanwhile, the end of a power-on delay, a new id.
    fn begin_event(&mut self, now_ns: u64) {
        // Both leave the announced event in the past, so that the drive runs next and announces another.
        self.start_if_ready(now_ns);
        if self.faults.has_actions() {
            self.apply_faults(now_ns);
            self.start_if_ready(now_ns);
        }
        self.registers.settle_id(now_ns);
    }

    fn end_event(&mut self) {
        let start_ns = match self.power {
            Power::On => None,
            Power::Down { ready_ns, .. } => Some(ready_ns),
        };
        self.next_event_ns = [
            self.outbox.next_due_ns(),
            self.motion.check_due_ns(),
            self.next_alarm_frame_ns(),
            start_ns,
        ]
        .into_iter()
        .flatten()
        .min();
    }

    fn is_addressed(&self, frame: &Frame) -> bool {
        let Id::Standard(id) = frame.id() else {
            return false;
        };
        match Address::from_can_id(id.as_raw()) {
            Address::Broadcast => true,
            Address::Drive(drive) => self.id() == Some(drive),
        }
    }
}

impl Device for DynDrive {
    fn on_frame(&mut self, now_ns: u64, frame: &Frame) {
        self.begin_event(now_ns);
        if !self.is_up() || !self.faults.hears() || !self.is_addressed(frame) {
            return;
        }
        // Remote frames are not answered (1.6A section 4).
        let Ok(frame) = DataFrame::from_can(frame) else {
            return;
        };
        self.sync(now_ns);
        self.obey_frame(now_ns, &frame);
        self.end_event();
    }

    fn next_event_ns(&self) -> Option<u64> {
        self.next_event_ns
    }

    fn run(&mut self, now_ns: u64, transmit: &mut dyn FnMut(Frame)) {
        self.begin_event(now_ns);
        self.sync(now_ns);
        if self
            .next_alarm_frame_ns()
            .is_some_and(|due_ns| due_ns <= now_ns)
        {
            self.send_alarm(now_ns);
        }
        while let Some(frame) = self.outbox.pop_due(now_ns) {
            if self.faults.sends() {
                transmit(frame);
            } else {
                self.books.unsent_frames += 1;
            }
        }
        self.end_event();
    }
}

impl Bench<DynDrive> {
    /// A bench with a fault-free bus and one drive for each configuration, in their order.
    pub fn with_drives(
        rate: BitRate,
        configs: impl IntoIterator<Item = DynDriveConfig>,
    ) -> (Self, Vec<DeviceId>) {
        let mut bench = Self::new(Bus::new(rate));
        let drives = configs
            .into_iter()
            .map(|config| bench.add_device(DynDrive::new(config), ControllerConfig::device()))
            .collect();
        (bench, drives)
    }
}

fn counts_per_s_of_rpm(registers: &Registers) -> f64 {
    let gear = registers.ram.group3.gear_number;
    f64::from(units::command_counts_per_turn(gear)) / S_PER_MIN
}

/// The limits of the parameters in use, in command counts.
fn limits(config: &DynDriveConfig, registers: &Registers) -> Limits {
    let per_rpm = counts_per_s_of_rpm(registers);
    let gear = registers.ram.group3.gear_number;
    let group = registers.ram.group2;
    let profile_speed = units::max_speed_rpm(group.max_speed, gear) * per_rpm;
    let profile_acceleration =
        units::max_acceleration_rpm_s(group.max_acceleration, gear) * per_rpm;
    let (motor_speed, motor_acceleration) = match config.dynamics {
        ServoDynamics::FromParameters => (profile_speed, profile_acceleration),
        ServoDynamics::Limited(limits) => (
            limits.speed_rpm() * per_rpm,
            limits.acceleration_rpm_s() * per_rpm,
        ),
    };
    let steps = config.lost_phase_steps.map(f64::from);
    Limits {
        profile_speed,
        profile_acceleration,
        motor_speed,
        motor_acceleration,
        coast_deceleration: config.coast.rpm_s() * per_rpm,
        lost_phase: steps.map(|steps| steps / units::gear_ratio(gear)),
        stops: config.mechanics.stops.map(|stops| stops.of_gear(gear)),
        gains: config.servo_loop.gains(&registers.ram.group1),
    }
}

#[cfg(test)]
mod tests;
