//! Reads how an axis is homed.

use std::borrow::ToOwned;
use std::format;

use toml::Spanned;

use super::error::FileError;
use super::reader::{AxisText, Number, Reader, Word};
use crate::homing::{HomingDirection, HomingMethod, HomingSearch, HomingSettings, SwitchLevel};

impl Reader<'_> {
    pub(super) fn homing(&self, axis: &AxisText) -> Result<Option<HomingSettings>, FileError> {
        let Some(word) = &axis.homing else {
            self.refuse_strays(axis, "")?;
            return Ok(None);
        };
        let method = match word.get_ref().as_str() {
            "here" => HomingMethod::Here,
            "stop" => HomingMethod::Stop {
                search: self.search(word, axis)?,
                torque_permille: self.u16_or(
                    axis.homing_torque_permille.as_ref(),
                    HomingSettings::TORQUE_PERMILLE,
                )?,
                contact_millidegrees: self.u32_or(
                    axis.homing_contact_millidegrees.as_ref(),
                    HomingSettings::CONTACT_MILLIDEGREES,
                )?,
            },
            "switch" => {
                let pin = axis.homing_switch_pin.as_ref();
                let pin = pin.ok_or_else(|| self.missing(word, "homing_switch_pin"))?;
                let active = axis.homing_switch_active.as_ref();
                let active = active.ok_or_else(|| self.missing(word, "homing_switch_active"))?;
                HomingMethod::Switch {
                    search: self.search(word, axis)?,
                    pin: self.u8(pin)?,
                    active: match active.get_ref().as_str() {
                        "high" => SwitchLevel::High,
                        "low" => SwitchLevel::Low,
                        _ => {
                            return Err(self.wrong(
                                &active.span(),
                                "\"high\" or \"low\"",
                                "say the level of the switch while it is operated",
                            ));
                        }
                    },
                }
            }
            _ => {
                return Err(self.wrong(
                    &word.span(),
                    "\"stop\", \"switch\" or \"here\"",
                    "docs/homing.md says what they do",
                ));
            }
        };
        self.refuse_strays(axis, word.get_ref())?;
        let default = HomingSettings::new(method);
        Ok(Some(HomingSettings {
            order: match &axis.homing_order {
                Some(number) => self.u8(number)?,
                None => default.order,
            },
            reference_millidegrees: match &axis.homing_reference_millidegrees {
                Some(number) => self.number(number, (i32::MIN.into(), i32::MAX.into()))?,
                None => default.reference_millidegrees,
            },
            ..default
        }))
    }

    fn search(&self, method: &Word, axis: &AxisText) -> Result<HomingSearch, FileError> {
        let direction = axis.homing_direction.as_ref();
        let direction = direction.ok_or_else(|| self.missing(method, "homing_direction"))?;
        let way = axis.homing_way_millidegrees.as_ref();
        let way = way.ok_or_else(|| self.missing(method, "homing_way_millidegrees"))?;
        let direction = match direction.get_ref().as_str() {
            "positive" => HomingDirection::Positive,
            "negative" => HomingDirection::Negative,
            _ => {
                return Err(self.wrong(
                    &direction.span(),
                    "\"positive\" or \"negative\"",
                    "positive is towards larger counts",
                ));
            }
        };
        let default = HomingSearch::new(direction, self.u32(way)?);
        let u32_or = |number: &Option<Number>, default| self.u32_or(number.as_ref(), default);
        let u16_or = |number: &Option<Number>, default| self.u16_or(number.as_ref(), default);
        Ok(HomingSearch {
            speed_rpm: u16_or(&axis.homing_speed_rpm, default.speed_rpm)?,
            slow_speed_rpm: u16_or(&axis.homing_slow_speed_rpm, default.slow_speed_rpm)?,
            acceleration_rpm_per_s: u32_or(
                &axis.homing_acceleration_rpm_per_s,
                default.acceleration_rpm_per_s,
            )?,
            most_torque_permille: u16_or(
                &axis.homing_most_torque_permille,
                default.most_torque_permille,
            )?,
            most_millidegrees: u32_or(&axis.homing_most_millidegrees, default.most_millidegrees)?,
            back_off_millidegrees: u32_or(
                &axis.homing_back_off_millidegrees,
                default.back_off_millidegrees,
            )?,
            ..default
        })
    }

    /// Keys that mean nothing with this homing; the empty word is none.
    fn refuse_strays(&self, axis: &AxisText, homing: &str) -> Result<(), FileError> {
        const ALL: &[&str] = &["here", "stop", "switch"];
        const WAYS: &[&str] = &["stop", "switch"];
        let number = |number: &Option<Number>| number.as_ref().map(Spanned::span);
        let word = |word: &Option<Word>| word.as_ref().map(Spanned::span);
        let keys = [
            ("order", number(&axis.homing_order), ALL),
            (
                "reference_millidegrees",
                number(&axis.homing_reference_millidegrees),
                ALL,
            ),
            ("direction", word(&axis.homing_direction), WAYS),
            ("speed_rpm", number(&axis.homing_speed_rpm), WAYS),
            ("slow_speed_rpm", number(&axis.homing_slow_speed_rpm), WAYS),
            (
                "acceleration_rpm_per_s",
                number(&axis.homing_acceleration_rpm_per_s),
                WAYS,
            ),
            (
                "most_torque_permille",
                number(&axis.homing_most_torque_permille),
                WAYS,
            ),
            (
                "most_millidegrees",
                number(&axis.homing_most_millidegrees),
                WAYS,
            ),
            (
                "way_millidegrees",
                number(&axis.homing_way_millidegrees),
                WAYS,
            ),
            (
                "back_off_millidegrees",
                number(&axis.homing_back_off_millidegrees),
                WAYS,
            ),
            (
                "torque_permille",
                number(&axis.homing_torque_permille),
                &["stop"],
            ),
            (
                "contact_millidegrees",
                number(&axis.homing_contact_millidegrees),
                &["stop"],
            ),
            ("switch_pin", number(&axis.homing_switch_pin), &["switch"]),
            (
                "switch_active",
                word(&axis.homing_switch_active),
                &["switch"],
            ),
        ];
        for (key, span, homings) in keys {
            if let Some(span) = span.filter(|_| !homings.contains(&homing)) {
                let with = match homing {
                    "" => "without homing".to_owned(),
                    homing => format!("with homing = \"{homing}\""),
                };
                return Err(self.wrong(
                    &span,
                    &format!("no homing_{key} {with}"),
                    "leave it out, or choose another homing",
                ));
            }
        }
        Ok(())
    }

    fn missing(&self, method: &Word, key: &str) -> FileError {
        FileError::new(
            self.place(&method.span()),
            &format!("{key} beside homing = \"{}\"", method.get_ref()),
            "none",
            "say it; it has no default",
        )
    }
}
