//! The table of the checks, in the order in which they run: what fails soonest comes first.

use super::interop;
use super::need::{
    CAN_KERNEL, CARGO_DENY, CHROMIUM, OLDEST_RUST, PYTHON, TARGET, TARGET_INSTALLED, TMUX, TSHARK,
    WINDOWS, WINE,
};
use super::oldest_rust;
use super::published;
use super::python_package;
use super::recipes;
use super::report_page;
use super::seeded_mistakes;
use super::step::Step;
use super::tests_of_host;
use crate::cost;

/// Every step.
pub(super) const STEPS: &[Step] = &[
    Step::cargo(
        "format",
        "every file is as rustfmt writes it",
        &[
            "fmt --all --check",
            "fmt --manifest-path firmware-tests/Cargo.toml --check",
        ],
    ),
    Step::cargo(
        "lint",
        "clippy has nothing to say about the host's code",
        &["clippy --workspace --all-targets -- -D warnings"],
    ),
    Step::cargo(
        "module-cycles",
        "no two files of a crate need each other",
        &["xtask module-cycles"],
    ),
    // A missing `cfg` hides in the combinations nobody builds.
    Step::cargo(
        "features",
        "each feature of the libraries builds alone, and all build together",
        &[
            "check -p board-settings --no-default-features",
            "check -p board-settings --all-features",
            "check -p bus-plan --no-default-features",
            "check -p bus-plan --all-features",
            "check -p bus-user --no-default-features",
            "check -p bus-user --all-features",
            "check -p can-frame --no-default-features",
            "check -p can-frame --no-default-features --features embedded-can",
            "check -p can-frame --no-default-features --features defmt",
            "check -p dyn-can --no-default-features",
            "check -p dyn-can --no-default-features --features embedded-can",
            "check -p dyn-can --no-default-features --features defmt",
            "check -p dyn-can --all-features",
            "check -p dyn-commission --no-default-features",
            "check -p dyn-commission --all-features",
            "check -p homing --no-default-features",
            "check -p homing --all-features",
            "check -p dyn-values --no-default-features",
            "check -p dyn-values --all-features",
            "check -p dyn-serial --no-default-features",
            "check -p dyn-serial --no-default-features --features embedded-io",
            "check -p dyn-serial --no-default-features --features defmt",
            "check -p dyn-serial --all-features",
            "check -p zlac8030l --no-default-features",
            "check -p zlac8030l --no-default-features --features embedded-can",
            "check -p zlac8030l --no-default-features --features defmt",
            "check -p zlac8030l --all-features",
            "check -p can-motion --no-default-features",
            "check -p can-motion --no-default-features --features zlac",
            "check -p can-motion --all-features",
        ],
    ),
    Step::call(
        "test",
        "every test that runs on the host",
        tests_of_host::run,
    ),
    Step::cargo(
        "examples",
        "every example of the libraries runs to its end, and the pictures of the profiles are those that would be drawn",
        &[
            "run -q -p can-motion --example servo",
            "run -q -p can-motion --example group_stop",
            "run -q -p can-motion --example point_to_point",
            "run -q -p dyn-commission --example bring_up",
            "run -q -p can-motion --example third_family",
            "run -q -p can-motion --example async_front_end",
            "run -q -p can-motion --features zlac --example wheels",
            "run -q -p trajectory --example move_and_stop",
            "run -q -p trajectory --example override_and_pause",
            "run -q -p trajectory --example follow",
            "run -q -p trajectory --example pictures -- --check",
        ],
    ),
    Step::call(
        "recipes",
        "each recipe of ARCHITECTURE.md, as somebody followed it: its patch applies, builds, and passes its tests",
        recipes::run,
    ),
    Step::call(
        "packages",
        "every crate for users can be packed, and a project that has the packages alone builds and moves a simulated axis",
        published::run,
    ),
    Step::cargo(
        "docs",
        "rustdoc has no warning",
        &["doc --workspace --no-deps --config build.rustdocflags=[\"-D\",\"warnings\"]"],
    ),
    Step::for_boards(
        "firmware",
        "the images of each board build: firmware, without the link and with it over a UART and over USB, and commissioning",
        &[
            "fw --board stm32f405",
            "fw --board stm32g474",
            "fw --board stm32f405 --commission",
            "fw --board stm32g474 --commission",
            "fw --board stm32f405 --link",
            "fw --board stm32g474 --link",
            "fw --board stm32f405 --link --homing",
            "fw --board stm32g474 --link --homing",
            "fw --board stm32f405 --link-usb",
            "fw --board stm32g474 --link-usb",
        ],
    )
    .needs(&[&TARGET]),
    Step::for_boards(
        "hals",
        "the examples for bxcan, MCP2515, SocketCAN, embassy and an ESP32 compile",
        &["hals"],
    )
    .needs(&[&TARGET]),
    // The host's clippy does not see the code of the board, and only the toolchain of the target can lint it.
    Step::cargo(
        "firmware-lint",
        "clippy has nothing to say about the boards' code",
        &[
            // One package at a time: together each would have the features of the other.
            "clippy --release -p motion-board --target thumbv7em-none-eabihf -- -D warnings",
            "clippy --release -p proofs --target thumbv7em-none-eabihf -- -D warnings",
            "clippy --release -p motion-board --target thumbv7em-none-eabihf --no-default-features --features stm32g474 -- -D warnings",
            "clippy --release -p motion-board --target thumbv7em-none-eabihf --no-default-features --features stm32g474,misbehave,commission -- -D warnings",
            "clippy --release -p motion-board --target thumbv7em-none-eabihf --features misbehave,commission -- -D warnings",
            "clippy --release -p motion-board --target thumbv7em-none-eabihf --features link -- -D warnings",
            "clippy --release -p motion-board --target thumbv7em-none-eabihf --no-default-features --features stm32g474,link -- -D warnings",
            "clippy --release -p motion-board --target thumbv7em-none-eabihf --features link-homing -- -D warnings",
            "clippy --release -p motion-board --target thumbv7em-none-eabihf --features link-usb -- -D warnings",
            "clippy --release -p motion-board --target thumbv7em-none-eabihf --no-default-features --features stm32g474,link-homing -- -D warnings",
            "clippy --release -p motion-board --target thumbv7em-none-eabihf --no-default-features --features stm32g474,link-usb -- -D warnings",
        ],
    )
    .needs(&[&TARGET_INSTALLED]),
    Step::for_boards(
        "proofs",
        "the libraries contain no panic, and their size on the target",
        &["proofs"],
    )
    .needs(&[&TARGET]),
    Step::for_boards(
        "firmware-tests",
        "the real images on emulated boards; the first time this builds the emulator",
        &["firmware-tests"],
    )
    .needs(&[&TARGET, &PYTHON]),
    Step::call(
        "cost",
        "no figure that is quick to measure is more than 3 % above docs/cost.md: stm32f405 with 8 axes, its flash, hot path, profiles, libraries",
        |_| cost::check(),
    )
    .needs(&[&TARGET, &PYTHON]),
    Step::cargo(
        "sim",
        "a motion of the servos and of the wheels on simulated drives",
        &["sim", "sim -- --drives zlac"],
    ),
    Step::cargo(
        "limits",
        "the table of what a bus carries is measured",
        &["run -q --profile tools -p motionctl -- limits"],
    ),
    Step::call(
        "report-page",
        "the pages of sim (servos, wheels, a program), of run and of its log in a browser: wide, narrow, dark; nothing cut off, every chart answers",
        report_page::run,
    )
    .needs(&[&CHROMIUM]),
    Step::call(
        "terminal",
        "the live views of sim and run in a terminal of 80 columns and 24 lines: every axis and key is there, and the keys work",
        interop::terminal,
    )
    .needs(&[&PYTHON, &TMUX]),
    Step::call(
        "commands",
        "every command in a block of README and documents, run against simulated drives, and the output that is shown there",
        interop::commands,
    )
    .needs(&[&PYTHON]),
    Step::cargo(
        "serial-fuzz",
        "ten million random bytes for the serial decoder",
        &["run -q -p host-tests --bin serial-fuzz"],
    ),
    Step::cargo(
        "fuzz",
        "LLVM's fuzzer finds no input that breaks a decoder, a log reader or the reader of programs: 50,000 inputs each, more by hand",
        &["xtask fuzz --runs 50000 --seed 1"],
    ),
    Step::call(
        "python-can-logs",
        "logs that python-can writes, read by `motionctl decode`",
        interop::python_can_logs,
    )
    .needs(&[&PYTHON]),
    Step::call(
        "python-can-bench",
        "python-can at the adapter of the bench, the README's script, and a motion of `motionctl run` through it",
        interop::python_can_bench,
    )
    .needs(&[&PYTHON]),
    Step::call(
        "mcap",
        "MCAP files of sim and run, read by the Python package mcap: every cycle, every frame, each message by its schema",
        interop::mcap_recording,
    )
    .needs(&[&PYTHON]),
    Step::call(
        "socketcan",
        "a kernel with CAN, run as a program: SocketCAN, can-utils, and the bench behind a network interface",
        interop::socketcan,
    )
    .needs(&[&PYTHON, &CAN_KERNEL]),
    Step::call(
        "pyserial-bench",
        "pyserial at the serial port of the simulated drives, and python-can at the CAN bus of the same drives",
        interop::pyserial_bench,
    )
    .needs(&[&PYTHON]),
    Step::call(
        "python-canopen",
        "python-canopen as the drive of our SDO client, and as the master of the simulated hub-motor drive",
        interop::python_canopen,
    )
    .needs(&[&PYTHON]),
    Step::call(
        "python",
        "the wheel of the Python package, its types, its tests and examples: vectors, the tool, a simulated board",
        python_package::run,
    )
    .needs(&[&PYTHON]),
    Step::call(
        "python-emulator",
        "an example of the Python package commands the real image on the emulated board, through its serial port",
        python_package::on_emulator,
    )
    .needs(&[&TARGET, &PYTHON]),
    Step::call(
        "windows",
        "motionctl builds for Windows without a warning",
        |place| interop::windows_program(place).map(|_| Vec::new()),
    )
    .needs(&[&WINDOWS]),
    Step::call(
        "wine",
        "the program of Windows under Wine: plan, sim, decode, check say what they say on Linux; ports, PCAN-Basic, Ctrl-C in a motion",
        interop::wine,
    )
    .needs(&[&WINDOWS, &PYTHON, &WINE]),
    Step::call(
        "eds",
        "python-canopen and Lely's dcf-tools load the data sheet of the hub motors without a warning",
        interop::eds,
    )
    .needs(&[&PYTHON]),
    Step::call(
        "dbc",
        "cantools loads the database of DYN CAN, and says of each frame what `motionctl decode` says",
        interop::dbc,
    )
    .needs(&[&PYTHON]),
    Step::call(
        "wireshark",
        "tshark with the dissector of DYN CAN says of each frame what `motionctl decode` says",
        interop::wireshark,
    )
    .needs(&[&PYTHON, &TSHARK]),
    Step::cargo(
        "supply-chain",
        "licences, sources and doubles of what the project depends on are those of deny.toml; known vulnerabilities need a network",
        &["deny --offline check bans licenses sources"],
    )
    .needs(&[&CARGO_DENY]),
    Step::call(
        "oldest-rust",
        "everything of the host compiles with the oldest Rust of the manifests",
        oldest_rust::run,
    )
    .needs(&[&OLDEST_RUST]),
    Step::call(
        "mutants",
        "how many mistakes in the lines of the core that the last change touched are found, five minutes at most",
        seeded_mistakes::run,
    ),
];

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::ci::step::Action;

    #[test]
    fn every_name_is_there_once() {
        let names: BTreeSet<_> = STEPS.iter().map(|step| step.name).collect();
        assert_eq!(names.len(), STEPS.len());
    }

    #[test]
    fn every_step_does_something_and_says_what() {
        for step in STEPS {
            assert!(!step.purpose.is_empty(), "{}", step.name);
            if let Action::Cargo(lines) | Action::ForBoards(lines) = &step.action {
                assert!(!lines.is_empty(), "{}", step.name);
            }
        }
    }

    #[test]
    fn a_step_that_builds_for_the_boards_looks_for_their_toolchain() {
        for step in STEPS {
            if matches!(step.action, Action::ForBoards(_)) {
                let first = step.needs.first().map(|need| need.name);
                assert_eq!(first, Some(TARGET.name), "{}", step.name);
            }
        }
    }
}
