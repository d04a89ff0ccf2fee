//! Options of `motionctl board stream`.

use board_link::WhenDry;
use trajectory::Time;

use crate::board::arguments::PortOptions;
use crate::control::ControlOptions;
use crate::endpoint::Endpoint;
use crate::recording::RecordingOptions;
use crate::station::MotionLimits;
use crate::stream::{WhenDryOption, positive};
use crate::trajectory::MotionOptions;

const EXAMPLES: &str = "\
Examples:
  producer | motionctl board stream --port /dev/ttyACM0 --yes
  motionctl board stream tcp:7001 --port /dev/ttyACM0        and examples/stream.py 7001 in another terminal
  motionctl board stream unix:/tmp/points --port tcp:7002 --drives 2,1 --yes --json
  motionctl board stream tcp:7001 --port /dev/ttyACM0 --lead-ms 1000 --csv run.csv --report out

Lines, units, answers and errors are those of `motionctl run --stream`, see docs/stream.md. The set-points go to the board as segments, ahead of
their time: a program that is late by less than what is buffered, less the time that slowing down takes, costs nothing. One that is later lets the
board slow down along the path, come to rest, and end. What slows down does so as the settings of the board allow; --max-acceleration is for the
set-points, and an override above 100 % is held to 100. Ctrl-C slows down along the path, then the drives are disabled; a second Ctrl-C ends
all set-points at once. A host that is killed, or whose cable is pulled, is silent: the board slows down along the path half a second later,
and its drives stay enabled.

Exit status: 0 the motion is complete, 1 it is not, the set-points ran out, the board refuses it, or a drive is not off, 2 the input cannot be
used: nothing was switched, 3 the link failed, 130 stopped by Ctrl-C or an order to stop.";

/// Options of `motionctl board stream`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(in crate::board) struct Arguments {
    /// Where set-points come from: - for standard input, tcp:PORT or unix:PATH for one program of this machine.
    #[arg(value_name = "ENDPOINT", default_value = "-")]
    pub(super) endpoint: Endpoint,
    #[command(flatten)]
    pub(super) port: PortOptions,
    #[command(flatten)]
    pub(super) motion: MotionOptions,
    #[command(flatten)]
    pub(super) limits: MotionLimits,
    #[command(flatten)]
    pub(super) buffer: BufferOptions,
    #[command(flatten)]
    pub(super) control: ControlOptions,
    #[command(flatten)]
    pub(super) recording: RecordingOptions,
    /// Snapshots of the board in a second, of which recordings are made, and by which the credit of the sender is known.
    #[arg(long, value_name = "HZ", default_value_t = 50, value_parser = clap::value_parser!(u32).range(10..=1_000))]
    pub(super) snapshot_hz: u32,
    /// Start without asking.
    #[arg(long)]
    pub(super) yes: bool,
    /// Print the summary as JSON.
    #[arg(long)]
    pub(super) json: bool,
}

/// How much is buffered ahead of the board.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct BufferOptions {
    /// Largest jerk of a motor in r/min per second², half of it for the set-points; a set-point that needs more is refused. Without it jerk
    /// has the limit of the board's settings, or none.
    #[arg(long, value_name = "RPM_PER_S2", value_parser = positive)]
    pub(super) max_jerk: Option<f64>,
    /// Milliseconds of complete path that are buffered before the motion starts. The board itself waits for 300.
    #[arg(long, value_name = "MS", default_value_t = 500, value_parser = clap::value_parser!(u32).range(300..=10_000))]
    lead_ms: u32,
    /// Milliseconds that the sender is asked to keep buffered; its credit ends there.
    #[arg(long, value_name = "MS", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(300..=30_000))]
    ahead_ms: u32,
    /// What happens when the set-points run out. The axes come to rest along the path in any case.
    #[arg(long, value_enum, default_value_t)]
    when_dry: WhenDryOption,
}

/// The same, in cycles.
#[derive(Debug, Clone, Copy)]
pub(super) struct Buffering {
    pub(super) lead: Time,
    pub(super) ahead: Time,
    pub(super) when_dry: WhenDry,
}

impl BufferOptions {
    pub(super) fn in_cycles(&self, cycle_us: u32) -> Buffering {
        let ms = |ms: u32| Time::from_units(u64::from(ms) * 1_000, cycle_us);
        Buffering {
            lead: ms(self.lead_ms),
            // Less than the start waits for would never start.
            ahead: ms(self.ahead_ms.max(self.lead_ms)),
            when_dry: self.when_dry.into(),
        }
    }
}
