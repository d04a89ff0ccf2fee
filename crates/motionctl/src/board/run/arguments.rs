//! Options of `motionctl board run`.

use std::path::PathBuf;

use crate::board::arguments::PortOptions;
use crate::control::ControlOptions;
use crate::recording::RecordingOptions;
use crate::station::MotionLimits;
use crate::trajectory::MotionOptions;

const EXAMPLES: &str = "\
Examples:
  motionctl board run plan.csv --port /dev/ttyACM0
  motionctl board run plan.csv --port tcp:7002 --drives 2,1 --yes --json
  motionctl board run --program part.ngc --machine machine.toml --port /dev/ttyACM0
  motionctl board run plan.csv --port /dev/ttyACM0 --csv run.csv --report out
  motionctl board run plan.csv --port /dev/ttyACM0 --stay-enabled      after `motionctl board home`, and homed for the next one

The same files, units and limits as `motionctl run`; the set-points on the bus are the same, and the board keeps their time. The motion is sent
ahead in segments, which are checked against the settings of the board before anything is enabled.
Of an axis that was homed (`motionctl board home`) the positions are those from its origin: it must stand at the first one.
Ctrl-C slows down along the path, then the drives are disabled; a second Ctrl-C ends all set-points at once. A host that is killed, or whose
cable is pulled, is silent: the board slows down along the path half a second later, and its drives stay enabled.

Exit status: 0 the motion is complete, 1 it is not, the board refuses it, or a drive is not off, 2 the input cannot be used: nothing was
switched, 3 the link failed, 130 stopped by Ctrl-C or an order to stop.";

/// Options of `motionctl board run`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(in crate::board) struct Arguments {
    /// The motion file, as --trajectory.
    #[arg(value_name = "FILE", conflicts_with_all = ["trajectory", "program"])]
    pub(super) file: Option<PathBuf>,
    #[command(flatten)]
    pub(super) port: PortOptions,
    #[command(flatten)]
    motion: MotionOptions,
    #[command(flatten)]
    pub(super) limits: MotionLimits,
    #[command(flatten)]
    pub(super) control: ControlOptions,
    #[command(flatten)]
    pub(super) recording: RecordingOptions,
    /// Snapshots of the board in a second, of which recordings are made.
    #[arg(long, value_name = "HZ", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..=1_000))]
    pub(super) snapshot_hz: u32,
    /// Leave the drives enabled when the motion is complete, so that homed axes stay homed.
    #[arg(long)]
    pub(super) stay_enabled: bool,
    /// Start without asking.
    #[arg(long)]
    pub(super) yes: bool,
    /// Print the summary as JSON, and no progress.
    #[arg(long)]
    pub(super) json: bool,
}

impl Arguments {
    /// What to move.
    pub(super) fn motion(&self) -> MotionOptions {
        let mut motion = self.motion.clone();
        if let Some(file) = &self.file {
            motion.trajectory = Some(file.clone());
        }
        motion
    }
}
