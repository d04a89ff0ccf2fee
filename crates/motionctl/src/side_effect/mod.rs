//! Settings that do more than their name says, and are asked for on their own.

use dyn_can::{ConfigByte, OnPosRange};

use crate::confirm::{NotConfirmed, confirm_by};
use crate::drives::{Parameter, Setting};

/// What a setting does beside being stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SideEffect {
    /// The motor moves to the stored zero at each power-on.
    AbsoluteMode,
    /// An output becomes the brake output at the next power-on.
    BrakeOutput,
    /// The servo, which the configuration keeps free, is switched on at once.
    ServoOn,
}

impl SideEffect {
    /// The side effect of a setting, if it has one.
    pub(crate) fn of(setting: &Setting) -> Option<Self> {
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

    /// Whether a setting switches on the servo of a drive whose configuration keeps it free.
    pub(crate) fn switches_servo_on(setting: &Setting, before: Option<i32>) -> bool {
        let is_free = |value: i32| {
            u8::try_from(value).is_ok_and(|byte| ConfigByte::from_byte(byte).servo_free())
        };
        setting.parameter == Parameter::Config
            && before.is_some_and(is_free)
            && !is_free(setting.value)
    }

    /// Asks whether it is wanted; `is_allowed` is the answer given on the command line.
    ///
    /// # Errors
    /// [`NotConfirmed`] unless the answer is yes.
    pub(crate) fn confirm(self, is_allowed: bool) -> Result<(), NotConfirmed> {
        confirm_by(self.question(), is_allowed, self.option())
    }

    /// The option that allows it without a question.
    const fn option(self) -> &'static str {
        match self {
            Self::AbsoluteMode => "--allow-absolute-mode",
            Self::BrakeOutput => "--allow-brake-output",
            Self::ServoOn => "--allow-servo-on",
        }
    }

    /// The question.
    const fn question(self) -> &'static str {
        match self {
            Self::AbsoluteMode => {
                "In absolute mode the motor MOVES by itself at each power-on, to the zero that is stored. Is that wanted?"
            }
            Self::BrakeOutput => {
                "On-position range 127 also makes pin 9 of JP3 the output of a brake at the next power-on. Is that wanted?"
            }
            Self::ServoOn => {
                "The configuration of the file switches the servo ON at once, because the drive's own keeps it free. Is that wanted?"
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

    #[test]
    fn the_servo_goes_on_where_it_was_kept_free() {
        let on = |text: &str, before| {
            SideEffect::switches_servo_on(&Setting::parse(text).unwrap(), before)
        };
        assert!(on("config=0x00", Some(0x20)));
        assert!(on("config=0x04", Some(0x22)));
        assert!(!on("config=0x20", Some(0x20)));
        assert!(!on("config=0x00", Some(0x04)));
        assert!(!on("config=0x00", None));
        assert!(!on("main-gain=1", Some(0x20)));
    }
}
