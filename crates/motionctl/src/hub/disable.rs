//! `motionctl disable --drives zlac`: switches the power of drives off, whatever left it on.

use std::process::ExitCode;

use schemars::JsonSchema;
use serde::Serialize;
use zlac8030l::{ControlWord, NodeId, StatusWord, objects};

use super::bus::Bus;
use super::error::HubError;
use super::nodes::{SomeNodes, named};
use super::state::has_power;
use crate::link::LinkOptions;
use crate::output::{print, print_json};

/// Time for a wheel to stop by its quick stop, in steps of [`STEP_US`].
const STOP_STEPS: u32 = 250;
/// Time for the power to go off.
const OFF_STEPS: u32 = 100;
const STEP_US: u32 = 20_000;

const EXAMPLES: &str = "\
Examples:
  motionctl disable --drives zlac:4,5 --slcan /dev/ttyACM0
  motionctl disable --drives zlac --can can0 --json

A wheel that turns is stopped first (control word 2, up to 5 s), then its power goes off (control word 0): it can be turned by hand then,
and a vehicle on a slope rolls away. It does not ask, because it stops motion.

Exit status: 0 every drive says that its power is off, 1 one does not, 3 the link failed.";

/// Options of `motionctl disable --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    link: LinkOptions,
    #[command(flatten)]
    drives: SomeNodes,
    /// Print the drives as JSON.
    #[arg(long)]
    json: bool,
}

/// The drives afterwards.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub(super) struct Disabled {
    pub(super) disabled: Vec<u8>,
    pub(super) unconfirmed: Vec<u8>,
    /// Enabled before this tool came, and not switched off by it.
    pub(super) left_enabled: Vec<u8>,
}

/// Disables and waits for the confirmation.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    let mut bus = Bus::open(&arguments.link)?;
    let nodes = arguments.drives.ascending();
    // All of them are told to stop before any is waited for.
    for &node in &nodes {
        stop(&mut bus, node)?;
    }
    let mut disabled = Vec::new();
    let mut unconfirmed = Vec::new();
    for &node in &nodes {
        if switch_off(&mut bus, node)? {
            disabled.push(node);
        } else {
            unconfirmed.push(node);
        }
    }
    tell_end(&disabled, &unconfirmed, arguments.json)?;
    Ok(ExitCode::SUCCESS)
}

/// Tells which drives have no power; an error names those that have not said so.
///
/// # Errors
/// [`HubError::StillEnabled`], [`HubError::Print`].
pub(super) fn tell_end(
    disabled: &[NodeId],
    unconfirmed: &[NodeId],
    json: bool,
) -> Result<(), HubError> {
    if json {
        let numbers = |nodes: &[NodeId]| nodes.iter().map(|node| node.get()).collect();
        print_json(&Disabled {
            disabled: numbers(disabled),
            unconfirmed: numbers(unconfirmed),
            left_enabled: Vec::new(),
        })
        .map_err(HubError::Print)?;
    } else if !disabled.is_empty() {
        let verb = if disabled.len() == 1 { "is" } else { "are" };
        print(format_args!("{} {verb} disabled", named(disabled))).map_err(HubError::Print)?;
    }
    if unconfirmed.is_empty() {
        return Ok(());
    }
    Err(HubError::StillEnabled {
        nodes: unconfirmed.to_vec(),
        after: None,
    })
}

/// The quick stop, for a drive that has power.
fn stop(bus: &mut Bus, node: NodeId) -> Result<(), HubError> {
    let status = match bus.read(node, objects::STATUS_WORD) {
        Ok(status) => StatusWord::new(status),
        // It is switched off all the same.
        Err(HubError::NoAnswer { .. }) => return Ok(()),
        Err(error) => return Err(error),
    };
    if has_power(status) {
        tolerate(write_word(bus, node, ControlWord::QUICK_STOP))?;
    }
    Ok(())
}

/// Waits for standstill, then switches off; returns whether the drive says that it is off.
fn switch_off(bus: &mut Bus, node: NodeId) -> Result<bool, HubError> {
    for _ in 0..STOP_STEPS {
        match bus.read(node, objects::STATUS_WORD) {
            Ok(word) if has_power(StatusWord::new(word)) && StatusWord::new(word).running() => {}
            Ok(_) | Err(HubError::NoAnswer { .. }) => break,
            Err(error) => return Err(error),
        }
        bus.wait(STEP_US)?;
    }
    for _ in 0..OFF_STEPS {
        tolerate(write_word(bus, node, ControlWord::DISABLE_VOLTAGE))?;
        match bus.read(node, objects::STATUS_WORD) {
            Ok(word) if !has_power(StatusWord::new(word)) => return Ok(true),
            Ok(_) => bus.wait(STEP_US)?,
            Err(HubError::NoAnswer { .. }) => return Ok(false),
            Err(error) => return Err(error),
        }
    }
    Ok(false)
}

fn write_word(bus: &mut Bus, node: NodeId, word: ControlWord) -> Result<(), HubError> {
    bus.write(node, objects::CONTROL_WORD.write(word.get()))
}

/// A command that was not confirmed may have arrived: the status tells.
fn tolerate(written: Result<(), HubError>) -> Result<(), HubError> {
    match written {
        Err(HubError::WriteInDoubt { .. } | HubError::Refused { .. }) => Ok(()),
        other => other,
    }
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<Disabled>()
}
