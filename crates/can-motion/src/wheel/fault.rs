//! What can go wrong with a wheel, and what is done about it.

use core::fmt;

use zlac8030l::{Emcy, FaultCode, NmtState, SdoEnd, SetUpError};

use crate::core::counts::Counts;
use crate::core::family::{CommonFault, FaultKind, Reaction};
use crate::core::step::Loss;

/// Why a wheel stopped. A fault is latched and leaves only by an explicit `clear`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum WheelFault {
    /// The drive reports fault bits (603Fh). `clear` resets them once their cause is gone.
    #[error("the drive reports {0}")]
    Drive(FaultCode),
    /// The drive sent an emergency message.
    #[error("{0}")]
    Emergency(Emcy),
    /// An emergency stop input of the drive is active.
    #[error("an emergency stop input of the drive is active")]
    EmergencyInput,
    /// The drive left operation enabled, or its quick stop holds, without a command.
    #[error("the drive is not enabled any more")]
    NotEnabled,
    /// The drive is enabled although this master did not enable it: is there a second master?
    #[error(
        "the drive is enabled although this master did not enable it: look for a second master"
    )]
    SwitchedOn,
    /// The drive left the operational state of NMT: it takes no targets any more.
    #[error("the drive is {0} and takes no targets")]
    NotOperational(NmtState),
    /// The drive does not answer, or sends no feedback or heartbeat. Check power, wiring, termination, node and bit rate.
    #[error("the drive does not answer")]
    Lost,
    /// The drive started again: what was set up is gone.
    #[error("the drive started again")]
    Reboot,
    /// The drive cannot be set up.
    #[error("set-up: {0}")]
    SetUp(SetUpError),
    /// A transfer that a state needs failed.
    #[error("a transfer failed: {0}")]
    Transfer(SdoEnd),
    /// 202Fh:05 of the drive is not what the configuration says: its speeds would be wrong by that factor.
    #[error("speeds must count 1/{expected} r/min (202Fh:05), the drive counts 1/{actual}")]
    SpeedResolution {
        /// What the configuration says.
        expected: u16,
        /// What the drive says.
        actual: u32,
    },
    /// The wheel is too far from the position that was sent: it is blocked, slips, or is too slow.
    #[error("the wheel is {} from where it was sent", Counts(*.counts))]
    FollowingError {
        /// Position read minus position sent, in counts.
        counts: i32,
    },
    /// The wheel turns at another speed than it was told for too long: it is blocked, too slow, or driven by something else.
    #[error("the wheel turns at {} in place of {} r/min", Tenths(*.actual_decirpm), Tenths(*.sent_decirpm))]
    FollowingSpeed {
        /// Speed that was sent, in 0.1 r/min.
        sent_decirpm: i32,
        /// Speed that was read, in 0.1 r/min.
        actual_decirpm: i32,
    },
    /// A wheel in torque mode turns faster than it may, because its load is gone; or one in velocity mode turns half as fast again as its
    /// fastest target, and [`WheelLimits::following_speed`](crate::wheel::WheelLimits::following_speed) more.
    #[error("the wheel turns at {} r/min, at most {} are allowed", Tenths(*.actual_decirpm), Tenths(*.most_decirpm))]
    OverSpeed {
        /// What is allowed, in 0.1 r/min.
        most_decirpm: i32,
        /// Speed that was read, in 0.1 r/min.
        actual_decirpm: i32,
    },
    /// The bus failed.
    #[error("the bus failed")]
    Bus,
    /// The wheel did not stand still, or the drive did not confirm, in time.
    #[error("the drive did not confirm in time, or its wheel turns")]
    ConfirmTimeout,
    /// The position read leaves the range of targets.
    #[error("the position {actual} is outside the range of targets")]
    PositionRange {
        /// The position in counts.
        actual: i32,
    },
    /// Another wheel of the group has a fault.
    #[error("another wheel of the group has a fault")]
    Group,
}

impl From<CommonFault> for WheelFault {
    fn from(fault: CommonFault) -> Self {
        match fault {
            CommonFault::Group => Self::Group,
            CommonFault::Bus => Self::Bus,
            CommonFault::Lost => Self::Lost,
            CommonFault::NotConfirmed => Self::ConfirmTimeout,
            CommonFault::SwitchedOff => Self::NotEnabled,
            CommonFault::SwitchedOn => Self::SwitchedOn,
        }
    }
}

impl FaultKind for WheelFault {
    fn loss(self) -> Loss {
        self.consequences(&WheelReactions::DEFAULT).0
    }
}

impl WheelFault {
    /// What it takes from its wheel, and what it does to its group.
    const fn consequences(self, to: &WheelReactions) -> (Loss, Reaction) {
        match self {
            // What was set up and told is gone.
            Self::Reboot => (Loss::Drive, to.lost),
            // Whether the motor still has power must be read again.
            Self::Drive(_) | Self::Emergency(_) => (Loss::Contact, to.drive),
            Self::NotOperational(_) | Self::Lost => (Loss::Contact, to.lost),
            Self::Bus => (Loss::Contact, to.bus),
            Self::EmergencyInput => (Loss::Knowledge, to.drive),
            Self::SetUp(_)
            | Self::Transfer(_)
            | Self::SpeedResolution { .. }
            | Self::PositionRange { .. } => (Loss::Knowledge, Reaction::Halt),
            Self::NotEnabled | Self::SwitchedOn => (Loss::Anchor, to.lost),
            Self::ConfirmTimeout => (Loss::Anchor, Reaction::Halt),
            Self::FollowingError { .. } | Self::FollowingSpeed { .. } | Self::OverSpeed { .. } => {
                (Loss::Nothing, to.following_error)
            }
            Self::Group => (Loss::Nothing, Reaction::Halt),
        }
    }
}

/// A number of tenths, with its decimal point.
struct Tenths(i32);

impl fmt::Display for Tenths {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.0 < 0 { "-" } else { "" };
        let tenths = self.0.unsigned_abs();
        write!(f, "{sign}{}.{}", tenths / 10, tenths % 10)
    }
}

/// What each fault does to the group. [`Reaction::Halt`] is a quick stop: the drives brake as 605Ah says and stay energised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WheelReactions {
    /// To a fault or emergency message of the drive, or an emergency stop input.
    pub drive: Reaction,
    /// To a drive that does not answer, restarted, or takes no targets any more.
    pub lost: Reaction,
    /// To a wheel that does not follow.
    pub following_error: Reaction,
    /// To a failure of the bus.
    pub bus: Reaction,
}

impl WheelReactions {
    /// The group stops at once on everything.
    pub const DEFAULT: Self = Self {
        drive: Reaction::Halt,
        lost: Reaction::Halt,
        following_error: Reaction::Halt,
        bus: Reaction::Halt,
    };

    /// The reaction to a fault.
    #[must_use]
    pub const fn to(&self, fault: WheelFault) -> Reaction {
        fault.consequences(self).1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_fault_takes_what_its_row_says_and_has_its_own_reaction() {
        const NONE: WheelReactions = WheelReactions {
            drive: Reaction::Halt,
            lost: Reaction::Halt,
            following_error: Reaction::Halt,
            bus: Reaction::Halt,
        };
        const ALL: WheelReactions = WheelReactions {
            drive: Reaction::Disable,
            lost: Reaction::Disable,
            following_error: Reaction::Disable,
            bus: Reaction::Disable,
        };
        const OWN: Reaction = Reaction::Disable;
        let drive = WheelReactions { drive: OWN, ..NONE };
        let lost = WheelReactions { lost: OWN, ..NONE };
        let bus = WheelReactions { bus: OWN, ..NONE };
        let following = WheelReactions {
            following_error: OWN,
            ..NONE
        };
        let emergency = Emcy {
            error_code: 1,
            error_register: 1,
            manufacturer: [0; 5],
        };
        let resolution = WheelFault::SpeedResolution {
            expected: 1,
            actual: 10,
        };
        let speed = WheelFault::FollowingSpeed {
            sent_decirpm: 0,
            actual_decirpm: 1,
        };
        let over = WheelFault::OverSpeed {
            most_decirpm: 1,
            actual_decirpm: 2,
        };
        let state = WheelFault::NotOperational(NmtState::Stopped);
        let transfer = WheelFault::Transfer(SdoEnd::TimedOut);
        let set_up = WheelFault::SetUp(SetUpError::Differs {
            address: zlac8030l::objects::MODE.address(),
            expected: 3,
            actual: 1,
        });
        let range = WheelFault::PositionRange { actual: 0 };
        let error = WheelFault::FollowingError { counts: 1 };
        let rows = [
            (WheelFault::Reboot, Loss::Drive, lost),
            (WheelFault::Drive(FaultCode::new(1)), Loss::Contact, drive),
            (WheelFault::Emergency(emergency), Loss::Contact, drive),
            (state, Loss::Contact, lost),
            (WheelFault::Lost, Loss::Contact, lost),
            (WheelFault::Bus, Loss::Contact, bus),
            (WheelFault::EmergencyInput, Loss::Knowledge, drive),
            (set_up, Loss::Knowledge, ALL),
            (transfer, Loss::Knowledge, ALL),
            (resolution, Loss::Knowledge, ALL),
            (range, Loss::Knowledge, ALL),
            (WheelFault::NotEnabled, Loss::Anchor, lost),
            (WheelFault::SwitchedOn, Loss::Anchor, lost),
            (WheelFault::ConfirmTimeout, Loss::Anchor, ALL),
            (error, Loss::Nothing, following),
            (speed, Loss::Nothing, following),
            (over, Loss::Nothing, following),
            (WheelFault::Group, Loss::Nothing, ALL),
        ];
        // Of the reactions only its own says to disable; all say so where it halts at any rate.
        for (fault, loss, reactions) in rows {
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
