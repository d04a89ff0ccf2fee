//! A simulated ZLAC8030L hub-motor drive on CANopen.
//!
//! # Why a test against this drive is not circular
//!
//! Of the codec it uses the printed rows of the object dictionary and nothing else: it takes frames apart and puts them together byte by
//! byte itself, and what it does with them is written here from the guide, CiA 301 and CiA 402. A master that nobody here wrote drives
//! it in the interop tests. Where the guide is silent or contradicts itself the behaviour is a field of [`ZlacDriveConfig`].
//!
//! # Laws
//!
//! - Motion is lazy and advances in fixed ticks; results do not depend on how often anybody looks.
//! - An RW/S write goes to the EEPROM unless 2010h is 1, and is counted (Z32).
//! - PDO mappings change in pre-operational only, with count 0 first; PDOs run in operational only.
//! - A fault switches the power stage off; it goes by the edge of bit 7 of the control word, once its cause is gone.
//!
//! # What is not here
//!
//! Current loop, heat, bleeder, RS485, segmented SDO; what the guide names and does not explain (202Fh:02, 2007h, 2008h).

mod config;
mod faults;
mod looks;
mod mechanics;
mod memory;
mod motion;
mod network;
mod objects;
mod outbox;
mod power_stage;
mod process_data;
mod sdo_server;
mod terminals;

use embedded_can::{Frame as _, Id};

pub use config::{OfflineReaction, ZlacDriveConfig, ZlacQuirks, ZlacSurroundings};
pub use faults::{ReplyDamage, ZlacFaults};
pub use mechanics::{ZlacLoop, ZlacMechanics};
pub use memory::EepromWear;

use can_frame::BitRate;
use zlac8030l::NodeId;

use crate::bench::{Bench, DeviceId};
use crate::bus::Bus;
use crate::controller::ControllerConfig;
use crate::device::Device;
use crate::frame::Frame;
use faults::Action;
use memory::Memory;
use motion::{EmergencyInput, Motion};
use network::Network;
use outbox::Outbox;
use power_stage::{BrakesFirst, PowerStage};
use process_data::ProcessData;

/// Bit of 603Fh for a motor that is too hot.
const MOTOR_TEMPERATURE: u16 = 0x0400;

/// Nanoseconds in a millisecond.
const MS: u64 = 1_000_000;

/// What a drive heard and said since it was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct ZlacBooks {
    /// SDO requests that were answered with a value or a confirmation.
    pub sdo_served: u64,
    /// SDO requests that were refused.
    pub sdo_aborted: u64,
    /// Aborts of a client.
    pub client_aborts: u64,
    /// PDOs that were taken.
    pub rpdos: u64,
    /// PDOs that were sent.
    pub tpdos: u64,
    /// Starts of the drive, the first one included.
    pub boots: u64,
}

/// A simulated drive. It is powered on at 0 ns.
#[derive(Debug, Clone)]
pub struct ZlacDrive {
    config: ZlacDriveConfig,
    memory: Memory,
    network: Network,
    stage: PowerStage,
    motion: Motion,
    process_data: ProcessData,
    outbox: Outbox,
    faults: ZlacFaults,
    books: ZlacBooks,
    /// Last frame to this drive; `None` before the first one after a start.
    heard_ns: Option<u64>,
    /// An emergency stop input is active.
    emergency_input: bool,
    surroundings: ZlacSurroundings,
    /// Fault bit of a motor that is too hot now.
    is_hot: bool,
    /// The node number in force; 200Dh counts at the next start.
    node: NodeId,
    /// The bit rate in force is that of the bus.
    is_in_step: bool,
}

impl ZlacDrive {
    /// A drive that is powered on at 0 ns and sends its boot-up after its boot delay.
    pub fn new(config: ZlacDriveConfig) -> Self {
        let memory = Memory::new(&config);
        Self {
            network: Network::starting_at(config.boot_delay_ns),
            stage: PowerStage::default(),
            motion: Motion::new(&config),
            process_data: ProcessData::default(),
            outbox: Outbox::new(config.response_delay, config.seed),
            faults: ZlacFaults::default(),
            books: ZlacBooks::default(),
            heard_ns: None,
            emergency_input: false,
            surroundings: config.surroundings,
            is_hot: false,
            node: config.node,
            is_in_step: true,
            memory,
            config,
        }
    }

    fn node(&self) -> u16 {
        u16::from(self.node.get())
    }

    /// Brings motion and state to `now_ns`.
    fn sync(&mut self, now_ns: u64) {
        for action in self.faults.take_actions() {
            self.act(now_ns, action);
        }
        if self.network.starts_by(now_ns) {
            self.boot(now_ns);
        }
        self.motion.advance_to(now_ns);
        if self.stage.is_leaving() && self.motion.stands() {
            self.stage.stands();
            self.update_motion();
        }
        self.supervise(now_ns);
    }

    /// What the options of the drive say about the ways out of enabled (605Bh, 605Ch; Z43).
    fn brakes_first(&self) -> BrakesFirst {
        let is_set = |option| self.memory.get(option) == 1;
        BrakesFirst {
            on_shutdown: is_set(objects::SHUTDOWN_OPTION),
            on_disable: is_set(objects::DISABLE_OPTION),
            on_disable_voltage: self.config.brakes_before_power_off
                && is_set(objects::DISABLE_OPTION),
        }
    }

    fn act(&mut self, now_ns: u64, action: Action) {
        self.motion.advance_to(now_ns);
        match action {
            Action::Fault(bits) => self.trip(now_ns, bits),
            Action::FaultGone => self.stage.cause_gone(),
            Action::PowerCycle { off_ns } => self.cut_power(now_ns, off_ns),
            Action::EmergencyInput(active) => {
                self.emergency_input = active;
                self.update_motion();
            }
            Action::Surroundings(surroundings) => {
                self.surroundings = surroundings;
                self.watch_temperature(now_ns);
            }
        }
    }

    /// A motor at its threshold (2013h:01) trips the drive; it can be reset once it is cooler.
    fn watch_temperature(&mut self, now_ns: u64) {
        let limit = i64::from(self.memory.get(objects::TEMPERATURE_LIMIT));
        let is_hot = i64::from(self.surroundings.motor_decidegrees) >= limit;
        let was_hot = core::mem::replace(&mut self.is_hot, is_hot);
        if is_hot && !was_hot {
            self.trip(now_ns, MOTOR_TEMPERATURE);
        } else if was_hot && !is_hot {
            self.stage.cause_gone();
        }
    }

    fn cut_power(&mut self, now_ns: u64, off_ns: u64) {
        self.stage = PowerStage::default();
        self.motion.release();
        self.outbox.clear();
        self.process_data = ProcessData::default();
        self.heard_ns = None;
        let at_ns = now_ns
            .saturating_add(off_ns)
            .saturating_add(self.config.boot_delay_ns);
        self.network = Network::starting_at(at_ns);
    }

    fn boot(&mut self, now_ns: u64) {
        self.books.boots += 1;
        self.memory.power_on(&self.config);
        self.node = self.memory.stored_node(&self.config);
        let bus = self.config.bus_bit_rate;
        self.is_in_step = bus.is_none_or(|bus| self.memory.has_bit_rate(bus));
        self.motion.power_on(&self.memory);
        let frame = self.network.boot(now_ns, self.node());
        self.outbox.at_once(now_ns, frame);
    }

    fn trip(&mut self, now_ns: u64, bits: u16) {
        self.stage.trip(bits);
        self.update_motion();
        let [low, high] = bits.to_le_bytes();
        // Error code 1000h, generic; the guide describes no content, so the fault bits are in the maker's bytes.
        self.send_emcy(now_ns, [0x00, 0x10, 0x01, low, high, 0, 0, 0]);
    }

    fn send_emcy(&mut self, now_ns: u64, data: [u8; 8]) {
        let id = if self.config.quirks.emcy_on_sync_identifier {
            0x080
        } else {
            0x080 + self.node()
        };
        self.outbox.at_once(now_ns, (id, data.to_vec()));
    }

    /// Reaction to a master that has fallen silent (2000h, Z41).
    fn supervise(&mut self, now_ns: u64) {
        let Some(deadline_ns) = self.offline_deadline_ns() else {
            return;
        };
        if now_ns < deadline_ns {
            return;
        }
        self.heard_ns = None;
        match self.config.offline_reaction {
            OfflineReaction::Nothing => {}
            OfflineReaction::QuickStop => self.stage.command(0x0002, self.brakes_first()),
            OfflineReaction::PowerOff => self.stage.command(0x0000, self.brakes_first()),
        }
        self.update_motion();
    }

    fn offline_deadline_ns(&self) -> Option<u64> {
        let limit_ms = u64::from(self.memory.get(objects::OFFLINE_TIME));
        let supervised = limit_ms != 0 && self.config.offline_reaction != OfflineReaction::Nothing;
        Some(
            self.heard_ns
                .filter(|_| supervised)?
                .saturating_add(limit_ms * MS),
        )
    }

    /// What the motor does now, from state, mode, targets and inputs.
    fn update_motion(&mut self) {
        let is_stopped = self.emergency_input && self.memory.has_emergency_input();
        let input = if self.memory.get(objects::EMERGENCY_RELEASES) == 1 {
            EmergencyInput::Releases
        } else {
            EmergencyInput::Holds
        };
        let input = is_stopped.then_some(input);
        self.motion.drive(&self.stage, input, &self.memory);
    }

    fn set_control_word(&mut self, now_ns: u64, word: u16) {
        let before = self.stage.control_word();
        let had_fault = self.stage.fault() != 0;
        self.stage.command(word, self.brakes_first());
        if had_fault && self.stage.fault() == 0 {
            self.send_emcy(now_ns, [0; 8]);
        }
        // The edge of bit 4 takes the target position over.
        if self.stage.is_enabled() && word & !before & 0x0010 != 0 {
            self.motion.new_set_point(word & 0x0040 != 0, &self.memory);
        }
        self.motion.set_acknowledged(word & 0x0010 != 0);
        self.update_motion();
    }
}

impl Device for ZlacDrive {
    fn on_frame(&mut self, now_ns: u64, frame: &Frame) {
        self.sync(now_ns);
        let Id::Standard(id) = frame.id() else { return };
        let is_deaf = !self.faults.hears() || !self.network.is_up() || !self.is_in_step;
        if frame.is_remote_frame() || is_deaf {
            return;
        }
        let (id, node, data) = (id.as_raw(), self.node(), frame.data());
        match id {
            0x000 => self.obey_nmt(now_ns, data),
            0x080 if data.len() < 8 => self.on_sync(now_ns),
            _ if id == 0x600 + node => self.on_sdo(now_ns, data),
            _ if id & 0x7F == node && matches!(id & 0x780, 0x200 | 0x300 | 0x400 | 0x500) => {
                self.on_rpdo(now_ns, usize::from(id >> 8) - 2, data);
            }
            _ => return,
        }
        if id != 0x080 {
            self.heard_ns = Some(now_ns);
        }
    }

    fn next_event_ns(&self) -> Option<u64> {
        let urgent = self.faults.has_actions().then_some(0);
        let due = [
            urgent,
            self.network.next_event_ns(),
            self.process_data.next_event_ns(),
            self.outbox.next_due_ns(),
            self.offline_deadline_ns(),
        ];
        due.into_iter().flatten().min()
    }

    fn run(&mut self, now_ns: u64, transmit: &mut dyn FnMut(Frame)) {
        self.sync(now_ns);
        if let Some(frame) =
            self.network
                .heartbeat_due(now_ns, self.node(), self.memory.get(objects::HEARTBEAT))
        {
            self.outbox.at_once(now_ns, frame);
        }
        self.run_process_data(now_ns);
        while let Some(frame) = self.outbox.pop_due(now_ns) {
            if self.faults.sends() && self.is_in_step {
                transmit(frame);
            }
        }
    }
}

impl Bench<ZlacDrive> {
    /// A bench with a fault-free bus and one hub-motor drive for each configuration, in their order.
    pub fn with_zlac_drives(
        rate: BitRate,
        configs: impl IntoIterator<Item = ZlacDriveConfig>,
    ) -> (Self, Vec<DeviceId>) {
        let mut bench = Self::new(Bus::new(rate));
        let drives = configs
            .into_iter()
            .map(|config| bench.add_device(ZlacDrive::new(config), ControllerConfig::device()))
            .collect();
        (bench, drives)
    }
}

#[cfg(test)]
mod tests;
