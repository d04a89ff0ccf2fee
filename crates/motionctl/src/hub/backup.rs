//! `motionctl backup --drives zlac`: every writable object of drives into a file.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use schemars::JsonSchema;
use serde::Serialize;
use zlac8030l::dictionary::Entry;
use zlac8030l::{NodeId, objects};

use super::bus::Bus;
use super::error::HubError;
use super::frames;
use super::identity::{require_zlac, tell_of_master};
use super::nodes::SomeNodes;
use super::object::{ObjectSetting, settings};
use super::read::{Value, values};
use super::settings_file;
use crate::backup::file;
use crate::counted::counted;
use crate::drives::When;
use crate::dry_run;
use crate::link::LinkOptions;
use crate::output::{print, print_json};

const EXAMPLES: &str = "\
Examples:
  motionctl backup wheels.toml --drives zlac:4,5 --slcan /dev/ttyACM0
  motionctl backup wheels.toml --drives zlac:4,5 --can can0 --force --json

Every writable object is read, except commands, targets, node number and bit rate. Nothing moves and nothing is changed in the drives;
drives that are enabled or have a fault can be read too. A file that exists is kept unless --force is given.

Exit status: 0 the file has every setting of every drive, 1 a drive does not answer or holds something that cannot be restored, 2 the
file exists or cannot be written, 3 the link failed. There is no new file unless it is 0.";

/// Options of `motionctl backup --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// The file to write, in TOML.
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    #[command(flatten)]
    link: LinkOptions,
    #[command(flatten)]
    drives: SomeNodes,
    /// Replace a file that exists.
    #[arg(long)]
    force: bool,
    /// Show the frames, send nothing and write no file.
    #[arg(long)]
    dry_run: bool,
    /// Print what was read as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize, JsonSchema)]
struct BackedUp<'a> {
    file: &'a Path,
    drives: Vec<Drive<'a>>,
}

#[derive(Serialize, JsonSchema)]
struct Drive<'a> {
    node: u8,
    software_version: u16,
    objects: &'a [Value],
}

/// Reads the drives and writes the file.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    let entries: Vec<&'static Entry> = settings().collect();
    let nodes = arguments.drives.ascending();
    if arguments.dry_run {
        let reads = |node: NodeId| {
            let entries = entries.iter();
            entries.map(move |entry| frames::transfer(When::Always, node, entry.read()))
        };
        let steps = nodes.iter().flat_map(|&node| reads(node)).collect();
        dry_run::show(steps, arguments.json).map_err(HubError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    let path = &arguments.file;
    let in_file = |fault: file::FileFault| HubError::File(fault.to_string());
    file::require_room(path, arguments.force).map_err(in_file)?;
    let mut bus = Bus::open(&arguments.link)?;
    let mut drives = Vec::new();
    for node in nodes {
        require_zlac(&mut bus, node)?;
        tell_of_master(&mut bus, node, "the file has them")?;
        let software = bus.read(node, objects::SOFTWARE_VERSION)?;
        let values = values(&mut bus, node, &entries)?;
        check(node, &entries, &values)?;
        drives.push((node, software, values));
    }
    let text = settings_file::write(&file::origin(), &drives);
    file::create(path, &text, arguments.force).map_err(in_file)?;
    print_end(arguments, &drives)?;
    Ok(ExitCode::SUCCESS)
}

/// A value that `restore` would refuse is not written to a file.
fn check(node: NodeId, entries: &[&'static Entry], values: &[Value]) -> Result<(), HubError> {
    for (entry, value) in entries.iter().zip(values) {
        ObjectSetting::new(entry, value.value).map_err(|reason| HubError::BadReply {
            node,
            address: entry.address,
            reason: format!("{reason}: no file was written"),
        })?;
    }
    Ok(())
}

fn print_end(arguments: &Arguments, drives: &[(NodeId, u16, Vec<Value>)]) -> Result<(), HubError> {
    let path = arguments.file.as_path();
    let printed = if arguments.json {
        print_json(&BackedUp {
            file: path,
            drives: drives
                .iter()
                .map(|(node, software_version, objects)| Drive {
                    node: node.get(),
                    software_version: *software_version,
                    objects,
                })
                .collect(),
        })
    } else {
        let drives = counted(drives.len() as u64, "hub motor", "hub motors");
        print(format_args!(
            "{} has the settings of {drives}",
            path.display()
        ))
    };
    printed.map_err(HubError::Print)?;
    Ok(())
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<BackedUp<'_>>()
}
