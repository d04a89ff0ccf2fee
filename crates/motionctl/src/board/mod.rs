//! `motionctl board`: a motion board that takes orders, over its serial port.
//!
//! [`session`] carries the bytes of the protocol, which `board_link` speaks; [`mod@run`] plays a motion, [`mod@stream`] what another program sends,
//! [`motion`] is what both have in common, [`mod@order`] gives one order, [`mod@settings`] reads and writes what the board
//! is told, [`words`] puts what it says into words.

mod arguments;
mod ask;
mod error;
mod faults;
mod find;
mod home;
mod info;
mod monitor;
mod motion;
mod order;
mod run;
mod session;
mod settings;
mod stream;
mod words;

use std::process::ExitCode;

use clap::Subcommand;

use crate::schema::NamedSchema;
use error::BoardError;
use order::Order;

const HELP: &str = "\
Examples:
  motionctl bench --drives 1,2 --board /tmp/board --settings board.toml   a simulated board, in another terminal
  motionctl board find                              boards at USB ports
  motionctl board info --port /dev/ttyACM0
  motionctl board settings set board.toml --port /dev/ttyACM0
  motionctl board home --port /dev/ttyACM0          where the settings ask for it
  motionctl board run plan.csv --port /dev/ttyACM0
  producer | motionctl board stream --port /dev/ttyACM0 --yes
  motionctl board disable --port /dev/ttyACM0       after --stay-enabled
  motionctl board clear --port /dev/ttyACM0         after a fault

Without drives and without a board: docs/board.md. New firmware is written with probe-rs, as the first one: the boards have no boot loader that
takes it over the link, so there is no `update`.

Exit status: that of each word; in general 0 done, 1 a promise was broken or a board did not answer, 2 refused, 3 the link failed.";

/// Options of `motionctl board`.
#[derive(Debug, clap::Args)]
#[command(after_help = HELP, subcommand_required = true, arg_required_else_help = true)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    word: Word,
}

#[derive(Debug, Subcommand)]
enum Word {
    /// Find the boards: one question to each port, which moves nothing.
    Find(find::Arguments),
    /// Show what a board is, how it is, and what it has received.
    Info(info::Arguments),
    /// Read, check and write what a board is told: drives, limits, inputs.
    Settings(settings::Arguments),
    /// Let the axes of a board find their origins, as its settings say.
    Home(home::Arguments),
    /// Run a motion on a board, with the same files as `motionctl run`.
    Run(Box<run::Arguments>),
    /// Take set-points of another program while the motion runs, with the lines of `motionctl run --stream`.
    Stream(Box<stream::Arguments>),
    /// Slow down along the path; the drives stay enabled.
    #[command(after_help = order::HELP)]
    Stop(order::Arguments),
    /// End all set-points at once; the drives hold, and follow nothing until they are enabled again.
    #[command(after_help = order::HELP)]
    Halt(order::Arguments),
    /// Slow down, then switch the drives off.
    #[command(after_help = order::HELP)]
    Disable(order::Arguments),
    /// Forget faults whose cause is gone; nothing is switched on.
    #[command(after_help = order::HELP)]
    Clear(order::Arguments),
    /// Show the state of a board again and again.
    Monitor(monitor::Arguments),
    /// Show the faults that a board remembers.
    Faults(faults::Arguments),
}

/// Does what the word says.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, BoardError> {
    match &arguments.word {
        Word::Find(arguments) => find::run(arguments),
        Word::Info(arguments) => info::run(arguments),
        Word::Settings(arguments) => settings::run(arguments),
        Word::Home(arguments) => home::run(arguments),
        Word::Run(arguments) => run::run(arguments),
        Word::Stream(arguments) => stream::run(arguments),
        Word::Stop(arguments) => order::run(Order::Stop, arguments),
        Word::Halt(arguments) => order::run(Order::Halt, arguments),
        Word::Disable(arguments) => order::run(Order::Disable, arguments),
        Word::Clear(arguments) => order::run(Order::Clear, arguments),
        Word::Monitor(arguments) => monitor::run(arguments),
        Word::Faults(arguments) => faults::run(arguments),
    }
}

/// What the words print with `--json`, by the name of its file.
pub(crate) const SCHEMAS: &[NamedSchema] = &[
    ("board-clear", order::schema),
    ("board-disable", order::schema),
    ("board-faults", faults::schema),
    ("board-find", find::schema),
    ("board-halt", order::schema),
    ("board-home", home::schema),
    ("board-info", info::schema),
    ("board-monitor", monitor::schema),
    ("board-run", run::schema),
    ("board-settings", settings::schema),
    ("board-stop", order::schema),
    ("board-stream", stream::schema),
];
