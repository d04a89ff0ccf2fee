//! Hub motors (ZLAC8030L, CANopen): the same words as for servo drives, with `--drives zlac`.
//!
//! `motionctl WORD --drives zlac` reads its command line by the definitions here and not by those of servo drives, because the two families
//! share words and few options: CANopen drives have nodes and objects in place of ids and parameters.

mod assign_id;
mod backup;
mod bench;
mod bus;
mod disable;
mod enable;
mod error;
mod family;
mod for_now;
mod frames;
mod home;
mod identity;
mod jog;
mod look;
mod monitor;
mod move_to;
mod nodes;
mod object;
mod origin;
mod own_move;
mod plan;
mod read;
mod recorder;
mod reset;
mod restore;
mod run;
mod scan;
mod settings_file;
mod speed;
mod state;
mod station;
mod store;
mod tune;
mod write;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::exit::Failure;
use crate::schema::NamedSchema;
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
    /// Find the nodes on a real bus.
    Scan(scan::Arguments),
    /// Read the state and the objects of a drive.
    Read(read::Arguments),
    /// Change objects of a drive: compare, ask, write, read back, save once.
    Write(write::Arguments),
    /// Put every writable object of drives into a file.
    Backup(backup::Arguments),
    /// Bring drives to the objects of a file: compare, ask, write what differs, read back, save once.
    Restore(restore::Arguments),
    /// Give a drive its node number, or its bit rate.
    AssignId(assign_id::Arguments),
    /// Show the position of a drive, or make it 0.
    Origin(origin::Arguments),
    /// Find where an axis is: at a hard stop, at a switch, or where it stands.
    Home(Box<home::Arguments>),
    /// Clear the fault of a drive, or restore its factory settings.
    Reset(reset::Arguments),
    /// Enable drives and hold them at speed 0, until Ctrl-C.
    Enable(enable::Arguments),
    /// Turn one wheel a little, slowly.
    Jog(jog::Arguments),
    /// Move one wheel to a position, or by a way.
    Move(move_to::Arguments),
    /// Turn wheels at a speed, for a time.
    Speed(speed::Arguments),
    /// Measure how a wheel answers to steps, for up to three sets of gains side by side.
    Tune(Box<tune::Arguments>),
    /// Run speeds from a file, or twists of a vehicle, on the drives of a real bus.
    Run(Box<run::Arguments>),
    /// Work out before anything moves whether a bus carries its wheels in time.
    Plan(plan::Arguments),
    /// Switch the power of drives off.
    Disable(disable::Arguments),
    /// Show the state of drives again and again.
    Monitor(monitor::Arguments),
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
        Command::Scan(arguments) => scan::run(arguments).map_err(Failure::coded),
        Command::Read(arguments) => read::run(arguments).map_err(Failure::coded),
        Command::Write(arguments) => write::run(arguments).map_err(Failure::coded),
        Command::Backup(arguments) => backup::run(arguments).map_err(Failure::coded),
        Command::Restore(arguments) => restore::run(arguments).map_err(Failure::coded),
        Command::AssignId(arguments) => assign_id::run(arguments).map_err(Failure::coded),
        Command::Origin(arguments) => origin::run(arguments).map_err(Failure::coded),
        Command::Home(arguments) => home::run(arguments).map_err(Failure::coded),
        Command::Reset(arguments) => reset::run(arguments).map_err(Failure::coded),
        Command::Enable(arguments) => enable::run(arguments).map_err(Failure::coded),
        Command::Jog(arguments) => jog::run(arguments).map_err(Failure::coded),
        Command::Move(arguments) => move_to::run(arguments).map_err(Failure::coded),
        Command::Speed(arguments) => speed::run(arguments).map_err(Failure::coded),
        Command::Tune(arguments) => tune::run(arguments).map_err(Failure::coded),
        Command::Run(arguments) => run::run(arguments).map_err(Failure::coded),
        Command::Plan(arguments) => plan::run(arguments).map_err(Failure::coded),
        Command::Disable(arguments) => disable::run(arguments).map_err(Failure::coded),
        Command::Monitor(arguments) => monitor::run(arguments).map_err(Failure::coded),
    }
}

/// What each word prints with `--json`, by the name of its file of schemas.
pub(crate) const SCHEMAS: &[NamedSchema] = &[
    ("zlac-assign-id", assign_id::schema),
    ("zlac-backup", backup::schema),
    ("zlac-bench", bench::schema),
    ("zlac-disable", disable::schema),
    ("zlac-enable", disable::schema),
    ("zlac-home", home::schema),
    ("zlac-jog", own_move::schema),
    ("zlac-monitor", monitor::schema),
    ("zlac-move", own_move::schema),
    ("zlac-origin", origin::schema),
    ("zlac-plan", plan::schema),
    ("zlac-read", read::schema),
    ("zlac-reset", reset::schema),
    ("zlac-restore", restore::schema),
    ("zlac-run", run::schema),
    ("zlac-scan", crate::scan::schema),
    ("zlac-sim", crate::sim::wheels_schema),
    ("zlac-speed", speed::schema),
    ("zlac-tune", tune::schema),
    ("zlac-write", write::schema),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Arguments::command().debug_assert();
    }
}
