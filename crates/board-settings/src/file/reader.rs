//! Reads a file. Every key is known and said once, and every number fits; whether they make a board that works is asked afterwards, and
//! [`SettingsFile::locate`] finds the place of what is refused then.

use core::ops::Range;
use std::format;
use std::string::{String, ToString};
use std::vec::Vec;

use serde::Deserialize;
use toml::Spanned;

use super::FORMAT;
use super::error::{FileError, Place};
use crate::axis::{AxisSettings, Dialect, MotorLimits, Polls, ReadBack, Travel};
use crate::refusal::Refusal;
use crate::settings::{BusSettings, Inputs, MOST_AXES, Name, Settings};

pub(super) type Number = Spanned<i64>;
pub(super) type Word = Spanned<String>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileText {
    format: Number,
    name: Option<Word>,
    bus: BusText,
    inputs: Option<InputsText>,
    #[serde(default)]
    axis: Vec<Spanned<AxisText>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BusText {
    bit_rate_kbit_per_s: Number,
    requests_per_cycle: Option<Number>,
    response_min_us: Option<Number>,
    response_max_us: Option<Number>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct InputsText {
    enable_fitted: Option<bool>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AxisText {
    drive: Number,
    gear_number: Number,
    speed_rpm: Number,
    acceleration_rpm_per_s: Number,
    jerk_rpm_per_s2: Option<Number>,
    travel_min_millidegrees: Option<Number>,
    travel_max_millidegrees: Option<Number>,
    travel_min_counts: Option<Number>,
    travel_max_counts: Option<Number>,
    read_back: Option<Word>,
    read_back_counts: Option<Number>,
    read_back_command_counts: Option<Number>,
    group: Option<Number>,
    status_poll_us: Option<Number>,
    position_poll_us: Option<Number>,
    torque_poll_us: Option<Number>,
    speed_poll_us: Option<Number>,
    counter_poll_us: Option<Number>,
    unwatched: Option<bool>,
    load_can_fall: Option<bool>,
    dialect: Option<Word>,
    following_error_counts: Option<Number>,
    drift_tolerance_counts: Option<Number>,
    pub(super) homing: Option<Word>,
    pub(super) homing_order: Option<Number>,
    pub(super) homing_reference_millidegrees: Option<Number>,
    pub(super) homing_direction: Option<Word>,
    pub(super) homing_speed_rpm: Option<Number>,
    pub(super) homing_slow_speed_rpm: Option<Number>,
    pub(super) homing_acceleration_rpm_per_s: Option<Number>,
    pub(super) homing_torque_permille: Option<Number>,
    pub(super) homing_most_torque_permille: Option<Number>,
    pub(super) homing_contact_millidegrees: Option<Number>,
    pub(super) homing_most_millidegrees: Option<Number>,
    pub(super) homing_way_millidegrees: Option<Number>,
    pub(super) homing_back_off_millidegrees: Option<Number>,
    pub(super) homing_switch_pin: Option<Number>,
    pub(super) homing_switch_active: Option<Word>,
}

/// The settings of a file, and where they stand in it.
#[derive(Debug, Clone)]
pub struct SettingsFile {
    /// The settings.
    pub settings: Settings,
    text: String,
    axes: Vec<Range<usize>>,
}

/// Reads the text of a file.
///
/// # Errors
/// [`FileError`]: the first thing that is wrong.
pub fn read(text: &str) -> Result<SettingsFile, FileError> {
    let reader = Reader { text };
    let file: FileText = toml::from_str(text).map_err(|error| reader.syntax(&error))?;
    if *file.format.get_ref() != FORMAT {
        return Err(reader.wrong(
            &file.format.span(),
            &format!("format = {FORMAT}"),
            "use the version of the tool that wrote it",
        ));
    }
    let mut axes = heapless::Vec::new();
    for axis in &file.axis {
        let settings = reader.axis(axis)?;
        axes.push(settings).map_err(|_| {
            FileError::new(
                reader.place(&axis.span()),
                &format!("at most {MOST_AXES} axes"),
                &format!("{}", file.axis.len()),
                "divide them among several boards",
            )
        })?;
    }
    Ok(SettingsFile {
        settings: Settings {
            name: reader.name(file.name.as_ref())?,
            bus: reader.bus(&file.bus)?,
            inputs: Inputs {
                enable_fitted: file
                    .inputs
                    .and_then(|inputs| inputs.enable_fitted)
                    .unwrap_or(true),
            },
            axes,
        },
        text: text.to_string(),
        axes: file.axis.iter().map(Spanned::span).collect(),
    })
}

impl SettingsFile {
    /// The place of what is refused: the key, the heading of the axis where the key is left out, or the first line.
    #[must_use]
    pub fn locate(&self, refusal: &Refusal) -> Place {
        let axis = refusal.axis.map(usize::from);
        let part = match axis {
            Some(axis) => self.part_of_axis(axis),
            None => 0..self.text.len(),
        };
        let key = refusal.kind.key();
        let wanted = self.lines(part.clone()).find(|(_, line)| {
            let name = line.split('=').next().unwrap_or_default().trim();
            let value = line.split('=').nth(1).unwrap_or_default();
            let value = value.split('#').next().unwrap_or_default().trim();
            let fits = name == key
                || key == "travel" && name.starts_with("travel_")
                || key == "read_back" && name.starts_with("read_back")
                || key == "poll_us"
                    && name.ends_with(key)
                    && value.replace('_', "") == refusal.actual.to_string();
            !key.is_empty() && fits
        });
        Place::of(&self.text, wanted.map_or(part.start, |(at, _)| at))
    }

    fn part_of_axis(&self, axis: usize) -> Range<usize> {
        let start = self.axes.get(axis).map_or(0, |span| span.start);
        let next = self.axes.get(axis + 1);
        start..next.map_or(self.text.len(), |span| span.start)
    }

    /// The lines of a part, each with the place of its first word.
    fn lines(&self, part: Range<usize>) -> impl Iterator<Item = (usize, &str)> {
        let mut at = part.start;
        let text = self.text.get(part).unwrap_or_default();
        text.split_inclusive('\n').map(move |line| {
            let indent = line.len() - line.trim_start().len();
            let first = at + indent;
            at += line.len();
            (first, line)
        })
    }
}

/// Knows the text, for places in it.
#[derive(Clone, Copy)]
pub(super) struct Reader<'a> {
    text: &'a str,
}

impl Reader<'_> {
    pub(super) fn place(&self, span: &Range<usize>) -> Place {
        Place::of(self.text, span.start)
    }

    /// What stands there is not what was expected.
    pub(super) fn wrong(&self, span: &Range<usize>, expected: &str, advice: &str) -> FileError {
        let text = self.text.get(span.clone()).unwrap_or_default();
        let actual = text.lines().next().unwrap_or_default();
        FileError::new(self.place(span), expected, actual, advice)
    }

    fn syntax(&self, error: &toml::de::Error) -> FileError {
        let span = error.span().unwrap_or_default();
        let message = error.message().trim_end();
        FileError::new(
            self.place(&span),
            "settings of a board",
            message,
            "the README of board-settings has an example",
        )
    }

    pub(super) fn number<T: TryFrom<i64> + Copy>(
        &self,
        number: &Number,
        (least, most): (i64, i64),
    ) -> Result<T, FileError> {
        T::try_from(*number.get_ref()).map_err(|_| {
            self.wrong(
                &number.span(),
                &format!("{least} to {most}"),
                "correct the number",
            )
        })
    }

    pub(super) fn u8(&self, number: &Number) -> Result<u8, FileError> {
        self.number(number, (0, u8::MAX.into()))
    }

    fn u16(&self, number: &Number) -> Result<u16, FileError> {
        self.number(number, (0, u16::MAX.into()))
    }

    pub(super) fn u32(&self, number: &Number) -> Result<u32, FileError> {
        self.number(number, (0, u32::MAX.into()))
    }

    pub(super) fn u16_or(&self, number: Option<&Number>, default: u16) -> Result<u16, FileError> {
        number.map_or(Ok(default), |number| self.u16(number))
    }

    pub(super) fn u32_or(&self, number: Option<&Number>, default: u32) -> Result<u32, FileError> {
        number.map_or(Ok(default), |number| self.u32(number))
    }

    fn name(&self, name: Option<&Word>) -> Result<Name, FileError> {
        let Some(name) = name else {
            return Ok(Name::new());
        };
        let text = name.get_ref().as_str();
        Name::try_from(text).map_err(|_| {
            FileError::new(
                self.place(&name.span()),
                "a name of at most 24 bytes",
                &format!("{} bytes", text.len()),
                "choose a shorter name",
            )
        })
    }

    fn bus(&self, bus: &BusText) -> Result<BusSettings, FileError> {
        let default = BusSettings::new(self.u16(&bus.bit_rate_kbit_per_s)?);
        Ok(BusSettings {
            requests_per_cycle: match &bus.requests_per_cycle {
                Some(number) => self.u8(number)?,
                None => default.requests_per_cycle,
            },
            response_min_us: self.u32_or(bus.response_min_us.as_ref(), default.response_min_us)?,
            response_max_us: self.u32_or(bus.response_max_us.as_ref(), default.response_max_us)?,
            ..default
        })
    }

    fn axis(&self, axis: &Spanned<AxisText>) -> Result<AxisSettings, FileError> {
        let (span, axis) = (axis.span(), axis.get_ref());
        let limits = MotorLimits {
            speed_rpm: self.u32(&axis.speed_rpm)?,
            acceleration_rpm_per_s: self.u32(&axis.acceleration_rpm_per_s)?,
        };
        let optional = |number: &Option<Number>| match number {
            Some(number) => self.u32(number).map(Some),
            None => Ok(None),
        };
        Ok(AxisSettings {
            jerk_rpm_per_s2: optional(&axis.jerk_rpm_per_s2)?,
            read_back: self.read_back(&span, axis)?,
            group: match &axis.group {
                Some(group) => self.u8(group)?,
                None => 0,
            },
            polls: self.polls(axis)?,
            unwatched: axis.unwatched.unwrap_or(false),
            load_can_fall: axis.load_can_fall.unwrap_or(false),
            dialect: self.dialect(axis.dialect.as_ref())?,
            following_error_counts: optional(&axis.following_error_counts)?,
            drift_tolerance_counts: optional(&axis.drift_tolerance_counts)?,
            homing: self.homing(axis)?,
            ..AxisSettings::new(
                self.u8(&axis.drive)?,
                self.u16(&axis.gear_number)?,
                limits,
                self.travel(&span, axis)?,
            )
        })
    }

    fn travel(&self, span: &Range<usize>, axis: &AxisText) -> Result<Travel, FileError> {
        let ends = (
            &axis.travel_min_millidegrees,
            &axis.travel_max_millidegrees,
            &axis.travel_min_counts,
            &axis.travel_max_counts,
        );
        let count = |number| self.number(number, (i32::MIN.into(), i32::MAX.into()));
        match ends {
            (Some(min), Some(max), None, None) => Ok(Travel::Millidegrees {
                min: *min.get_ref(),
                max: *max.get_ref(),
            }),
            (None, None, Some(min), Some(max)) => Ok(Travel::Counts {
                min: count(min)?,
                max: count(max)?,
            }),
            _ => Err(FileError::new(
                self.place(span),
                "travel_min_millidegrees and travel_max_millidegrees, or travel_min_counts and travel_max_counts",
                "other keys of the travel",
                "say where the axis may go, in one of the two units; an axis without ends has -134217728 to 134217727 counts",
            )),
        }
    }

    fn read_back(&self, span: &Range<usize>, axis: &AxisText) -> Result<ReadBack, FileError> {
        let keys = (
            &axis.read_back,
            &axis.read_back_counts,
            &axis.read_back_command_counts,
        );
        match keys {
            (None, None, None) => Ok(ReadBack::CommandCounts),
            (None, Some(read_back_counts), Some(command_counts)) => Ok(ReadBack::Ratio {
                read_back_counts: self.u32(read_back_counts)?,
                command_counts: self.u32(command_counts)?,
            }),
            (Some(word), None, None) => match word.get_ref().as_str() {
                "command-counts" => Ok(ReadBack::CommandCounts),
                "movement-positions" => Ok(ReadBack::MovementPositions),
                "motor-steps" => Ok(ReadBack::MotorSteps),
                _ => Err(self.wrong(
                    &word.span(),
                    "\"command-counts\", \"movement-positions\" or \"motor-steps\"",
                    "turn the shaft once by a command and compare",
                )),
            },
            _ => Err(FileError::new(
                self.place(span),
                "read_back, or read_back_counts and read_back_command_counts",
                "other keys of the read-back",
                "keep one of the two",
            )),
        }
    }

    fn polls(&self, axis: &AxisText) -> Result<Polls, FileError> {
        let default = Polls::DEFAULT;
        let period = |number: &Option<Number>, default| self.u32_or(number.as_ref(), default);
        Ok(Polls {
            status_us: period(&axis.status_poll_us, default.status_us)?,
            position_us: period(&axis.position_poll_us, default.position_us)?,
            torque_us: period(&axis.torque_poll_us, default.torque_us)?,
            speed_us: period(&axis.speed_poll_us, default.speed_us)?,
            counter_us: period(&axis.counter_poll_us, default.counter_us)?,
        })
    }

    fn dialect(&self, word: Option<&Word>) -> Result<Dialect, FileError> {
        let Some(word) = word else {
            return Ok(Dialect::Detect);
        };
        match word.get_ref().as_str() {
            "detect" => Ok(Dialect::Detect),
            "1.2A" => Ok(Dialect::V1_2A),
            "1.6A" => Ok(Dialect::V1_6A),
            _ => Err(self.wrong(
                &word.span(),
                "\"detect\", \"1.2A\" or \"1.6A\"",
                "`motionctl scan` shows the revision of a drive",
            )),
        }
    }
}
