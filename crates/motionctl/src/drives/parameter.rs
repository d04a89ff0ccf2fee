//! The parameters of a drive by name, with their ranges and units.

use core::fmt;

use clap::ValueEnum;
use dyn_can::{
    CommandMode, ConfigByte, GearNumber, MaxAcceleration, MaxSpeed, OnPosRange, Quantity,
    RangeError, ServoMode, TorqueFilter, units,
};
use schemars::JsonSchema;
use serde::{Serialize, Serializer};

/// A parameter that a drive stores.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, ValueEnum, JsonSchema)]
#[schemars(rename_all = "kebab-case")]
pub(crate) enum Parameter {
    /// Configuration byte: command mode, absolute mode, servo mode, servo free.
    Config,
    /// Main gain.
    MainGain,
    /// Speed gain.
    SpeedGain,
    /// Integration gain.
    IntegrationGain,
    /// Torque filter constant.
    TorqueFilter,
    /// Top speed of built-in moves.
    MaxSpeed,
    /// Acceleration of built-in moves.
    MaxAcceleration,
    /// On-position range.
    OnPositionRange,
    /// Gear number.
    GearNumber,
    /// Line number.
    LineNumber,
}

impl Parameter {
    const fn quantity(self) -> Quantity {
        match self {
            Self::Config => Quantity::ConfigByte,
            Self::MainGain => Quantity::MainGain,
            Self::SpeedGain => Quantity::SpeedGain,
            Self::IntegrationGain => Quantity::IntegrationGain,
            Self::TorqueFilter => Quantity::TorqueFilter,
            Self::MaxSpeed => Quantity::MaxSpeed,
            Self::MaxAcceleration => Quantity::MaxAcceleration,
            Self::OnPositionRange => Quantity::OnPosRange,
            Self::GearNumber => Quantity::GearNumber,
            Self::LineNumber => Quantity::LineNumber,
        }
    }

    /// Smallest and largest value, both allowed.
    pub(crate) const fn limits(self) -> (i32, i32) {
        self.quantity().limits()
    }

    /// A value with its meaning, as in `60 (3028.8 rpm)`.
    pub(crate) fn in_units(self, value: i32, gear: Option<GearNumber>) -> String {
        match self.meaning(value, gear) {
            Some(meaning) => format!("{value} ({meaning})"),
            None => value.to_string(),
        }
    }

    /// What a value means, in units; `None` for a plain number. Speeds depend on the gear number.
    pub(crate) fn meaning(self, value: i32, gear: Option<GearNumber>) -> Option<String> {
        match self {
            Self::Config => Some(config_in_words(ConfigByte::from_byte(
                value.try_into().ok()?,
            ))),
            Self::TorqueFilter => {
                let corner = units::torque_filter_rad_s(TorqueFilter::new(value).ok()?);
                Some(format!("{corner:.0} rad/s"))
            }
            Self::MaxSpeed => {
                let rpm = units::max_speed_rpm(MaxSpeed::new(value).ok()?, gear?);
                Some(format!("{rpm:.1} rpm"))
            }
            Self::MaxAcceleration => {
                let parameter = MaxAcceleration::new(value).ok()?;
                let rpm_s = units::max_acceleration_rpm_s(parameter, gear?);
                Some(format!("{rpm_s:.0} rpm/s"))
            }
            Self::OnPositionRange => {
                let range = OnPosRange::new(value).ok()?;
                let brake = if range.enables_brake_output() {
                    ", and JP3-9 is the brake output after the next power cycle"
                } else {
                    ""
                };
                let degrees = units::on_position_degrees(range);
                Some(format!("{degrees:.2} degrees{brake}"))
            }
            Self::GearNumber => {
                let gear = GearNumber::new(value).ok()?;
                let counts = units::command_counts_per_turn(gear);
                Some(format!(
                    "ratio {:.3}, {counts} counts a turn",
                    units::gear_ratio(gear)
                ))
            }
            Self::MainGain | Self::SpeedGain | Self::IntegrationGain | Self::LineNumber => None,
        }
    }
}

fn config_in_words(byte: ConfigByte) -> String {
    let command = match byte.command_mode() {
        CommandMode::Rs232 => "commands by link",
        CommandMode::CwCcw => "commands by CW and CCW pulses",
        CommandMode::PulseDirection => "commands by pulse and direction",
        CommandMode::Analog => "commands by analog input",
    };
    let servo = match byte.config().map(|config| config.servo_mode) {
        Ok(ServoMode::Position) => "position servo",
        Ok(ServoMode::Speed) => "speed servo",
        Ok(ServoMode::Torque) => "torque servo",
        Err(_) => "an undefined servo mode",
    };
    let position = if byte.absolute_mode() {
        "absolute"
    } else {
        "relative"
    };
    let free = if byte.servo_free() {
        ", servo free"
    } else {
        ""
    };
    format!("{command}, {servo}, {position}{free}")
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.to_possible_value();
        f.write_str(value.as_ref().map_or("parameter", |value| value.get_name()))
    }
}

impl Serialize for Parameter {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// A parameter and the value that it shall have, within its range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Setting {
    pub(crate) parameter: Parameter,
    pub(crate) value: i32,
}

impl Setting {
    /// Reads `name=value`; the value may be hexadecimal.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let (name, value) = text
            .split_once('=')
            .ok_or("expected name=value, as in max-speed=40")?;
        let parameter = Parameter::from_str(name.trim(), true).map_err(|_| {
            let names: Vec<String> = Parameter::value_variants()
                .iter()
                .map(ToString::to_string)
                .collect();
            format!(
                "there is no parameter {name}; there are {}",
                names.join(", ")
            )
        })?;
        let value = value.trim();
        let number = match value.strip_prefix("0x") {
            Some(digits) => i32::from_str_radix(digits, 16).ok(),
            None => value.parse().ok(),
        };
        let number = number.ok_or_else(|| format!("{value} is not a whole number"))?;
        Self::new(parameter, number).map_err(|error| error.to_string())
    }

    /// A value for a parameter.
    ///
    /// # Errors
    /// When it is out of range, or a configuration byte with an undefined servo mode.
    pub(crate) fn new(parameter: Parameter, value: i32) -> Result<Self, RangeError> {
        let value = parameter.quantity().check(value)?;
        if parameter == Parameter::Config {
            let byte = value.try_into().unwrap_or(u8::MAX);
            dyn_can::DriveConfig::from_byte(byte)?;
        }
        Ok(Self { parameter, value })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_checked_against_their_range() {
        let expected = Setting {
            parameter: Parameter::MaxSpeed,
            value: 40,
        };
        assert_eq!(Setting::parse("max-speed=40"), Ok(expected));
        assert_eq!(Setting::parse(" MAX-SPEED = 0x28"), Ok(expected));
        let refused = |text| Setting::parse(text).unwrap_err();
        assert!(refused("max-speed").contains("expected name=value"));
        assert!(refused("speed=1").contains("there are config, main-gain"));
        assert!(refused("max-speed=128").contains("must be 1..=127, got 128"));
        assert!(refused("gear-number=499").contains("500..=16384"));
        assert!(refused("main-gain=ten").contains("not a whole number"));
        // Servo mode 3 is undefined.
        assert!(refused("config=0x18").contains("servo mode"));
    }

    #[test]
    fn values_have_units() {
        let gear = GearNumber::new(4096).ok();
        let meaning = |parameter: Parameter, value| parameter.meaning(value, gear).unwrap();
        // DYN2 manual A1.8 section 7, worked example: MaxSpd 48, MaxAcl 30.
        assert_eq!(meaning(Parameter::MaxSpeed, 48), "1984.9 rpm");
        assert_eq!(meaning(Parameter::MaxAcceleration, 30), "19073 rpm/s");
        assert_eq!(
            meaning(Parameter::GearNumber, 4096),
            "ratio 1.000, 16384 counts a turn"
        );
        assert!(meaning(Parameter::OnPositionRange, 127).contains("brake output"));
        assert_eq!(
            meaning(Parameter::Config, 0x24),
            "commands by link, position servo, absolute, servo free"
        );
        assert_eq!(Parameter::MaxSpeed.meaning(48, None), None);
    }
}
