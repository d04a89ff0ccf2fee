//! What a drive gives as the reason of its stop.

use core::fmt;

/// Alarm code in bits 4..2 of the status byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Alarm {
    /// No alarm.
    None,
    /// 1: the motor lost phase, the position error is too large (D47).
    LostPhase,
    /// 2: over-current.
    OverCurrent,
    /// 3: overheat or over-power.
    OverheatOrOverpower,
    /// 4: a command was refused; called a CRC error on CAN (D49) and a wrong checksum on the serial line.
    CommandRefused,
    /// 5 ..= 7: not documented; 5 is probably over-voltage (D48).
    Unknown(UnknownAlarm),
}

/// An alarm code that the documents do not list: 5, 6 or 7.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum UnknownAlarm {
    /// Code 5.
    Code5,
    /// Code 6.
    Code6,
    /// Code 7.
    Code7,
}

impl Alarm {
    /// The alarm in the lower three bits.
    #[must_use]
    pub const fn from_code(code: u8) -> Self {
        match code & 0b111 {
            0 => Self::None,
            1 => Self::LostPhase,
            2 => Self::OverCurrent,
            3 => Self::OverheatOrOverpower,
            4 => Self::CommandRefused,
            5 => Self::Unknown(UnknownAlarm::Code5),
            6 => Self::Unknown(UnknownAlarm::Code6),
            _ => Self::Unknown(UnknownAlarm::Code7),
        }
    }

    /// The code, 0 ..= 7.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::None => 0,
            Self::LostPhase => 1,
            Self::OverCurrent => 2,
            Self::OverheatOrOverpower => 3,
            Self::CommandRefused => 4,
            Self::Unknown(UnknownAlarm::Code5) => 5,
            Self::Unknown(UnknownAlarm::Code6) => 6,
            Self::Unknown(UnknownAlarm::Code7) => 7,
        }
    }

    /// Any code but 0.
    #[must_use]
    pub const fn is_alarm(self) -> bool {
        !matches!(self, Self::None)
    }
}

impl fmt::Display for Alarm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::None => "no alarm",
            Self::LostPhase => "lost phase",
            Self::OverCurrent => "over-current",
            Self::OverheatOrOverpower => "overheat or over-power",
            Self::CommandRefused => "command refused",
            Self::Unknown(_) => return write!(f, "undocumented alarm {}", self.code()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn undocumented_alarm_codes_survive() {
        for code in 0..8 {
            assert_eq!(Alarm::from_code(code).code(), code);
        }
        assert!(Alarm::from_code(7).is_alarm());
    }

    #[test]
    fn each_code_has_its_name_and_only_0_is_none() {
        let names = [
            "no alarm",
            "lost phase",
            "over-current",
            "overheat or over-power",
            "command refused",
            "undocumented alarm 5",
            "undocumented alarm 6",
            "undocumented alarm 7",
        ];
        for (code, name) in (0..).zip(names) {
            let alarm = Alarm::from_code(code);
            assert_eq!(std::format!("{alarm}"), name);
            assert_eq!(alarm.is_alarm(), code != 0, "{name}");
        }
    }
}
