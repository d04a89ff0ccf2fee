//! `motionctl run --drives zlac`: speeds from a file, or twists of a vehicle, on the drives of a real bus.

mod follow;
mod recording;
mod speeds;
mod stream;
mod summary;
mod vehicle;

use std::path::PathBuf;
use std::process::ExitCode;

use super::error::HubError;
use super::jog::acceleration;
use crate::link::LinkOptions;
use crate::recording::RecordingOptions;
use crate::schema::Either;
use crate::trajectory::MotionOptions;
use crate::twist::TwistOptions;

const CYCLE_US: u32 = 10_000;

const EXAMPLES: &str = "\
Examples:
  motionctl bench --drives zlac:4,5 --slcan /tmp/can-adapter       simulated drives, in another terminal
  motionctl run --drives zlac:4,5 --slcan /tmp/can-adapter --trajectory wheels.csv
  motionctl run --drives zlac:4,5 --can can0 --twist square.csv --track 0.4 --wheel-radius 0.085
  motionctl run --drives zlac:4,5 --can can0 --trajectory wheels.csv --report out --mcap run.mcap --live
  joystick | motionctl run --drives zlac:4,5 --can can0 --twist - --track 0.4 --wheel-radius 0.085 --yes

A file of --trajectory has a column of speeds in r/min for each wheel. Lines of --twist are time,v,omega in s, m/s and rad/s: each holds
until the next, its time counts from the first line, and one that comes late counts when it comes. What a live sender has said
while the wheels were still being enabled is not replayed; a file in a pipe is played from its begin. Without a new line for --dead-man-ms
the wheels ramp to 0, which is said; the next line goes on. The end of the lines is a stop.

The drives are enabled, follow, ramp down and are switched off: at the end, after a fault, after Ctrl-C. A vehicle on a slope rolls away
then. A program that is killed leaves them to their own supervision (2000h), which is set to 500 ms.

A recording that fails stops and says so; the motion goes on.

Exit status: 0 the end was reached, the wheels stand and everything is recorded, 1 a wheel had a fault or did not confirm that its power is
off, or a recording is not complete, 2 the input
cannot be used: nothing was switched, 3 the link failed, 130 stopped by Ctrl-C.";

/// Options of `motionctl run --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    link: LinkOptions,
    #[command(flatten)]
    motion: MotionOptions,
    #[command(flatten)]
    twist: TwistOptions,
    /// Write where the vehicle is after each cycle: time, x, y, heading and the counts of both wheels.
    #[arg(long, value_name = "FILE", requires = "twist")]
    odometry: Option<PathBuf>,
    /// Speeds of a file: fastest change in r/min per second; a file that needs more is refused.
    #[arg(long, value_name = "RPM_PER_S", default_value = "1000", value_parser = acceleration, conflicts_with = "twist")]
    max_acceleration: f64,
    #[command(flatten)]
    recording: RecordingOptions,
    /// Show wheels, load and events in the terminal while they turn; keys stop them.
    #[arg(long, conflicts_with = "json")]
    live: bool,
    /// Start without asking.
    #[arg(long)]
    yes: bool,
    /// Print the summary as JSON, and no progress.
    #[arg(long)]
    json: bool,
}

/// Checks everything, asks, moves, prints the summary.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    match &arguments.twist.twist {
        Some(source) => vehicle::run(arguments, source),
        None => speeds::run(arguments),
    }
}

/// The shape of what `--json` prints: of wheels that are moved by a file, or of a vehicle.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<Either<crate::trajectory::WithMotion<'_, summary::Summary>, summary::Summary>>(
    )
}
