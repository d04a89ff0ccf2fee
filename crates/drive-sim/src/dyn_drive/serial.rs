//! The serial port of a drive (DYN2 manual A1.8, section 7).
//!
//! Law: the port is a second door to the same drive. It has its own codec and its own function codes; what a request does and
//! what a reply tells are written once, for both doors. Nothing is acknowledged, and a packet that is damaged, not for this
//! drive, or not a request is dropped without a word (M26). Set commands wear the EEPROM as they do over CAN. Faults of
//! replies concern the next reply of either door; faults of the CAN cable do not reach this one.

use std::collections::VecDeque;

use dyn_can::{
    Amplitude, ConfigByte, Counts28, DriveConfig, FrequencyHz, GearNumber, IntegrationGain,
    MainGain, MaxAcceleration, MaxSpeed, OnPosRange, RangeError, SetParamGroup1, SetParamGroup2,
    SetParamGroup3, SpeedGain, SpeedRpm, StoredDriveId, TorqueFilter,
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
    fn serial_reply(
        &self,
        now_ns: u64,
        request: Request,
    ) -> Result<Option<Reply>, dyn_serial::RangeError> {
        let ram = &self.registers.ram;
        Ok(Some(match request {
            Request::ReadDriveId => Reply::DriveId(i32::from(ram.id.get()).try_into()?),
            Request::ReadDriveConfig => Reply::Config(config_of(ram.config)?),
            Request::ReadDriveStatus => Reply::Status(dyn_serial::DriveStatus::from_byte(
                self.status(now_ns).to_byte(),
            )),
            // Four data bytes hold 28 bits.
            Request::GeneralRead(ReadSelector::Position) => {
                Reply::Position((self.read_back(now_ns) << 4 >> 4).try_into()?)
            }
            Request::GeneralRead(ReadSelector::Torque) => Reply::Torque(self.torque(now_ns).raw),
            Request::ReadMainGain => Reply::MainGain(number(ram.group1.main_gain.get())?),
            Request::ReadSpeedGain => Reply::SpeedGain(number(ram.group1.speed_gain.get())?),
            Request::ReadIntGain => {
                Reply::IntegrationGain(number(ram.group1.integration_gain.get())?)
            }
            Request::ReadTrqCons => Reply::TorqueFilter(number(ram.group1.torque_filter.get())?),
            Request::ReadHighSpeed => Reply::MaxSpeed(number(ram.group2.max_speed.get())?),
            Request::ReadHighAccel => {
                Reply::MaxAcceleration(number(ram.group2.max_acceleration.get())?)
            }
            Request::ReadPosOnRange => Reply::OnPosRange(number(ram.group3.on_pos_range.get())?),
            Request::ReadGearNumber => Reply::GearNumber(number(ram.group3.gear_number.get())?),
            _ => return Ok(None),
        }))
    }
}

fn number<T: TryFrom<i32, Error = dyn_serial::RangeError>>(
    value: impl Into<i32>,
) -> Result<T, dyn_serial::RangeError> {
    T::try_from(value.into())
}

fn config_of(config: ConfigByte) -> Result<dyn_serial::ConfigByte, dyn_serial::RangeError> {
    dyn_serial::ConfigByte::new((config.to_byte() & STORED_CONFIG).into())
}

/// The command of the other door that does the same, nothing for a read.
fn command(request: Request) -> Result<Option<dyn_can::Request>, RangeError> {
    use dyn_can::Request as Can;
    Ok(Some(match request {
        Request::SetOrigin => Can::SetOrigin,
        Request::GoAbsolutePos(counts) => Can::GoAbsolutePosPtp(Counts28::new(counts.get())?),
        Request::MakeLinearLine(counts) => Can::MakeLinearLine(Counts28::new(counts.get())?),
        Request::GoRelativePos(counts) => Can::GoRelativePosPtp(Counts28::new(counts.get())?),
        Request::MakeCircularArc(counts) => Can::MakeCircularArc(Counts28::new(counts.get())?),
        Request::AssignDriveId(id) => Can::AssignDriveId(StoredDriveId::new(id.get().into())?),
        Request::SetDriveConfig(config) => {
            Can::SetDriveConfig(DriveConfig::from_byte(config.get() & STORED_CONFIG)?)
        }
        Request::TurnConstSpeed(speed) => Can::TurnConstSpeed(SpeedRpm::new(speed.get().into())?),
        Request::SquareWave(amplitude) => Can::SquareWave(Amplitude::new(amplitude.get().into())?),
        Request::SinWave(amplitude) => Can::SinWave(Amplitude::new(amplitude.get().into())?),
        Request::SsFrequency(hz) => Can::SsFrequency(FrequencyHz::new(hz.get().into())?),
        other => return set_parameter(other),
    }))
}

/// The group command that sets one parameter and keeps the others.
fn set_parameter(request: Request) -> Result<Option<dyn_can::Request>, RangeError> {
    let (group1, group2, group3) = (
        SetParamGroup1::default(),
        SetParamGroup2::default(),
        SetParamGroup3::default(),
    );
    let set_group1 = |group| Ok(Some(dyn_can::Request::SetParamGroup1(group)));
    let set_group2 = |group| Ok(Some(dyn_can::Request::SetParamGroup2(group)));
    let set_group3 = |group| Ok(Some(dyn_can::Request::SetParamGroup3(group)));
    match request {
        Request::SetMainGain(value) => set_group1(SetParamGroup1 {
            main_gain: Some(MainGain::new(value.get().into())?),
            ..group1
        }),
        Request::SetSpeedGain(value) => set_group1(SetParamGroup1 {
            speed_gain: Some(SpeedGain::new(value.get().into())?),
            ..group1
        }),
        Request::SetIntGain(value) => set_group1(SetParamGroup1 {
            integration_gain: Some(IntegrationGain::new(value.get().into())?),
            ..group1
        }),
        Request::SetTrqCons(value) => set_group1(SetParamGroup1 {
            torque_filter: Some(TorqueFilter::new(value.get().into())?),
            ..group1
        }),
        Request::SetHighSpeed(value) => set_group2(SetParamGroup2 {
            max_speed: Some(MaxSpeed::new(value.get().into())?),
            ..group2
        }),
        Request::SetHighAccel(value) => set_group2(SetParamGroup2 {
            max_acceleration: Some(MaxAcceleration::new(value.get().into())?),
            ..group2
        }),
        Request::SetPosOnRange(value) => set_group3(SetParamGroup3 {
            on_pos_range: Some(OnPosRange::new(value.get().into())?),
            ..group3
        }),
        Request::SetGearNumber(value) => set_group3(SetParamGroup3 {
            gear_number: Some(GearNumber::new(value.get().into())?),
            ..group3
        }),
        _ => Ok(None),
    }
}
