//! Options of a stream.

use board_link::{Config, WhenDry};
use clap::ValueEnum;
use trajectory::Time;

use crate::endpoint::Endpoint;

/// Where set-points come from, and how much of them is buffered.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct StreamOptions {
    /// Take set-points while the motion runs, one a line: - for standard input, tcp:PORT or unix:PATH for one program of this machine. The
    /// first line names the columns as in files; positions count from where the axes stand. See docs/stream.md.
    #[arg(long, value_name = "ENDPOINT", conflicts_with = "trajectory")]
    pub(crate) stream: Option<Endpoint>,
    /// Stream: largest jerk of a motor in r/min per second², half of it for the set-points; a set-point that needs more is refused. Without
    /// it jerk has no limit.
    #[arg(long, value_name = "RPM_PER_S2", value_parser = positive, requires = "stream")]
    pub(crate) max_jerk: Option<f64>,
    /// Stream: milliseconds of complete path that are buffered before the motion starts.
    #[arg(long, value_name = "MS", default_value_t = 300, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    lead_ms: u32,
    /// Stream: milliseconds that the sender is asked to keep buffered; its credit ends there.
    #[arg(long, value_name = "MS", default_value_t = 600, value_parser = clap::value_parser!(u32).range(1..=30_000))]
    ahead_ms: u32,
    /// Stream: what happens when the set-points run out. The axes come to rest at the last one in any case.
    #[arg(long, value_enum, default_value_t)]
    when_dry: WhenDryOption,
}

/// What happens when the set-points run out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum WhenDryOption {
    /// The motion ends.
    #[default]
    End,
    /// It goes on when --lead-ms are buffered again.
    Wait,
}

/// Longest time from one set-point to the next, in seconds: more is a mistake in the unit.
pub(crate) const LONGEST_GAP_S: u32 = 10;
/// Accelerations are means over so much.
const WINDOW_MS: u32 = 20;

impl StreamOptions {
    /// The buffer in cycles.
    pub(crate) fn config(&self, cycle_us: u32) -> Config {
        let ms = |ms: u32| Time::from_units(u64::from(ms) * 1_000, cycle_us);
        Config {
            lead: ms(self.lead_ms),
            // Less than the start waits for would never start.
            ahead: ms(self.ahead_ms.max(self.lead_ms)),
            longest_gap: ms(LONGEST_GAP_S * 1_000),
            window: ms(WINDOW_MS).max(Time::from_cycles(1)),
            when_dry: self.when_dry.into(),
        }
    }
}

impl From<WhenDryOption> for WhenDry {
    fn from(option: WhenDryOption) -> Self {
        match option {
            WhenDryOption::End => Self::End,
            WhenDryOption::Wait => Self::Wait,
        }
    }
}

pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(number),
        _ => Err(format!("must be a number above 0, got {text}")),
    }
}
