//! The serial port of a drive (DYN2 manual A1.8, section 7).
//!
//! Specification: the port is a second door to the same drive. It has its own codec and its own function codes; what a request does and
//! what a reply tells are written once, for both doors. Nothing is acknowledged, and a packet that is damaged, not for this
//! drive, or not a request is dropped without a word (M26). Set commands wear the EEPROM as they do over CAN. Faults of
//! replies concern the next reply of either door; faults of the CAN cable do not reach this one.

use std::collections::VecDeque;

use dyn_can::{
    ConfigByte, DriveConfig, RangeError, SetParamGroup1, SetParamGroup2, SetParamGroup3,
    StoredDriveId,
};
use dyn_serial::{
    Address, Decoder, Dialect, DriveId, Event, GeneralId, Packet, ReadSelector, Reply, Request,
};

use super::DynDrive;
use super::faults::Resize;
use crate::serial_line::{BYTE_NS, SerialDevice};

/// A drive obeys whatever comes on the general id.
const LISTENING: Dialect = Dialect {
    general_id: GeneralId::LoneDrive,
    ..Dialect::MANUAL
};

/// Bit 6 of the configuration byte has no meaning (manual section 7.3) and is not stored.
const STORED_CONFIG: u8 = 0x3F;

/// What has come in and what goes out.
#[derive(Debug, Clone, Default)]
pub(super) struct SerialPort {
    decoder: Decoder,
    /// Bytes with the instant at which each has been sent.
    outgoing: VecDeque<(u64, u8)>,
}

impl SerialPort {
    /// Forgets everything, as without power.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Sends bytes one after the other, from `ready_ns` on or when the line is free.
    fn send(&mut self, ready_ns: u64, bytes: &[u8]) {
        let free_ns = self.outgoing.back().map_or(0, |(end_ns, _)| *end_ns);
        let start_ns = ready_ns.max(free_ns);
        let ends = (1..).map(|byte| start_ns.saturating_add(byte * BYTE_NS));
        self.outgoing.extend(ends.zip(bytes.iter().copied()));
    }
}

impl SerialDevice for DynDrive {
    fn on_serial_byte(&mut self, now_ns: u64, byte: u8) {
        self.begin_event(now_ns);
        if !self.is_up() {
            return;
        }
        if let Some(Event::Packet(packet)) = self.serial.decoder.push(byte)
            && self.is_addressed_by(&packet)
        {
            self.sync(now_ns);
            self.obey_packet(now_ns, &packet);
        }
        self.end_event();
    }

    fn next_serial_ns(&self) -> Option<u64> {
        self.serial.outgoing.front().map(|(end_ns, _)| *end_ns)
    }

    fn pop_serial(&mut self, now_ns: u64) -> Option<(u64, u8)> {
        if self.next_serial_ns()? > now_ns {
            return None;
        }
        self.serial.outgoing.pop_front()
    }
}

impl DynDrive {
    fn serial_id(&self) -> Option<DriveId> {
        DriveId::new(self.registers.ram.id.get().into()).ok()
    }

    fn is_addressed_by(&self, packet: &Packet) -> bool {
        match Address::from_start_byte(packet.start_byte()) {
            Ok(Address::All) => true,
            Ok(Address::Drive(drive)) => self.serial_id() == Some(drive),
            Err(_) => false,
        }
    }

    fn obey_packet(&mut self, now_ns: u64, packet: &Packet) {
        let Ok((_, request)) = Request::decode(packet, &LISTENING) else {
            self.books.undecodable_packets += 1;
            return;
        };
        self.books.serial_requests += 1;
        match command(request) {
            Ok(Some(command)) => self.obey(now_ns, command),
            Ok(None) => self.answer_packet(now_ns, request),
            // Legal on the line, and a value that no drive can store.
            Err(_) => self.books.undecodable_packets += 1,
        }
    }

    fn answer_packet(&mut self, now_ns: u64, request: Request) {
        let (Ok(Some(reply)), Some(from)) = (self.serial_reply(now_ns, request), self.serial_id())
        else {
            return;
        };
        let fault = self.faults.next_reply();
        self.books.serial_replies += 1;
        let delay_ns = self.outbox.draw_delay_ns().saturating_add(fault.delay_ns);
        let mut bytes = reply.encode(from).as_bytes().to_vec();
        match fault.resize {
            None => {}
            Some(Resize::Shorter) => bytes.truncate(bytes.len() - 1),
            Some(Resize::Longer) => bytes.push(0x80),
        }
        for _ in 0..fault.copies {
            self.serial.send(now_ns.saturating_add(delay_ns), &bytes);
        }
    }

    /// The state of the drive as a reply to a read; nothing for any other request.
    fn serial_reply(&self, now_ns: u64, request: Request) -> Result<Option<Reply>, RangeError> {
        let ram = &self.registers.ram;
        Ok(Some(match request {
            Request::ReadDriveId => Reply::DriveId(i32::from(ram.id.get()).try_into()?),
            Request::ReadDriveConfig => Reply::Config(config_of(ram.config)?),
            Request::ReadDriveStatus => Reply::Status(self.status(now_ns)),
            // Four data bytes hold 28 bits.
            Request::GeneralRead(ReadSelector::Position) => {
                Reply::Position((self.read_back(now_ns) << 4 >> 4).try_into()?)
            }
            Request::GeneralRead(ReadSelector::Torque) => Reply::Torque(self.torque(now_ns).raw),
            Request::ReadMainGain => Reply::MainGain(ram.group1.main_gain),
            Request::ReadSpeedGain => Reply::SpeedGain(ram.group1.speed_gain),
            Request::ReadIntGain => Reply::IntegrationGain(ram.group1.integration_gain),
            Request::ReadTrqCons => Reply::TorqueFilter(ram.group1.torque_filter),
            Request::ReadHighSpeed => Reply::MaxSpeed(ram.group2.max_speed),
            Request::ReadHighAccel => Reply::MaxAcceleration(ram.group2.max_acceleration),
            Request::ReadPosOnRange => Reply::OnPosRange(ram.group3.on_pos_range),
            Request::ReadGearNumber => Reply::GearNumber(ram.group3.gear_number),
            _ => return Ok(None),
        }))
    }
}

fn config_of(config: ConfigByte) -> Result<dyn_serial::ConfigByte, RangeError> {
    dyn_serial::ConfigByte::new((config.to_byte() & STORED_CONFIG).into())
}

/// The command of the other door that does the same, nothing for a read.
fn command(request: Request) -> Result<Option<dyn_can::Request>, RangeError> {
    use dyn_can::Request as Can;
    Ok(Some(match request {
        Request::SetOrigin => Can::SetOrigin,
        Request::GoAbsolutePos(counts) => Can::GoAbsolutePosPtp(counts),
        Request::MakeLinearLine(counts) => Can::MakeLinearLine(counts),
        Request::GoRelativePos(counts) => Can::GoRelativePosPtp(counts),
        Request::MakeCircularArc(counts) => Can::MakeCircularArc(counts),
        Request::AssignDriveId(id) => Can::AssignDriveId(StoredDriveId::new(id.get().into())?),
        Request::SetDriveConfig(config) => {
            Can::SetDriveConfig(DriveConfig::from_byte(config.get() & STORED_CONFIG)?)
        }
        Request::TurnConstSpeed(speed) => Can::TurnConstSpeed(speed),
        Request::SquareWave(amplitude) => Can::SquareWave(amplitude),
        Request::SinWave(amplitude) => Can::SinWave(amplitude),
        Request::SsFrequency(hz) => Can::SsFrequency(hz),
        other => return Ok(set_parameter(other)),
    }))
}

/// The group command that sets one parameter and keeps the others.
fn set_parameter(request: Request) -> Option<dyn_can::Request> {
    let (group1, group2, group3) = (
        SetParamGroup1::default(),
        SetParamGroup2::default(),
        SetParamGroup3::default(),
    );
    let set_group1 = |group| Some(dyn_can::Request::SetParamGroup1(group));
    let set_group2 = |group| Some(dyn_can::Request::SetParamGroup2(group));
    let set_group3 = |group| Some(dyn_can::Request::SetParamGroup3(group));
    match request {
        Request::SetMainGain(value) => set_group1(SetParamGroup1 {
            main_gain: Some(value),
            ..group1
        }),
        Request::SetSpeedGain(value) => set_group1(SetParamGroup1 {
            speed_gain: Some(value),
            ..group1
        }),
        Request::SetIntGain(value) => set_group1(SetParamGroup1 {
            integration_gain: Some(value),
            ..group1
        }),
        Request::SetTrqCons(value) => set_group1(SetParamGroup1 {
            torque_filter: Some(value),
            ..group1
        }),
        Request::SetHighSpeed(value) => set_group2(SetParamGroup2 {
            max_speed: Some(value),
            ..group2
        }),
        Request::SetHighAccel(value) => set_group2(SetParamGroup2 {
            max_acceleration: Some(value),
            ..group2
        }),
        Request::SetPosOnRange(value) => set_group3(SetParamGroup3 {
            on_pos_range: Some(value),
            ..group3
        }),
        Request::SetGearNumber(value) => set_group3(SetParamGroup3 {
            gear_number: Some(value),
            ..group3
        }),
        _ => None,
    }
}
