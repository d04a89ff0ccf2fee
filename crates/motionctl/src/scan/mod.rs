//! `motionctl scan`: which drives are there.

mod canopen;

use std::process::ExitCode;

use indicatif::{ProgressBar, ProgressStyle};
use schemars::JsonSchema;
use serde::Serialize;

use crate::confirm::confirm;
use crate::drives::{DrivesError, DrivesOptions, FoundDrive};
use crate::exit;
use crate::link::{Link, LinkOptions};
use crate::output::{print, print_json};
use crate::station::AxisOptions;

/// Ids that are asked.
const IDS: u64 = 63;
/// Nodes that are asked.
const NODES: u64 = 127;
const QUESTION: &str =
    "Are there only CANopen drives on this bus? The same identifiers are moves of DYN drives.";

const NO_DRIVE: &str = "no drive answers: check power, wiring, termination and bit rate; a fresh drive has no id on CAN yet, and is drive 0 on its serial port";

const EXAMPLES: &str = "\
Examples:
  motionctl scan --slcan /dev/ttyACM0
  motionctl scan --can can0 --json
  motionctl scan --serial /dev/ttyUSB0
  motionctl scan --can can0 --protocol canopen

Every id from 1 to 63 is asked for its parameter group 3, over --serial every id from 0 to 63 for its id.
This changes nothing and moves nothing.

With --protocol canopen every node from 1 to 127 is asked for its device type 1000h. Never on a bus
with DYN drives: the same identifiers are moves there. It asks first, scripts answer with --yes. Hub-motor drives leave
the factory with 500 kbit/s, which is what it uses unless --bit-rate is given.

Exit status: 0 at least one drive answered, 1 none did, 3 the link failed.";

/// Options of `motionctl scan`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    drives: DrivesOptions,
    /// What the bus speaks.
    #[arg(long, value_enum, default_value_t)]
    protocol: ProtocolOption,
    /// Do not ask whether the bus is one of CANopen drives only.
    #[arg(long)]
    yes: bool,
    /// Print the drives as JSON, and no progress.
    #[arg(long)]
    json: bool,
}

/// What a bus speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
enum ProtocolOption {
    /// DYN2 and DYN4 servo drives.
    #[default]
    Dyn,
    /// ZLAC8030L hub-motor drives and other CANopen nodes.
    Canopen,
}

#[derive(Serialize, JsonSchema)]
struct Found {
    drives: Vec<FoundDrive>,
}

/// Asks every id and prints what answered.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, DrivesError> {
    let (drives, silence) = match arguments.protocol {
        ProtocolOption::Dyn => (scan_dyn(arguments)?, NO_DRIVE.to_owned()),
        ProtocolOption::Canopen => scan_canopen(arguments)?,
    };
    show(drives, silence, arguments.json)
}

/// Asks every CANopen node on a bus and prints what answered.
pub(crate) fn run_canopen(
    link: &LinkOptions,
    yes: bool,
    json: bool,
) -> Result<ExitCode, DrivesError> {
    confirm(QUESTION, yes).map_err(DrivesError::NotConfirmed)?;
    let mut link = link
        .open_of_drives_with(zlac8030l::FACTORY_BIT_RATE)
        .map_err(DrivesError::Open)?;
    let silence = no_node(link.bit_rate().kbit_per_s());
    show(scan_nodes(&mut link, json)?, silence, json)
}

fn show(drives: Vec<FoundDrive>, silence: String, json: bool) -> Result<ExitCode, DrivesError> {
    let found = Found { drives };
    if json {
        print_json(&found).map_err(DrivesError::Print)?;
    } else if found.drives.is_empty() {
        print(silence).map_err(DrivesError::Print)?;
    }
    for found in found.drives.iter().filter(|_| !json) {
        print(format_args!("drive {:2}  {}", found.drive, found.protocol))
            .map_err(DrivesError::Print)?;
    }
    Ok(if found.drives.is_empty() {
        exit::BROKEN_PROMISE.into()
    } else {
        ExitCode::SUCCESS
    })
}

fn scan_dyn(arguments: &Arguments) -> Result<Vec<FoundDrive>, DrivesError> {
    let mut drives = arguments
        .drives
        .open(AxisOptions::default())
        .map_err(DrivesError::Open)?;
    let bar = progress_bar(IDS, !arguments.json);
    let found = drives.scan(&mut |id| bar.set_position(id.into()));
    bar.finish_and_clear();
    found
}

/// The nodes, and what is said when there is none.
fn scan_canopen(arguments: &Arguments) -> Result<(Vec<FoundDrive>, String), DrivesError> {
    if arguments.drives.is_serial() {
        return Err(DrivesError::CanopenOnSerial);
    }
    confirm(QUESTION, arguments.yes).map_err(DrivesError::NotConfirmed)?;
    let (mut link, kbit_per_s) = arguments.drives.open_canopen().map_err(DrivesError::Open)?;
    Ok((scan_nodes(&mut link, arguments.json)?, no_node(kbit_per_s)))
}

fn scan_nodes(link: &mut Link, json: bool) -> Result<Vec<FoundDrive>, DrivesError> {
    let bar = progress_bar(NODES, !json);
    let found = canopen::scan(link, &mut |node| bar.set_position(node.into()));
    bar.finish_and_clear();
    found
}

/// Names the other bit rates of the drives; none is tried unasked, because a wrong one disturbs the bus.
fn no_node(kbit_per_s: u32) -> String {
    let others: Vec<String> = zlac8030l::BIT_RATES
        .iter()
        .map(|rate| rate.kbit_per_s())
        .filter(|&rate| rate != kbit_per_s)
        .map(|rate| rate.to_string())
        .collect();
    format!(
        "no node answers at {kbit_per_s} kbit/s: check power, wiring and termination, or try --bit-rate with {}",
        others.join(", ")
    )
}

fn progress_bar(ids: u64, show: bool) -> ProgressBar {
    if !show {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(ids);
    match ProgressStyle::with_template("{bar:40} id {pos}/{len}") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<Found>()
}
