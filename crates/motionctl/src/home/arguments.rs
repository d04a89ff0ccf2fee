//! Options of `motionctl home`.

use std::path::PathBuf;

use clap::ValueEnum;
use dyn_can::{DriveId, GearNumber, PdStep};
use homing::Direction;

use super::error::HomeError;
use crate::drive_ids::drive_id;
use crate::link::LinkOptions;
use crate::station::AxisOptions;

const EXAMPLES: &str = "\
Examples:
  motionctl home --slcan /dev/ttyACM0 --drive 3 --method stop --direction negative --max-turns 4 --travel 0:3.5 --origins machine.toml
  motionctl home --can can0 --drive 3 --method here --travel -1:1 --origins machine.toml
  motionctl home --slcan /dev/ttyACM0 --drive 3 --method switch --direction positive --switch-input /dev/ttyUSB1

stop: slowly against a hard stop, until torque and following error both say that the axis is in contact; back, once more at --slow-rpm, back.
switch: until the switch is operated, back, slowly to its edge, back. An adapter has no inputs: a program writes the level of the switch to
--switch-input, 1 or 0 on a line of its own, at each change and at least five times a second.
here: nothing moves and nothing is enabled; the axis stands at its reference.
The reference is at --reference of the axis, which may be within --travel from then on. The origin is kept in --origins, for `jog` and `run`,
until the drive loses its power. Over CAN only: the serial protocol cannot stream.

Exit status: 0 found, and kept where --origins says; 1 not found, or the drive did not confirm that it is disabled; 2 not confirmed, or
options that cannot work, and nothing has moved; 3 the link failed; 130 stopped by Ctrl-C.";

/// How the reference is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MethodOption {
    /// By torque, at a hard stop.
    Stop,
    /// At the edge of a switch.
    Switch,
    /// Where the axis stands.
    Here,
}

impl MethodOption {
    pub(super) const fn word(self) -> &'static str {
        match self {
            Self::Stop => "stop",
            Self::Switch => "switch",
            Self::Here => "here",
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum DirectionOption {
    /// Clockwise seen from the shaft, towards larger counts.
    Positive,
    /// Counter-clockwise, towards smaller counts.
    Negative,
}

impl From<DirectionOption> for Direction {
    fn from(option: DirectionOption) -> Self {
        match option {
            DirectionOption::Positive => Self::Positive,
            DirectionOption::Negative => Self::Negative,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LevelOption {
    /// 1 while it is operated.
    High,
    /// 0 while it is operated, as a normally closed switch.
    Low,
}

/// Options of `motionctl home`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(super) link: LinkOptions,
    #[command(flatten)]
    pub(super) axes: AxisOptions,
    /// Id of the drive.
    #[arg(long, value_name = "ID", value_parser = drive_id)]
    pub(super) drive: DriveId,
    /// How the reference is found.
    #[arg(long, value_enum)]
    pub(super) method: MethodOption,
    /// Where the stop or the switch is.
    #[arg(long, value_enum, required_if_eq_any([("method", "stop"), ("method", "switch")]))]
    pub(super) direction: Option<DirectionOption>,
    /// Farthest way of the search in motor turns, at most 100.
    #[arg(long, value_name = "TURNS", required_if_eq_any([("method", "stop"), ("method", "switch")]), value_parser = turns)]
    pub(super) max_turns: Option<f64>,
    /// Speed of the search in rpm, at most 120.
    #[arg(long, value_name = "RPM", default_value = "15", value_parser = rpm)]
    pub(super) rpm: f64,
    /// Speed of the second approach in rpm.
    #[arg(long, value_name = "RPM", default_value = "3", value_parser = rpm)]
    pub(super) slow_rpm: f64,
    /// Fastest change of the speed in r/min per second; also of the ramp with which it stops.
    #[arg(long, value_name = "RPM_PER_S", default_value = "300", value_parser = acceleration)]
    pub(super) max_acceleration: f64,
    /// Torque of a contact in percent of the drive's peak: more than the axis needs to move, less than its mechanics bear.
    #[arg(long, value_name = "PERCENT", default_value = "15", value_parser = percent)]
    pub(super) torque: f64,
    /// Torque that ends the search at once, in percent of the peak.
    #[arg(long, value_name = "PERCENT", default_value = "80", value_parser = percent)]
    pub(super) max_torque: f64,
    /// Following error of a contact in degrees of the motor: more than the lag of the axis while it moves.
    #[arg(long, value_name = "DEGREES", default_value = "3", value_parser = degrees)]
    pub(super) contact_degrees: f64,
    /// Following error that ends the search, in degrees of the motor.
    #[arg(long, value_name = "DEGREES", default_value = "45", value_parser = degrees)]
    pub(super) max_degrees: f64,
    /// How far the axis backs off, in motor turns.
    #[arg(long, value_name = "TURNS", default_value = "0.05", value_parser = turns)]
    pub(super) back_off: f64,
    /// Where the reference is on the axis, in motor turns from its zero.
    #[arg(long, value_name = "TURNS", default_value = "0", allow_hyphen_values = true, value_parser = place)]
    pub(super) reference: f64,
    /// Where the axis may be from then on, in motor turns from its zero, as in 0:3.5. Required with --origins.
    #[arg(long, value_name = "MIN:MAX", allow_hyphen_values = true, value_parser = travel)]
    pub(super) travel: Option<(f64, f64)>,
    /// Level of the switch while it is operated.
    #[arg(long, value_enum, default_value = "high")]
    pub(super) switch_active: LevelOption,
    /// Where the levels of the switch are read from: a pipe or a terminal, or - for standard input.
    #[arg(long, value_name = "PATH", required_if_eq("method", "switch"))]
    pub(super) switch_input: Option<PathBuf>,
    /// File of software origins in which the result is kept, in TOML; other drives in it stay.
    #[arg(long, value_name = "FILE.toml", requires = "travel")]
    pub(super) origins: Option<PathBuf>,
    /// Make the place where the axis rests the drive's own zero too, disabled and at standstill: one write of its EEPROM.
    #[arg(long)]
    pub(super) in_drive: bool,
    /// Gear number that the drive must have, 500..=16384. Default: the one that it reports.
    #[arg(long, value_name = "NUMBER", value_parser = gear_number)]
    pub(super) gear_number: Option<GearNumber>,
    /// Move and write without asking.
    #[arg(long)]
    pub(super) yes: bool,
    /// Show the frames and send nothing.
    #[arg(long)]
    pub(super) dry_run: bool,
    /// Print the result as JSON.
    #[arg(long)]
    pub(super) json: bool,
}

impl Arguments {
    /// What the options cannot say together.
    pub(super) fn check(&self) -> Result<(), HomeError> {
        if self.method != MethodOption::Switch && self.switch_input.is_some() {
            return Err(HomeError::SwitchWithoutMethod);
        }
        if self.torque > self.max_torque {
            return Err(HomeError::Order {
                what: "--torque",
                than: "--max-torque",
                actual: self.torque,
                most: self.max_torque,
            });
        }
        if self.contact_degrees >= self.max_degrees {
            return Err(HomeError::Order {
                what: "--contact-degrees",
                than: "--max-degrees",
                actual: self.contact_degrees,
                most: self.max_degrees,
            });
        }
        Ok(())
    }

    pub(super) fn moves(&self) -> bool {
        self.method != MethodOption::Here
    }

    /// A count in the direction of the search, for `--dry-run`.
    pub(super) fn first_step(&self) -> PdStep {
        let direction = self.direction.map_or(Direction::Positive, Direction::from);
        PdStep::new(direction.sign()).unwrap_or(PdStep::ZERO)
    }

    pub(super) fn question(&self) -> String {
        let drive = self.drive;
        let in_drive = if self.in_drive {
            " It will store where it rests as its own zero, in its EEPROM; in absolute mode its motor MOVES there at each power-on."
        } else {
            ""
        };
        let Some(direction) = self.direction.filter(|_| self.moves()) else {
            return format!(
                "The present position of drive {drive} will be its reference, at {} turns of the axis; nothing moves.{in_drive} Is it there?",
                self.reference
            );
        };
        let way = match direction {
            DirectionOption::Positive => "clockwise",
            DirectionOption::Negative => "counter-clockwise",
        };
        let what = match self.method {
            MethodOption::Switch => "to a switch".to_owned(),
            _ => format!(
                "AGAINST A STOP with {} % of its peak torque or more",
                self.torque
            ),
        };
        format!(
            "The motor of drive {drive} will TURN {way}, {what}, by up to {} turns at {} r/min.{in_drive} Is everybody clear of the machine?",
            self.max_turns.unwrap_or_default(),
            self.rpm
        )
    }
}

fn within(text: &str, least: f64, most: f64, unit: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if (least..=most).contains(&number) => Ok(number),
        _ => Err(format!("must be {least}..={most} {unit}, got {text}")),
    }
}

fn turns(text: &str) -> Result<f64, String> {
    within(text, 0.001, 100.0, "turns")
}

fn place(text: &str) -> Result<f64, String> {
    within(text, -1_000.0, 1_000.0, "turns")
}

fn rpm(text: &str) -> Result<f64, String> {
    within(text, 0.5, 120.0, "rpm")
}

fn acceleration(text: &str) -> Result<f64, String> {
    within(text, 1.0, 100_000.0, "r/min per second")
}

fn percent(text: &str) -> Result<f64, String> {
    within(text, 1.0, 100.0, "%")
}

fn degrees(text: &str) -> Result<f64, String> {
    within(text, 0.1, 170.0, "degrees")
}

fn travel(text: &str) -> Result<(f64, f64), String> {
    let expected = || format!("expected MIN:MAX in turns, MIN below MAX, as in 0:3.5, got {text}");
    let (min, max) = text.split_once(':').ok_or_else(expected)?;
    let (min, max) = (place(min)?, place(max)?);
    if min >= max {
        return Err(expected());
    }
    Ok((min, max))
}

fn gear_number(text: &str) -> Result<GearNumber, String> {
    let number = text.parse().map_err(|_| "expected a number".to_owned())?;
    GearNumber::new(number).map_err(|error| error.to_string())
}
