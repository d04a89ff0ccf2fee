//! What the numbers mean, their limits, and what is said of a number outside.

use core::fmt;

/// A quantity of the drives with the limits that the documents print for it.
///
/// Sources are sections of the CAN specification 1.6A, 1.2A prints the same ranges; for what only the serial protocol carries they
/// are sections of the DYN2 manual A1.8. Where that manual prints no range (M23) the limit is that of the CAN specification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Quantity {
    /// Drive id for addressing (section 4). 0 is broadcast; 64 is printed but needs 7 bits (D1, D2).
    DriveId,
    /// Drive id as a drive reports or stores it: 0 on a drive that was never given one (D2).
    StoredDriveId,
    /// Drive id on a serial line, where 0 is one as well; 64 ..= 126 are reserved and 127 is every drive (manual section 7.2.3; D3).
    SerialDriveId,
    /// Position or distance in counts, 28 bit (section 4, data range).
    Counts28,
    /// Step of Go_Relative_Pos_PD in counts (section 6, #28).
    PdStep,
    /// Largest step of Go_Relative_Pos_PD that a master allows itself, in counts.
    StepLimit,
    /// Speed of Turn_ConstSpeed in rpm (section 6, #10).
    SpeedRpm,
    /// Amplitude of Square_Wave and Sin_Wave in counts; 1024 is 45 degrees (section 6, #11, #12).
    Amplitude,
    /// Frequency of Square_Wave and Sin_Wave in Hz (section 6, #13).
    FrequencyHz,
    /// Main gain (section 6, #16).
    MainGain,
    /// Speed gain (section 6, #16).
    SpeedGain,
    /// Integration gain (section 6, #16).
    IntegrationGain,
    /// Torque filter constant (section 6, #16).
    TorqueFilter,
    /// Max speed parameter (section 6, #17); `units` turns it into rpm.
    MaxSpeed,
    /// Max acceleration parameter (section 6, #17); `units` turns it into rpm/s.
    MaxAcceleration,
    /// On-position range (section 6, #18).
    OnPosRange,
    /// Gear number (section 6, #18).
    GearNumber,
    /// Gear number as two 7-bit bytes of the serial protocol can carry it: 16384 does not fit (M13).
    GearNumberInTwoBytes,
    /// Line number (section 6, #18); not explained by any document (D24).
    LineNumber,
    /// Configuration byte: bits 7 and 6 must be 0 when written (section 6, #7).
    ConfigByte,
    /// Configuration byte of the serial protocol, 7 bits (manual section 7.3).
    SerialConfigByte,
    /// Servo mode in the configuration byte: 3 is undefined (section 6, #7).
    ServoMode,
    /// Command input mode in the configuration byte (section 6, #7).
    CommandMode,
    /// Torque as a drive reports it on the serial line, 16 bit (manual section 7.7, example 10; M14).
    SerialTorque,
    /// Feed rate of a coordinated move on the serial line (manual section 7.7, examples 7 and 8).
    FeedRate,
    /// The byte that a function of the serial protocol without data sends (manual section 7.2.1).
    Dummy,
}

impl Quantity {
    /// Smallest and largest value, both allowed.
    #[must_use]
    pub const fn limits(self) -> (i32, i32) {
        match self {
            Self::DriveId => (1, 63),
            Self::StoredDriveId | Self::SerialDriveId => (0, 63),
            Self::Counts28 => (-(1 << 27), (1 << 27) - 1),
            Self::PdStep => (-16_384, 16_384),
            Self::StepLimit => (1, 16_384),
            Self::SpeedRpm => (-20_000, 20_000),
            Self::Amplitude => (0, 4_096),
            Self::FrequencyHz => (0, 50),
            Self::MainGain
            | Self::SpeedGain
            | Self::IntegrationGain
            | Self::TorqueFilter
            | Self::MaxSpeed
            | Self::MaxAcceleration
            | Self::OnPosRange
            | Self::FeedRate => (1, 127),
            Self::GearNumber => (500, 16_384),
            Self::GearNumberInTwoBytes => (500, 16_383),
            Self::LineNumber => (500, 4_095),
            Self::ConfigByte => (0, 0x3F),
            Self::SerialConfigByte | Self::Dummy => (0, 127),
            Self::ServoMode => (0, 2),
            Self::CommandMode => (0, 3),
            Self::SerialTorque => (-32_768, 32_767),
        }
    }

    /// The value itself when it lies within the limits.
    ///
    /// # Errors
    /// [`RangeError`] with this quantity and the value when it does not.
    pub const fn check(self, actual: i32) -> Result<i32, RangeError> {
        let (min, max) = self.limits();
        if actual < min || actual > max {
            return Err(RangeError {
                quantity: self,
                actual,
            });
        }
        Ok(actual)
    }

    const fn name(self) -> &'static str {
        match self {
            Self::DriveId | Self::SerialDriveId => "drive id",
            Self::StoredDriveId => "stored drive id",
            Self::Counts28 => "position or distance in counts",
            Self::PdStep => "PD step in counts",
            Self::StepLimit => "step limit in counts",
            Self::SpeedRpm => "speed in rpm",
            Self::Amplitude => "wave amplitude in counts",
            Self::FrequencyHz => "wave frequency in Hz",
            Self::MainGain => "main gain",
            Self::SpeedGain => "speed gain",
            Self::IntegrationGain => "integration gain",
            Self::TorqueFilter => "torque filter constant",
            Self::MaxSpeed => "max speed parameter",
            Self::MaxAcceleration => "max acceleration parameter",
            Self::OnPosRange => "on-position range",
            Self::GearNumber => "gear number",
            Self::GearNumberInTwoBytes => "gear number in two 7-bit bytes",
            Self::LineNumber => "line number",
            Self::ConfigByte | Self::SerialConfigByte => "configuration byte",
            Self::ServoMode => "servo mode",
            Self::CommandMode => "command input mode",
            Self::SerialTorque => "torque",
            Self::FeedRate => "feed rate",
            Self::Dummy => "dummy byte",
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A number outside the range of its quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RangeError {
    /// The quantity, which knows its limits.
    pub quantity: Quantity,
    /// The number that was given or received.
    pub actual: i32,
}

impl fmt::Display for RangeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (min, max) = self.quantity.limits();
        write!(
            f,
            "{} must be {min}..={max}, got {}",
            self.quantity, self.actual
        )
    }
}

impl core::error::Error for RangeError {}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn the_limits_are_allowed_and_the_next_numbers_are_refused_with_what_was_expected() {
        let refused = |actual| {
            Err(RangeError {
                quantity: Quantity::SerialConfigByte,
                actual,
            })
        };
        for (value, expected) in [
            (-1, refused(-1)),
            (0, Ok(0)),
            (127, Ok(127)),
            (128, refused(128)),
        ] {
            assert_eq!(Quantity::SerialConfigByte.check(value), expected);
        }
        let error = Quantity::SerialConfigByte.check(128).unwrap_err();
        assert_eq!(
            error.to_string(),
            "configuration byte must be 0..=127, got 128"
        );
    }

    #[test]
    fn each_protocol_has_its_own_limits_for_one_thing() {
        assert!(Quantity::DriveId.check(0).is_err());
        assert_eq!(Quantity::SerialDriveId.check(0), Ok(0));
        assert!(Quantity::ConfigByte.check(0x40).is_err());
        assert_eq!(Quantity::SerialConfigByte.check(0x40), Ok(0x40));
        assert!(Quantity::GearNumberInTwoBytes.check(16_384).is_err());
        assert_eq!(Quantity::GearNumber.check(16_384), Ok(16_384));
    }

    #[test]
    fn the_limits_are_those_that_the_documents_print() {
        let printed = [
            (Quantity::DriveId, 1, 63),
            (Quantity::StoredDriveId, 0, 63),
            (Quantity::SerialDriveId, 0, 63),
            (Quantity::Counts28, -134_217_728, 134_217_727),
            (Quantity::PdStep, -16_384, 16_384),
            (Quantity::StepLimit, 1, 16_384),
            (Quantity::SpeedRpm, -20_000, 20_000),
            (Quantity::Amplitude, 0, 4_096),
            (Quantity::FrequencyHz, 0, 50),
            (Quantity::MainGain, 1, 127),
            (Quantity::SpeedGain, 1, 127),
            (Quantity::IntegrationGain, 1, 127),
            (Quantity::TorqueFilter, 1, 127),
            (Quantity::MaxSpeed, 1, 127),
            (Quantity::MaxAcceleration, 1, 127),
            (Quantity::OnPosRange, 1, 127),
            (Quantity::GearNumber, 500, 16_384),
            (Quantity::GearNumberInTwoBytes, 500, 16_383),
            (Quantity::LineNumber, 500, 4_095),
            (Quantity::ConfigByte, 0, 63),
            (Quantity::SerialConfigByte, 0, 127),
            (Quantity::ServoMode, 0, 2),
            (Quantity::CommandMode, 0, 3),
            (Quantity::SerialTorque, -32_768, 32_767),
            (Quantity::FeedRate, 1, 127),
            (Quantity::Dummy, 0, 127),
        ];
        for (quantity, min, max) in printed {
            assert_eq!(quantity.limits(), (min, max), "{quantity}");
        }
    }
}
