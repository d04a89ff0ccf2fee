//! `motionctl plan --drives zlac`: whether a bus carries its wheels in time.

use std::process::ExitCode;

use can_motion::wheel::{
    FeedbackTiming, WheelConfig, WheelLimits, WheelMaster, WheelMasterConfig, WheelMode, WheelPlan,
};
use comfy_table::Table;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use drive_sim::BitRate;
use schemars::JsonSchema;
use serde::Serialize;

use super::error::HubError;
use super::nodes::SomeNodes;
use super::station::MOST_WHEELS;
use crate::exit;
use crate::output::{print, print_json};
use crate::table::align_numbers;
use crate::virtual_drives::bit_rate;

const EXAMPLES: &str = "\
Examples:
  motionctl plan --drives zlac:4,5
  motionctl plan --drives zlac:4-11 --cycle-us 20000 --bit-rate 250 --json
  motionctl plan --drives zlac:4,5 --sync

Nothing is opened and nothing is sent. Every kind of frame is checked against its deadline in the worst case.

Exit status: 0 the bus carries them, 1 a frame may be late, 2 the input cannot be used.";

/// Options of `motionctl plan --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    drives: SomeNodes,
    /// Cycle time in microseconds.
    #[arg(long, value_name = "US", default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(1_000..=1_000_000))]
    cycle_us: u32,
    /// Bit rate of the bus in kbit/s: 100, 125, 250, 500 or 1000.
    #[arg(long, value_name = "KBIT", default_value = "500", value_parser = bit_rate)]
    bit_rate: BitRate,
    /// Requests a cycle that are not targets.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=16))]
    requests: u8,
    /// Feedback after each SYNC, in place of by the timer of the drives.
    #[arg(long)]
    sync: bool,
    /// Ticks of the timer of the drives; 0.5 ms each, as the guide says (Z11).
    #[arg(long, value_name = "N", default_value_t = 40, conflicts_with = "sync")]
    feedback_ticks: u16,
    /// Print the plan as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Stream {
    frame: &'static str,
    count: u32,
    period_us: u32,
    /// The longest time from its release to the end of the frame; none where the bus carries more than it can.
    worst_us: Option<f64>,
    deadline_us: u32,
    in_time: bool,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Plan {
    fits: bool,
    reason: Option<String>,
    cycle_us: u32,
    bit_rate_kbit: u32,
    streams: Vec<Stream>,
}

/// Works it out and prints it.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    let config = WheelMasterConfig {
        cycle_us: arguments.cycle_us,
        requests_per_cycle: arguments.requests,
        bit_rate: arguments.bit_rate,
        feedback: if arguments.sync {
            FeedbackTiming::Sync
        } else {
            FeedbackTiming::Timer {
                ticks: arguments.feedback_ticks,
            }
        },
        ..WheelMasterConfig::DEFAULT
    };
    let wheel =
        |node| WheelConfig::new(node, WheelMode::Velocity, WheelLimits::speed(1_000, 1_000));
    let wheels: Vec<WheelConfig> = arguments
        .drives
        .ascending()
        .into_iter()
        .map(wheel)
        .collect();
    let plan = plan_of(arguments, &config, &wheels);
    if arguments.json {
        print_json(&plan).map_err(HubError::Print)?;
    } else {
        print(text(&plan)).map_err(HubError::Print)?;
    }
    Ok(if plan.fits {
        ExitCode::SUCCESS
    } else {
        exit::BROKEN_PROMISE.into()
    })
}

fn plan_of(arguments: &Arguments, config: &WheelMasterConfig, wheels: &[WheelConfig]) -> Plan {
    let plan = WheelPlan::new(config, wheels);
    let bit_us = 1_000.0 / f64::from(arguments.bit_rate.kbit_per_s());
    let streams = plan
        .streams()
        .into_iter()
        .zip(plan.response_times())
        .filter(|(stream, _)| stream.count > 0)
        .map(|(stream, response)| Stream {
            frame: stream.name,
            count: stream.count,
            period_us: stream.period_us,
            worst_us: response.bits.map(|bits| f64::from(bits) * bit_us),
            deadline_us: stream.deadline_us,
            in_time: response
                .bits
                .is_some_and(|bits| bits <= response.deadline_bits),
        })
        .collect();
    let admitted = WheelMaster::<MOST_WHEELS>::new(*config, wheels);
    let reason = admitted.err().map(|error| error.to_string());
    Plan {
        fits: reason.is_none(),
        reason,
        cycle_us: arguments.cycle_us,
        bit_rate_kbit: arguments.bit_rate.kbit_per_s(),
        streams,
    }
}

fn text(plan: &Plan) -> String {
    let mut table = Table::new();
    table.load_style(UTF8_BORDERS_ONLY).set_header([
        "number",
        "every us",
        "worst us",
        "deadline us",
        "frame",
    ]);
    for stream in &plan.streams {
        let late = if stream.in_time { "" } else { "  LATE" };
        table.add_row([
            stream.count.to_string(),
            stream.period_us.to_string(),
            stream
                .worst_us
                .map_or("-".to_owned(), |us| format!("{us:.0}")),
            stream.deadline_us.to_string(),
            format!("{}{late}", stream.frame),
        ]);
    }
    align_numbers(&mut table);
    let verdict = plan.reason.as_deref().map_or_else(
        || "The bus carries its wheels: every frame is in time in the worst case.".to_owned(),
        str::to_owned,
    );
    format!("{table}\n{verdict}")
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<Plan>()
}
