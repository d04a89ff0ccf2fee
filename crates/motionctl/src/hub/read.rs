//! `motionctl read --drives zlac`: the state and the objects of a drive.

use std::process::ExitCode;

use comfy_table::Table;
use comfy_table::presets::NOTHING;
use schemars::JsonSchema;
use serde::Serialize;
use zlac8030l::dictionary::{self, Access, Entry};
use zlac8030l::{NodeId, objects};

use super::bus::Bus;
use super::error::HubError;
use super::frames;
use super::nodes::OneNode;
use super::object::{address_text, name, object, settings};
use super::state::HubState;
use crate::drives::When;
use crate::dry_run;
use crate::link::LinkOptions;
use crate::output::{print, print_json};
use crate::schema::Either;

const EXAMPLES: &str = "\
Examples:
  motionctl read --drives zlac --slcan /dev/ttyACM0                  the state and every setting of node 4
  motionctl read --drives zlac:5 --can can0 2029h 2026h:01 rated-current
  motionctl read --drives zlac --can can0 --all --json               every object of the dictionary

An object is an address (2014h, 202Fh:05) or its name in the guide (rated-current). Nothing moves and nothing is changed; a drive with
a fault, or one that is enabled, can be read too.

Exit status: 0 read, 1 the drive does not answer or refuses, 2 there is no such object, 3 the link failed.";

/// Options of `motionctl read --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    link: LinkOptions,
    #[command(flatten)]
    node: OneNode,
    /// Objects to read. Default: the state and every setting.
    #[arg(value_name = "OBJECT", value_parser = object)]
    objects: Vec<&'static Entry>,
    /// Read every object of the dictionary.
    #[arg(long, conflicts_with = "objects")]
    all: bool,
    /// Show the frames and send nothing.
    #[arg(long)]
    dry_run: bool,
    /// Print what was read as JSON.
    #[arg(long)]
    json: bool,
}

/// One object with its value.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Value {
    pub(super) object: String,
    pub(super) name: String,
    pub(super) value: i64,
    unit: &'static str,
    /// As it is printed in the guide; none where it prints none.
    default: Option<i64>,
    /// Kept over a power cycle, once it is saved.
    stored: bool,
}

impl Value {
    /// The unit of the value; empty where the guide has none.
    pub(super) fn unit(&self) -> &'static str {
        self.unit
    }
}

#[derive(Debug, Serialize, JsonSchema)]
struct Readings {
    node: u8,
    software_version: u16,
    #[serde(flatten)]
    state: HubState,
    objects: Vec<Value>,
}

/// Reads a drive and prints what it tells.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    let node = arguments.node.get()?;
    let wanted = wanted(arguments);
    if arguments.dry_run {
        let reads = wanted.iter().map(|entry| entry.read());
        let steps = reads.map(|read| frames::transfer(When::Always, node, read));
        dry_run::show(steps.collect(), arguments.json).map_err(HubError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut bus = Bus::open(&arguments.link)?;
    if !arguments.objects.is_empty() {
        return print_values(&values(&mut bus, node, &wanted)?, arguments.json);
    }
    let readings = Readings {
        node: node.get(),
        software_version: bus.read(node, objects::SOFTWARE_VERSION)?,
        state: HubState::read(&mut bus, node)?,
        objects: values(&mut bus, node, &wanted)?,
    };
    if arguments.json {
        print_json(&readings).map_err(HubError::Print)?;
    } else {
        print(format_args!(
            "node {node}, software {:04X}h: {}",
            readings.software_version, readings.state
        ))
        .map_err(HubError::Print)?;
        print(table(&readings.objects)).map_err(HubError::Print)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn wanted(arguments: &Arguments) -> Vec<&'static Entry> {
    if arguments.all {
        dictionary::entries().collect()
    } else if arguments.objects.is_empty() {
        settings().collect()
    } else {
        arguments.objects.clone()
    }
}

/// Reads objects one after the other.
///
/// # Errors
/// As [`Bus::read`].
pub(super) fn values(
    bus: &mut Bus,
    node: NodeId,
    entries: &[&'static Entry],
) -> Result<Vec<Value>, HubError> {
    let read = |entry: &&'static Entry| {
        Ok(Value {
            object: address_text(entry.address),
            name: name(entry),
            value: bus.read_number(node, entry.address)?,
            unit: entry.unit,
            default: entry.default.of(node),
            stored: entry.access == Access::RwS,
        })
    };
    entries.iter().map(read).collect()
}

fn print_values(values: &[Value], json: bool) -> Result<ExitCode, HubError> {
    if json {
        print_json(&values).map_err(HubError::Print)?;
    } else {
        print(table(values)).map_err(HubError::Print)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn table(values: &[Value]) -> String {
    let mut table = Table::new();
    table.load_style(NOTHING);
    for value in values {
        let differs = value.default.filter(|default| *default != value.value);
        table.add_row([
            value.object.clone(),
            value.name.clone(),
            value.value.to_string(),
            value.unit.to_owned(),
            differs.map_or(String::new(), |default| format!("default {default}")),
        ]);
    }
    table.trim_fmt()
}

/// The shape of what `--json` prints: everything, or the objects that were named.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<Either<Readings, Vec<Value>>>()
}
