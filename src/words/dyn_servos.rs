//! Of DYN servo drives.

use can_motion::{Dyn, EventKind, Fault};
use dyn_can::Alarm;

use super::{Who, Words};

impl Words for Dyn {
    fn write(axis: Option<u8>, kind: &EventKind) {
        let words = EventWords { axis, kind };
        match *kind {
            EventKind::Fault(Fault::Gear {
                expected,
                actual: Some(actual),
            }) => defmt::error!(
                "{}: its gear number is {=u16}, the configuration says {=u16}: correct one of the two; it is not enabled",
                words,
                actual,
                expected
            ),
            EventKind::FoundOn => defmt::warn!(
                "{}: it is left alone until enable becomes active, or the stop circuit opens",
                words
            ),
            EventKind::DisableUnconfirmed { .. } => defmt::error!(
                "{}: the drive may still have power; the command is repeated until the drive confirms it",
                words
            ),
            EventKind::Fault(_) | EventKind::BusOff => defmt::error!("{}", words),
            EventKind::State { .. } | EventKind::Revision(_) | EventKind::BusRecovered => {
                defmt::info!("{}", words);
            }
            _ => defmt::warn!("{}", words),
        }
    }
}

/// An event as a part of a line.
struct EventWords<'a> {
    axis: Option<u8>,
    kind: &'a EventKind,
}

impl defmt::Format for EventWords<'_> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{}: ", Who(self.axis));
        write_kind(f, self.kind);
    }
}

fn write_kind(f: defmt::Formatter<'_>, kind: &EventKind) {
    match kind {
        EventKind::State { from, to, reason } => {
            defmt::write!(f, "{} -> {} ({})", from, to, reason);
        }
        EventKind::Fault(fault) => write_fault(f, *fault),
        EventKind::FoundOn => defmt::write!(f, "it is enabled, and this board did not enable it"),
        EventKind::DisableUnconfirmed { repeated } => {
            defmt::write!(
                f,
                "it did not confirm that it is disabled, told again {=u32} x",
                *repeated
            );
        }
        EventKind::Revision(revision) => defmt::write!(f, "revision {}", revision),
        EventKind::SetPointMerged => defmt::write!(f, "a set-point missed its cycle"),
        EventKind::SetPointDisplaced => defmt::write!(f, "a set-point came back unsent"),
        EventKind::RequestDisplaced(kind) => {
            defmt::write!(f, "a request came back unsent: {}", kind)
        }
        EventKind::ReplyTimeout(kind) => defmt::write!(f, "no reply: {}", kind),
        EventKind::LateReply(function) => defmt::write!(f, "late or twice: {}", function),
        EventKind::StrayReply(function) => defmt::write!(f, "nobody asked for it: {}", function),
        EventKind::BadReply(error) => defmt::write!(f, "a reply does not decode: {}", error),
        EventKind::ForeignFrame { id } => defmt::write!(f, "a frame of no drive: {=u16:#05x}", *id),
        EventKind::CyclesMissed(cycles) => defmt::write!(f, "cycles missed: {=u32}", *cycles),
        EventKind::BusError(kind) => defmt::write!(f, "error: {}", kind),
        EventKind::BusOff => defmt::write!(f, "off: check wiring, termination and bit rate"),
        EventKind::BusRecovered => defmt::write!(f, "works again"),
        other => defmt::write!(f, "{}", other),
    }
}

/// What is wrong, and the next step.
fn write_fault(f: defmt::Formatter<'_>, fault: Fault) {
    match fault {
        Fault::AlarmFrame => defmt::write!(
            f,
            "alarm, its shaft is free: its status has the name, or the vendor's tool"
        ),
        Fault::AlarmStatus(alarm) => write_alarm(f, alarm),
        Fault::DataError => {
            defmt::write!(
                f,
                "it refused a command as out of range: look for a second master"
            );
        }
        Fault::UnknownError { byte } => {
            defmt::write!(f, "undocumented error {}: look for a second master", byte);
        }
        Fault::SwitchedOff => {
            defmt::write!(f, "disabled by somebody else: look for a second master")
        }
        Fault::SwitchedOn => defmt::write!(f, "enabled by somebody else: look for a second master"),
        Fault::Config(byte) => defmt::write!(
            f,
            "configuration byte {=u8:#04x}: it must be in command mode 0 and position mode",
            byte.to_byte()
        ),
        Fault::Gear { .. } => defmt::write!(f, "another gear number, or none that can be read"),
        Fault::NoBrake => defmt::write!(f, "its load can fall and it has no brake output"),
        Fault::Lost => defmt::write!(f, "no answer: check power, wiring, termination and id"),
        Fault::Backlog { counts } => {
            defmt::write!(f, "{=i32} counts behind: the target moves too fast", counts);
        }
        Fault::Drift { counts, cause } => {
            defmt::write!(
                f,
                "off by {=i32} counts at rest, as after {}",
                counts,
                cause
            );
        }
        Fault::FollowingError { counts } => defmt::write!(
            f,
            "off by {=i32} counts in motion: blocked, too slow, or another unit of its position",
            counts
        ),
        Fault::PositionJump { counts } => {
            defmt::write!(f, "its position jumped by {=i32} counts", counts);
        }
        Fault::Reboot { .. } => defmt::write!(f, "it started again: look at its supply"),
        Fault::Bus => defmt::write!(f, "no set-point got out: check the bus"),
        Fault::ConfirmTimeout => defmt::write!(f, "it did not confirm in time, or its shaft turns"),
        Fault::PositionRange { read_back } => {
            defmt::write!(f, "position {=i32} is outside the travel", read_back);
        }
        Fault::Group => defmt::write!(f, "stopped with the others"),
        other => defmt::write!(f, "{}", other),
    }
}

fn write_alarm(f: defmt::Formatter<'_>, alarm: Alarm) {
    match alarm {
        Alarm::LostPhase => defmt::write!(f, "alarm, lost phase: blocked or too slow"),
        Alarm::OverCurrent => defmt::write!(f, "alarm, over-current: motor, cable or load"),
        Alarm::OverheatOrOverpower => defmt::write!(f, "alarm, overheat or over-power"),
        Alarm::CommandRefused => defmt::write!(f, "alarm, command refused"),
        Alarm::None | Alarm::Unknown(_) => {
            defmt::write!(f, "alarm {=u8}, undocumented", alarm.code());
        }
    }
    defmt::write!(f, "; remove the cause, then switch the drive off and on");
}
