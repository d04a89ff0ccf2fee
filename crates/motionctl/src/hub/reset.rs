//! `motionctl reset --drives zlac`: clears the fault of a drive, or restores its factory settings.

use std::process::ExitCode;

use schemars::JsonSchema;
use serde::Serialize;
use zlac8030l::{ControlWord, FaultCode, NmtCommand, NmtRequest, NodeId, objects};

use super::bus::Bus;
use super::error::HubError;
use super::frames;
use super::identity::require_settable;
use super::nodes::OneNode;
use super::state::HubState;
use crate::confirm::confirm;
use crate::drives::{Step, When};
use crate::dry_run;
use crate::link::LinkOptions;
use crate::output::{print, print_json};

/// From the command to the answer of a drive that starts again.
const RESTART_US: u32 = 2_000_000;

const EXAMPLES: &str = "\
Examples:
  motionctl reset --drives zlac --slcan /dev/ttyACM0               clear the fault of node 4
  motionctl reset --drives zlac:5 --can can0 --factory             and bring every setting back to what the maker gave it

The fault is cleared by the edge of bit 7 of the control word (0, 80h, 0); the power stage stays off. It comes back when its cause is
still there. --factory writes 2009h = 1 and restarts the drive: node number and bit rate are those of the factory then (4 and 500 kbit/s,
where no DIP switch says otherwise), so keep a backup.

Exit status: 0 there is no fault, or the settings are restored, 1 the fault stays or the drive does not answer, 2 not confirmed or
enabled, 3 the link failed.";

/// Options of `motionctl reset --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    link: LinkOptions,
    #[command(flatten)]
    node: OneNode,
    /// Restore the factory settings of every object.
    #[arg(long)]
    factory: bool,
    /// Reset without asking.
    #[arg(long)]
    yes: bool,
    /// Show the frames and send nothing.
    #[arg(long)]
    dry_run: bool,
    /// Print what was done as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize, JsonSchema)]
struct End {
    node: u8,
    fault_before: Option<String>,
    fault_after: Option<String>,
    factory_settings: bool,
    /// The node that answers after the restart, where one was looked for.
    node_after: Option<u8>,
    eeprom_writes: u32,
}

/// 0, 80h, 0: an edge whatever the word was before (Z40).
fn words() -> [ControlWord; 3] {
    let off = ControlWord::DISABLE_VOLTAGE;
    [off, ControlWord::FAULT_RESET, off]
}

/// Asks, resets, reads again.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    let node = arguments.node.get()?;
    if arguments.dry_run {
        dry_run::show(frames_of(arguments, node), arguments.json).map_err(HubError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut bus = Bus::open(&arguments.link)?;
    let before = require_settable(&mut bus, node)?;
    confirm(&question(arguments, node, &before), arguments.yes).map_err(HubError::NotConfirmed)?;
    let end = if arguments.factory {
        factory(&mut bus, node, &before)?
    } else {
        clear(&mut bus, node, &before)?
    };
    show(&end, arguments.json)?;
    if arguments.factory && end.node_after.is_none() {
        return Err(HubError::NoAnswer {
            node: NodeId::FACTORY,
            address: objects::DEVICE_TYPE.address(),
        });
    }
    Ok(ExitCode::SUCCESS)
}

fn question(arguments: &Arguments, node: NodeId, before: &HubState) -> String {
    if arguments.factory {
        format!(
            "Every setting of node {node} will be lost, node number and bit rate too, and the drive restarts. Go on?"
        )
    } else {
        let fault = before.fault.as_deref().unwrap_or("no fault");
        format!("Node {node} reports {fault}. Is its cause removed?")
    }
}

fn clear(bus: &mut Bus, node: NodeId, before: &HubState) -> Result<End, HubError> {
    for word in words() {
        bus.write(node, objects::CONTROL_WORD.write(word.get()))?;
    }
    let fault = FaultCode::new(bus.read(node, objects::FAULT_CODE)?);
    if fault.is_fault() {
        return Err(HubError::FaultStays { node, fault });
    }
    Ok(End {
        node: node.get(),
        fault_before: before.fault.clone(),
        fault_after: None,
        factory_settings: false,
        node_after: Some(node.get()),
        eeprom_writes: 0,
    })
}

fn factory(bus: &mut Bus, node: NodeId, before: &HubState) -> Result<End, HubError> {
    bus.write(node, objects::STORE.write(objects::STORE_FACTORY_SETTINGS))?;
    bus.command(NmtRequest {
        command: NmtCommand::ResetNode,
        node: Some(node),
    })?;
    bus.wait(RESTART_US)?;
    let mut node_after = None;
    for candidate in [NodeId::FACTORY, node] {
        if node_after.is_none() && bus.answers(candidate)? {
            node_after = Some(candidate.get());
        }
    }
    Ok(End {
        node: node.get(),
        fault_before: before.fault.clone(),
        fault_after: None,
        factory_settings: true,
        node_after,
        eeprom_writes: 1,
    })
}

fn frames_of(arguments: &Arguments, node: NodeId) -> Vec<Step> {
    let mut steps = vec![
        frames::transfer(When::Before, node, objects::STATUS_WORD.read()),
        frames::transfer(When::Before, node, objects::FAULT_CODE.read()),
    ];
    if arguments.factory {
        let store = objects::STORE.write(objects::STORE_FACTORY_SETTINGS);
        steps.push(frames::transfer(When::Always, node, store));
        let request = NmtRequest {
            command: NmtCommand::ResetNode,
            node: Some(node),
        };
        steps.push(frames::command(
            When::Always,
            request,
            "NMT: the drive restarts",
        ));
    } else {
        let words = words().map(|word| objects::CONTROL_WORD.write(word.get()));
        steps.extend(words.map(|write| frames::transfer(When::Always, node, write)));
        let fault = objects::FAULT_CODE.read();
        steps.push(frames::transfer(When::ReadBack, node, fault));
    }
    steps
}

fn show(end: &End, json: bool) -> Result<(), HubError> {
    let printed = if json {
        print_json(end)
    } else if end.factory_settings {
        match end.node_after {
            Some(node) => print(format_args!(
                "the factory settings are restored; the drive is node {node} now"
            )),
            None => print(
                "the factory settings were asked for; no drive answers at this bit rate since: switch its power off and on, then `motionctl scan --drives zlac --bit-rate 500`",
            ),
        }
    } else {
        let fault = end.fault_before.as_deref().unwrap_or("no fault");
        print(format_args!(
            "node {} reported {fault} and reports none now",
            end.node
        ))
    };
    printed.map_err(HubError::Print)?;
    Ok(())
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<End>()
}
