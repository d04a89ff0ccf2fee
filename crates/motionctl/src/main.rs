//! `motionctl`: motion and traffic on CAN, simulated or through an adapter.

#![forbid(unsafe_code)]
// A closed pipe would be a panic: `output` prints.
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod assign_id;
mod backup;
mod bench;
mod board;
mod check;
mod completions;
mod confirm;
mod control;
mod counted;
mod decode;
mod disable;
mod drive_ids;
mod drives;
mod dry_run;
mod enable;
mod ending;
mod endpoint;
mod exit;
mod home;
mod host_port;
mod hub;
mod interrupt;
mod jog;
mod keyframes;
mod lawicel;
mod limits;
mod link;
mod live_view;
mod loopback;
mod man;
mod monitor;
mod moves;
mod origin;
mod origins;
mod output;
mod own_moves;
#[cfg(test)]
mod plain_words;
mod plan;
mod probe;
mod program;
mod read;
mod record;
mod recording;
mod report;
mod reset;
mod restore;
mod revision;
mod run;
mod scan;
mod schema;
mod set_points;
mod settings_file;
mod side_effect;
mod sim;
mod speed;
mod station;
mod stream;
mod system;
mod table;
mod trajectory;
mod tune;
mod twist;
mod virtual_drives;
mod write;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use exit::Failure;
use output::tell;

/// Motion and traffic on CAN: servo axes simulated or through an adapter, with the master that the firmware runs, and logs
/// in plain words.
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
    /// Offer simulated drives behind a CAN adapter, in real time, to this tool or any other.
    Bench(bench::Arguments),
    /// Show what a motion file would do, against limits and bus, without drives.
    Check(Box<check::Arguments>),
    /// Write a program as the motion that the firmware compiles in.
    Keyframes(Box<keyframes::Arguments>),
    /// Work out before anything moves whether a bus carries its axes in time.
    Plan(Box<plan::Arguments>),
    /// Measure on the simulated bus how many axes it carries, and how regularly.
    Limits(limits::Arguments),
    /// Run a motion on the drives of a real bus, in real time.
    Run(Box<run::Arguments>),
    /// Command a motion board over its serial port: find it, tell it its settings, run a motion on it.
    Board(board::Arguments),
    /// Find the drives on a real bus, and their revisions.
    Scan(scan::Arguments),
    /// Read the state and the parameters of a drive, in units.
    Read(read::Arguments),
    /// Change parameters of a drive: compare, ask, write, read back.
    Write(write::Arguments),
    /// Put every setting of drives into a file.
    Backup(backup::Arguments),
    /// Bring drives to the settings of a file: compare, ask, write what differs, read back.
    Restore(restore::Arguments),
    /// Give a drive its id.
    AssignId(assign_id::Arguments),
    /// Show where the zero of a drive is, or make it stand at its zero.
    Origin(origin::Arguments),
    /// Find where an axis is: at a hard stop, at a switch, or where it stands.
    Home(Box<home::Arguments>),
    /// Clear the alarm and the position of a drive.
    Reset(reset::Arguments),
    /// Find out the byte order of a drive, without moving it.
    Probe(probe::Arguments),
    /// Enable drives and hold them where they stand, until Ctrl-C.
    Enable(enable::Arguments),
    /// Disable drives.
    Disable(disable::Arguments),
    /// Turn one motor a little, slowly.
    Jog(jog::Arguments),
    /// Let drives go to positions by themselves, several together.
    Move(moves::Arguments),
    /// Let motors turn at constant speed.
    Speed(speed::Arguments),
    /// Measure how an axis answers to steps, for up to three sets of gains side by side.
    Tune(Box<tune::Arguments>),
    /// Write the traffic of a bus into log files, one after the other, until Ctrl-C.
    Record(record::Arguments),
    /// Show the state of drives again and again.
    Monitor(monitor::Arguments),
    /// Print the manual page of the tool or of a command, or write all of them.
    Man(man::Arguments),
    /// Print the JSON schema of what a command prints with --json, or write all of them.
    Schema(schema::Arguments),
    /// Print a script that completes this command line in a shell.
    Completions(completions::Arguments),
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
    let words = without_alias_dashes(std::env::args_os());
    let result = if hub::is_meant(&words) {
        hub::run(words)
    } else {
        run(&Arguments::parse_from(words))
    };
    result.unwrap_or_else(|failure| {
        tell(format_args!("error: {}", failure.error));
        failure.code.into()
    })
}

fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    match &arguments.command {
        Command::Sim(arguments) => sim::run(arguments).map_err(Into::into),
        Command::Decode(arguments) => decode::run(arguments).map_err(Failure::coded),
        Command::Check(arguments) => check::run(arguments).map_err(Into::into),
        Command::Keyframes(arguments) => keyframes::run(arguments).map_err(Into::into),
        Command::Plan(arguments) => plan::run(arguments).map_err(Into::into),
        Command::Limits(arguments) => limits::run(arguments).map_err(Into::into),
        Command::Bench(arguments) => bench::run(arguments).map_err(Failure::coded),
        Command::Run(arguments) => run::run(arguments).map_err(Failure::coded),
        Command::Board(arguments) => board::run(arguments).map_err(Failure::coded),
        Command::Scan(arguments) => scan::run(arguments).map_err(Failure::coded),
        Command::Read(arguments) => read::run(arguments).map_err(Failure::coded),
        Command::Write(arguments) => write::run(arguments).map_err(Failure::coded),
        Command::Backup(arguments) => backup::run(arguments).map_err(Failure::coded),
        Command::Restore(arguments) => restore::run(arguments).map_err(Failure::coded),
        Command::AssignId(arguments) => assign_id::run(arguments).map_err(Failure::coded),
        Command::Origin(arguments) => origin::run(arguments).map_err(Failure::coded),
        Command::Home(arguments) => home::run(arguments).map_err(Failure::coded),
        Command::Reset(arguments) => reset::run(arguments).map_err(Failure::coded),
        Command::Probe(arguments) => probe::run(arguments).map_err(Failure::coded),
        Command::Enable(arguments) => enable::run(arguments).map_err(Failure::coded),
        Command::Disable(arguments) => disable::run(arguments).map_err(Failure::coded),
        Command::Jog(arguments) => jog::run(arguments).map_err(Failure::coded),
        Command::Move(arguments) => moves::run(arguments).map_err(Failure::coded),
        Command::Speed(arguments) => speed::run(arguments).map_err(Failure::coded),
        Command::Tune(arguments) => tune::run(arguments).map_err(Failure::coded),
        Command::Monitor(arguments) => monitor::run(arguments).map_err(Failure::coded),
        Command::Record(arguments) => record::run(arguments).map_err(Failure::coded),
        Command::Man(arguments) => man::run(arguments, Arguments::command()).map_err(Into::into),
        Command::Schema(arguments) => schema::run(arguments).map_err(Into::into),
        Command::Completions(arguments) => {
            completions::run(arguments, Arguments::command()).map_err(Into::into)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
