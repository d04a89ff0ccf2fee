//! `docs/coverage.md` has every function code, function, object and section of the documents, and names only what exists.
//!
//! The page is written by hand. Codes and objects are compared with the tables of the codecs, paths with the items in the source, commands
//! with the definition that clap reads, files with the repository. Macros are not expanded, so a name in a macro call counts as declared.

mod answer;
mod broken_pages;
mod check;
mod commands;
mod names;
mod page;
mod required;
mod sources;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use check::check;
use commands::Tool;
use names::typed_objects;
use page::Complaint;
use sources::Items;

/// The page, from the top of the workspace.
const PAGE: &str = "docs/coverage.md";

const CRATES: [(&str, &str); 14] = [
    ("bus_plan", "crates/bus-plan/src/lib.rs"),
    ("bus_user", "crates/bus-user/src/lib.rs"),
    ("can_frame", "crates/can-frame/src/lib.rs"),
    ("can_motion", "crates/can-motion/src/lib.rs"),
    ("diff_drive", "crates/diff-drive/src/lib.rs"),
    ("drive_sim", "crates/drive-sim/src/lib.rs"),
    ("dyn_can", "crates/dyn-can/src/lib.rs"),
    ("dyn_commission", "crates/dyn-commission/src/lib.rs"),
    ("homing", "crates/homing/src/lib.rs"),
    ("dyn_serial", "crates/dyn-serial/src/lib.rs"),
    ("dyn_values", "crates/dyn-values/src/lib.rs"),
    ("motion_board", "src/main.rs"),
    ("motionctl", "crates/motionctl/src/main.rs"),
    ("zlac8030l", "crates/zlac8030l/src/lib.rs"),
];

fn top() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.parent().expect("the workspace").to_path_buf()
}

fn page() -> String {
    std::fs::read_to_string(top().join(PAGE)).expect(PAGE)
}

/// The code as it is, to compare pages with.
struct Code {
    /// The workspace.
    top: PathBuf,
    /// Items by the name of their crate.
    crates: BTreeMap<&'static str, Items>,
    /// The command line.
    tool: Tool,
    /// Addresses of the constants of `zlac8030l::objects`.
    typed_objects: BTreeMap<String, String>,
}

/// Read once for all tests.
static CODE: LazyLock<Code> = LazyLock::new(|| {
    let top = top();
    let mut read = BTreeMap::new();
    for (name, file) in CRATES {
        read.insert(name, sources::read(&top.join(file)));
    }
    Code {
        tool: Tool::of(&read["motionctl"].1),
        typed_objects: typed_objects(&read["zlac8030l"].1),
        crates: read
            .into_iter()
            .map(|(name, (items, _))| (name, items))
            .collect(),
        top,
    }
});

impl Code {
    /// What is wrong with a page that says this.
    fn complaints(&self, text: &str) -> Vec<Complaint> {
        check(text, self)
    }
}

#[test]
fn the_page_is_complete_and_names_what_exists() {
    let complaints = CODE.complaints(&page());
    let lines: Vec<String> = complaints.iter().map(ToString::to_string).collect();
    assert!(
        lines.is_empty(),
        "{PAGE} does not agree with the code:\n{}",
        lines.join("\n")
    );
}

/// Rows with something that is missing, and whether the end of the page lists them by what stands in their first cell.
fn unlisted(page: &str) -> Vec<&str> {
    let missing = page
        .split_once("\n## What is missing\n")
        .map_or("", |(_, missing)| missing);
    page.lines()
        .filter(|line| line.starts_with("| ") && line.contains("not yet"))
        .filter_map(|line| line.trim_start_matches("| ").split(" | ").next())
        .filter(|subject| !missing.contains(subject))
        .collect()
}

#[test]
fn what_is_not_there_yet_is_listed_in_one_place() {
    let page = page();
    assert_eq!(unlisted(&page), Vec::<&str>::new());
    let worse = page.replacen("no: gains are tuned once, with the tool", "not yet", 1);
    assert_eq!(unlisted(&worse), ["0x0B"]);
}
