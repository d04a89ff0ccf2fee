//! `motionctl`: look at motion and traffic on CAN.

#![forbid(unsafe_code)]

mod decode;
mod exit;
mod revision;
mod sim;
mod trajectory;
mod virtual_drives;

use std::error::Error;
use std::ffi::OsString;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Look at motion and traffic on CAN: simulate servo axes with the master that the firmware runs, decode logs.
#[derive(Debug, Parser)]
#[command(name = "motionctl", version, propagate_version = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a motion on simulated drives, in virtual time, and show whether every promise was kept.
    Sim(Box<sim::Arguments>),
    /// Put the frames of a log into plain words, with statistics of each identifier.
    Decode(decode::Arguments),
}

/// `cargo sim -- --trajectory FILE` reaches the tool as `sim -- --trajectory FILE`. Everything of `sim` is an option, so
/// the two dashes behind the subcommand mean nothing: dropping them lets both spellings work.
fn without_alias_dashes(arguments: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let mut arguments: Vec<OsString> = arguments.collect();
    if arguments.get(2).is_some_and(|argument| argument == "--") {
        arguments.remove(2);
    }
    arguments
}

fn main() -> ExitCode {
    let arguments = Arguments::parse_from(without_alias_dashes(std::env::args_os()));
    let result: Result<ExitCode, Box<dyn Error>> = match &arguments.command {
        Command::Sim(arguments) => sim::run(arguments).map_err(Into::into),
        Command::Decode(arguments) => decode::run(arguments).map_err(Into::into),
    };
    result.unwrap_or_else(|error| {
        eprintln!("error: {error}");
        exit::BAD_INPUT.into()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn the_alias_may_be_called_with_and_without_dashes() {
        let parse = |words: &[&str]| {
            let words = words.iter().map(OsString::from);
            Arguments::try_parse_from(without_alias_dashes(words)).is_ok()
        };
        assert!(parse(&["motionctl", "sim", "--axes", "2"]));
        assert!(parse(&["motionctl", "sim", "--", "--axes", "2"]));
        assert!(!parse(&["motionctl", "sim", "--axes", "2", "--", "--json"]));
    }
}
