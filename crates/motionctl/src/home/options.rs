//! Options of a homing that every family has.

use std::path::PathBuf;

use clap::ValueEnum;
use homing::{Config, Direction, HardStop, Level, Method, Switch, Travel, Watch};

use super::error::HomeError;
use super::scale::Scale;

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
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Stop => "stop",
            Self::Switch => "switch",
            Self::Here => "here",
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum DirectionOption {
    /// Towards larger counts: clockwise seen from the shaft, unless a hub motor was told otherwise (2001h).
    Positive,
    /// Towards smaller counts.
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

/// What is searched for, how fast, how hard and how far.
#[derive(Debug, clap::Args)]
pub(crate) struct SearchOptions {
    /// How the reference is found.
    #[arg(long, value_enum)]
    pub(crate) method: MethodOption,
    /// Where the stop or the switch is.
    #[arg(long, value_enum, required_if_eq_any([("method", "stop"), ("method", "switch")]))]
    pub(crate) direction: Option<DirectionOption>,
    /// Farthest way of the search in motor turns, at most 100.
    #[arg(long, value_name = "TURNS", required_if_eq_any([("method", "stop"), ("method", "switch")]), value_parser = turns)]
    pub(crate) max_turns: Option<f64>,
    /// Speed of the search in rpm, at most 120.
    #[arg(long, value_name = "RPM", default_value = "15", value_parser = rpm)]
    pub(crate) rpm: f64,
    /// Speed of the second approach in rpm.
    #[arg(long, value_name = "RPM", default_value = "3", value_parser = rpm)]
    pub(crate) slow_rpm: f64,
    /// Fastest change of the speed in r/min per second; also of the ramp with which it stops.
    #[arg(long, value_name = "RPM_PER_S", default_value = "300", value_parser = acceleration)]
    pub(crate) max_acceleration: f64,
    /// Torque of a contact in percent of the drive's peak: more than the axis needs to move, less than its mechanics bear.
    #[arg(long, value_name = "PERCENT", default_value = "15", value_parser = percent)]
    pub(crate) torque: f64,
    /// Torque that ends the search at once, in percent of the peak.
    #[arg(long, value_name = "PERCENT", default_value = "80", value_parser = percent)]
    pub(crate) max_torque: f64,
    /// Following error of a contact in degrees of the motor: more than the lag of the axis while it moves [default: 3; hub motors: 15].
    #[arg(long, value_name = "DEGREES", value_parser = degrees)]
    contact_degrees: Option<f64>,
    /// Following error that ends the search, in degrees of the motor [default: 45; hub motors: 90].
    #[arg(long, value_name = "DEGREES", value_parser = degrees)]
    max_degrees: Option<f64>,
    /// How far the axis backs off, in motor turns.
    #[arg(long, value_name = "TURNS", default_value = "0.05", value_parser = turns)]
    pub(crate) back_off: f64,
    /// Where the reference is on the axis, in motor turns from its zero.
    #[arg(long, value_name = "TURNS", default_value = "0", allow_hyphen_values = true, value_parser = place)]
    pub(crate) reference: f64,
    /// Where the axis may be from then on, in motor turns from its zero, as in 0:3.5. Required with --origins.
    #[arg(long, value_name = "MIN:MAX", allow_hyphen_values = true, value_parser = travel)]
    pub(crate) travel: Option<(f64, f64)>,
    /// Level of the switch while it is operated.
    #[arg(long, value_enum, default_value = "high")]
    pub(crate) switch_active: LevelOption,
    /// Where the levels of the switch are read from: a pipe or a terminal, or - for standard input.
    #[arg(long, value_name = "PATH", required_if_eq("method", "switch"))]
    pub(crate) switch_input: Option<PathBuf>,
}

/// A sense of rotation, seen from the shaft.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Turning {
    Clockwise,
    CounterClockwise,
}

/// What the options leave to the family of the drive.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Family {
    /// Defaults of --contact-degrees and --max-degrees.
    pub(crate) contact_degrees: f64,
    pub(crate) max_degrees: f64,
    /// A reading may be this old: a PC lets a program wait, and adapters on USB hold bytes back.
    pub(crate) max_age_us: u32,
    /// By how much a position may be off at rest.
    pub(crate) still_counts: u32,
}

impl SearchOptions {
    /// What the options cannot say together.
    ///
    /// # Errors
    /// [`HomeError`]; nothing was sent.
    pub(crate) fn check(&self, family: &Family) -> Result<(), HomeError> {
        if self.method != MethodOption::Switch && self.switch_input.is_some() {
            return Err(HomeError::SwitchWithoutMethod);
        }
        let order = |what, than, actual, most| HomeError::Order {
            what,
            than,
            actual,
            most,
        };
        if self.torque > self.max_torque {
            return Err(order(
                "--torque",
                "--max-torque",
                self.torque,
                self.max_torque,
            ));
        }
        let (contact, most) = (self.contact_degrees(family), self.max_degrees(family));
        if contact >= most {
            return Err(order("--contact-degrees", "--max-degrees", contact, most));
        }
        Ok(())
    }

    /// Whether the motor turns.
    pub(crate) fn moves(&self) -> bool {
        self.method != MethodOption::Here
    }

    fn contact_degrees(&self, family: &Family) -> f64 {
        self.contact_degrees.unwrap_or(family.contact_degrees)
    }

    /// Following error that ends the search.
    pub(crate) fn max_degrees(&self, family: &Family) -> f64 {
        self.max_degrees.unwrap_or(family.max_degrees)
    }

    /// 1 or -1, for `--dry-run`.
    pub(crate) fn sign(&self) -> i32 {
        self.direction
            .map_or(Direction::Positive, Direction::from)
            .sign()
    }

    /// What is asked before the motor of `who`, as in `drive 3`, turns; `stores` is what else will happen, `positive` the way towards
    /// larger counts.
    pub(crate) fn question(&self, who: &str, stores: &str, positive: Turning) -> String {
        let Some(direction) = self.direction.filter(|_| self.moves()) else {
            return format!(
                "The present position of {who} will be its reference, at {} turns of the axis; nothing moves.{stores} Is it there?",
                self.reference
            );
        };
        let way = match (direction, positive) {
            (DirectionOption::Positive, Turning::Clockwise)
            | (DirectionOption::Negative, Turning::CounterClockwise) => "clockwise",
            _ => "counter-clockwise",
        };
        let what = match self.method {
            MethodOption::Switch => "to a switch".to_owned(),
            _ => format!(
                "AGAINST A STOP with {} % of its peak torque or more",
                self.torque
            ),
        };
        format!(
            "The motor of {who} will TURN {way}, {what}, by up to {} turns at {} r/min.{stores} Is everybody clear of the machine?",
            self.max_turns.unwrap_or_default(),
            self.rpm
        )
    }

    /// The homing that the options describe.
    ///
    /// # Errors
    /// [`HomeError::Limits`] for a speed that set-points cannot express.
    pub(crate) fn config(&self, scale: &Scale, family: &Family) -> Result<Config, HomeError> {
        let way = scale.counts(self.max_turns.unwrap_or_default());
        let (min_counts, max_counts) = match self.travel {
            Some((min, max)) => (scale.counts(min), scale.counts(max)),
            None => (i32::MIN / 4, i32::MAX / 4),
        };
        let acceleration = self.max_acceleration;
        Ok(Config {
            method: self.method_config(scale, family),
            cycle_us: scale.cycle_us,
            search: scale.limits(self.rpm, acceleration)?,
            slow: scale.limits(self.slow_rpm, acceleration)?,
            way_counts: way.unsigned_abs(),
            back_off_counts: scale.counts(self.back_off).unsigned_abs(),
            reference_counts: scale.counts(self.reference),
            travel: Travel {
                min_counts,
                max_counts,
            },
            watch: Watch {
                max_age_us: family.max_age_us,
                still_counts: family.still_counts,
                ..Watch::DEFAULT
            },
        })
    }

    fn method_config(&self, scale: &Scale, family: &Family) -> Method {
        let permille = |percent: f64| (percent * 10.0).round() as u16;
        let direction = self.direction.unwrap_or(DirectionOption::Positive).into();
        let most_counts = scale.counts_of_degrees(self.max_degrees(family));
        let contact_counts = scale.counts_of_degrees(self.contact_degrees(family));
        match self.method {
            MethodOption::Here => Method::Here,
            MethodOption::Stop => Method::HardStop(HardStop {
                direction,
                contact_permille: permille(self.torque),
                most_permille: permille(self.max_torque),
                contact_counts,
                most_counts,
                repeat_counts: contact_counts,
            }),
            MethodOption::Switch => Method::Switch(Switch {
                direction,
                operated: match self.switch_active {
                    LevelOption::High => Level::High,
                    LevelOption::Low => Level::Low,
                },
                most_counts,
                most_permille: Some(permille(self.max_torque)),
            }),
        }
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
