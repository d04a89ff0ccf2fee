//! `motionctl assign-id --drives zlac`: gives a drive its node number, and its bit rate.

use std::process::ExitCode;

use drive_sim::BitRate;
use schemars::JsonSchema;
use serde::Serialize;
use zlac8030l::{NmtCommand, NmtRequest, NodeId, SdoRequest, objects};

use super::bus::Bus;
use super::error::HubError;
use super::frames;
use super::identity::{require_settable, tell_of_master};
use super::nodes::{Nodes, node, nodes};
use super::store::protect;
use crate::confirm::confirm;
use crate::drives::{Step, When};
use crate::dry_run;
use crate::link::LinkOptions;
use crate::output::{print, print_json};
use crate::virtual_drives::bit_rate;

/// From the command to the answer of a drive that starts again.
const RESTART_US: u32 = 2_000_000;
/// Lower numbers come from the DIP switch (200Dh).
const LEAST_NODE: u8 = 4;

const EXAMPLES: &str = "\
Examples:
  motionctl assign-id --drives zlac --slcan /dev/ttyACM0 --from 4 --to 5       a new drive, alone on the bus
  motionctl assign-id --drives zlac --can can0 --from 5 --new-bit-rate 1000    another bit rate, from its next power-on

New drives all have node 4: connect one at a time, because two with the same number cannot be told apart. Before anything is written the
drive must answer as --from, without power, and none as --to. The number is written to the RAM, read back, and saved once. The guide does
not say when it counts: the drive is restarted, and looked for; where it does not come, its power must be switched off and on. A number
can be stored only while the DIP switch of the drive is 0.

Exit status: 0 the drive answers with its new number, or the bit rate is stored, 1 it does not, or another drive is in the way, 2 not
confirmed or enabled, and nothing was written, 3 the link failed.";

/// Options of `motionctl assign-id --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    link: LinkOptions,
    /// Hub motors: zlac.
    #[arg(long, value_name = "zlac", value_parser = nodes)]
    drives: Nodes,
    /// Node number that the drive has.
    #[arg(long, value_name = "NODE", value_parser = node)]
    from: NodeId,
    /// Node number that it shall have, 4 to 127.
    #[arg(long, value_name = "NODE", value_parser = stored_node, required_unless_present = "new_bit_rate")]
    to: Option<NodeId>,
    /// Bit rate in kbit/s that it shall have from its next power-on: 100, 125, 250, 500 or 1000.
    #[arg(long, value_name = "KBIT", value_parser = bit_rate_code)]
    new_bit_rate: Option<u16>,
    /// Assign without asking.
    #[arg(long)]
    yes: bool,
    /// Show the frames and send nothing.
    #[arg(long)]
    dry_run: bool,
    /// Print what was done as JSON.
    #[arg(long)]
    json: bool,
}

/// A node number that can be stored.
fn stored_node(text: &str) -> Result<NodeId, String> {
    let node = node(text)?;
    if node.get() < LEAST_NODE {
        return Err(format!(
            "must be {LEAST_NODE}..=127, got {node}: lower numbers are set with the DIP switch of the drive"
        ));
    }
    Ok(node)
}

/// The code of 200Eh of a bit rate in kbit/s.
fn bit_rate_code(text: &str) -> Result<u16, String> {
    let wanted: BitRate = bit_rate(text)?;
    let mut codes = (0_u16..).zip(zlac8030l::BIT_RATES);
    codes
        .find(|(_, rate)| *rate == wanted)
        .map(|(code, _)| code)
        .ok_or_else(|| "hub motors have 100, 125, 250, 500 and 1000 kbit/s".to_owned())
}

#[derive(Debug, Serialize, JsonSchema)]
struct End {
    from: u8,
    to: u8,
    /// Stored for the next power-on.
    new_bit_rate_kbit: Option<u32>,
    /// The drive answers with its new number.
    confirmed: bool,
    eeprom_writes: u32,
}

/// Asks, looks who is there, assigns, restarts, looks again.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    let _ = &arguments.drives;
    let (from, to) = (arguments.from, arguments.to.unwrap_or(arguments.from));
    if arguments.to == Some(from) {
        return Err(HubError::Input(format!(
            "--from and --to are both {from}: nothing to do"
        )));
    }
    if arguments.dry_run {
        dry_run::show(frames_of(arguments, to), arguments.json).map_err(HubError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut bus = Bus::open(&arguments.link)?;
    require_settable(&mut bus, from)?;
    tell_of_master(&mut bus, from, "the save stores them too")?;
    if to != from && bus.answers(to)? {
        return Err(HubError::Taken { node: to });
    }
    confirm(&question(arguments), arguments.yes).map_err(HubError::NotConfirmed)?;
    store(&mut bus, arguments)?;
    let end = End {
        from: from.get(),
        to: to.get(),
        new_bit_rate_kbit: arguments.new_bit_rate.map(kbit_per_s),
        // Another bit rate counts at the restart too: the drive is left as it is until its power is switched.
        confirmed: arguments.new_bit_rate.is_none() && restart(&mut bus, from, to)?,
        eeprom_writes: 1,
    };
    show(&end, arguments.json)?;
    if arguments.new_bit_rate.is_none() && !end.confirmed {
        return Err(HubError::NoAnswer {
            node: to,
            address: objects::DEVICE_TYPE.address(),
        });
    }
    Ok(ExitCode::SUCCESS)
}

fn kbit_per_s(code: u16) -> u32 {
    zlac8030l::BIT_RATES
        .get(usize::from(code))
        .map_or(0, |rate| rate.kbit_per_s())
}

fn writes(arguments: &Arguments) -> Vec<SdoRequest> {
    let node = arguments
        .to
        .map(|to| objects::CAN_NODE.write(to.get().into()));
    let bit_rate = arguments
        .new_bit_rate
        .map(|code| objects::CAN_BIT_RATE.write(code));
    node.into_iter().chain(bit_rate).collect()
}

/// Writes to the RAM, reads back, saves once.
fn store(bus: &mut Bus, arguments: &Arguments) -> Result<(), HubError> {
    let node = arguments.from;
    let update_before = bus.read(node, objects::EEPROM_UPDATE)?;
    protect(bus, node)?;
    for request in writes(arguments) {
        let SdoRequest::Write(address, data) = request else {
            continue;
        };
        bus.write(node, request)?;
        let actual = bus.read_number(node, address)?;
        let expected = i64::from(data.raw());
        if actual != expected {
            return Err(HubError::NotTaken {
                node,
                address,
                expected,
                actual,
            });
        }
    }
    bus.write(node, objects::STORE.write(objects::STORE_SAVE_ALL))?;
    bus.write(node, objects::EEPROM_UPDATE.write(update_before))
}

/// Restarts the drive and tells whether it answers with its new number.
fn restart(bus: &mut Bus, from: NodeId, to: NodeId) -> Result<bool, HubError> {
    bus.command(NmtRequest {
        command: NmtCommand::ResetNode,
        node: Some(from),
    })?;
    bus.wait(RESTART_US)?;
    bus.answers(to)
}

fn question(arguments: &Arguments) -> String {
    let from = arguments.from;
    let mut changes = Vec::new();
    if let Some(to) = arguments.to {
        changes.push(format!("node number {to}"));
    }
    if let Some(code) = arguments.new_bit_rate {
        changes.push(format!("{} kbit/s", kbit_per_s(code)));
    }
    format!(
        "Node {from} will store {} with everything else in its RAM, in one EEPROM write, and restarts. Is it the only drive with this number, and nothing else sends?",
        changes.join(" and ")
    )
}

fn frames_of(arguments: &Arguments, to: NodeId) -> Vec<Step> {
    let from = arguments.from;
    let mut steps = vec![
        frames::transfer(When::Before, from, objects::DEVICE_TYPE.read()),
        frames::transfer(When::Before, from, objects::STATUS_WORD.read()),
    ];
    if to != from {
        let device = objects::DEVICE_TYPE.read();
        steps.push(frames::transfer(When::Before, to, device));
    }
    let off = objects::EEPROM_UPDATE.write(objects::EEPROM_UPDATE_OFF);
    steps.push(frames::transfer(When::Always, from, off));
    for request in writes(arguments) {
        steps.push(frames::transfer(When::Always, from, request));
    }
    let save = objects::STORE.write(objects::STORE_SAVE_ALL);
    steps.push(frames::transfer(When::Always, from, save));
    if arguments.new_bit_rate.is_none() {
        let request = NmtRequest {
            command: NmtCommand::ResetNode,
            node: Some(from),
        };
        steps.push(frames::command(
            When::Always,
            request,
            "NMT: the drive restarts",
        ));
        let device = objects::DEVICE_TYPE.read();
        steps.push(frames::transfer(When::ReadBack, to, device));
    }
    steps
}

fn show(end: &End, json: bool) -> Result<(), HubError> {
    let printed = if json {
        print_json(end)
    } else {
        match end.new_bit_rate_kbit {
            Some(kbit) => print(format_args!(
                "node {} has stored {kbit} kbit/s{}: switch its power off and on, then use --bit-rate {kbit}",
                end.from,
                if end.to == end.from {
                    String::new()
                } else {
                    format!(" and node number {}", end.to)
                }
            )),
            None if end.confirmed => print(format_args!(
                "the drive that was node {} is node {} now",
                end.from, end.to
            )),
            None => print(format_args!(
                "node number {} is stored, and no drive answers with it yet: switch its power off and on, and see that its DIP switch is 0",
                end.to
            )),
        }
    };
    printed.map_err(HubError::Print)?;
    Ok(())
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<End>()
}
