//! `motionctl monitor --drives zlac`: the state of drives, again and again, until Ctrl-C.

use std::process::ExitCode;

use schemars::JsonSchema;
use serde::Serialize;
use zlac8030l::NodeId;

use super::bus::Bus;
use super::error::HubError;
use super::nodes::SomeNodes;
use super::state::HubState;
use crate::interrupt;
use crate::link::LinkOptions;
use crate::output::{Printed, print};

/// The longest wait, so that Ctrl-C is heard.
const LONGEST_WAIT_US: u32 = 20_000;

const EXAMPLES: &str = "\
Examples:
  motionctl monitor --drives zlac:4,5 --slcan /dev/ttyACM0
  motionctl monitor --drives zlac --can can0 --every-ms 50 --count 100 --json > states.jsonl

Status, fault, mode, position, speed, torque, temperatures and voltage are read object by object. Nothing is changed and nothing moves;
but the reads are traffic to the drive, so its supervision (2000h) is content while it runs.

Exit status: 0 ended by Ctrl-C or --count, 3 the link failed.";

/// Options of `motionctl monitor --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    link: LinkOptions,
    #[command(flatten)]
    drives: SomeNodes,
    /// Time from one line of a drive to the next, in milliseconds.
    #[arg(long, value_name = "MS", default_value_t = 500, value_parser = clap::value_parser!(u32).range(20..=60_000))]
    every_ms: u32,
    /// End after so many lines of each drive.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    count: Option<u64>,
    /// Print one JSON object a line.
    #[arg(long)]
    json: bool,
}

/// One line.
#[derive(Debug, Serialize, JsonSchema)]
struct Line {
    /// Since the start.
    time_s: f64,
    node: u8,
    answers: bool,
    #[serde(flatten)]
    state: Option<HubState>,
}

/// Prints the states until the user asks to stop.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    let mut bus = Bus::open(&arguments.link)?;
    interrupt::listen().map_err(HubError::Interrupt)?;
    let mut lines = 0;
    let mut due_s = 0.0;
    while interrupt::requests() == 0 && arguments.count.is_none_or(|count| lines < count) {
        while bus.seconds() < due_s && interrupt::requests() == 0 {
            bus.wait(LONGEST_WAIT_US)?;
        }
        due_s = bus.seconds().max(due_s) + f64::from(arguments.every_ms) / 1_000.0;
        for node in arguments.drives.in_order() {
            let line = line_of(&mut bus, node)?;
            if show(&line, arguments.json)? == Printed::NobodyReads {
                return Ok(ExitCode::SUCCESS);
            }
        }
        lines += 1;
    }
    Ok(ExitCode::SUCCESS)
}

fn line_of(bus: &mut Bus, node: NodeId) -> Result<Line, HubError> {
    let state = match HubState::read(bus, node) {
        Ok(state) => Some(state),
        Err(HubError::NoAnswer { .. }) => None,
        Err(error) => return Err(error),
    };
    Ok(Line {
        time_s: bus.seconds(),
        node: node.get(),
        answers: state.is_some(),
        state,
    })
}

fn show(line: &Line, json: bool) -> Result<Printed, HubError> {
    let text = match &line.state {
        _ if json => serde_json::to_string(line).map_err(|error| HubError::Print(error.into()))?,
        Some(state) => format!("{:9.3} s  node {:3}: {state}", line.time_s, line.node),
        None => format!(
            "{:9.3} s  node {:3}: does not answer",
            line.time_s, line.node
        ),
    };
    print(text).map_err(HubError::Print)
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<Line>()
}
