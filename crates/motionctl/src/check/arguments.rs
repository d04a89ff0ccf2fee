//! Options of `motionctl check`.

use std::path::PathBuf;

use can_motion::PollPeriods;
use drive_sim::BitRate;

use crate::station::{AxisOptions, MotionLimits};
use crate::trajectory::MotionOptions;
use crate::virtual_drives::bit_rate;

const EXAMPLES: &str = "\
Examples:
  motionctl check plan.csv                            travel, speeds, bus load, duration, against the limits of `run`
  motionctl check plan.csv --max-rpm 1000 --svg plan.svg
  motionctl check plan.csv --drives 5,7 --bit-rate 500 --cycle-us 2000 --json

Exit status: 0 `run` would take it with the same options, 1 it exceeds a limit or the bus, 2 the file cannot be used.";

/// Options of `motionctl check`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Motion file; the same as --trajectory. Without it the built-in pick-and-place is checked.
    #[arg(value_name = "FILE", conflicts_with = "trajectory")]
    file: Option<PathBuf>,
    #[command(flatten)]
    motion: MotionOptions,
    #[command(flatten)]
    pub(super) limits: MotionLimits,
    /// Cycle time in microseconds.
    #[arg(long, value_name = "US", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(250..=1_000_000))]
    pub(super) cycle_us: u32,
    /// Bit rate of the bus in kbit/s.
    #[arg(long, value_name = "KBIT", default_value = "1000", value_parser = bit_rate)]
    pub(super) bit_rate: BitRate,
    /// Status polls of each axis in Hz, 0 for none.
    #[arg(long, value_name = "HZ", default_value_t = 50)]
    status_hz: u32,
    /// Position polls of each axis in Hz, 0 for none.
    #[arg(long, value_name = "HZ", default_value_t = 50)]
    position_hz: u32,
    #[command(flatten)]
    pub(super) axes: AxisOptions,
    /// Draw positions and speeds of every axis into this file.
    #[arg(long, value_name = "FILE")]
    pub(super) svg: Option<PathBuf>,
    /// Print the result as JSON.
    #[arg(long)]
    pub(super) json: bool,
}

impl Arguments {
    pub(super) fn motion(&self) -> MotionOptions {
        let mut motion = self.motion.clone();
        if self.file.is_some() {
            motion.trajectory.clone_from(&self.file);
        }
        motion
    }

    pub(super) fn polls(&self) -> PollPeriods {
        let period_us = |hz: u32| 1_000_000_u32.checked_div(hz);
        PollPeriods {
            status_us: period_us(self.status_hz),
            position_us: period_us(self.position_hz),
            ..PollPeriods::OFF
        }
    }
}
