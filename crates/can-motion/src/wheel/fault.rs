//! What can go wrong with a wheel, and what is done about it.

use core::fmt;

use zlac8030l::{Emcy, FaultCode, NmtState, SdoEnd, SetUpError};

use crate::core::family::{CommonFault, FaultKind, Reaction};
use crate::core::step::Loss;

/// Why a wheel stopped. A fault is latched and leaves only by an explicit `clear`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum WheelFault {
    /// The drive reports fault bits (603Fh). `clear` resets them once their cause is gone.
    Drive(FaultCode),
    /// The drive sent an emergency message.
    Emergency(Emcy),
    /// An emergency stop input of the drive is active.
    EmergencyInput,
    /// The drive left operation enabled, or its quick stop holds, without a command.
    NotEnabled,
    /// The drive is enabled although this master did not enable it: is there a second master?
    SwitchedOn,
    /// The drive left the operational state of NMT: it takes no targets any more.
    NotOperational(NmtState),
    /// The drive does not answer, or sends no feedback or heartbeat. Check power, wiring, termination, node and bit rate.
    Lost,
    /// The drive started again: what was set up is gone.
    Reboot,
    /// The drive cannot be set up.
    SetUp(SetUpError),
    /// A transfer that a state needs failed.
    Transfer(SdoEnd),
    /// 202Fh:05 of the drive is not what the configuration says: its speeds would be wrong by that factor.
    SpeedResolution {
        /// What the configuration says.
        expected: u16,
        /// What the drive says.
        actual: u32,
    },
    /// The wheel is too far from the position that was sent: it is blocked, slips, or is too slow.
    FollowingError {
        /// Position read minus position sent, in counts.
        counts: i32,
    },
    /// The wheel turns at another speed than it was told for too long: it is blocked, too slow, or driven by something else.
    FollowingSpeed {
        /// Speed that was sent, in 0.1 r/min.
        sent_decirpm: i32,
        /// Speed that was read, in 0.1 r/min.
        actual_decirpm: i32,
    },
    /// The bus failed.
    Bus,
    /// The wheel did not stand still, or the drive did not confirm, in time.
    ConfirmTimeout,
    /// The position read leaves the range of targets.
    PositionRange {
        /// The position in counts.
        actual: i32,
    },
    /// Another wheel of the group has a fault.
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
        match self {
            // What was set up and told is gone.
            Self::Reboot => Loss::Drive,
            // Whether the motor still has power must be read again.
            Self::Drive(_)
            | Self::Emergency(_)
            | Self::NotOperational(_)
            | Self::Lost
            | Self::Bus => Loss::Contact,
            Self::EmergencyInput
            | Self::SetUp(_)
            | Self::Transfer(_)
            | Self::SpeedResolution { .. }
            | Self::PositionRange { .. } => Loss::Knowledge,
            Self::NotEnabled | Self::SwitchedOn | Self::ConfirmTimeout => Loss::Anchor,
            Self::FollowingError { .. } | Self::FollowingSpeed { .. } | Self::Group => {
                Loss::Nothing
            }
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

impl fmt::Display for WheelFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drive(code) => write!(f, "the drive reports {code}"),
            Self::Emergency(emergency) => emergency.fmt(f),
            Self::EmergencyInput => f.write_str("an emergency stop input of the drive is active"),
            Self::NotEnabled => f.write_str("the drive is not enabled any more"),
            Self::SwitchedOn => f.write_str(
                "the drive is enabled although this master did not enable it: look for a second master",
            ),
            Self::NotOperational(state) => write!(f, "the drive is {state} and takes no targets"),
            Self::Lost => f.write_str("the drive does not answer"),
            Self::Reboot => f.write_str("the drive started again"),
            Self::SetUp(error) => write!(f, "set-up: {error}"),
            Self::Transfer(end) => write!(f, "a transfer failed: {end}"),
            Self::SpeedResolution { expected, actual } => write!(
                f,
                "speeds must count 1/{expected} r/min (202Fh:05), the drive counts 1/{actual}"
            ),
            Self::FollowingError { counts } => {
                let noun = if counts.unsigned_abs() == 1 {
                    "count"
                } else {
                    "counts"
                };
                write!(f, "the wheel is {counts} {noun} from where it was sent")
            }
            Self::FollowingSpeed {
                sent_decirpm,
                actual_decirpm,
            } => write!(
                f,
                "the wheel turns at {} in place of {} r/min",
                Tenths(*actual_decirpm),
                Tenths(*sent_decirpm)
            ),
            Self::Bus => f.write_str("the bus failed"),
            Self::ConfirmTimeout => {
                f.write_str("the drive did not confirm in time, or its wheel turns")
            }
            Self::PositionRange { actual } => {
                write!(f, "the position {actual} is outside the range of targets")
            }
            Self::Group => f.write_str("another wheel of the group has a fault"),
        }
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
        match fault {
            WheelFault::Drive(_) | WheelFault::Emergency(_) | WheelFault::EmergencyInput => {
                self.drive
            }
            WheelFault::Lost
            | WheelFault::Reboot
            | WheelFault::NotEnabled
            | WheelFault::SwitchedOn
            | WheelFault::NotOperational(_) => self.lost,
            WheelFault::FollowingError { .. } | WheelFault::FollowingSpeed { .. } => {
                self.following_error
            }
            WheelFault::Bus => self.bus,
            WheelFault::SetUp(_)
            | WheelFault::Transfer(_)
            | WheelFault::SpeedResolution { .. }
            | WheelFault::ConfirmTimeout
            | WheelFault::PositionRange { .. }
            | WheelFault::Group => Reaction::Halt,
        }
    }
}
