//! What a machine must have for a step, and how it gets it.

use std::env;
use std::process::{Command, Stdio};

use super::oldest_rust::VERSION as OLDEST;
use crate::target::Target;
use crate::thumb::TARGET as BOARD_TARGET;
use crate::toolchain::{Preference, Toolchain};
use crate::windows::TARGET as WINDOWS_TARGET;

/// Something that a machine may lack.
pub(super) struct Need {
    /// What tells it apart from the others.
    pub(super) name: &'static str,
    /// What is lacking now; nothing when it is there.
    pub(super) lacking: fn() -> Option<String>,
    /// The packages of Debian that bring it.
    pub(super) packages: &'static [&'static str],
    /// What to do where these packages are of no use.
    pub(super) otherwise: Option<&'static str>,
}

/// Python with virtual environments.
pub(super) const PYTHON: Need = Need {
    name: "python",
    lacking: || all_of(&["python3"]),
    packages: &["python3", "python3-venv"],
    otherwise: None,
};

/// Any toolchain for the boards.
pub(super) const TARGET: Need = Need {
    name: "target",
    lacking: || no_toolchain(&BOARD_TARGET, Preference::Auto),
    packages: BOARD_TARGET.packages,
    otherwise: Some("rustup target add thumbv7em-none-eabihf"),
};

/// The usual toolchain with the target of the boards.
pub(super) const TARGET_INSTALLED: Need = Need {
    name: "installed target",
    lacking: || {
        let found = Toolchain::find(&BOARD_TARGET, Preference::Installed);
        found
            .err()
            .map(|_| format!("{} is not installed", BOARD_TARGET.triple))
    },
    packages: &[],
    otherwise: Some("rustup target add thumbv7em-none-eabihf"),
};

/// Any toolchain for Windows. It is not fetched with rustup, which may wait a minute for a server: its packages are at hand.
pub(super) const WINDOWS: Need = Need {
    name: "target of Windows",
    lacking: || {
        no_toolchain(&WINDOWS_TARGET, Preference::Installed)?;
        no_toolchain(&WINDOWS_TARGET, Preference::Source)
    },
    packages: WINDOWS_TARGET.packages,
    otherwise: Some(
        "rustup target add x86_64-pc-windows-gnu, and the linker x86_64-w64-mingw32-gcc",
    ),
};

/// Runs programs of Windows on Linux.
pub(super) const WINE: Need = Need {
    name: "wine",
    lacking: || all_of(&["wine"]),
    packages: &["wine", "wine64"],
    otherwise: None,
};

/// Looks at the licences and sources of dependencies. Building it takes minutes, so it is not installed unasked.
pub(super) const CARGO_DENY: Need = Need {
    name: "cargo-deny",
    lacking: || all_of(&["cargo-deny"]),
    packages: &[],
    otherwise: Some("cargo install cargo-deny --locked"),
};

/// The oldest compiler that the manifests allow.
pub(super) const OLDEST_RUST: Need = Need {
    name: "oldest Rust",
    lacking: || {
        let asked = Command::new("rustup")
            .args(["run", OLDEST, "rustc", "--version"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status();
        let is_there = asked.is_ok_and(|status| status.success());
        (!is_there).then(|| format!("Rust {OLDEST} is not installed"))
    },
    packages: &[],
    otherwise: Some(concat!(
        "rustup toolchain install ",
        env!("CARGO_PKG_RUST_VERSION"),
        " --profile minimal"
    )),
};

/// A kernel with CAN that runs as a program, and the tools for CAN interfaces.
pub(super) const CAN_KERNEL: Need = Need {
    name: "kernel with CAN",
    lacking: || all_of(&["linux.uml", "slcand", "candump", "cansend", "ip"]),
    packages: &["user-mode-linux", "can-utils", "iproute2"],
    otherwise: None,
};

/// Wireshark without a window.
pub(super) const TSHARK: Need = Need {
    name: "tshark",
    lacking: || all_of(&["tshark"]),
    packages: &["tshark"],
    otherwise: None,
};

/// A terminal without a window.
pub(super) const TMUX: Need = Need {
    name: "tmux",
    lacking: || all_of(&["tmux"]),
    packages: &["tmux"],
    otherwise: None,
};

/// The names under which Chromium is installed.
pub(super) const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// A browser that runs without a screen.
pub(super) const CHROMIUM: Need = Need {
    name: "browser",
    lacking: || any_of(&BROWSERS),
    packages: &["chromium"],
    otherwise: None,
};

impl Need {
    /// What a user can do about it.
    pub(super) fn remedy(&self) -> String {
        let packages = (!self.packages.is_empty()).then(|| {
            format!(
                "apt-get install {} (Debian, as root; `--install-packages` does it)",
                self.packages.join(" ")
            )
        });
        let ways: Vec<String> = packages
            .into_iter()
            .chain(self.otherwise.map(str::to_owned))
            .collect();
        ways.join(", or: ")
    }
}

/// Whether a program is on the search path.
pub(super) fn is_installed(program: &str) -> bool {
    let path = env::var_os("PATH").unwrap_or_default();
    env::split_paths(&path).any(|folder| folder.join(program).is_file())
}

fn no_toolchain(target: &'static Target, preference: Preference) -> Option<String> {
    let found = Toolchain::find(target, preference);
    found
        .err()
        .map(|_| format!("no toolchain for {}", target.triple))
}

fn all_of(programs: &[&str]) -> Option<String> {
    let missing: Vec<&str> = programs
        .iter()
        .copied()
        .filter(|program| !is_installed(program))
        .collect();
    (!missing.is_empty()).then(|| format!("there is no {}", missing.join(", ")))
}

fn any_of(programs: &[&str]) -> Option<String> {
    let found = programs.iter().any(|program| is_installed(program));
    (!found).then(|| format!("there is none of {}", programs.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_missing_program_is_named() {
        assert_eq!(
            all_of(&["no-such-program-1", "cargo", "no-such-program-2"]).as_deref(),
            Some("there is no no-such-program-1, no-such-program-2")
        );
        assert_eq!(all_of(&["cargo"]), None);
    }

    #[test]
    fn one_of_several_programs_is_enough() {
        assert_eq!(any_of(&["no-such-program", "cargo"]), None);
        assert_eq!(
            any_of(&["no-such-program"]).as_deref(),
            Some("there is none of no-such-program")
        );
    }

    #[test]
    fn a_remedy_names_the_packages_and_the_other_way() {
        assert_eq!(
            TARGET.remedy(),
            "apt-get install rustc-web rust-web-src (Debian, as root; `--install-packages` does it), \
             or: rustup target add thumbv7em-none-eabihf"
        );
        assert_eq!(
            TARGET_INSTALLED.remedy(),
            "rustup target add thumbv7em-none-eabihf"
        );
    }
}
