//! Tasks of the project: `cargo xtask <task>`, with `cargo fw` as the short form of `cargo xtask fw`.

mod axis_profile;
mod calls;
mod ci;
mod cost;
mod emulator;
mod error;
mod firmware;
mod fuzz;
mod hals;
mod images;
mod module_cycles;
mod mutants;
mod output;
mod peers;
mod places;
mod profile;
mod proofs;
mod size;
mod size_profile;
mod symbols;
mod target;
mod thumb;
mod toolchain;
mod windows;
mod workspace;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Tasks of the project that a plain cargo command does not cover.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Run every check of the project, or the steps that are named.
    Ci(ci::Arguments),
    /// Measure instructions, stack, flash and RAM, and write docs/cost.md.
    Cost(cost::Arguments),
    /// Build the firmware for the board and print its size.
    Fw(firmware::Arguments),
    /// Build an image and watch it run on an emulated board with simulated drives.
    Emulate(emulator::EmulateArguments),
    /// Test the real image of the firmware on an emulated board with simulated drives.
    FirmwareTests(emulator::Arguments),
    /// Run LLVM's fuzzer against the decoders.
    Fuzz(fuzz::Arguments),
    /// Check the examples for other people's drivers.
    Hals(hals::Arguments),
    /// Show which files of a crate need each other.
    ModuleCycles(module_cycles::Arguments),
    /// Seed mistakes into a crate and count those that its tests find.
    Mutants(mutants::Arguments),
    /// Show what our codec takes beside public ones.
    Peers(peers::Arguments),
    /// Show by function where the instructions of a cycle go, on an emulated board.
    Profile(profile::Arguments),
    /// Show that the libraries cannot panic, and how large they are on the target.
    Proofs(proofs::Arguments),
    /// Build motionctl for Windows.
    Windows(windows::Arguments),
}

fn main() -> ExitCode {
    let result = match Arguments::parse().task {
        Task::Fw(arguments) => firmware::run(&arguments),
        Task::Ci(arguments) => ci::run(&arguments),
        Task::Cost(arguments) => cost::run(&arguments),
        Task::Emulate(arguments) => emulator::emulate(&arguments),
        Task::FirmwareTests(arguments) => emulator::run(&arguments),
        Task::Fuzz(arguments) => fuzz::run(&arguments),
        Task::Hals(arguments) => hals::run(&arguments),
        Task::ModuleCycles(arguments) => module_cycles::run(&arguments),
        Task::Mutants(arguments) => mutants::run(&arguments),
        Task::Peers(arguments) => peers::run(&arguments),
        Task::Profile(arguments) => profile::run(&arguments),
        Task::Proofs(arguments) => proofs::run(&arguments),
        Task::Windows(arguments) => windows::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn what_follows_two_dashes_goes_to_cargo() {
        let parsed = Arguments::try_parse_from(["xtask", "fw", "--", "--locked"]).unwrap();
        let Task::Fw(arguments) = parsed.task else {
            panic!("another task");
        };
        assert_eq!(arguments.cargo, ["--locked"]);
    }
}
