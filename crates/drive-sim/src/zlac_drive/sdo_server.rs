//! SDO server: expedited transfers byte by byte, and what writing an object does.
//!
//! Specification: one request, one reply; a refusal names its reason (CiA 301 abort codes).

use zlac8030l::dictionary::{self, Entry};

use super::ZlacDrive;
use super::faults::ReplyDamage;
use super::memory::row;
use super::network::NodeState;
use super::objects::{self, Address};
use super::process_data::is_mapping;

/// Why a request is refused.
type Abort = u32;

const SPECIFIER: Abort = 0x0504_0001;
const READ_ONLY: Abort = 0x0601_0002;
const NO_OBJECT: Abort = 0x0602_0000;
const LENGTH: Abort = 0x0607_0010;
const NO_SUB_INDEX: Abort = 0x0609_0011;
const RANGE: Abort = 0x0609_0030;
pub(super) const STATE: Abort = 0x0800_0022;

/// Which of the two objects for torques.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TorqueObject {
    Demand,
    Actual,
}

impl ZlacDrive {
    pub(super) fn on_sdo(&mut self, now_ns: u64, data: &[u8]) {
        let Ok(request) = <[u8; 8]>::try_from(data) else {
            // A short request is no request.
            return;
        };
        if self.network.state() == NodeState::Stopped {
            return;
        }
        if request[0] == 0x80 {
            self.books.client_aborts += 1;
            return;
        }
        let is_write = matches!(request[0], 0x2F | 0x2B | 0x27 | 0x23);
        if is_write && !self.faults.takes_write() {
            return;
        }
        let address = (u16::from_le_bytes([request[1], request[2]]), request[3]);
        let reply = match self.serve(now_ns, request, address) {
            Ok((specifier, value)) => {
                self.books.sdo_served += 1;
                reply_bytes(specifier, address, value)
            }
            Err(abort) => {
                self.books.sdo_aborted += 1;
                reply_bytes(0x80, address, abort)
            }
        };
        self.send_reply(now_ns, reply);
    }

    fn serve(
        &mut self,
        now_ns: u64,
        request: [u8; 8],
        address: Address,
    ) -> Result<(u8, u32), Abort> {
        let [specifier, _, _, _, a, b, c, d] = request;
        let written = u32::from_le_bytes([a, b, c, d]);
        match specifier {
            0x40 => {
                let entry = find(address)?;
                let unused = 4 - entry.data_type.bytes();
                let value = self.read(now_ns, address) & mask(entry.data_type.bytes());
                if self.config.quirks.replies_without_size {
                    return Ok((0x42, value));
                }
                Ok((0x43 | unused << 2, value))
            }
            0x2F => self.write(now_ns, address, 1, written).map(|()| (0x60, 0)),
            0x2B => self.write(now_ns, address, 2, written).map(|()| (0x60, 0)),
            0x27 => self.write(now_ns, address, 3, written).map(|()| (0x60, 0)),
            0x23 => self.write(now_ns, address, 4, written).map(|()| (0x60, 0)),
            _ => Err(SPECIFIER),
        }
    }

    /// The value of an object at this moment.
    pub(super) fn read(&self, now_ns: u64, address: Address) -> u32 {
        let motion = self.motion.at(now_ns);
        match address {
            objects::ERROR_REGISTER => u32::from(self.stage.fault() != 0),
            objects::FAULT_CODE => u32::from(self.stage.fault()),
            objects::STATUS_WORD => u32::from(self.status_word(now_ns)),
            objects::CONTROL_WORD => u32::from(self.stage.control_word()),
            objects::MODE_DISPLAY => self.reported_mode() as u32,
            objects::ACTUAL_POSITION => motion.counts() as u32,
            objects::ACTUAL_SPEED => (motion.speed_rpm() * 10.0).round() as i32 as u32,
            objects::TORQUE_DEMAND => self.torque(motion.demand_ma(), TorqueObject::Demand),
            objects::ACTUAL_TORQUE => self.torque(motion.current_ma(), TorqueObject::Actual),
            objects::MOTOR_TEMPERATURE => self.surroundings.motor_decidegrees as u32,
            objects::DRIVER_TEMPERATURE => self.surroundings.driver_decidegrees as u32,
            objects::BUS_VOLTAGE => u32::from(self.surroundings.bus_centivolts),
            objects::HALL_INPUTS => self.hall_inputs(now_ns),
            objects::INPUT_LEVELS => self.input_levels(now_ns),
            objects::OUTPUT_LEVELS => self.output_levels(now_ns),
            objects::MOTOR_STATUS => u32::from(!motion.at_rest()),
            other => self.memory.get(other),
        }
    }

    /// In 0.1 A or mA: the texts of the two objects and their ranges say the opposite (Z25).
    fn torque(&self, ma: f64, object: TorqueObject) -> u32 {
        let in_ma = (object == TorqueObject::Demand) != self.config.quirks.torque_units_by_range;
        let number = if in_ma { ma } else { ma / 100.0 };
        number.round() as i32 as u32
    }

    fn write(&mut self, now_ns: u64, address: Address, bytes: u8, value: u32) -> Result<(), Abort> {
        let entry = find(address)?;
        if !entry.access.is_writable() {
            return Err(READ_ONLY);
        }
        if entry.data_type.bytes() != bytes {
            return Err(LENGTH);
        }
        let value = value & mask(bytes);
        if !in_range(entry, value) {
            return Err(RANGE);
        }
        self.check_mapping(address, value)?;
        self.apply(now_ns, entry, value);
        Ok(())
    }

    /// Takes a value that was checked, from an SDO or a PDO.
    pub(super) fn apply(&mut self, now_ns: u64, entry: &Entry, value: u32) {
        self.motion.advance_to(now_ns);
        self.memory.write(entry, value);
        let address = (entry.address.index, entry.address.sub);
        match address {
            // The object has 16 bits.
            objects::CONTROL_WORD => self.set_control_word(now_ns, value as u16),
            objects::MODE => self.set_mode(value as u8 as i8),
            objects::STORE => self.memory.store(value, &self.config),
            objects::HEARTBEAT => self.heartbeat_written(now_ns),
            objects::CLEAR_FEEDBACK | objects::CLEAR_ABSOLUTE if value == 1 => {
                self.motion.clear_position();
                self.memory.set(address, 0);
            }
            _ if is_mapping(address) => {}
            _ => self.update_motion(),
        }
    }

    /// 6 or 4 for torque, by quirk; the other one of the two is no mode.
    fn set_mode(&mut self, value: i8) {
        let torque = self.torque_mode_value();
        let mode = match value {
            1 | 3 => value,
            value if value == torque => 4,
            _ => 0,
        };
        self.motion.set_mode(mode);
        self.update_motion();
    }

    fn torque_mode_value(&self) -> i8 {
        if self.config.quirks.torque_mode_is_6 {
            6
        } else {
            4
        }
    }

    fn reported_mode(&self) -> i8 {
        match self.motion.mode() {
            4 => self.torque_mode_value(),
            mode => mode,
        }
    }

    fn send_reply(&mut self, now_ns: u64, mut reply: [u8; 8]) {
        let profile_speed = reply[..4] == [0x60, 0x81, 0x60, 0x00];
        if profile_speed && self.config.quirks.profile_speed_confirmed_as_sub_1 {
            reply[3] = 1;
        }
        let (mut copies, mut length, mut extra_ns) = (1, 8, 0);
        match self.faults.next_damage() {
            None => {}
            Some(ReplyDamage::Drop) => copies = 0,
            Some(ReplyDamage::Duplicate) => copies = 2,
            Some(ReplyDamage::Delay(ns)) => extra_ns = ns,
            Some(ReplyDamage::WrongIndex) => reply[1] = reply[1].wrapping_add(1),
            Some(ReplyDamage::WrongSub) => reply[3] = reply[3].wrapping_add(1),
            Some(ReplyDamage::Short) => length = 4,
        }
        for _ in 0..copies {
            self.outbox.reply(
                now_ns,
                extra_ns,
                (0x580 + self.node(), reply[..length].to_vec()),
            );
        }
    }
}

fn find(address: Address) -> Result<&'static Entry, Abort> {
    row(address).ok_or_else(|| {
        let known = dictionary::entries().any(|entry| entry.address.index == address.0);
        if known { NO_SUB_INDEX } else { NO_OBJECT }
    })
}

fn mask(bytes: u8) -> u32 {
    u32::MAX >> (32 - 8 * u32::from(bytes))
}

/// The printed range, by the sign of the printed type.
fn in_range(entry: &Entry, value: u32) -> bool {
    let shift = 32 - 8 * u32::from(entry.data_type.bytes());
    let number = if entry.data_type.min() < 0 {
        i64::from((value << shift) as i32 >> shift)
    } else {
        i64::from(value)
    };
    (entry.min..=entry.max).contains(&number)
}

fn reply_bytes(specifier: u8, (index, sub): Address, value: u32) -> [u8; 8] {
    let [low, high] = index.to_le_bytes();
    let [a, b, c, d] = value.to_le_bytes();
    [specifier, low, high, sub, a, b, c, d]
}
