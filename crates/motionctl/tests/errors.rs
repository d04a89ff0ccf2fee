//! The error messages of docs/errors.md are those of the tool.
//!
//! To add one, add an entry to `MESSAGES`; `UPDATE_DOCS=1 cargo test -p motionctl --test errors` writes the page anew.

mod tool;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use tool::text;

/// One message: a title, the files it needs, the command that brings it about, its exit status.
struct Message {
    title: &'static str,
    files: &'static [(&'static str, &'static str)],
    command: &'static [&'static str],
    status: i32,
}

const MESSAGES: &[Message] = &[
    Message {
        title: "A value is missing",
        files: &[("motion.csv", "t,a,b\n0,0,0\n0.5,10,\n1,20,0\n")],
        command: &["sim", "--trajectory", "motion.csv"],
        status: 2,
    },
    Message {
        title: "A line is neither a header nor numbers",
        files: &[("motion.csv", "0,x,0\n0.5,10,5\n1,20,0\n")],
        command: &["sim", "--trajectory", "motion.csv"],
        status: 2,
    },
    Message {
        title: "No column is named time",
        files: &[("motion.csv", "x,a,b\n0,0,0\n0.5,10,5\n")],
        command: &["sim", "--trajectory", "motion.csv"],
        status: 2,
    },
    Message {
        title: "Columns without names",
        files: &[("motion.csv", "0 0 0\n1 10 10\n2 20 10\n")],
        command: &["sim", "--trajectory", "motion.csv"],
        status: 2,
    },
    Message {
        title: "A name that may mean an axis or something else",
        files: &[("motion.csv", "t,x,v\n0,0,0\n1,10,10\n")],
        command: &["sim", "--trajectory", "motion.csv"],
        status: 2,
    },
    Message {
        title: "A unit in a name and another in the option",
        files: &[("motion.csv", "time_ms,a_rad\n0,0\n500,1\n")],
        command: &["sim", "--trajectory", "motion.csv", "--unit", "degrees"],
        status: 2,
    },
    Message {
        title: "Millimetres without the travel of a turn",
        files: &[("motion.csv", "time_ms,x_mm\n0,0\n500,10\n")],
        command: &["sim", "--trajectory", "motion.csv"],
        status: 2,
    },
    Message {
        title: "A motion too long to be meant",
        files: &[(
            "motion.csv",
            "t,a\n1700000000000000000,0\n1700000001000000000,20\n",
        )],
        command: &["sim", "--trajectory", "motion.csv"],
        status: 2,
    },
    Message {
        title: "A motion too fast",
        files: &[("motion.csv", "t,a\n0,0\n0.1,360\n")],
        command: &["sim", "--trajectory", "motion.csv", "--max-step", "200"],
        status: 2,
    },
    Message {
        title: "A file that is no log",
        files: &[("notes.txt", "bought a screw\n")],
        command: &["decode", "notes.txt"],
        status: 2,
    },
    Message {
        title: "A log with a header that is not known",
        files: &[(
            "trace.trc",
            ";$FILEVERSION=2.1\n;$COLUMNS=N,O,Q,I,D\n 1 0.0 DT 0029\n",
        )],
        command: &["decode", "trace.trc"],
        status: 2,
    },
    Message {
        title: "Damaged lines of a log",
        files: &[(
            "run.log",
            "(0.1) can0 029#\n(0.2) can0 029#0\n(0.3) can0 029#00\n",
        )],
        command: &["decode", "--statistics-only", "run.log"],
        status: 1,
    },
];

const BEGIN: &str = "\
# Error messages

One message of each kind, with the files and the command that bring it about. A test of `motionctl` (`tests/errors.rs`) runs the
commands and compares this page with what the tool prints.
";

#[test]
fn the_page_has_the_messages_of_the_tool() {
    let mut actual = BEGIN.to_owned();
    for message in MESSAGES {
        write(&mut actual, message).expect("a text");
    }
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/errors.md");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&page, &actual).expect("the page");
    }
    let expected = std::fs::read_to_string(&page).expect("the page");
    for (expected, actual) in expected.lines().zip(actual.lines()) {
        assert_eq!(
            expected, actual,
            "run it with UPDATE_DOCS=1 and read what has changed"
        );
    }
    assert_eq!(expected, actual);
}

fn write(page: &mut String, message: &Message) -> std::fmt::Result {
    let folder = Folder::new();
    writeln!(page, "\n## {}\n", message.title)?;
    for (name, content) in message.files {
        std::fs::write(folder.0.join(name), content).expect("a temporary file");
        writeln!(page, "`{name}`:\n\n```text\n{}```\n", content)?;
    }
    let command = message.command.join(" ");
    let output = Command::new(env!("CARGO_BIN_EXE_motionctl"))
        .args(message.command)
        .current_dir(&folder.0)
        .output()
        .expect("motionctl runs");
    assert_eq!(
        output.status.code(),
        Some(message.status),
        "{}: {output:?}",
        message.title
    );
    let errors = text(&output.stderr);
    assert!(!errors.is_empty(), "{}", message.title);
    writeln!(
        page,
        "`motionctl {command}` ends with exit status {} and says:\n",
        message.status
    )?;
    writeln!(page, "```text\n{errors}```")
}

/// A folder of its own, so that the messages name files without their folders.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        let path = std::env::temp_dir().join(format!("motionctl-{}-errors", std::process::id()));
        std::fs::create_dir_all(&path).expect("a temporary folder");
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // Nothing depends on it: the folder is temporary.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
