//! What the shafts of simulated drives meet, and how their motors answer.

use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use drive_sim::{
    DynDriveConfig, EndStops, Mechanics, ServoLoop, Switch, SwitchSide, ZlacDriveConfig, ZlacLoop,
    ZlacMechanics,
};
use dyn_can::units;

use super::error::BenchError;
use crate::host_port::Place;
use crate::system::Pty;

/// What the shafts meet, and how the motors answer.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct MechanicsOptions {
    /// End stops of every shaft, in turns from where it stands at the start, as in -2:3.
    #[arg(long, value_name = "LOW:HIGH", allow_hyphen_values = true, value_parser = stops)]
    stops: Option<(f64, f64)>,
    /// A switch beside the shaft of each drive, so many turns from where it stands at the start; operated from there on, away from the start.
    #[arg(long, value_name = "TURNS", allow_hyphen_values = true, value_parser = place)]
    switch_at: Option<f64>,
    /// Terminal on which the level of the switch of the first drive is told, 1 or 0 a line: a link that does not exist yet.
    #[arg(long, value_name = "PATH", requires = "switch_at")]
    switch_lines: Option<PathBuf>,
    /// The gains change how the motors answer, as in a loop that somebody has to tune.
    #[arg(long)]
    with_gains: bool,
}

impl MechanicsOptions {
    /// A drive with these mechanics.
    pub(super) fn on(&self, config: DynDriveConfig) -> DynDriveConfig {
        let turn = f64::from(units::command_counts_per_turn(config.group3.gear_number));
        let counts = |turns: f64| (turns * turn).round() as i64;
        DynDriveConfig {
            mechanics: Mechanics {
                stops: self.stops.map(|(low, high)| EndStops {
                    low_counts: counts(low),
                    high_counts: counts(high),
                }),
                switch: self.switch_at.map(|at| Switch {
                    at_counts: counts(at),
                    side: if at < 0.0 {
                        SwitchSide::Below
                    } else {
                        SwitchSide::Above
                    },
                }),
            },
            servo_loop: if self.with_gains {
                ServoLoop::WithGains
            } else {
                ServoLoop::Smooth
            },
            ..config
        }
    }

    /// The terminal of the switch, where the user wants one.
    ///
    /// # Errors
    /// [`BenchError::Create`].
    pub(crate) fn switch_output(&self) -> Result<Option<SwitchOutput>, BenchError> {
        let create = |link: &PathBuf| {
            SwitchOutput::create(link).map_err(|source| BenchError::Create {
                place: Place::Path(link.clone()),
                source,
            })
        };
        self.switch_lines.as_ref().map(create).transpose()
    }

    /// A hub motor with these mechanics.
    pub(crate) fn on_wheel(&self, config: ZlacDriveConfig) -> ZlacDriveConfig {
        ZlacDriveConfig {
            mechanics: ZlacMechanics {
                stops_turns: self.stops,
                switch_turns: self.switch_at,
                control: if self.with_gains {
                    ZlacLoop::WithGains
                } else {
                    ZlacLoop::Ideal
                },
                ..config.mechanics
            },
            ..config
        }
    }
}

/// How often the level is told, whether it changes or not.
const PERIOD: Duration = Duration::from_millis(50);

/// A terminal on which the level of a switch is told.
#[derive(Debug)]
pub(crate) struct SwitchOutput {
    pty: Pty,
    told: Option<(bool, Instant)>,
}

impl SwitchOutput {
    fn create(link: &Path) -> io::Result<Self> {
        Ok(Self {
            pty: Pty::create(link)?,
            told: None,
        })
    }

    /// Tells the level when it has changed, and from time to time; what nobody reads is lost.
    pub(crate) fn tell(&mut self, is_operated: bool) -> io::Result<()> {
        let is_due = self
            .told
            .is_none_or(|(level, at)| level != is_operated || at.elapsed() >= PERIOD);
        if is_due {
            self.told = Some((is_operated, Instant::now()));
            self.pty.write(if is_operated { b"1\n" } else { b"0\n" })?;
        }
        Ok(())
    }
}

fn stops(text: &str) -> Result<(f64, f64), String> {
    let expected =
        || format!("expected LOW:HIGH in turns with 0 between them, as in -2:3, got {text}");
    let (low, high) = text.split_once(':').ok_or_else(expected)?;
    let (low, high) = (place(low)?, place(high)?);
    if low > 0.0 || high < 0.0 || low >= high {
        return Err(expected());
    }
    Ok((low, high))
}

fn place(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(turns) if turns.abs() <= 1_000.0 => Ok(turns),
        _ => Err(format!("must be -1000..=1000 turns, got {text}")),
    }
}
