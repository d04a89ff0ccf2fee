//! Options of `motionctl run`.

use std::path::PathBuf;

use can_motion::PollPeriods;

use crate::control::ControlOptions;
use crate::link::BusesOptions;
use crate::recording::RecordingOptions;
use crate::station::{AxisOptions, MotionLimits};
use crate::stream::StreamOptions;
use crate::trajectory::MotionOptions;

const EXAMPLES: &str = "\
Examples:
  motionctl bench --drives 1-4 --slcan /tmp/can-adapter     simulated drives, in another terminal
  motionctl run --slcan /tmp/can-adapter                    the built-in pick-and-place on drives 1 to 4
  motionctl run --slcan /dev/ttyACM0 --trajectory plan.csv --drives 5,7 --axes 2
  motionctl run --can can0 --trajectory plan.csv --cycle-us 2000 --yes --json
  motionctl run --can can0 --report out --mcap run.mcap     a page, and a file for Foxglove and PlotJuggler
  motionctl run --can can0 --drives 1,2 --stream tcp:7001     set-points from another program, see docs/stream.md
  motionctl run --bus can:can0=1,2 --bus can:can1=1,2 --trajectory plan.csv   four columns on two buses
  motionctl run --can can0 --trajectory plan.csv --control unix:/tmp/motion   orders from another program

Drives that are disabled are enabled, follow the motion from where they stand, and are disabled: at the end, after
a fault, after Ctrl-C; a vertical axis without a brake falls then. Drives that are enabled already stay enabled.
Ctrl-C slows down first, a second Ctrl-C stops at once; Ctrl-Z and Ctrl-\\ do the same, because a program that is
paused or killed leaves its drives enabled. A motion that needs more speed, acceleration or way than
--max-rpm, --max-acceleration and --max-turns allow is refused. A PC keeps time as well as it can: cycles that began
late or never are counted and reported, and the axes catch up a quarter faster than the motion is. A recording
that fails stops and says so; the motion goes on.

In a terminal, keys pause with space, change the speed between 0 and 200 % with + - 1 and stop with s; the axes stay on their path,
and an override that would exceed a limit is held to it.

Exit status: 0 the motion is complete, every set-point was sent and everything is recorded, 1 it is not, or a drive
did not confirm that it is disabled, 2 the input cannot be used, or a drive has another scale: nothing was switched, 3 the link failed or
stood still, 130 stopped by Ctrl-C or an order to stop.";

/// Options of `motionctl run`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(super) link: BusesOptions,
    #[command(flatten)]
    pub(super) motion: MotionOptions,
    #[command(flatten)]
    pub(super) stream: StreamOptions,
    #[command(flatten)]
    pub(super) control: ControlOptions,
    #[command(flatten)]
    pub(super) axes: AxisOptions,
    /// Cycle time in microseconds.
    #[arg(long, value_name = "US", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(250..=1_000_000))]
    pub(super) cycle_us: u32,
    #[command(flatten)]
    pub(super) limits: MotionLimits,
    /// File of software origins that `motionctl home` wrote: the positions of the motion are those of the axes, each of which must stand at
    /// the first one and stays within its travel. Without it a motion is relative to where the axes stand.
    #[arg(long, value_name = "FILE.toml", conflicts_with_all = ["stream", "bus"])]
    pub(super) origins: Option<PathBuf>,
    /// Status polls of each axis in Hz, 0 for none: then nobody notices a drive that left the bus.
    #[arg(long, value_name = "HZ", default_value_t = 50)]
    status_hz: u32,
    /// Position polls of each axis in Hz, 0 for none.
    #[arg(long, value_name = "HZ", default_value_t = 50)]
    position_hz: u32,
    #[command(flatten)]
    pub(super) recording: RecordingOptions,
    /// Show axes, load and events in the terminal while the motion runs; keys pause it, change its speed and stop it.
    #[arg(long, conflicts_with_all = ["json", "bus"])]
    pub(super) live: bool,
    /// Start without asking.
    #[arg(long)]
    pub(super) yes: bool,
    /// Print the summary as JSON, and no progress.
    #[arg(long)]
    pub(super) json: bool,
}

impl Arguments {
    pub(super) fn polls(&self) -> PollPeriods {
        let period_us = |hz: u32| 1_000_000_u32.checked_div(hz);
        PollPeriods {
            status_us: period_us(self.status_hz),
            position_us: period_us(self.position_hz),
            ..PollPeriods::OFF
        }
    }
}
