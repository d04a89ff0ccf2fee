//! What `--dry-run` shows.

use std::io;

use comfy_table::Table;
use comfy_table::presets::NOTHING;
use schemars::JsonSchema;
use serde::Serialize;

use crate::drives::Step;
use crate::output::{print, print_json};

#[derive(Serialize, JsonSchema)]
struct DryRun {
    /// Always true: nothing was sent.
    dry_run: bool,
    frames: Vec<Step>,
}

/// Shows the frames that a command would send.
///
/// # Errors
/// As [`print()`].
pub(crate) fn show(frames: Vec<Step>, json: bool) -> io::Result<()> {
    if json {
        print_json(&DryRun {
            dry_run: true,
            frames,
        })?;
        return Ok(());
    }
    let mut table = Table::new();
    table.load_style(NOTHING);
    for step in frames {
        table.add_row([step.when.words().to_owned(), step.hex, step.words]);
    }
    print("dry run: nothing is sent and no port is opened. These frames would go out")?;
    print(table.trim_fmt())?;
    Ok(())
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<DryRun>()
}
