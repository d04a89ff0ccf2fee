//! Hub motors (ZLAC8030L, CANopen): the same words as for servo drives, with `--drives zlac`.
//!
//! `motionctl WORD --drives zlac` reads its command line by the definitions here and not by those of servo drives, because the two families
//! share words and few options: CANopen drives have nodes and objects in place of ids and parameters.

mod bench;
mod family;
mod nodes;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::exit::Failure;
pub(crate) use family::is_meant;
use family::refusal;

/// The tool for hub motors.
#[derive(Debug, Parser)]
#[command(name = "motionctl", version, propagate_version = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Offer simulated hub motors behind a CAN adapter, in real time, to this tool or any other.
    Bench(bench::Arguments),
}

/// Runs a command line for which [`is_meant`] is true.
///
/// # Errors
/// What the command says, with its exit status.
pub(crate) fn run(words: Vec<OsString>) -> Result<ExitCode, Failure> {
    if let Some(refusal) = refusal(&words) {
        return Err(Failure::coded(refusal));
    }
    let matches = Arguments::command().get_matches_from(words);
    let arguments = Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    match &arguments.command {
        Command::Bench(arguments) => bench::run(arguments).map_err(Failure::coded),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Arguments::command().debug_assert();
    }
}
