//! What can go wrong with an axis, and what is done about it.

use core::fmt;

use dyn_can::{Alarm, ConfigByte};

use crate::core::family::{CommonFault, FaultKind, Reaction};
use crate::core::step::Loss;

/// Why an axis stopped. A fault is latched and leaves only by an explicit `clear`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Fault {
    /// The drive sent Drive_Error EE. Read the status for the cause; most alarms need a power cycle (D36).
    AlarmFrame,
    /// The status byte shows an alarm.
    AlarmStatus(Alarm),
    /// The drive sent Drive_Error FF: it refused a command, and does not say which.
    DataError,
    /// The drive sent a Drive_Error that no document lists: another byte, or not one byte.
    UnknownError {
        /// The first byte; `None` for an empty frame.
        byte: Option<u8>,
    },
    /// The status byte says disabled although this master enabled the drive.
    SwitchedOff,
    /// The status byte says enabled although this master did not enable the drive: is there a second master?
    SwitchedOn,
    /// The drive is not in command mode 0 and position mode; set it with the serial tool or Set_Drive_Config (D45).
    Config(ConfigByte),
    /// The gear number of the drive is not that of the configuration: each step would turn the shaft by another angle.
    Gear {
        /// The gear number of the configuration.
        expected: u16,
        /// The gear number of the drive; `None` when its parameters do not decode.
        actual: Option<u16>,
    },
    /// A load can fall, and the drive has no brake output (on-position range 127, D54).
    NoBrake,
    /// The drive did not answer several times in a row. Check power, wiring, termination and drive id.
    Lost,
    /// The axis fell too far behind its target. The target moves too fast, or the bus is blocked.
    Backlog {
        /// What was owed, in command counts.
        counts: i32,
    },
    /// At standstill the position is not where the sent set-points should have taken it. Anchor the axis anew.
    Drift {
        /// Position minus expected position, in command counts.
        counts: i32,
        /// What may have happened.
        cause: DriftCause,
    },
    /// The drive follows too far behind its set-points: it is blocked, too slow, or the read-back scale is wrong (D44).
    FollowingError {
        /// Position minus expected position, in command counts.
        counts: i32,
    },
    /// From one reading to the next the position changed by more than the set-points between them: the shaft was turned, the drive
    /// started again, or a set-point was lost or doubled.
    PositionJump {
        /// Change of the position minus change of the set-points, in command counts.
        counts: i32,
    },
    /// The drive started again: its diagnostic counter restarted.
    Reboot {
        /// The counter that should have come.
        expected: u8,
        /// The counter that came.
        actual: u8,
    },
    /// The bus failed; which of the latest set-points arrived is unknown.
    Bus,
    /// The shaft did not stand still, or the drive did not confirm, in time.
    ConfirmTimeout,
    /// The position read back leaves the travel or 28 bit.
    PositionRange {
        /// The position as read, in read-back counts.
        read_back: i32,
    },
    /// Another axis of the group has a fault.
    Group,
}

impl From<CommonFault> for Fault {
    fn from(fault: CommonFault) -> Self {
        match fault {
            CommonFault::Group => Self::Group,
            CommonFault::Bus => Self::Bus,
            CommonFault::Lost => Self::Lost,
            CommonFault::NotConfirmed => Self::ConfirmTimeout,
            CommonFault::SwitchedOff => Self::SwitchedOff,
            CommonFault::SwitchedOn => Self::SwitchedOn,
        }
    }
}

impl FaultKind for Fault {
    fn loss(self) -> Loss {
        match self {
            // An alarm frees the shaft (DYN2 manual A1.8, alarm table), and a drive that started again comes up with its servo on.
            Self::AlarmFrame
            | Self::AlarmStatus(_)
            | Self::UnknownError { .. }
            | Self::Reboot { .. } => Loss::Drive,
            Self::Lost | Self::Bus => Loss::Contact,
            Self::DataError
            | Self::Config(_)
            | Self::Gear { .. }
            | Self::NoBrake
            | Self::Drift { .. }
            | Self::FollowingError { .. }
            | Self::PositionJump { .. }
            | Self::PositionRange { .. } => Loss::Knowledge,
            Self::ConfirmTimeout | Self::SwitchedOff | Self::SwitchedOn => Loss::Anchor,
            Self::Backlog { .. } | Self::Group => Loss::Nothing,
        }
    }
}

/// What may have made a position differ from what was sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DriftCause {
    /// The error fits one step that the drive took twice: CAN repeats a frame after an error in its last bit.
    OneStepRepeated,
    /// The error fits one step that never arrived.
    OneStepLost,
    /// Steps went in both directions, so either fits.
    OneStepLostOrRepeated,
    /// No single step is large enough.
    MoreThanOneStep,
}

impl fmt::Display for DriftCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OneStepRepeated => "one step repeated",
            Self::OneStepLost => "one step lost",
            Self::OneStepLostOrRepeated => "one step lost or repeated",
            Self::MoreThanOneStep => "more than one step",
        })
    }
}

/// The noun that fits a number of counts.
const fn counts_noun(counts: i32) -> &'static str {
    match counts {
        1 | -1 => "count",
        _ => "counts",
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AlarmFrame => f.write_str("the drive reports an alarm"),
            Self::AlarmStatus(alarm) => write!(f, "the status shows: {alarm}"),
            Self::DataError => f.write_str("the drive refused a command as out of range"),
            Self::UnknownError { byte: Some(byte) } => {
                write!(f, "the drive reports the undocumented error 0x{byte:02X}")
            }
            Self::UnknownError { byte: None } => {
                f.write_str("the drive reports an error without saying which")
            }
            Self::SwitchedOff => {
                f.write_str("the drive is disabled although it was enabled by this master")
            }
            Self::SwitchedOn => f.write_str(
                "the drive is enabled although this master did not enable it: look for a second master",
            ),
            Self::Gear {
                expected,
                actual: Some(actual),
            } => write!(
                f,
                "the drive has gear number {actual}, the configuration says {expected}: correct one of the two"
            ),
            Self::Gear {
                expected,
                actual: None,
            } => write!(
                f,
                "the gear number of the drive cannot be read, the configuration says {expected}: check the dialect"
            ),
            Self::NoBrake => f.write_str(
                "the load of the axis can fall, and the drive has no brake output (on-position range 127)",
            ),
            Self::Config(config) => write!(
                f,
                "the drive must be in command mode 0 and position mode, its configuration byte is 0x{:02X}",
                config.to_byte()
            ),
            Self::Lost => f.write_str("the drive does not answer"),
            Self::Backlog { counts } => write!(
                f,
                "the axis is {counts} {} behind its target",
                counts_noun(*counts)
            ),
            Self::Drift { counts, cause } => {
                write!(
                    f,
                    "at standstill the position is {counts} {} off, as after {cause}",
                    counts_noun(*counts)
                )
            }
            Self::FollowingError { counts } => {
                write!(
                    f,
                    "the drive is {counts} {} off its set-points while moving",
                    counts_noun(*counts)
                )
            }
            Self::PositionJump { counts } => write!(
                f,
                "the position jumped by {counts} {} from one reading to the next",
                counts_noun(*counts)
            ),
            Self::Reboot { expected, actual } => write!(
                f,
                "the drive started again: its counter should be {expected}, it is {actual}"
            ),
            Self::Bus => {
                f.write_str("the bus failed, the fate of the latest set-points is unknown")
            }
            Self::ConfirmTimeout => {
                f.write_str("the drive did not confirm in time, or its shaft turns")
            }
            Self::PositionRange { read_back } => {
                write!(f, "the position {read_back} is outside the travel")
            }
            Self::Group => f.write_str("another axis of the group has a fault"),
        }
    }
}

/// The reaction to each kind of fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reactions {
    /// To an alarm, by frame or by status, or an undocumented error. The specification asks to stop (section 6, #29).
    pub alarm: Reaction,
    /// To a data error.
    pub data_error: Reaction,
    /// To a drive that does not answer.
    pub lost: Reaction,
    /// To a backlog beyond the limit.
    pub backlog: Reaction,
    /// To a drift, a jump, a restart, a position out of range, or a drive whose power changed by itself.
    pub position: Reaction,
    /// To a failure of the bus.
    pub bus: Reaction,
}

impl Reactions {
    /// Halt on an alarm and on everything after which the position is unknown, ramp down otherwise.
    pub const DEFAULT: Self = Self {
        alarm: Reaction::Halt,
        data_error: Reaction::Halt,
        lost: Reaction::RampDown,
        backlog: Reaction::Halt,
        position: Reaction::Halt,
        bus: Reaction::Halt,
    };

    /// The reaction to a fault.
    #[must_use]
    pub const fn to(&self, fault: Fault) -> Reaction {
        match fault {
            Fault::AlarmFrame | Fault::AlarmStatus(_) | Fault::UnknownError { .. } => self.alarm,
            Fault::DataError => self.data_error,
            Fault::Lost => self.lost,
            Fault::Backlog { .. } => self.backlog,
            Fault::Bus => self.bus,
            Fault::Drift { .. }
            | Fault::FollowingError { .. }
            | Fault::PositionJump { .. }
            | Fault::Reboot { .. }
            | Fault::PositionRange { .. }
            | Fault::SwitchedOff
            | Fault::SwitchedOn => self.position,
            Fault::Config(_)
            | Fault::Gear { .. }
            | Fault::NoBrake
            | Fault::ConfirmTimeout
            | Fault::Group => Reaction::Halt,
        }
    }
}
