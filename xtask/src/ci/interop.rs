//! Programs of other people against ours.

use std::path::PathBuf;

use super::place::Place;
use crate::error::Error;
use crate::toolchain::{Preference, Toolchain};
use crate::windows;

/// The independent implementations, pinned: a step must not change because one of them was released.
const PYTHON_PACKAGES: [&str; 7] = [
    "python-can==4.6.1",
    "canopen==2.4.1",
    "pyserial==3.5",
    "mcap==1.6.0",
    "fastjsonschema==2.22.3",
    "cantools==45.1.0",
    "dcf-tools==2.4.2",
];

/// A script against one of our programs.
struct Script {
    package: &'static str,
    program: &'static str,
    /// The script, from the root.
    path: &'static str,
    /// What it is given behind the program.
    arguments: &'static [&'static str],
}

pub(super) fn python_can_logs(place: &Place) -> Result<Vec<String>, Error> {
    Script {
        package: "motionctl",
        program: "motionctl",
        path: "crates/motionctl/tests/interop/python_can_logs.py",
        arguments: &[],
    }
    .run(place)
}

pub(super) fn python_can_bench(place: &Place) -> Result<Vec<String>, Error> {
    Script {
        package: "motionctl",
        program: "motionctl",
        path: "crates/motionctl/tests/interop/python_can_bench.py",
        arguments: &["README.md"],
    }
    .run(place)
}

pub(super) fn mcap_recording(place: &Place) -> Result<Vec<String>, Error> {
    Script {
        package: "motionctl",
        program: "motionctl",
        path: "crates/motionctl/tests/interop/mcap_recording.py",
        arguments: &[],
    }
    .run(place)
}

pub(super) fn pyserial_bench(place: &Place) -> Result<Vec<String>, Error> {
    Script {
        package: "motionctl",
        program: "motionctl",
        path: "crates/motionctl/tests/interop/pyserial_bench.py",
        arguments: &["host-tests/vectors/dyn232m.json"],
    }
    .run(place)
}

pub(super) fn python_canopen(place: &Place) -> Result<Vec<String>, Error> {
    Script {
        package: "host-tests",
        program: "canopen_bridge",
        path: "host-tests/interop/python_canopen.py",
        arguments: &[],
    }
    .run(place)
}

pub(super) fn eds(place: &Place) -> Result<Vec<String>, Error> {
    Script {
        package: "host-tests",
        program: "canopen_bridge",
        path: "host-tests/interop/eds.py",
        arguments: &["interop/zlac8030l.eds"],
    }
    .run(place)
}

pub(super) fn dbc(place: &Place) -> Result<Vec<String>, Error> {
    Script {
        package: "motionctl",
        program: "motionctl",
        path: "crates/motionctl/tests/interop/dbc.py",
        arguments: &["interop/dyn-can.dbc"],
    }
    .run(place)
}

pub(super) fn wireshark(place: &Place) -> Result<Vec<String>, Error> {
    Script {
        package: "motionctl",
        program: "motionctl",
        path: "crates/motionctl/tests/interop/wireshark.py",
        arguments: &["interop/dyn-can.lua"],
    }
    .run(place)
}

/// Needs no package of Python, and its kernel cannot see a virtual environment everywhere.
pub(super) fn socketcan(place: &Place) -> Result<Vec<String>, Error> {
    plain(place, "crates/motionctl/tests/interop/socketcan.py")
}

/// The tool for Windows.
pub(super) fn windows_program(place: &Place) -> Result<PathBuf, Error> {
    let workspace = place.workspace();
    // What `need` has found.
    let toolchain = Toolchain::find(&windows::TARGET, Preference::Installed)
        .or_else(|_| Toolchain::find(&windows::TARGET, Preference::Source))?;
    windows::build(workspace, &toolchain, windows::QUICK)
}

/// The tool for Windows beside the one for this system.
pub(super) fn wine(place: &Place) -> Result<Vec<String>, Error> {
    let program = windows_program(place)?;
    let motionctl = place.tool("motionctl", "motionctl")?;
    let script = "crates/motionctl/tests/interop/windows.py";
    place.script(
        place
            .command("python3")
            .arg(script)
            .arg(motionctl)
            .arg(program),
    )
}

/// What a terminal shows of the live views.
pub(super) fn terminal(place: &Place) -> Result<Vec<String>, Error> {
    plain(place, "crates/motionctl/tests/interop/terminal.py")
}

/// The commands of README and documents, against simulated drives.
pub(super) fn commands(place: &Place) -> Result<Vec<String>, Error> {
    plain(place, "crates/motionctl/tests/interop/commands.py")
}

/// A script that needs nothing but Python, given the tool.
fn plain(place: &Place, script: &str) -> Result<Vec<String>, Error> {
    let motionctl = place.tool("motionctl", "motionctl")?;
    place.script(place.command("python3").arg(script).arg(motionctl))
}

impl Script {
    fn run(&self, place: &Place) -> Result<Vec<String>, Error> {
        let python = virtual_environment(place, "interop-python", &PYTHON_PACKAGES)?;
        let program = place.tool(self.package, self.program)?;
        let mut command = place.command(python);
        place.script(command.arg(self.path).arg(program).args(self.arguments))
    }
}

/// A Python in `target` that has packages. pip is run as a module: its script does not start from a path with a space.
pub(super) fn virtual_environment(
    place: &Place,
    name: &str,
    packages: &[&str],
) -> Result<PathBuf, Error> {
    let folder = place.target().join(name);
    place.run(place.command("python3").args(["-m", "venv"]).arg(&folder))?;
    let python = folder.join("bin/python");
    place.run(
        place
            .command(&python)
            .args(["-m", "pip", "-q", "--disable-pip-version-check", "install"])
            .args(packages),
    )?;
    Ok(python)
}
