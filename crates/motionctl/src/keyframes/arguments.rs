//! Options of `motionctl keyframes`.

use std::path::PathBuf;

use crate::trajectory::MotionOptions;

const EXAMPLES: &str = "\
Examples:
  motionctl keyframes part.rs --program part.ngc --axes 2 --mm-per-turn 5
  motionctl keyframes part.rs --program part.ngc --machine gantry.toml --force --json

In a configuration of the firmware, `include!(\"part.rs\")` takes the place of its keyframes (docs/paths.md); the board repeats its motion, so
the program must end where it starts.

Exit status: 0 the file is written, 2 the program cannot be used, or the file exists; nothing was written.";

/// Options of `motionctl keyframes`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// File of Rust to write.
    #[arg(value_name = "FILE.rs")]
    pub(super) file: PathBuf,
    #[command(flatten)]
    pub(super) motion: MotionOptions,
    /// How far a motor may be from the path between two cycles' set-points and their rounding, in command counts, 0.75 to 100.
    /// Keyframes are whole counts, which takes 0.5 of it; with more there are fewer of them.
    #[arg(long, value_name = "COUNTS", default_value_t = 1.0, value_parser = tolerance)]
    pub(super) tolerance_counts: f64,
    /// Cycle time of the board in microseconds.
    #[arg(long, value_name = "US", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(250..=1_000_000))]
    pub(super) cycle_us: u32,
    /// Replace a file that exists.
    #[arg(long)]
    pub(super) force: bool,
    /// Print the result as JSON.
    #[arg(long)]
    pub(super) json: bool,
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(counts) if (0.75..=100.0).contains(&counts) => Ok(counts),
        _ => Err(format!("expected 0.75 to 100 counts, got {text}")),
    }
}
