//! Slow, wearing and dangerous commands: read, or compare, write and read back.
//!
//! They run beside the cycle: their requests share the budget and the one slot per drive with the polls, and a write is
//! refused while its axis is enabled. Parameters live in an EEPROM of 1,000,000 writes (section 1 of both revisions), so
//! a value that is already there is not written again, writes are counted, and they keep a distance.

mod error;
mod run;

use dyn_can::{
    DriveConfig, Reply, ReplyKind, Request, SetParamGroup1, SetParamGroup2, SetParamGroup3,
};

pub use error::ProcedureError;
pub(crate) use run::Run;

/// Something that the application asks of one drive beside the cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Procedure {
    /// Reads the drive id.
    ReadDriveId,
    /// Reads the configuration byte.
    ReadConfig,
    /// Reads gains and torque filter.
    ReadGroup1,
    /// Reads max speed and max acceleration.
    ReadGroup2,
    /// Reads on-position range, gear and line number.
    ReadGroup3,
    /// Writes the configuration byte where it differs. In absolute mode the motor moves to the stored zero at each power-on, so that
    /// mode needs [`Confirmation::Given`](crate::Confirmation::Given).
    WriteConfig(DriveConfig),
    /// Writes gains and torque filter where they differ.
    WriteGroup1(SetParamGroup1),
    /// Writes max speed and max acceleration where they differ.
    WriteGroup2(SetParamGroup2),
    /// Writes on-position range, gear and line number where they differ. Range 127 also makes an output the brake
    /// output after the next power cycle and needs [`Confirmation::Given`](crate::Confirmation::Given) (D54).
    WriteGroup3(SetParamGroup3),
    /// Makes the present position the zero of the drive. Needs [`Confirmation::Given`](crate::Confirmation::Given); the axis is anchored anew.
    SetOrigin,
    /// Resets the drive: clears its fault and its position (1.6A). Needs [`Confirmation::Given`](crate::Confirmation::Given); the axis starts anew.
    DriveReset,
}

/// How a procedure ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ProcedureEnd {
    /// The reading came.
    Read(Reply),
    /// The drive already had the values: nothing was written.
    Unchanged,
    /// Written, and read back as written.
    Written,
    /// Sent; the drive acknowledges nothing.
    Sent,
    /// Written, but this was read back.
    NotTaken(Reply),
    /// The drive answered with a data error.
    Refused,
    /// The drive did not answer, or not in a way that decodes.
    NoReply,
    /// A fault of the axis came first, or `clear` behind one.
    Aborted,
}

/// How much an axis may wear the EEPROM of its drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WearLimits {
    /// Parameters that may be written since the start of the master.
    pub budget: u16,
    /// Shortest time from one write to the next, in microseconds.
    pub interval_us: u32,
}

impl WearLimits {
    /// 100 parameters, one write a second.
    pub const DEFAULT: Self = Self {
        budget: 100,
        interval_us: 1_000_000,
    };
}

impl Procedure {
    pub(crate) const fn writes(self) -> bool {
        self.command().is_some()
    }

    pub(crate) fn needs_confirmation(self) -> bool {
        match self {
            Self::SetOrigin | Self::DriveReset => true,
            Self::WriteConfig(config) => config.absolute_mode,
            Self::WriteGroup3(set) => set
                .on_pos_range
                .is_some_and(dyn_can::OnPosRange::enables_brake_output),
            _ => false,
        }
    }

    /// EEPROM writes that a write may cost. Whether a frame with two parameters is one write or two is not stated, so
    /// each parameter counts (D53).
    pub(crate) fn wear(self) -> u16 {
        match self {
            Self::WriteGroup1(set) => set.count(),
            Self::WriteGroup2(set) => set.count(),
            Self::WriteGroup3(set) => set.count(),
            Self::WriteConfig(_) | Self::SetOrigin => 1,
            _ => 0,
        }
    }

    const fn reading(self) -> Option<ReplyKind> {
        match self {
            Self::ReadDriveId => Some(ReplyKind::DriveId),
            Self::ReadConfig | Self::WriteConfig(_) => Some(ReplyKind::DriveConfig),
            Self::ReadGroup1 | Self::WriteGroup1(_) => Some(ReplyKind::ParamGroup1),
            Self::ReadGroup2 | Self::WriteGroup2(_) => Some(ReplyKind::ParamGroup2),
            Self::ReadGroup3 | Self::WriteGroup3(_) => Some(ReplyKind::ParamGroup3),
            Self::SetOrigin | Self::DriveReset => None,
        }
    }

    pub(crate) const fn command(self) -> Option<Request> {
        match self {
            Self::WriteConfig(config) => Some(Request::SetDriveConfig(config)),
            Self::WriteGroup1(set) => Some(Request::SetParamGroup1(set)),
            Self::WriteGroup2(set) => Some(Request::SetParamGroup2(set)),
            Self::WriteGroup3(set) => Some(Request::SetParamGroup3(set)),
            Self::SetOrigin => Some(Request::SetOrigin),
            Self::DriveReset => Some(Request::DriveReset),
            _ => None,
        }
    }

    /// Whether a reading already shows what is to be written.
    fn is_in(self, reply: &Reply) -> bool {
        match (self, reply) {
            (Self::WriteConfig(wanted), Reply::DriveConfig(present)) => {
                present.config() == Ok(wanted)
            }
            (Self::WriteGroup1(wanted), Reply::ParamGroup1(present)) => wanted.is_in(present),
            (Self::WriteGroup2(wanted), Reply::ParamGroup2(present)) => wanted.is_in(present),
            (Self::WriteGroup3(wanted), Reply::ParamGroup3(present)) => wanted.is_in(present),
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dyn_can::{MaxAcceleration, MaxSpeed, OnPosRange};

    fn speed(value: i32) -> Procedure {
        Procedure::WriteGroup2(SetParamGroup2 {
            max_speed: MaxSpeed::new(value).ok(),
            max_acceleration: None,
        })
    }

    #[test]
    fn what_is_hard_to_undo_needs_a_confirmation() {
        let range = |value| {
            Procedure::WriteGroup3(SetParamGroup3 {
                on_pos_range: OnPosRange::new(value).ok(),
                ..SetParamGroup3::default()
            })
        };
        assert!(range(127).needs_confirmation());
        assert!(!range(126).needs_confirmation());
        assert!(Procedure::SetOrigin.needs_confirmation());
        let config = |byte| Procedure::WriteConfig(DriveConfig::from_byte(byte).unwrap());
        assert!(config(0x04).needs_confirmation());
        assert!(!config(0x3B & !0x18).needs_confirmation());
        assert!(!speed(1).needs_confirmation());
    }

    #[test]
    fn every_parameter_of_a_frame_counts_as_wear() {
        assert_eq!(speed(1).wear(), 1);
        let both = SetParamGroup2 {
            max_speed: Some(MaxSpeed::MIN),
            max_acceleration: Some(MaxAcceleration::MIN),
        };
        assert_eq!(Procedure::WriteGroup2(both).wear(), 2);
        assert_eq!(Procedure::ReadGroup1.wear(), 0);
    }
}
