//! Options of `motionctl plan`.

use std::path::PathBuf;

use can_motion::plan::{BitRate, BusSetup, RequestMix, ResponseWindow, TxOrder};
use can_motion::{AxisConfig, Limits, MasterConfig, PollPeriods, StepChange, Travel};
use clap::ValueEnum;
use dyn_can::{DriveId, GearNumber, StepLimit};

use crate::drive_ids::drive_ids;

const EXAMPLES: &str = "\
Examples:
  motionctl plan --axes 8                        8 drives, status and position at 50 Hz
  motionctl plan --axes 14 --status-hz 0 --position-hz 0
  motionctl plan --drives 3,7-9 --bit-rate 500 --cycle-us 2000 --svg cycle.svg
  motionctl plan --axes 6 --alarms 1 --error-interval-us 10000

Exit status: 0 every frame is in time, 1 the plan is refused.";

/// Options of `motionctl plan`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Number of axes, with drives 1, 2, 3 ...
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u8).range(1..=63))]
    axes: u8,
    /// Drive ids instead, in any order: numbers and ranges as in 1,2,5-7.
    #[arg(long, value_name = "IDS", value_parser = drive_ids, conflicts_with = "axes")]
    drives: Option<std::vec::Vec<DriveId>>,
    /// Cycle time in microseconds.
    #[arg(long, value_name = "US", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(250..=1_000_000))]
    cycle_us: u32,
    /// Bit rate in kbit/s: 10, 20, 50, 125, 250, 500, 800 or 1000.
    #[arg(long, value_name = "KBIT", default_value = "1000", value_parser = bit_rate)]
    bit_rate: BitRate,
    /// Largest step of an axis in one cycle, in command counts: up to 127 the set-points are a byte shorter.
    #[arg(long, value_name = "COUNTS", default_value = "16384", value_parser = step_limit)]
    max_step: StepLimit,
    /// Status polls of each axis in Hz, 0 for none.
    #[arg(long, value_name = "HZ", default_value_t = 50)]
    status_hz: u32,
    /// Position polls of each axis in Hz, 0 for none.
    #[arg(long, value_name = "HZ", default_value_t = 50)]
    position_hz: u32,
    /// Torque polls of each axis in Hz, 0 for none.
    #[arg(long, value_name = "HZ", default_value_t = 0)]
    torque_hz: u32,
    /// Speed polls of each axis in Hz, 0 for none.
    #[arg(long, value_name = "HZ", default_value_t = 0)]
    speed_hz: u32,
    /// Polls of each diagnostic counter in Hz, 0 for none.
    #[arg(long, value_name = "HZ", default_value_t = 0)]
    counter_hz: u32,
    /// Requests that may go out in one cycle.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..))]
    requests: u8,
    /// Shortest and longest response of the drives in microseconds.
    #[arg(long, value_name = "MIN-MAX", default_value = "375-625", value_parser = window)]
    response_us: ResponseWindow,
    /// Which waiting frame of the master goes out first.
    #[arg(long, value_enum, default_value_t)]
    tx_order: TxOrderOption,
    /// Axes are brought up or parameterised while others stream.
    #[arg(long)]
    any_request: bool,
    /// How late a cycle may begin, in microseconds.
    #[arg(long, value_name = "US", default_value_t = 0)]
    release_jitter_us: u32,
    /// Alarm frames in two cycles that set-points must survive on time.
    #[arg(long, value_name = "N", default_value_t = 0)]
    alarms: u8,
    /// Shortest time between two errors on the bus that set-points must survive on time, in microseconds.
    #[arg(long, value_name = "US", value_parser = clap::value_parser!(u32).range(1..))]
    error_interval_us: Option<u32>,
    /// Write the picture of one cycle as SVG.
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    /// Print the plan as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum TxOrderOption {
    /// The oldest, as bxCAN with TXFP or FDCAN in FIFO mode.
    #[default]
    Fifo,
    /// The lowest identifier, as bxCAN out of reset.
    Identifier,
}

impl Arguments {
    pub(crate) fn config(&self) -> MasterConfig {
        MasterConfig {
            cycle_us: self.cycle_us,
            requests_per_cycle: self.requests,
            bus: BusSetup {
                bit_rate: self.bit_rate,
                order: match self.tx_order {
                    TxOrderOption::Fifo => TxOrder::Fifo,
                    TxOrderOption::Identifier => TxOrder::Identifier,
                },
                response: self.response_us,
                requests: if self.any_request {
                    RequestMix::Any
                } else {
                    RequestMix::Polls
                },
                release_jitter_us: self.release_jitter_us,
                alarm_burst: self.alarms,
                error_interval_us: self.error_interval_us,
                canopen: None,
            },
            ..MasterConfig::DEFAULT
        }
    }

    /// The axes, ascending as the master wants them.
    pub(crate) fn axes(&self) -> Vec<AxisConfig> {
        let mut drives = self
            .drives
            .clone()
            .unwrap_or_else(|| DriveId::all().take(usize::from(self.axes)).collect());
        drives.sort_unstable();
        drives.into_iter().map(|drive| self.axis(drive)).collect()
    }

    /// An axis as all of them are.
    pub(crate) fn axis(&self, drive: DriveId) -> AxisConfig {
        let period_us = |hz: u32| 1_000_000_u32.checked_div(hz);
        let limits = Limits::new(self.max_step, StepChange::MAX, Travel::WHOLE);
        AxisConfig {
            unwatched: self.status_hz == 0,
            polls: PollPeriods {
                status_us: period_us(self.status_hz),
                position_us: period_us(self.position_hz),
                torque_us: period_us(self.torque_hz),
                speed_us: period_us(self.speed_hz),
                counter_us: period_us(self.counter_hz),
            },
            // No frame depends on the gear.
            ..AxisConfig::new(drive, GearNumber::MAX, limits)
        }
    }
}

fn bit_rate(text: &str) -> Result<BitRate, String> {
    let rate = text.parse().ok().map(BitRate::from_kbit_per_s);
    rate.and_then(Result::ok)
        .filter(|rate| dyn_can::knows_bit_rate(*rate))
        .ok_or_else(|| format!("expected 10, 20, 50, 125, 250, 500, 800 or 1000, got {text}"))
}

fn step_limit(text: &str) -> Result<StepLimit, String> {
    let counts = text.parse().map_err(|_| "expected a number".to_owned())?;
    StepLimit::new(counts).map_err(|error| error.to_string())
}

fn window(text: &str) -> Result<ResponseWindow, String> {
    let (min, max) = text.split_once('-').unwrap_or((text, text));
    match (min.trim().parse(), max.trim().parse()) {
        (Ok(min_us), Ok(max_us)) if min_us <= max_us => Ok(ResponseWindow { min_us, max_us }),
        _ => Err(format!(
            "expected shortest-longest as in 375-625, got {text}"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_is_one_number_or_two_ascending() {
        let both = |min_us, max_us| Ok(ResponseWindow { min_us, max_us });
        assert_eq!(window("500"), both(500, 500));
        assert_eq!(window("375 - 625"), both(375, 625));
        assert!(window("625-375").is_err() && window("fast").is_err());
    }

    #[test]
    fn only_the_rates_of_the_drives() {
        assert_eq!(bit_rate("125"), Ok(BitRate::Kbit125));
        assert!(bit_rate("100").is_err() && bit_rate("fast").is_err());
    }
}
