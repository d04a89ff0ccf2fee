//! Writes a file of settings, with comments that explain the numbers.

use std::fmt::Write as _;

use toml::value::Datetime;

use super::{DriveSettings, FORMAT};
use crate::drives::Parameter;

/// Where and when the settings were read.
#[derive(Debug, Clone)]
pub(crate) struct Origin {
    /// Name and version of the tool.
    pub(crate) tool: String,
    pub(crate) date: Datetime,
}

const BEGIN: &str = "\
# Settings of DYN servo drives. `motionctl restore` compares them with the drives and writes only what differs.
#
# Each number is the one that the drive stores, and `restore` reads nothing else. Behind it is what it means in units.
#   config             bits 1-0: commands by link (0), CW/CCW pulses (1), pulse and direction (2), analog input (3); bit 2: absolute
#                      mode; bits 4-3: position (0), speed (1) or torque servo (2); bit 5: servo free
#   main-gain, speed-gain, integration-gain: no unit
#   torque-filter      corner frequency, 26 rad/s for each step
#   max-speed          of built-in moves: (value + 3)^2 / 16 * 12.21 rpm * 4096 / gear-number
#   max-acceleration   of built-in moves: value * 635.78 rpm/s * 4096 / gear-number
#   on-position-range  value * 360 / 16384 degrees of the motor; 127 also makes an output the brake output
#   gear-number        4 counts a turn for each step, gear ratio 4096 / value
#   line-number        500 to 4095, explained by no document; 0: the drive has none
";

/// The text of a file.
pub(crate) fn write(origin: &Origin, drives: &[DriveSettings]) -> String {
    let Origin { tool, date } = origin;
    let mut text = format!("{BEGIN}\nformat = {FORMAT}\ntool = \"{tool}\"\ndate = {date}\n");
    for drive in drives {
        // A text takes whatever is written to it.
        let _ = write_drive(&mut text, drive);
    }
    text
}

fn write_drive(text: &mut String, drive: &DriveSettings) -> std::fmt::Result {
    writeln!(
        text,
        "\n[[drive]]\nid = {}\nrevision = \"{}\"",
        drive.id, drive.revision
    )?;
    for setting in &drive.settings {
        let (parameter, value) = (setting.parameter, setting.value);
        let number = match parameter {
            Parameter::Config => format!("0x{value:02X}"),
            _ => value.to_string(),
        };
        write!(text, "{parameter} = {number}")?;
        if let Some(meaning) = parameter.meaning(value, drive.gear()) {
            write!(text, "  # {meaning}")?;
        }
        writeln!(text)?;
    }
    if drive.value(Parameter::LineNumber).is_none() {
        let (name, why) = match drive.revision {
            super::FileRevision::Unknown => ("# ", "the serial port does not reach it"),
            super::FileRevision::Can(_) => ("", "the drive has none"),
        };
        writeln!(text, "{name}{} = 0  # {why}", Parameter::LineNumber)?;
    }
    Ok(())
}
