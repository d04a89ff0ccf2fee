//! Messages in plain words with units; the manual's name of the function comes first.

use core::fmt::{self, Display};

use dyn_can::{
    Address, CommandMode, ConfigByte, DriveConfig, DriveError, DriveStatus, ParamGroup1,
    ParamGroup2, ParamGroup3, ReadSelector, Reply, Request, ServoMode, ServoSwitch, SetParamGroup1,
    SetParamGroup2, SetParamGroup3, SyncKind, Torque, units,
};

use super::message::{Content, Message, Note};
use crate::conversation::Direction;

/// Nanoseconds of a millisecond.
const MS: f64 = 1e6;

impl Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.said().fmt(f)?;
        if let (Some(ns), None) = (self.response_ns(), self.note) {
            write!(f, " ({:.3} ms after the request)", ns as f64 / MS)?;
        }
        self.note.map_or(Ok(()), |note| write!(f, " [{note}]"))
    }
}

/// What a message says, without its place in time: equal messages have equal words.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Said<'a>(&'a Message);

impl Message {
    /// What it says, without response time and note.
    #[must_use]
    pub const fn said(&self) -> Said<'_> {
        Said(self)
    }
}

impl Display for Said<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let message = self.0;
        write_party(f, message.direction(), message.address)?;
        f.write_str(message.function.name())?;
        f.write_str(": ")?;
        match &message.content {
            Content::Request(request) => write_request(f, request),
            Content::Reply { reply, .. } => write_reply(f, reply),
            Content::PositionOrTorque { value } => {
                write!(f, "position or torque {value}, its request was not seen")
            }
            Content::Undecodable { error, .. } => write!(f, "does not decode: {error}"),
        }
    }
}

/// `to drive 1    ` and `from drive 12 ` end in the same column.
fn write_party(f: &mut fmt::Formatter<'_>, direction: Direction, address: Address) -> fmt::Result {
    f.write_str(match direction {
        Direction::ToDrive => "to ",
        Direction::FromDrive => "from ",
    })?;
    let Address::Drive(drive) = address else {
        return f.write_str(match direction {
            Direction::ToDrive => "all drives ",
            Direction::FromDrive => "drive 0  ",
        });
    };
    let used = match (direction, drive.get()) {
        (Direction::ToDrive, ..=9) => 10,
        (Direction::ToDrive, _) => 11,
        (Direction::FromDrive, ..=9) => 12,
        (Direction::FromDrive, _) => 13,
    };
    write!(f, "drive {drive}")?;
    f.write_str(&"     "[..14 - used])
}

impl Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ms = |ns: u64| ns as f64 / MS;
        match *self {
            Self::Repeated { after_ns } => write!(
                f,
                "the same frame as {:.3} ms before: repeated by CAN, or sent twice",
                ms(after_ns)
            ),
            Self::NoReply { after_ns: None } => f.write_str("asked before without a reply"),
            Self::NoReply {
                after_ns: Some(after_ns),
            } => {
                write!(f, "asked {:.3} ms before without a reply", ms(after_ns))
            }
            Self::Late { after_ns } => {
                write!(f, "late: {:.3} ms after the request", ms(after_ns))
            }
            Self::Unasked => {
                f.write_str("nobody asked: it came twice, or its request was not seen")
            }
        }
    }
}

fn write_request(f: &mut fmt::Formatter<'_>, request: &Request) -> fmt::Result {
    match request {
        Request::SetOrigin => f.write_str("make this position the zero, stored"),
        Request::GoAbsolutePosPtp(to) => write!(f, "move to {to} counts"),
        Request::MakeLinearLine(word) => write!(f, "a word of a line, {word} counts"),
        Request::GoRelativePosPtp(by) => write!(f, "move by {by} counts"),
        Request::MakeCircularArc(word) => write!(f, "a word of an arc, {word} counts"),
        Request::AssignDriveId(id) => write!(f, "store drive id {}", id.get()),
        Request::ReadDriveId => f.write_str("read the drive id"),
        Request::SetDriveConfig(config) => {
            f.write_str("store the configuration: ")?;
            write_config(f, *config)
        }
        Request::ReadDriveConfig => f.write_str("read the configuration"),
        Request::ReadDriveStatus => f.write_str("read the status"),
        Request::TurnConstSpeed(speed) => write!(f, "turn at {speed} rpm"),
        Request::SquareWave(amplitude) => write!(f, "square wave, amplitude {amplitude} of 4096"),
        Request::SinWave(amplitude) => write!(f, "sine wave, amplitude {amplitude} of 4096"),
        Request::SsFrequency(frequency) => write!(f, "wave frequency {frequency} Hz"),
        Request::GeneralRead(ReadSelector::Position) => f.write_str("read the position"),
        Request::GeneralRead(ReadSelector::Torque) => f.write_str("read the torque"),
        Request::SetParamGroup1(group) => write_set_group1(f, group),
        Request::SetParamGroup2(group) => write_set_group2(f, group),
        Request::SetParamGroup3(group) => write_set_group3(f, group),
        Request::ReadParamGroup1 => f.write_str("read gains and torque filter"),
        Request::ReadParamGroup2 => f.write_str("read max speed and max acceleration"),
        Request::ReadParamGroup3 => f.write_str("read on-position range, gear and line number"),
        Request::GoAbsolutePosSync(to) => write!(f, "load a move to {to} counts"),
        Request::GoRelativePosSync(by) => write!(f, "load a move by {by} counts"),
        Request::SyncTrigger(SyncKind::Absolute) => f.write_str("start the loaded absolute moves"),
        Request::SyncTrigger(SyncKind::Relative) => f.write_str("start the loaded relative moves"),
        Request::ServoDisable(ServoSwitch::Enable) => f.write_str("ENABLE the servo"),
        Request::ServoDisable(ServoSwitch::Disable) => {
            f.write_str("disable the servo, the motor coasts")
        }
        Request::ReadMotorSpeed => f.write_str("read the motor speed"),
        Request::DriveReset => f.write_str("clear the fault and reset the position"),
        Request::GoRelativePosPd(step) => {
            f.write_str("step by ")?;
            step.fmt(f)?;
            f.write_str(" counts")
        }
        Request::EchoFunction(bytes) => write_bytes(f, "send back", bytes),
        Request::DiagnosticCounter => f.write_str("read the counter"),
    }
}

/// The direction is that of the revision, and a torque that no document allows says so.
fn write_torque(f: &mut fmt::Formatter<'_>, torque: Torque) -> fmt::Result {
    let (raw, full_scale) = (torque.raw, torque.full_scale.get());
    let share = torque.of_peak();
    write!(
        f,
        "torque {raw} of {full_scale}, {:.1} % of the peak current",
        100.0 * share.abs()
    )?;
    if share > 0.0 {
        f.write_str(" clockwise")?;
    } else if share < 0.0 {
        f.write_str(" counter-clockwise")?;
    }
    if torque.is_beyond_scale() {
        f.write_str(", in doubt: more than its scale, is the revision another one?")?;
    }
    Ok(())
}

fn write_reply(f: &mut fmt::Formatter<'_>, reply: &Reply) -> fmt::Result {
    match reply {
        Reply::DriveId(id) => write!(f, "drive id {}", id.get()),
        Reply::DriveConfig(byte) => write_config_byte(f, *byte),
        Reply::DriveStatus(status) => write_status(f, *status),
        Reply::Position(counts) => {
            f.write_str("position ")?;
            counts.fmt(f)?;
            f.write_str(" counts")
        }
        Reply::Torque(torque) => write_torque(f, *torque),
        Reply::ParamGroup1(group) => write_group1(f, group),
        Reply::ParamGroup2(group) => write_group2(f, group),
        Reply::ParamGroup3(group) => write_group3(f, group),
        Reply::MotorSpeed(speed_rpm) => write!(f, "{speed_rpm} rpm"),
        Reply::DriveReset(byte) => write!(f, "answered 0x{byte:02X}, which no document explains"),
        Reply::Echo(bytes) => write_bytes(f, "sent back", bytes),
        Reply::DiagnosticCounter(count) => write!(f, "counter {count}"),
        Reply::DriveError(DriveError::Alarm) => {
            f.write_str("ALARM: the drive stopped, read its status")
        }
        Reply::DriveError(DriveError::DataError) => {
            f.write_str("DATA ERROR: a command was out of range")
        }
        Reply::DriveError(error) => error.fmt(f),
    }
}

fn write_bytes(f: &mut fmt::Formatter<'_>, what: &str, [a, b, c, d]: &[u8; 4]) -> fmt::Result {
    write!(f, "{what} {a:02X} {b:02X} {c:02X} {d:02X}")
}

fn write_status(f: &mut fmt::Formatter<'_>, status: DriveStatus) -> fmt::Result {
    f.write_str(if status.on_position() {
        "on position, "
    } else {
        "off position, "
    })?;
    f.write_str(if status.is_disabled() {
        "disabled, "
    } else {
        "enabled, "
    })?;
    status.alarm().fmt(f)?;
    f.write_str(if status.motion_busy() {
        ", built-in motion runs"
    } else {
        ""
    })
}

fn write_config_byte(f: &mut fmt::Formatter<'_>, byte: ConfigByte) -> fmt::Result {
    match byte.config() {
        Ok(config) => write_config(f, config),
        Err(error) => write!(f, "configuration 0x{:02X}: {error}", byte.to_byte()),
    }
}

fn write_config(f: &mut fmt::Formatter<'_>, config: DriveConfig) -> fmt::Result {
    let command = match config.command_mode {
        CommandMode::Rs232 => "link",
        CommandMode::CwCcw => "CW/CCW pulse",
        CommandMode::PulseDirection => "pulse and direction",
        CommandMode::Analog => "analog",
    };
    let servo = match config.servo_mode {
        ServoMode::Position => "position",
        ServoMode::Speed => "speed",
        ServoMode::Torque => "torque",
    };
    write!(f, "{command} commands, {servo} mode")?;
    if config.absolute_mode {
        f.write_str(", absolute mode")?;
    }
    if config.servo_free {
        f.write_str(", servo free")?;
    }
    Ok(())
}

fn write_group1(f: &mut fmt::Formatter<'_>, group: &ParamGroup1) -> fmt::Result {
    write!(
        f,
        "main gain {}, speed gain {}, integration gain {}, torque filter {} ({:.0} rad/s)",
        group.main_gain,
        group.speed_gain,
        group.integration_gain,
        group.torque_filter,
        units::torque_filter_rad_s(group.torque_filter)
    )
}

fn write_group2(f: &mut fmt::Formatter<'_>, group: &ParamGroup2) -> fmt::Result {
    write!(
        f,
        "max speed {}, max acceleration {}",
        group.max_speed, group.max_acceleration
    )
}

fn write_group3(f: &mut fmt::Formatter<'_>, group: &ParamGroup3) -> fmt::Result {
    write!(
        f,
        "on-position range {} ({:.2} degrees), gear number {} ({} counts a turn)",
        group.on_pos_range,
        units::on_position_degrees(group.on_pos_range),
        group.gear_number,
        units::command_counts_per_turn(group.gear_number)
    )?;
    match group.line_number {
        Some(line) => write!(f, ", line number {line}"),
        None => f.write_str(", no line number"),
    }
}

/// What a parameter write changes; what it keeps is not named.
struct Changes<'a, 'f> {
    f: &'a mut fmt::Formatter<'f>,
    any: bool,
}

impl<'a, 'f> Changes<'a, 'f> {
    fn new(f: &'a mut fmt::Formatter<'f>) -> Self {
        Self { f, any: false }
    }

    fn note(&mut self, name: &str, value: Option<impl Display>) -> fmt::Result {
        let Some(value) = value else { return Ok(()) };
        self.f.write_str(if self.any { ", " } else { "store " })?;
        self.any = true;
        write!(self.f, "{name} {value}")
    }

    fn end(self) -> fmt::Result {
        if self.any {
            Ok(())
        } else {
            self.f.write_str("keep everything")
        }
    }
}

fn write_set_group1(f: &mut fmt::Formatter<'_>, group: &SetParamGroup1) -> fmt::Result {
    let mut changes = Changes::new(f);
    changes.note("main gain", group.main_gain)?;
    changes.note("speed gain", group.speed_gain)?;
    changes.note("integration gain", group.integration_gain)?;
    changes.note("torque filter", group.torque_filter)?;
    changes.end()
}

fn write_set_group2(f: &mut fmt::Formatter<'_>, group: &SetParamGroup2) -> fmt::Result {
    let mut changes = Changes::new(f);
    changes.note("max speed", group.max_speed)?;
    changes.note("max acceleration", group.max_acceleration)?;
    changes.end()
}

fn write_set_group3(f: &mut fmt::Formatter<'_>, group: &SetParamGroup3) -> fmt::Result {
    let mut changes = Changes::new(f);
    changes.note("on-position range", group.on_pos_range)?;
    changes.note("gear number", group.gear_number)?;
    changes.note("line number", group.line_number)?;
    changes.end()
}
