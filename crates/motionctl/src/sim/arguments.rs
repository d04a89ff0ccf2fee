//! Options of `motionctl sim`.

use std::path::PathBuf;

use can_motion::PollPeriods;
use clap::ValueEnum;
use drive_sim::{BitRate, ResponseDelay, TxOrder};
use dyn_can::{DriveId, Revision, StepLimit};

use super::bench::{MOST_AXES, Setup};
use super::error::SimError;
use crate::trajectory::{AxisScale, ColumnChoice, Interpolation, TrajectoryError, Unit};

const EXAMPLES: &str = "\
Examples:
  cargo sim                                     the built-in four-axis pick-and-place
  cargo sim -- --trajectory plan.csv --axes 6   the first six columns behind time, in degrees
  cargo sim -- --trajectory plan.csv --columns shoulder,elbow --gear-ratio 50
  cargo sim -- --candump run.log                and the bus traffic as a candump log

Exit status: 0 every promise kept, 1 a promise broken (a sum differs, a cycle was late, an axis
faulted), 2 the input cannot be used and nothing was run.";

/// Options of `motionctl sim`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Motion file: time and one position an axis in each line, separated by commas, semicolons, tabs or spaces. The
    /// motion starts where the drives stand. Without it the built-in pick-and-place runs.
    #[arg(long, value_name = "FILE")]
    pub(crate) trajectory: Option<PathBuf>,
    /// Position columns: names from the header line, numbers from 1, or ranges as in 2-7.
    #[arg(long, value_name = "COLUMN", value_delimiter = ',')]
    columns: Vec<String>,
    /// Number of axes, taken from the left. Default: every column but time, less columns that are velocities.
    #[arg(long, value_name = "N")]
    axes: Option<usize>,
    /// Time column: a name or a number from 1. Default: the first.
    #[arg(long, value_name = "COLUMN")]
    time_column: Option<String>,
    /// Unit of the time column.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) time_unit: TimeUnit,
    /// Unit of the positions.
    #[arg(long, value_enum, default_value_t)]
    unit: Unit,
    /// Motor turns for one turn of the output, one for all axes or one each; negative reverses.
    #[arg(
        long,
        value_name = "RATIO",
        value_delimiter = ',',
        default_value = "1",
        value_parser = scale_factor,
        allow_hyphen_values = true
    )]
    gear_ratio: Vec<f64>,
    /// Command counts of one motor turn, one for all axes or one each: 4 times the drive's gear number.
    #[arg(
        long,
        value_name = "COUNTS",
        value_delimiter = ',',
        default_value = "16384",
        value_parser = scale_factor
    )]
    counts_per_turn: Vec<f64>,
    /// How to go from point to point.
    #[arg(long, value_enum, default_value_t)]
    pub(crate) interpolation: Interpolation,
    /// Drive ids in the order of the axes. Default: 1, 2, 3 ...
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    drives: Vec<i32>,
    /// Cycle time in microseconds.
    #[arg(long, value_name = "US", default_value_t = 1_000)]
    cycle_us: u32,
    /// Bit rate in kbit/s: 10, 20, 50, 125, 250, 500, 800 or 1000.
    #[arg(long, value_name = "KBIT", default_value_t = 1_000)]
    bit_rate: u32,
    /// Largest step of an axis in one cycle, in command counts.
    #[arg(long, value_name = "COUNTS", default_value_t = 16_384)]
    max_step: i32,
    /// Status polls of each axis in Hz, 0 for none.
    #[arg(long, value_name = "HZ", default_value_t = 50)]
    status_hz: u32,
    /// Position polls of each axis in Hz, 0 for none.
    #[arg(long, value_name = "HZ", default_value_t = 50)]
    position_hz: u32,
    /// Mean response delay of the drives in microseconds.
    #[arg(long, value_name = "US", default_value_t = 500)]
    response_us: u32,
    /// Spread of the response delay around its mean in percent.
    #[arg(long, value_name = "PERCENT", default_value_t = 25)]
    response_spread: u32,
    /// Revision of the simulated drives.
    #[arg(long, value_enum, default_value_t)]
    revision: RevisionOption,
    /// Order in which the master's controller sends its mailboxes.
    #[arg(long, value_enum, default_value_t)]
    tx_order: TxOrderOption,
    /// Seed of the response delays.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Write the bus traffic as a candump log; the time is the end of each frame.
    #[arg(long, value_name = "FILE")]
    pub(crate) candump: Option<PathBuf>,
    /// Print the summary as JSON, and no progress.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Unit of the time column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum TimeUnit {
    /// Seconds.
    #[default]
    S,
    /// Milliseconds.
    Ms,
    /// Microseconds.
    Us,
}

impl TimeUnit {
    /// One unit in seconds.
    pub(crate) const fn seconds(self) -> f64 {
        match self {
            Self::S => 1.0,
            Self::Ms => 1e-3,
            Self::Us => 1e-6,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum RevisionOption {
    /// CAN specification 1.2A.
    #[value(name = "1.2A", alias = "1.2a")]
    V1_2A,
    /// CAN specification 1.6A.
    #[default]
    #[value(name = "1.6A", alias = "1.6a")]
    V1_6A,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum TxOrderOption {
    /// In the order of the requests, as bxCAN with TXFP or FDCAN in FIFO mode.
    #[default]
    Fifo,
    /// The lowest identifier first, as bxCAN out of reset.
    Identifier,
}

impl Arguments {
    pub(crate) fn column_choice(&self) -> ColumnChoice {
        ColumnChoice {
            time: self.time_column.clone(),
            positions: self.columns.clone(),
            axes: self.axes,
        }
    }

    pub(crate) fn scales(&self, axes: usize) -> Result<Vec<AxisScale>, TrajectoryError> {
        let gear_ratios = for_each_axis("--gear-ratio", &self.gear_ratio, axes)?;
        let counts = for_each_axis("--counts-per-turn", &self.counts_per_turn, axes)?;
        let scale = |(&gear_ratio, &counts_per_turn): (&f64, &f64)| AxisScale {
            unit: self.unit,
            gear_ratio,
            counts_per_turn,
        };
        Ok(gear_ratios.iter().zip(&counts).map(scale).collect())
    }

    pub(crate) fn setup(&self, axes: usize) -> Result<Setup, SimError> {
        let period_us = |hz: u32| 1_000_000_u32.checked_div(hz);
        Ok(Setup {
            drives: self.drive_ids(axes)?,
            cycle_us: self.cycle_us,
            bit_rate: BitRate::from_kbit_per_s(self.bit_rate).map_err(SimError::BitRate)?,
            max_step: StepLimit::new(self.max_step).map_err(|source| SimError::Option {
                name: "--max-step",
                source,
            })?,
            polls: PollPeriods {
                status_us: period_us(self.status_hz),
                position_us: period_us(self.position_hz),
                ..PollPeriods::OFF
            },
            response_delay: self.response_delay()?,
            revision: match self.revision {
                RevisionOption::V1_2A => Revision::V1_2A,
                RevisionOption::V1_6A => Revision::V1_6A,
            },
            tx_order: match self.tx_order {
                TxOrderOption::Fifo => TxOrder::Fifo,
                TxOrderOption::Identifier => TxOrder::ByIdentifier,
            },
            seed: self.seed,
        })
    }

    fn response_delay(&self) -> Result<ResponseDelay, SimError> {
        let delay_ns = u64::from(self.response_us) * 1_000;
        let spread_ns = delay_ns * u64::from(self.response_spread) / 100;
        delay_ns
            .checked_sub(spread_ns)
            .and_then(|least_ns| ResponseDelay::between(least_ns, delay_ns + spread_ns).ok())
            .ok_or(SimError::ResponseSpread {
                actual_percent: self.response_spread,
            })
    }

    fn drive_ids(&self, axes: usize) -> Result<Vec<DriveId>, SimError> {
        if axes > MOST_AXES {
            return Err(SimError::AxisCount {
                most: MOST_AXES,
                actual: axes,
            });
        }
        if self.drives.is_empty() {
            return Ok(DriveId::all().take(axes).collect());
        }
        if self.drives.len() != axes {
            return Err(SimError::DriveCount {
                expected: axes,
                actual: self.drives.len(),
            });
        }
        let ids = self
            .drives
            .iter()
            .map(|&id| DriveId::new(id))
            .collect::<Result<_, _>>();
        ids.map_err(|source| SimError::Option {
            name: "--drives",
            source,
        })
    }
}

/// A factor that neither loses nor invents a motion.
fn scale_factor(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(factor) if factor.is_finite() && factor != 0.0 => Ok(factor),
        _ => Err("expected a finite number other than 0".to_owned()),
    }
}

/// One value for all axes, or one each.
fn for_each_axis(
    what: &'static str,
    values: &[f64],
    axes: usize,
) -> Result<Vec<f64>, TrajectoryError> {
    match values {
        [all] => Ok(vec![*all; axes]),
        each if each.len() == axes => Ok(each.to_vec()),
        _ => Err(TrajectoryError::ListLength {
            what,
            expected: axes,
            actual: values.len(),
        }),
    }
}
