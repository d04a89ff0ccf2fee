//! Options of `motionctl run`.

use can_motion::PollPeriods;
use dyn_can::StepLimit;

use crate::link::LinkOptions;
use crate::station::AxisOptions;
use crate::trajectory::MotionOptions;

const EXAMPLES: &str = "\
Examples:
  motionctl bench --drives 1-4 --slcan /tmp/can-adapter     simulated drives, in another terminal
  motionctl run --slcan /tmp/can-adapter                    the built-in pick-and-place on drives 1 to 4
  motionctl run --slcan /dev/ttyACM0 --trajectory plan.csv --drives 5,7 --axes 2
  motionctl run --can can0 --trajectory plan.csv --cycle-us 2000 --yes --json

The drives are enabled, follow the motion from where they stand, and are disabled. Ctrl-C ramps down and
disables, a second Ctrl-C stops at once. At the end, and after a fault, every drive is disabled: a vertical
axis without a brake falls then. A PC keeps time as well as it can: cycles that began late or never
are counted and reported, and the axes catch up within --max-step.

Exit status: 0 the motion is complete and every set-point was sent, 1 it is not, 2 the input cannot be used
and nothing was sent, 3 the link failed, 130 stopped by Ctrl-C.";

/// Options of `motionctl run`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(super) link: LinkOptions,
    #[command(flatten)]
    pub(super) motion: MotionOptions,
    #[command(flatten)]
    pub(super) axes: AxisOptions,
    /// Cycle time in microseconds.
    #[arg(long, value_name = "US", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(250..=1_000_000))]
    pub(super) cycle_us: u32,
    /// Largest step of an axis in one cycle, in command counts: how fast an axis catches up after missed cycles.
    /// Default: a quarter above the largest step of the motion.
    #[arg(long, value_name = "COUNTS", value_parser = step_limit)]
    pub(super) max_step: Option<StepLimit>,
    /// Status polls of each axis in Hz, 0 for none.
    #[arg(long, value_name = "HZ", default_value_t = 50)]
    status_hz: u32,
    /// Position polls of each axis in Hz, 0 for none.
    #[arg(long, value_name = "HZ", default_value_t = 50)]
    position_hz: u32,
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

fn step_limit(text: &str) -> Result<StepLimit, String> {
    let counts: i32 = text.parse().map_err(|_| "expected a number".to_owned())?;
    StepLimit::new(counts).map_err(|error| error.to_string())
}
