//! What a drive tells about itself.

use core::fmt;

use comfy_table::presets::NOTHING;
use comfy_table::{CellAlignment, Table};
use dyn_can::{GearNumber, Revision};
use schemars::JsonSchema;
use serde::Serialize;

use super::Parameter;

/// The state of a drive at one moment; what it did not tell is `None`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub(crate) struct DriveState {
    pub(crate) enabled: Option<bool>,
    pub(crate) on_position: Option<bool>,
    /// A built-in move or wave is under way.
    pub(crate) busy: Option<bool>,
    pub(crate) alarm: Option<String>,
    /// In the unit of the drive's read-back.
    pub(crate) position_counts: Option<i32>,
    pub(crate) speed_rpm: Option<i32>,
    /// Share of the peak current, positive clockwise.
    pub(crate) torque_share: Option<f64>,
    /// The torque is beyond the scale of the drive's revision, so that its share is in doubt.
    pub(crate) torque_in_doubt: bool,
}

/// A parameter as it was read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
struct ParameterReading {
    parameter: Parameter,
    value: i32,
    meaning: Option<String>,
}

/// Everything that was read from one drive.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub(crate) struct Readings {
    drive: u8,
    protocol: String,
    /// The serial port does not tell it.
    #[serde(skip)]
    pub(crate) revision: Option<Revision>,
    pub(crate) state: DriveState,
    parameters: Vec<ParameterReading>,
}

impl Readings {
    /// Puts together what was read; the parameters get their units.
    pub(crate) fn new(
        drive: u8,
        protocol: String,
        state: DriveState,
        mut parameters: Vec<(Parameter, i32)>,
    ) -> Self {
        parameters.sort_unstable();
        let gear = parameters
            .iter()
            .find(|(parameter, _)| *parameter == Parameter::GearNumber)
            .and_then(|&(_, value)| GearNumber::new(value).ok());
        let reading = |(parameter, value): (Parameter, i32)| ParameterReading {
            parameter,
            value,
            meaning: parameter.meaning(value, gear),
        };
        Self {
            drive,
            protocol,
            revision: None,
            state,
            parameters: parameters.into_iter().map(reading).collect(),
        }
    }

    /// The same with the revision of the drive.
    pub(crate) fn of_revision(self, revision: Option<Revision>) -> Self {
        Self { revision, ..self }
    }

    /// A parameter, when the drive has it.
    pub(crate) fn value(&self, wanted: Parameter) -> Option<i32> {
        let mut readings = self.parameters.iter();
        readings
            .find(|reading| reading.parameter == wanted)
            .map(|reading| reading.value)
    }

    /// Every parameter that was read.
    pub(crate) fn values(&self) -> impl Iterator<Item = (Parameter, i32)> + '_ {
        let readings = self.parameters.iter();
        readings.map(|reading| (reading.parameter, reading.value))
    }

    /// The gear number, on which the units of speeds depend.
    pub(crate) fn gear(&self) -> Option<GearNumber> {
        GearNumber::new(self.value(Parameter::GearNumber)?).ok()
    }
}

impl fmt::Display for DriveState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = |state: Option<bool>, yes: &str, no: &str| match state {
            Some(true) => yes.to_owned(),
            Some(false) => no.to_owned(),
            None => "?".to_owned(),
        };
        let number = |value: Option<i32>, unit: &str| {
            value.map_or_else(|| format!("? {unit}"), |value| format!("{value} {unit}"))
        };
        let doubt = if self.torque_in_doubt {
            " (in doubt: beyond its scale)"
        } else {
            ""
        };
        let torque = match self.torque_share {
            None => "? % of peak".to_owned(),
            Some(share) => {
                let direction = match share {
                    share if share > 0.0 => " clockwise",
                    share if share < 0.0 => " counter-clockwise",
                    _ => "",
                };
                format!("{:.1} % of peak{direction}{doubt}", 100.0 * share.abs())
            }
        };
        write!(
            f,
            "{}, {}, {}, {}; position {}, speed {}, torque {torque}",
            word(self.enabled, "enabled", "disabled"),
            self.alarm.as_deref().unwrap_or("no alarm"),
            word(self.on_position, "on position", "not on position"),
            word(self.busy, "busy", "no built-in motion"),
            number(self.position_counts, "counts"),
            number(self.speed_rpm, "rpm"),
        )
    }
}

impl fmt::Display for Readings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "drive {}, {}", self.drive, self.protocol)?;
        writeln!(f, "  {}", self.state)?;
        let mut table = Table::new();
        table.load_style(NOTHING);
        for reading in &self.parameters {
            table.add_row([
                reading.parameter.to_string(),
                reading.value.to_string(),
                reading.meaning.clone().unwrap_or_default(),
            ]);
        }
        if let Some(values) = table.column_mut(1) {
            values.set_cell_alignment(CellAlignment::Right);
        }
        write!(f, "{}", table.trim_fmt())
    }
}
