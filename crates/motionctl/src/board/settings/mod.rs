//! `motionctl board settings`: what a board is told.

mod difference;
mod file;

use core::fmt;
use std::path::PathBuf;
use std::process::ExitCode;

use board_settings::{LONGEST, Settings};
use clap::Subcommand;
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::{BAUD, PortOptions};
use super::error::BoardError;
use super::session::Session;
use crate::backup::{create_file, require_room};
use crate::confirm::confirm;
use crate::counted::counted;
use crate::output::{print, print_json, tell};
use difference::{Difference, differences};
use file::{built, check, read};

const EXAMPLES: &str = "\
Examples:
  motionctl board settings get --port /dev/ttyACM0 > board.toml
  motionctl board settings check board.toml --board stm32f405          without a board
  motionctl board settings check board.toml --port /dev/ttyACM0
  motionctl board settings set board.toml --port /dev/ttyACM0

A file is read as a whole and checked, the plan of the bus included, before anything is sent; then the board checks it, too. It is stored only
while no drive is enabled, and counts from the next start of the board on.

Exit status: 0 read, right or stored, 1 the board refuses it or has stored something else, 2 the file cannot be used, 3 no board answers.";

/// Options of `motionctl board settings`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES, subcommand_required = true, arg_required_else_help = true)]
pub(super) struct Arguments {
    #[command(subcommand)]
    word: Word,
}

#[derive(Debug, Subcommand)]
enum Word {
    /// Write the settings of a board to standard output or into a file.
    Get(Get),
    /// Bring a board to the settings of a file: compare, ask, write; the board reads back what it has stored.
    Set(Set),
    /// Check a file, with a board or without.
    Check(Check),
}

#[derive(Debug, clap::Args)]
struct Get {
    /// The file to write, in TOML. Default: standard output.
    #[arg(value_name = "FILE.toml")]
    file: Option<PathBuf>,
    #[command(flatten)]
    port: PortOptions,
    /// Replace a file that exists.
    #[arg(long)]
    force: bool,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, clap::Args)]
struct Set {
    /// The file, in TOML.
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    #[command(flatten)]
    port: PortOptions,
    /// Write without asking.
    #[arg(long)]
    yes: bool,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, clap::Args)]
struct Check {
    /// The file, in TOML.
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    /// Check it for such a board: stm32f405 or stm32g474.
    #[arg(
        long,
        value_name = "NAME",
        required_unless_present = "port",
        conflicts_with = "port"
    )]
    board: Option<String>,
    /// Let this board check it, too; nothing is stored.
    #[arg(long, value_name = "TTY|tcp:PORT")]
    port: Option<String>,
    /// Speed of the serial port in baud; USB CDC ignores it.
    #[arg(long, value_name = "BAUD", default_value_t = BAUD, value_parser = clap::value_parser!(u32).range(300..=12_000_000))]
    baud: u32,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

/// What came of it.
#[derive(Debug, Default, Serialize, JsonSchema)]
struct Report {
    board: String,
    axes: usize,
    /// The board has checked them, too.
    checked_by_board: bool,
    /// What the file changes.
    differences: Vec<Difference>,
    stored: bool,
    /// They count from the next start of the board on.
    restart_needed: bool,
    /// The settings, where they were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    settings: Option<String>,
}

/// Does what the word says.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, BoardError> {
    match &arguments.word {
        Word::Get(get) => run_get(get),
        Word::Set(set) => run_set(set),
        Word::Check(check) => run_check(check),
    }
}

fn run_get(arguments: &Get) -> Result<ExitCode, BoardError> {
    if let Some(path) = &arguments.file {
        require_room(path, arguments.force).map_err(BoardError::WriteFile)?;
    }
    let mut session = Session::open(&arguments.port, false)?;
    let port = session.name().to_owned();
    let settings = session.settings()?;
    let settings = settings.ok_or(BoardError::NoSettings { port })?;
    let text = board_settings::file::write(&settings);
    if let Some(path) = &arguments.file {
        create_file(path, &text, arguments.force).map_err(BoardError::WriteFile)?;
        tell(format_args!("settings: {}", path.display()));
    }
    if arguments.json {
        let report = Report {
            board: session.info().board.to_string(),
            axes: settings.axes.len(),
            settings: Some(text),
            ..Report::default()
        };
        print_json(&report).map_err(BoardError::Print)?;
    } else if arguments.file.is_none() {
        print(text.trim_end()).map_err(BoardError::Print)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn run_check(arguments: &Check) -> Result<ExitCode, BoardError> {
    let file = read(&arguments.file)?;
    let mut report = Report {
        axes: file.settings.axes.len(),
        ..Report::default()
    };
    if let Some(name) = &arguments.board {
        check(&arguments.file, &file, &built(name)?)?;
        report.board.clone_from(name);
    }
    if let Some(port) = &arguments.port {
        let options = PortOptions {
            port: port.clone(),
            baud: arguments.baud,
        };
        let mut session = Session::open(&options, true)?;
        let board = session.info().board.to_string();
        check(&arguments.file, &file, &built(&board)?)?;
        report.differences = differences(session.settings()?.as_ref(), &file.settings);
        let staged = session.stage(&bytes(&file.settings)?);
        session.leave()?;
        staged?;
        (report.board, report.checked_by_board) = (board, true);
    }
    show(&report, arguments.json)
}

fn run_set(arguments: &Set) -> Result<ExitCode, BoardError> {
    let file = read(&arguments.file)?;
    let mut session = Session::open(&arguments.port, false)?;
    let board = session.info().board.to_string();
    check(&arguments.file, &file, &built(&board)?)?;
    let before = session.settings()?;
    let mut report = Report {
        board,
        axes: file.settings.axes.len(),
        differences: differences(before.as_ref(), &file.settings),
        ..Report::default()
    };
    if report.differences.is_empty() && before.is_some() {
        return show(&report, arguments.json);
    }
    if before.is_none() {
        tell("the board has no settings");
    } else if !arguments.json {
        for difference in &report.differences {
            tell(difference);
        }
    }
    let question = format!(
        "{} will be stored on the board at {}. They count from its next start on. Go on?",
        counted(report.differences.len() as u64, "setting", "settings"),
        session.name()
    );
    confirm(&question, arguments.yes).map_err(BoardError::NotConfirmed)?;
    session.take_command()?;
    let bytes = bytes(&file.settings)?;
    // The board answers when it has read back what is in its flash. Until its next start it tells the settings that are in force.
    let stored = session.stage(&bytes).and_then(|()| session.commit(&bytes));
    session.leave()?;
    stored?;
    report.checked_by_board = true;
    (report.stored, report.restart_needed) = (true, true);
    show(&report, arguments.json)
}

fn bytes(settings: &Settings) -> Result<Vec<u8>, BoardError> {
    let mut room = [0; LONGEST];
    let bytes = settings.write(&mut room);
    bytes
        .map(|bytes| bytes.to_vec())
        .map_err(BoardError::UnreadableSettings)
}

fn show(report: &Report, json: bool) -> Result<ExitCode, BoardError> {
    if json {
        print_json(report).map_err(BoardError::Print)?;
    } else {
        print(report).map_err(BoardError::Print)?;
    }
    Ok(ExitCode::SUCCESS)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.stored {
            return f.write_str(
                "stored, and read back by the board; switch the board off and on, or press its reset, and they count",
            );
        }
        let axes = counted(self.axes as u64, "axis", "axes");
        let by = if self.checked_by_board {
            ", and the board agrees"
        } else {
            ""
        };
        match self.differences.as_slice() {
            [] if self.checked_by_board || self.board.is_empty() => {
                write!(
                    f,
                    "right for {}: {axes}{by}; the board has the same",
                    self.board
                )
            }
            [] => write!(f, "right for {}: {axes}", self.board),
            differences => {
                for difference in differences {
                    writeln!(f, "{difference}")?;
                }
                write!(
                    f,
                    "right for {}: {axes}{by}; the board has others",
                    self.board
                )
            }
        }
    }
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<Report>()
}
