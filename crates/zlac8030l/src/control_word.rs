//! Control word 6040h and modes of operation 6060h (guide section 4).

use core::fmt;

/// A control word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ControlWord(u16);

impl ControlWord {
    /// 0000: power stage off, the motor coasts.
    pub const DISABLE_VOLTAGE: Self = Self(0x0000);
    /// 0002: stop as 605Ah says and stay energised; [`Self::ENABLE_OPERATION`] releases it.
    pub const QUICK_STOP: Self = Self(0x0002);
    /// 0006: first step of enabling.
    pub const SHUTDOWN: Self = Self(0x0006);
    /// 0007: second step, and back from operation enabled.
    pub const SWITCH_ON: Self = Self(0x0007);
    /// 000F: third step, and release of a quick stop.
    pub const ENABLE_OPERATION: Self = Self(0x000F);
    /// 0080: the edge of bit 7 resets a fault. Send [`Self::DISABLE_VOLTAGE`] after it, so that the next reset has an edge (Z40).
    pub const FAULT_RESET: Self = Self(0x0080);
    /// 010F: halt of CiA 402, stops as 605Dh says and stays enabled. The guide describes 605Dh and not this bit.
    pub const HALT: Self = Self(0x010F);

    /// A control word from its value.
    #[must_use]
    pub const fn new(word: u16) -> Self {
        Self(word)
    }

    /// The word on the wire.
    #[must_use]
    pub const fn get(self) -> u16 {
        self.0
    }

    /// The two words that start a move to the target position 607Ah: the second one has the edge of bit 4.
    ///
    /// Wait for bit 12 of the status word after the second, and for its end after the next first, with a timeout (Z35).
    #[must_use]
    pub const fn start_move(kind: MoveKind) -> [Self; 2] {
        match kind {
            MoveKind::Relative => [Self(0x004F), Self(0x005F)],
            MoveKind::Absolute => [Self(0x000F), Self(0x001F)],
        }
    }
}

impl fmt::Display for ControlWord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04X}h", self.0)
    }
}

/// How a target position is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MoveKind {
    /// From where the motor is.
    Relative,
    /// From the origin.
    Absolute,
}

/// A target position outside the range of its kind (607Ah).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TargetPositionError {
    /// How it was meant.
    pub kind: MoveKind,
    /// The counts given.
    pub actual: i32,
}

impl fmt::Display for TargetPositionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let limit = self.kind.limit();
        write!(
            f,
            "the target must be {}..={limit} counts, got {}",
            -limit, self.actual
        )
    }
}

impl core::error::Error for TargetPositionError {}

impl MoveKind {
    /// The largest distance either way (607Ah, Z39).
    #[must_use]
    pub const fn limit(self) -> i32 {
        match self {
            Self::Relative => 0x7FFF_FFFF,
            Self::Absolute => 0x3FFF_FFFF,
        }
    }

    /// Checks a target position.
    ///
    /// # Errors
    /// [`TargetPositionError`] beyond the limit.
    pub const fn check(self, counts: i32) -> Result<i32, TargetPositionError> {
        let limit = self.limit();
        if counts < -limit || counts > limit {
            return Err(TargetPositionError {
                kind: self,
                actual: counts,
            });
        }
        Ok(counts)
    }
}

/// Mode of operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(i8)]
pub enum Mode {
    /// 1: profile position.
    Position = 1,
    /// 3: profile velocity.
    Velocity = 3,
    /// 4: profile torque. The guide's example and CiA 402 say 4, its dictionary says 6, which CiA 402 calls homing (Z4).
    Torque = 4,
}

impl Mode {
    /// The mode that 6061h reports; `None` for 0, for 6 (Z4) and for what nobody describes.
    #[must_use]
    pub const fn from_value(value: i8) -> Option<Self> {
        match value {
            1 => Some(Self::Position),
            3 => Some(Self::Velocity),
            4 => Some(Self::Torque),
            _ => None,
        }
    }

    /// The value for 6060h.
    #[must_use]
    pub const fn value(self) -> i8 {
        self as i8
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Torque => "torque",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moves_start_as_printed() {
        let words = |kind| ControlWord::start_move(kind).map(ControlWord::get);
        assert_eq!(words(MoveKind::Relative), [0x4F, 0x5F]);
        assert_eq!(words(MoveKind::Absolute), [0x0F, 0x1F]);
    }

    #[test]
    fn absolute_targets_are_limited_more() {
        assert!(MoveKind::Absolute.check(0x4000_0000).is_err());
        assert!(MoveKind::Absolute.check(-0x3FFF_FFFF).is_ok());
        assert!(MoveKind::Relative.check(0x4000_0000).is_ok());
        assert!(MoveKind::Relative.check(i32::MIN).is_err());
    }

    #[test]
    fn torque_is_4_and_6_is_no_mode() {
        assert_eq!(Mode::Torque.value(), 4);
        for value in i8::MIN..=i8::MAX {
            let expected = matches!(value, 1 | 3 | 4).then_some(value);
            assert_eq!(Mode::from_value(value).map(Mode::value), expected);
        }
    }

    #[test]
    fn a_target_is_refused_beyond_its_limit_and_nowhere_else() {
        for (kind, limit) in [
            (MoveKind::Relative, 0x7FFF_FFFF),
            (MoveKind::Absolute, 0x3FFF_FFFF),
        ] {
            assert_eq!(kind.check(limit), Ok(limit));
            assert_eq!(kind.check(-limit), Ok(-limit));
            let actual = -limit - 1;
            let refused = TargetPositionError { kind, actual };
            assert_eq!(kind.check(actual), Err(refused));
        }
        let kind = MoveKind::Absolute;
        let refused = TargetPositionError {
            kind,
            actual: 0x4000_0000,
        };
        assert_eq!(kind.check(0x4000_0000), Err(refused));
        assert_eq!(
            std::format!("{refused}"),
            "the target must be -1073741823..=1073741823 counts, got 1073741824"
        );
    }

    #[test]
    fn words_and_modes_print_as_in_the_guide() {
        let [first, _] = ControlWord::start_move(MoveKind::Relative);
        assert_eq!(std::format!("{first}"), "004Fh");
        let modes = [Mode::Position, Mode::Velocity, Mode::Torque];
        let names = modes.map(|mode| std::format!("{mode}"));
        assert_eq!(names, ["position", "velocity", "torque"]);
    }
}
