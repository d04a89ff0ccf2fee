//! `motionctl restore --drives zlac`: the objects of a file into drives.

use core::fmt;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use schemars::JsonSchema;
use serde::Serialize;
use zlac8030l::NodeId;

use super::bus::Bus;
use super::error::HubError;
use super::identity::{require_settable, require_zlac, tell_of_master};
use super::nodes::SomeNodes;
use super::settings_file::{self, NodeSettings};
use super::store::NodeOutcome;
use super::write::write_frames;
use crate::confirm::confirm;
use crate::dry_run;
use crate::exit;
use crate::interrupt;
use crate::link::LinkOptions;
use crate::output::{print, print_json, tell};

const EXAMPLES: &str = "\
Examples:
  motionctl restore wheels.toml --drives zlac --slcan /dev/ttyACM0              every drive of the file
  motionctl restore wheels.toml --drives zlac:5 --can can0 --yes --json
  motionctl restore wheels.toml --drives zlac --can can0 --compare              show the difference and write nothing

The drives must not be enabled. Each is compared with the file; what differs is shown, confirmed, written to the RAM of the drive, read
back, and saved once: one EEPROM write a drive that differs. Objects that the drive has no EEPROM place for last until the power goes,
and are marked so. Where something fails, what was written until then is said, and that drive is not saved.

Exit status: 0 every drive has every value, 1 a drive refuses or does not answer, or --compare found a difference, 2 the file cannot be
used, or a drive is enabled, and nothing was written, 3 the link failed, 4 some of it is written.";

/// Options of `motionctl restore --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// The file of a backup.
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    #[command(flatten)]
    link: LinkOptions,
    #[command(flatten)]
    drives: SomeNodes,
    /// Show what differs and write nothing.
    #[arg(long)]
    compare: bool,
    /// Write to the RAM of the drives and save nothing.
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

/// What has become of everything.
#[derive(Debug, Serialize, JsonSchema)]
struct Outcome<'a> {
    file: &'a Path,
    /// Every drive has every value of the file.
    complete: bool,
    drives: Vec<NodeOutcome>,
}

/// Reads the file, compares, asks, writes what differs.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    let wanted = wanted(arguments)?;
    if arguments.dry_run {
        let mut steps = Vec::new();
        for drive in &wanted {
            steps.extend(write_frames(
                drive.node,
                &drive.settings,
                !arguments.no_save,
            )?);
        }
        dry_run::show(steps, arguments.json).map_err(HubError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut bus = Bus::open(&arguments.link)?;
    let mut outcome = compare(arguments, &mut bus, &wanted)?;
    let is_same = outcome.drives.iter().all(NodeOutcome::is_same);
    if is_same || arguments.compare {
        outcome.complete = is_same;
        report(arguments, &outcome)?;
        return Ok(if is_same {
            ExitCode::SUCCESS
        } else {
            exit::BROKEN_PROMISE.into()
        });
    }
    confirm(&question(arguments, &outcome), arguments.yes).map_err(HubError::NotConfirmed)?;
    interrupt::listen().map_err(HubError::Interrupt)?;
    let written = write(arguments, &mut bus, &wanted, &mut outcome);
    outcome.complete = written.is_ok();
    // Whatever failed, and even when this cannot be printed: the user has to know what is in the drives now.
    let printed = report(arguments, &outcome);
    match written {
        Ok(()) => printed.map(|()| ExitCode::SUCCESS),
        Err(error) => {
            if printed.is_err() {
                tell(&outcome);
            }
            Err(HubError::Unfinished {
                error: Box::new(error),
                is_started: outcome.drives.iter().any(NodeOutcome::has_written),
            })
        }
    }
}

/// The drives of the file that were asked for.
fn wanted(arguments: &Arguments) -> Result<Vec<NodeSettings>, HubError> {
    let path = &arguments.file;
    let text = settings_file::read(path).map_err(HubError::File)?;
    let in_file = |what: String| HubError::File(format!("{}: {what}", path.display()));
    let mut drives = settings_file::parse(&text).map_err(in_file)?;
    if !arguments.drives.are_named() {
        return Ok(drives);
    }
    let named = arguments.drives.ascending();
    for node in &named {
        if !drives.iter().any(|drive| drive.node == *node) {
            let there: Vec<NodeId> = drives.iter().map(|drive| drive.node).collect();
            return Err(in_file(format!(
                "node {node} is not in it, only {}",
                super::nodes::named(&there)
            )));
        }
    }
    drives.retain(|drive| named.contains(&drive.node));
    Ok(drives)
}

fn compare<'a>(
    arguments: &'a Arguments,
    bus: &mut Bus,
    wanted: &[NodeSettings],
) -> Result<Outcome<'a>, HubError> {
    let mut drives = Vec::new();
    for drive in wanted {
        if arguments.compare {
            require_zlac(bus, drive.node)?;
        } else {
            require_settable(bus, drive.node)?;
            tell_of_master(
                bus,
                drive.node,
                "a save stores those that the file leaves out",
            )?;
        }
        drives.push(NodeOutcome::compare(bus, drive.node, &drive.settings)?);
    }
    Ok(Outcome {
        file: &arguments.file,
        complete: false,
        drives,
    })
}

fn write(
    arguments: &Arguments,
    bus: &mut Bus,
    wanted: &[NodeSettings],
    outcome: &mut Outcome<'_>,
) -> Result<(), HubError> {
    for (drive, outcome) in wanted.iter().zip(&mut outcome.drives) {
        if interrupt::requests() > 0 {
            return Err(HubError::Interrupted);
        }
        outcome.write(bus, drive.node, !arguments.no_save)?;
    }
    Ok(())
}

fn question(arguments: &Arguments, outcome: &Outcome<'_>) -> String {
    let drives = outcome.drives.iter().filter(|drive| !drive.is_same());
    let saves = if arguments.no_save { 0 } else { drives.count() };
    format!("{outcome}\nThe drives will have these values. EEPROM writes: {saves}. Write?")
}

fn report(arguments: &Arguments, outcome: &Outcome<'_>) -> Result<(), HubError> {
    let printed = if arguments.json {
        print_json(outcome)
    } else {
        print(outcome)
    };
    printed.map_err(HubError::Print)?;
    Ok(())
}

impl fmt::Display for Outcome<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, drive) in self.drives.iter().enumerate() {
            if place > 0 {
                writeln!(f)?;
            }
            drive.fmt(f)?;
        }
        Ok(())
    }
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<Outcome<'_>>()
}
