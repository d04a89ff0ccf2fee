//! `motionctl origin --drives zlac`: where a drive counts, or makes its present position 0.

use std::process::ExitCode;

use schemars::JsonSchema;
use serde::Serialize;
use zlac8030l::{SdoRequest, objects};

use super::bus::Bus;
use super::error::HubError;
use super::frames;
use super::identity::require_settable;
use super::nodes::OneNode;
use crate::confirm::confirm;
use crate::drives::When;
use crate::dry_run;
use crate::link::LinkOptions;
use crate::output::{print, print_json};

const EXAMPLES: &str = "\
Examples:
  motionctl origin --drives zlac --slcan /dev/ttyACM0              show the position
  motionctl origin --drives zlac:5 --can can0 --set --yes          make it 0

--set clears the feedback (2005h) and the position of absolute moves (2006h) together, so that both count from the same place. The
encoder is incremental: the zero is lost with the power, and nothing is stored. The drive must not be enabled.

Exit status: 0 shown or set, 1 the drive does not answer or did not take it, 2 not confirmed, or enabled, 3 the link failed.";

/// Options of `motionctl origin --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    link: LinkOptions,
    #[command(flatten)]
    node: OneNode,
    /// Make the present position 0.
    #[arg(long)]
    set: bool,
    /// Set without asking.
    #[arg(long)]
    yes: bool,
    /// Show the frames and send nothing.
    #[arg(long)]
    dry_run: bool,
    /// Print the positions as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize, JsonSchema)]
struct End {
    node: u8,
    position_before_counts: i32,
    /// The same without --set.
    position_counts: i32,
    was_set: bool,
}

/// What makes the present position 0.
pub(super) fn clearing() -> [SdoRequest; 2] {
    [
        objects::CLEAR_FEEDBACK_POSITION.write(1),
        objects::CLEAR_ABSOLUTE_POSITION.write(1),
    ]
}

/// Shows the position, or clears it.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    let node = arguments.node.get()?;
    let position = objects::ACTUAL_POSITION;
    if arguments.dry_run {
        let read = frames::transfer(When::Before, node, position.read());
        let clearing = clearing().map(|request| frames::transfer(When::Always, node, request));
        let set = clearing.into_iter().filter(|_| arguments.set);
        let steps = core::iter::once(read).chain(set).collect();
        dry_run::show(steps, arguments.json).map_err(HubError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut bus = Bus::open(&arguments.link)?;
    if arguments.set {
        require_settable(&mut bus, node)?;
    }
    let before = bus.read(node, position)?;
    if arguments.set {
        let question = format!(
            "Node {node} will count from where it stands: {before} counts become 0, until its power goes. Set?"
        );
        confirm(&question, arguments.yes).map_err(HubError::NotConfirmed)?;
        for request in clearing() {
            bus.write(node, request)?;
        }
    }
    let end = End {
        node: node.get(),
        position_before_counts: before,
        position_counts: bus.read(node, position)?,
        was_set: arguments.set,
    };
    show(&end, arguments.json)?;
    if arguments.set && end.position_counts != 0 {
        return Err(HubError::NotTaken {
            node,
            address: position.address(),
            expected: 0,
            actual: end.position_counts.into(),
        });
    }
    Ok(ExitCode::SUCCESS)
}

fn show(end: &End, json: bool) -> Result<(), HubError> {
    let printed = if json {
        print_json(end)
    } else if end.was_set {
        print(format_args!(
            "node {} stood at {} counts and is at {} now",
            end.node, end.position_before_counts, end.position_counts
        ))
    } else {
        print(format_args!(
            "node {} is at {} counts",
            end.node, end.position_counts
        ))
    };
    printed.map_err(HubError::Print)?;
    Ok(())
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<End>()
}
