//! Numbers of the faults that a board tells its host and keeps in its log, and what they mean. A number never changes; new ones come at the end.

use core::fmt;

use can_motion::{EventKind, Fault};
use dyn_can::Alarm;

/// A fault of an axis (1 ..= 99), of the bus (100) or of the firmware (200 ..= 203), as [`Event::Fault`](board_link::message::Event::Fault) and
/// [`FaultEntry`](board_link::message::FaultEntry) have it. `Display` says what it means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaultNumber {
    /// The number: `code` of the messages.
    pub code: u16,
    /// What else is known: see [`Fault::number`], [`PANIC`](Self::PANIC) and [`PROCESSOR`](Self::PROCESSOR); else 0.
    pub detail: i32,
}

impl FaultNumber {
    /// The controller went bus-off: about no axis.
    pub const BUS_OFF: u16 = 100;
    /// The firmware panicked; the detail is the line, and the entry of the log has the file.
    pub const PANIC: u16 = 200;
    /// A fault of the processor; the detail is its CFSR (Armv7-M ARM, B3.2.15).
    pub const PROCESSOR: u16 = 201;
    /// The crystal stopped.
    pub const CRYSTAL: u16 = 202;
    /// The watchdog reset the board.
    pub const WATCHDOG: u16 = 203;

    /// The number of a fault of an axis.
    pub const fn of_axis(fault: Fault) -> Self {
        let (code, detail) = fault.number();
        Self { code, detail }
    }

    /// The number of an event; `None` when it is no fault.
    pub const fn of_event(kind: &EventKind) -> Option<Self> {
        match kind {
            EventKind::Fault(fault) => Some(Self::of_axis(*fault)),
            EventKind::BusOff => Some(Self {
                code: Self::BUS_OFF,
                detail: 0,
            }),
            _ => None,
        }
    }

    /// What a number means where nothing else is known, as in a snapshot; `None` when this version does not know it.
    pub const fn name(code: u16) -> Option<&'static str> {
        Some(match code {
            1 | 2 => "the drive reports an alarm",
            3 => "the drive refuses a request as malformed",
            4 => "the drive reports an error that is not documented",
            5 => "the drive lost its power or was switched off",
            6 => "the drive was switched on by somebody else",
            7 => "the configuration of the drive cannot be used",
            8 => "the drive has another gear number than the settings say",
            9 => "a load can fall, and the drive has no brake output",
            10 => "the drive does not answer any more",
            11 => "the axis is too far behind its set-points",
            12 => "the axis drifts at standstill",
            13 => "the following error is too large",
            14 => "the position jumped",
            15 => "the drive has started anew",
            16 => "no set-point got out onto the bus",
            17 => "the drive did not confirm that it is on or off",
            18 => "the drive reads back a position that makes no sense",
            19 => "the axis did not arrive",
            20 => "the axis is at the end of its travel",
            21 => "another axis of its group has a fault",
            Self::BUS_OFF => "the controller went bus-off",
            Self::PANIC => "the firmware panicked",
            Self::PROCESSOR => "the processor of the board had a fault",
            Self::CRYSTAL => "the crystal of the board stopped",
            Self::WATCHDOG => "the watchdog of the board reset it",
            _ => return None,
        })
    }
}

impl fmt::Display for FaultNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { code, detail } = *self;
        let Some(name) = Self::name(code) else {
            return write!(f, "fault {code}, {detail}");
        };
        match code {
            // Three bits of the status byte (1.6A section 6, #9).
            2 if (1..8).contains(&detail) => {
                write!(f, "{name}: {}", Alarm::from_code(detail as u8))
            }
            2 | 4 | 18 => write!(f, "{name}: {detail}"),
            7 | Self::PROCESSOR => write!(f, "{name}: {detail:#04x}"),
            8 if detail < 0 => f.write_str("the gear number of the drive cannot be read"),
            8 => write!(f, "{name}: {detail}"),
            11..=14 | 20 => write!(f, "{name}: {detail} counts"),
            19 => write!(f, "{name}: {detail} counts are missing"),
            _ => f.write_str(name),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn a_number_says_what_it_means_and_what_is_known() {
        for (code, detail, text) in [
            (1, 0, "the drive reports an alarm"),
            (2, 1, "the drive reports an alarm: lost phase"),
            (2, 99, "the drive reports an alarm: 99"),
            (7, 8, "the configuration of the drive cannot be used: 0x08"),
            (8, -1, "the gear number of the drive cannot be read"),
            (
                8,
                4_096,
                "the drive has another gear number than the settings say: 4096",
            ),
            (14, -7, "the position jumped: -7 counts"),
            (100, 0, "the controller went bus-off"),
            (200, 17, "the firmware panicked"),
            (201, 0x0100, "the processor of the board had a fault: 0x100"),
            (99, 5, "fault 99, 5"),
        ] {
            assert_eq!(FaultNumber { code, detail }.to_string(), text);
        }
    }
}
