//! `motionctl write --drives zlac`: changes objects of a drive, after comparing and asking.

use std::process::ExitCode;

use super::bus::Bus;
use super::error::HubError;
use super::frames;
use super::identity::{require_settable, tell_of_master};
use super::nodes::OneNode;
use super::object::ObjectSetting;
use super::store::{NodeOutcome, request};
use crate::confirm::confirm;
use crate::drives::{Step, When};
use crate::dry_run;
use crate::interrupt;
use crate::link::LinkOptions;
use crate::output::{print, print_json, tell};
use zlac8030l::{NodeId, objects};

const EXAMPLES: &str = "\
Examples:
  motionctl write --drives zlac --slcan /dev/ttyACM0 2014h=120                    rated current 12 A
  motionctl write --drives zlac:5 --can can0 speed-resolution-divider=10 --yes    1/10 r/min, from the next start on
  motionctl write --drives zlac --can can0 2030h:02=9 202Fh:03=0                  X0 is an emergency stop that holds the shaft
  motionctl write --drives zlac --can can0 parking-mode=1 --no-save               until the power goes

The drive must not be enabled. It is read first; what it has already is not written. The rest is shown, confirmed, written to the RAM of
the drive, read back, and saved once (2009h = 2), which stores everything that is in its RAM: one EEPROM write, however many objects.

Exit status: 0 the drive has every value, 1 it refuses or does not answer, 2 not confirmed, enabled, or out of range, and nothing was
written, 3 the link failed, 4 some of it is in the RAM and nothing was saved.";

/// Options of `motionctl write --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    link: LinkOptions,
    #[command(flatten)]
    node: OneNode,
    /// Objects and their new values.
    #[arg(value_name = "OBJECT=VALUE", required = true, value_parser = ObjectSetting::parse, allow_hyphen_values = false)]
    settings: Vec<ObjectSetting>,
    /// Write to the RAM of the drive and save nothing.
    #[arg(long)]
    no_save: bool,
    /// Write without asking.
    #[arg(long)]
    yes: bool,
    /// Show the frames and send nothing.
    #[arg(long)]
    dry_run: bool,
    /// Print what was done as JSON.
    #[arg(long)]
    json: bool,
}

/// Reads, compares, asks, writes, saves.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    let node = arguments.node.get()?;
    refuse_twice(&arguments.settings)?;
    if arguments.dry_run {
        let steps = write_frames(node, &arguments.settings, !arguments.no_save)?;
        dry_run::show(steps, arguments.json).map_err(HubError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut bus = Bus::open(&arguments.link)?;
    require_settable(&mut bus, node)?;
    let mut outcome = NodeOutcome::compare(&mut bus, node, &arguments.settings)?;
    if !outcome.is_same() {
        tell_of_master(&mut bus, node, "a save stores them too")?;
        confirm(&question(&outcome, arguments.no_save), arguments.yes)
            .map_err(HubError::NotConfirmed)?;
        interrupt::listen().map_err(HubError::Interrupt)?;
    }
    let written = outcome.write(&mut bus, node, !arguments.no_save);
    // Whatever failed: the user has to know what is in the drive now.
    let printed = if arguments.json {
        print_json(&outcome)
    } else {
        print(&outcome)
    };
    if let Err(error) = written {
        if printed.is_err() {
            tell(&outcome);
        }
        return Err(HubError::Unfinished {
            error: Box::new(error),
            is_started: outcome.has_written(),
        });
    }
    printed.map_err(HubError::Print)?;
    Ok(ExitCode::SUCCESS)
}

fn refuse_twice(settings: &[ObjectSetting]) -> Result<(), HubError> {
    for (place, setting) in settings.iter().enumerate() {
        let address = setting.entry.address;
        if settings[..place]
            .iter()
            .any(|other| other.entry.address == address)
        {
            return Err(HubError::Input(format!("{setting} is given twice")));
        }
    }
    Ok(())
}

fn question(outcome: &NodeOutcome, no_save: bool) -> String {
    let lasts = if no_save {
        "until its power goes; nothing is saved"
    } else {
        "and save them with everything else in its RAM, which outlasts a power cycle: one EEPROM write"
    };
    let mut text = format!("Node {} will have these values {lasts}:\n", outcome.node);
    for change in &outcome.changes {
        text.push_str(&format!("  {change}\n"));
    }
    text.push_str("Write?");
    text
}

/// The frames of writing settings to a drive.
///
/// # Errors
/// [`HubError::Input`] for a value that an object cannot hold.
pub(super) fn write_frames(
    node: NodeId,
    settings: &[ObjectSetting],
    saves: bool,
) -> Result<Vec<Step>, HubError> {
    let before = [
        objects::DEVICE_TYPE.read(),
        objects::VENDOR_ID.read(),
        objects::PRODUCT_CODE.read(),
        objects::STATUS_WORD.read(),
    ];
    let mut steps: Vec<Step> = before
        .into_iter()
        .chain(settings.iter().map(|setting| setting.entry.read()))
        .map(|read| frames::transfer(When::Before, node, read))
        .collect();
    let off = objects::EEPROM_UPDATE.write(objects::EEPROM_UPDATE_OFF);
    steps.push(frames::transfer(When::IfDifferent, node, off));
    for setting in settings {
        steps.push(frames::transfer(When::IfDifferent, node, request(setting)?));
        steps.push(frames::transfer(When::ReadBack, node, setting.entry.read()));
    }
    if saves {
        let save = objects::STORE.write(objects::STORE_SAVE_ALL);
        steps.push(frames::transfer(When::IfDifferent, node, save));
    }
    Ok(steps)
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<NodeOutcome>()
}
