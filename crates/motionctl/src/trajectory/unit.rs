//! Units of positions and of time.

use core::fmt;

use clap::ValueEnum;
use schemars::JsonSchema;
use serde::Serialize;

/// Unit of the positions in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Unit {
    /// Command counts of the drive.
    Counts,
    /// Degrees at the output.
    #[default]
    #[value(alias = "deg")]
    Degrees,
    /// Radians at the output.
    #[value(alias = "rad")]
    Radians,
    /// Turns at the output.
    Turns,
    /// Millimetres at the output; --mm-per-turn says how many make a turn.
    #[value(alias = "millimetres")]
    Mm,
    /// Speed of a wheel, for hub motors alone.
    #[value(skip)]
    Rpm,
}

impl Unit {
    /// As the command line has it.
    pub(super) const fn option(self) -> &'static str {
        match self {
            Self::Counts => "counts",
            Self::Degrees => "degrees",
            Self::Radians => "radians",
            Self::Turns => "turns",
            Self::Mm => "mm",
            Self::Rpm => "r/min",
        }
    }
}

/// As it stands behind a number.
impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Degrees => "deg",
            Self::Radians => "rad",
            other => other.option(),
        })
    }
}

/// Unit of the time column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum TimeUnit {
    /// Seconds.
    #[default]
    S,
    /// Milliseconds.
    Ms,
    /// Microseconds.
    Us,
    /// Nanoseconds, as ROS writes them.
    Ns,
}

impl TimeUnit {
    pub(super) const ALL: [Self; 4] = [Self::S, Self::Ms, Self::Us, Self::Ns];

    /// So many are a second.
    pub(super) const fn per_second(self) -> u32 {
        match self {
            Self::S => 1,
            Self::Ms => 1_000,
            Self::Us => 1_000_000,
            Self::Ns => 1_000_000_000,
        }
    }
}

impl fmt::Display for TimeUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::S => "s",
            Self::Ms => "ms",
            Self::Us => "us",
            Self::Ns => "ns",
        })
    }
}

/// From the unit of an axis to command counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AxisScale {
    /// Unit of the file.
    pub(crate) unit: Unit,
    /// Motor turns for one turn of the output; negative reverses the direction. Not used with counts.
    pub(crate) gear_ratio: f64,
    /// Command counts of one motor turn.
    pub(crate) counts_per_turn: f64,
    /// Millimetres for one turn of the output. Used with millimetres alone.
    pub(crate) mm_per_turn: f64,
}

impl AxisScale {
    /// Command counts of one unit.
    pub(crate) fn counts_per_unit(&self) -> f64 {
        let of_turn = self.gear_ratio * self.counts_per_turn;
        match self.unit {
            Unit::Counts => 1.0,
            Unit::Degrees => of_turn / 360.0,
            Unit::Radians => of_turn / core::f64::consts::TAU,
            // The speed of a wheel counts as many units as the drive resolves.
            Unit::Turns | Unit::Rpm => of_turn,
            Unit::Mm => of_turn / self.mm_per_turn,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_of_one_turn_is_the_same() {
        let counts = |unit, value: f64| {
            let scale = AxisScale {
                unit,
                gear_ratio: -2.0,
                counts_per_turn: 16_384.0,
                mm_per_turn: 5.0,
            };
            value * scale.counts_per_unit()
        };
        for (unit, one_turn) in [
            (Unit::Degrees, 360.0),
            (Unit::Radians, core::f64::consts::TAU),
            (Unit::Turns, 1.0),
            (Unit::Mm, 5.0),
        ] {
            assert_eq!(counts(unit, one_turn), -32_768.0, "{unit}");
        }
        assert_eq!(counts(Unit::Counts, 7.0), 7.0);
    }
}
