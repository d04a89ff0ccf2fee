//! Settings that do more than their name says, and are asked for on their own.

use dyn_can::{ConfigByte, OnPosRange};

use crate::drives::{Parameter, Setting};

/// What a setting does beside being stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SideEffect {
    /// The motor moves to the stored zero at each power-on.
    AbsoluteMode,
    /// An output becomes the brake output at the next power-on.
    BrakeOutput,
}

impl SideEffect {
    /// The side effect of a setting, if it has one.
    pub(super) fn of(setting: &Setting) -> Option<Self> {
        let value = setting.value;
        match setting.parameter {
            Parameter::Config => {
                let byte = ConfigByte::from_byte(value.try_into().ok()?);
                byte.absolute_mode().then_some(Self::AbsoluteMode)
            }
            Parameter::OnPositionRange => {
                let range = OnPosRange::new(value).ok()?;
                range.enables_brake_output().then_some(Self::BrakeOutput)
            }
            _ => None,
        }
    }

    /// The option that allows it without a question.
    pub(super) const fn option(self) -> &'static str {
        match self {
            Self::AbsoluteMode => "--allow-absolute-mode",
            Self::BrakeOutput => "--allow-brake-output",
        }
    }

    /// The question.
    pub(super) const fn question(self) -> &'static str {
        match self {
            Self::AbsoluteMode => {
                "In absolute mode the motor MOVES by itself at each power-on, to the zero that is stored. Is that wanted?"
            }
            Self::BrakeOutput => {
                "On-position range 127 also makes pin 9 of JP3 the output of a brake at the next power-on. Is that wanted?"
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absolute_mode_and_range_127_have_a_side_effect_and_no_other_setting() {
        let of = |text: &str| SideEffect::of(&Setting::parse(text).unwrap());
        for config in ["config=0x04", "config=0x24", "config=0x0C"] {
            assert_eq!(of(config), Some(SideEffect::AbsoluteMode), "{config}");
        }
        assert_eq!(of("on-position-range=127"), Some(SideEffect::BrakeOutput));
        for harmless in [
            "config=0x20",
            "config=0x03",
            "on-position-range=126",
            "main-gain=127",
            "max-speed=127",
        ] {
            assert_eq!(of(harmless), None, "{harmless}");
        }
    }
}
