//! What can go wrong with an axis, and what is done about it.

use core::fmt;

use dyn_can::{Alarm, ConfigByte};

use crate::core::counts::Counts;
use crate::core::family::{CommonFault, FaultKind, Reaction};
use crate::core::step::Loss;

/// Why an axis stopped. A fault is latched and leaves only by an explicit `clear`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Fault {
    /// The drive sent Drive_Error EE. Read the status for the cause; most alarms need a power cycle (D36).
    #[error("the drive reports an alarm")]
    AlarmFrame,
    /// The status byte shows an alarm.
    #[error("the status shows: {0}")]
    AlarmStatus(Alarm),
    /// The drive sent Drive_Error FF: it refused a command, and does not say which.
    #[error("the drive refused a command as out of range")]
    DataError,
    /// The drive sent a Drive_Error that no document lists: another byte, or not one byte.
    #[error(fmt = unknown_error)]
    UnknownError {
        /// The first byte; `None` for an empty frame.
        byte: Option<u8>,
    },
    /// The status byte says disabled although this master enabled the drive.
    #[error("the drive is disabled although it was enabled by this master")]
    SwitchedOff,
    /// The status byte says enabled although this master did not enable the drive: is there a second master?
    #[error(
        "the drive is enabled although this master did not enable it: look for a second master"
    )]
    SwitchedOn,
    /// The drive is not in command mode 0 and position mode; set it with the serial tool or Set_Drive_Config (D45).
    #[error("the drive must be in command mode 0 and position mode, its configuration byte is 0x{:02X}", _0.to_byte())]
    Config(ConfigByte),
    /// The gear number of the drive is not that of the configuration: each step would turn the shaft by another angle.
    #[error(fmt = gear)]
    Gear {
        /// The gear number of the configuration.
        expected: u16,
        /// The gear number of the drive; `None` when its parameters do not decode.
        actual: Option<u16>,
    },
    /// A load can fall, and the drive has no brake output (on-position range 127, D54).
    #[error(
        "the load of the axis can fall, and the drive has no brake output (on-position range 127)"
    )]
    NoBrake,
    /// The drive did not answer several times in a row. Check power, wiring, termination and drive id.
    #[error("the drive does not answer")]
    Lost,
    /// The axis fell too far behind its target. The target moves too fast, or the bus is blocked.
    #[error("the axis is {} behind its target", Counts(*.counts))]
    Backlog {
        /// What was owed, in command counts.
        counts: i32,
    },
    /// At standstill the position is not where the sent set-points should have taken it. Anchor the axis anew.
    #[error("at standstill the position is {} off, as after {cause}", Counts(*.counts))]
    Drift {
        /// Position minus expected position, in command counts.
        counts: i32,
        /// What may have happened.
        cause: DriftCause,
    },
    /// The drive follows too far behind its set-points: it is blocked, too slow, or the read-back scale is wrong (D44).
    #[error("the drive is {} off its set-points while moving", Counts(*.counts))]
    FollowingError {
        /// Position minus expected position, in command counts.
        counts: i32,
    },
    /// From one reading to the next the position changed by more than the set-points between them: the shaft was turned, the drive
    /// started again, or a set-point was lost or doubled.
    #[error("the position jumped by {} from one reading to the next", Counts(*.counts))]
    PositionJump {
        /// Change of the position minus change of the set-points, in command counts.
        counts: i32,
    },
    /// The drive started again: its diagnostic counter restarted.
    #[error("the drive started again: its counter should be {expected}, it is {actual}")]
    Reboot {
        /// The counter that should have come.
        expected: u8,
        /// The counter that came.
        actual: u8,
    },
    /// The bus failed; which of the latest set-points arrived is unknown.
    #[error("the bus failed, the fate of the latest set-points is unknown")]
    Bus,
    /// The shaft did not stand still, or the drive did not confirm, in time.
    #[error("the drive did not confirm in time, or its shaft turns")]
    ConfirmTimeout,
    /// The position read back leaves the travel or 28 bit.
    #[error("the position {read_back} is outside the travel")]
    PositionRange {
        /// The position as read, in read-back counts.
        read_back: i32,
    },
    /// A motion that the drive makes by itself, or its stop, took longer than it may: it is blocked, or a command did not arrive.
    #[error("the motion of the drive itself did not end in time: it is {} off its end", Counts(*.counts))]
    NotArrived {
        /// Position minus the end of the motion, in command counts.
        counts: i32,
    },
    /// The drive turns at constant speed towards the end of the travel, and is stopped before.
    #[error("at constant speed the axis came near the end of its travel, at {position_counts}")]
    TravelEnd {
        /// The position, in command counts.
        position_counts: i32,
    },
    /// Another axis of the group has a fault.
    #[error("another axis of the group has a fault")]
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
        self.consequences(&Reactions::DEFAULT).0
    }
}

impl Fault {
    /// What it takes from its axis, and what it does to its group.
    const fn consequences(self, to: &Reactions) -> (Loss, Reaction) {
        match self {
            // An alarm frees the shaft (DYN2 manual A1.8, alarm table), and a drive that started again comes up with its servo on.
            Self::AlarmFrame | Self::AlarmStatus(_) | Self::UnknownError { .. } => {
                (Loss::Drive, to.alarm)
            }
            Self::Reboot { .. } => (Loss::Drive, to.position),
            Self::Lost => (Loss::Contact, to.lost),
            Self::Bus => (Loss::Contact, to.bus),
            Self::DataError => (Loss::Knowledge, to.data_error),
            Self::Config(_) | Self::Gear { .. } | Self::NoBrake => {
                (Loss::Knowledge, Reaction::Halt)
            }
            Self::Drift { .. }
            | Self::FollowingError { .. }
            | Self::PositionJump { .. }
            | Self::PositionRange { .. }
            | Self::NotArrived { .. } => (Loss::Knowledge, to.position),
            Self::SwitchedOff | Self::SwitchedOn => (Loss::Anchor, to.position),
            Self::ConfirmTimeout => (Loss::Anchor, Reaction::Halt),
            Self::Backlog { .. } => (Loss::Nothing, to.backlog),
            Self::TravelEnd { .. } => (Loss::Nothing, to.position),
            Self::Group => (Loss::Nothing, Reaction::Halt),
        }
    }

    /// Its number, 1 ..= 99, for a host or a memory that knows numbers alone, and what else is known of it: the code of an alarm, a byte, counts
    /// or the value read, -1 for one that cannot be read, 0 where there is nothing to say. A number never changes; new ones come at the end.
    pub const fn number(self) -> (u16, i32) {
        match self {
            Self::AlarmFrame => (1, 0),
            Self::AlarmStatus(alarm) => (2, alarm.code() as i32),
            Self::DataError => (3, 0),
            Self::UnknownError { byte: Some(byte) } => (4, byte as i32),
            Self::UnknownError { byte: None } => (4, -1),
            Self::SwitchedOff => (5, 0),
            Self::SwitchedOn => (6, 0),
            Self::Config(byte) => (7, byte.to_byte() as i32),
            Self::Gear {
                actual: Some(actual),
                ..
            } => (8, actual as i32),
            Self::Gear { actual: None, .. } => (8, -1),
            Self::NoBrake => (9, 0),
            Self::Lost => (10, 0),
            Self::Backlog { counts } => (11, counts),
            Self::Drift { counts, .. } => (12, counts),
            Self::FollowingError { counts } => (13, counts),
            Self::PositionJump { counts } => (14, counts),
            Self::Reboot { actual, .. } => (15, actual as i32),
            Self::Bus => (16, 0),
            Self::ConfirmTimeout => (17, 0),
            Self::PositionRange { read_back } => (18, read_back),
            Self::NotArrived { counts } => (19, counts),
            Self::TravelEnd { position_counts } => (20, position_counts),
            Self::Group => (21, 0),
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

fn unknown_error(byte: &Option<u8>, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match byte {
        Some(byte) => write!(f, "the drive reports the undocumented error 0x{byte:02X}"),
        None => f.write_str("the drive reports an error without saying which"),
    }
}

fn gear(expected: &u16, actual: &Option<u16>, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match actual {
        Some(actual) => write!(
            f,
            "the drive has gear number {actual}, the configuration says {expected}: correct one of the two"
        ),
        None => write!(
            f,
            "the gear number of the drive cannot be read, the configuration says {expected}: check the dialect"
        ),
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
        fault.consequences(self).1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: Reactions = Reactions {
        alarm: Reaction::Halt,
        data_error: Reaction::Halt,
        lost: Reaction::Halt,
        backlog: Reaction::Halt,
        position: Reaction::Halt,
        bus: Reaction::Halt,
    };
    const ALL: Reactions = Reactions {
        alarm: Reaction::Disable,
        data_error: Reaction::Disable,
        lost: Reaction::Disable,
        backlog: Reaction::Disable,
        position: Reaction::Disable,
        bus: Reaction::Disable,
    };

    /// Each fault with what it takes, and with reactions of which only its own says to disable; all say so where it halts at any rate.
    fn rows() -> [(Fault, Loss, Reactions); 21] {
        const OWN: Reaction = Reaction::Disable;
        let alarm = Reactions { alarm: OWN, ..NONE };
        let position = Reactions {
            position: OWN,
            ..NONE
        };
        let lost = Reactions { lost: OWN, ..NONE };
        let bus = Reactions { bus: OWN, ..NONE };
        let backlog = Reactions {
            backlog: OWN,
            ..NONE
        };
        let data_error = Reactions {
            data_error: OWN,
            ..NONE
        };
        let byte = ConfigByte::from_byte(0);
        let gear = Fault::Gear {
            expected: 4_096,
            actual: None,
        };
        let drift = Fault::Drift {
            counts: 1,
            cause: DriftCause::OneStepLost,
        };
        let reboot = Fault::Reboot {
            expected: 0,
            actual: 9,
        };
        let range = Fault::PositionRange { read_back: 0 };
        [
            (Fault::AlarmFrame, Loss::Drive, alarm),
            (Fault::AlarmStatus(Alarm::OverCurrent), Loss::Drive, alarm),
            (Fault::UnknownError { byte: None }, Loss::Drive, alarm),
            (reboot, Loss::Drive, position),
            (Fault::Lost, Loss::Contact, lost),
            (Fault::Bus, Loss::Contact, bus),
            (Fault::DataError, Loss::Knowledge, data_error),
            (Fault::Config(byte), Loss::Knowledge, ALL),
            (gear, Loss::Knowledge, ALL),
            (Fault::NoBrake, Loss::Knowledge, ALL),
            (drift, Loss::Knowledge, position),
            (
                Fault::FollowingError { counts: 1 },
                Loss::Knowledge,
                position,
            ),
            (Fault::PositionJump { counts: 1 }, Loss::Knowledge, position),
            (range, Loss::Knowledge, position),
            (Fault::NotArrived { counts: 1 }, Loss::Knowledge, position),
            (
                Fault::TravelEnd { position_counts: 1 },
                Loss::Nothing,
                position,
            ),
            (Fault::SwitchedOff, Loss::Anchor, position),
            (Fault::SwitchedOn, Loss::Anchor, position),
            (Fault::ConfirmTimeout, Loss::Anchor, ALL),
            (Fault::Backlog { counts: 1 }, Loss::Nothing, backlog),
            (Fault::Group, Loss::Nothing, ALL),
        ]
    }

    #[test]
    fn the_numbers_are_those_of_the_first_firmware_and_none_is_left_out() {
        let numbers = rows().map(|(fault, ..)| fault.number());
        assert_eq!(
            numbers,
            [
                (1, 0),
                (2, 2),
                (4, -1),
                (15, 9),
                (10, 0),
                (16, 0),
                (3, 0),
                (7, 0),
                (8, -1),
                (9, 0),
                (12, 1),
                (13, 1),
                (14, 1),
                (18, 0),
                (19, 1),
                (20, 1),
                (5, 0),
                (6, 0),
                (17, 0),
                (11, 1),
                (21, 0)
            ]
        );
        let mut codes = numbers.map(|(code, _)| code);
        codes.sort_unstable();
        assert!(codes.into_iter().eq(1..=rows().len() as u16), "{codes:?}");
    }

    #[test]
    fn each_fault_takes_what_its_row_says_and_has_its_own_reaction() {
        for (fault, loss, reactions) in rows() {
            assert_eq!(fault.loss(), loss, "{fault}");
            let own = if reactions == ALL {
                Reaction::Halt
            } else {
                Reaction::Disable
            };
            assert_eq!(reactions.to(fault), own, "{fault}");
        }
    }
}
