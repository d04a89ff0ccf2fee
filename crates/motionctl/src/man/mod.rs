//! `motionctl man`: manual pages.

use std::io;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Command;
use clap_mangen::{Man, generate_to};

use crate::output::{print, tell};

const EXAMPLES: &str = "\
Examples:
  motionctl man | man -l -                      the page of the tool
  motionctl man run | man -l -                  that of a command
  motionctl man --folder ~/.local/share/man/man1

Exit status: 0 printed or written, 2 there is no such command, or a page cannot be written.";

/// Options of `motionctl man`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// The command. Default: the tool itself.
    #[arg(value_name = "COMMAND", conflicts_with = "folder")]
    command: Option<String>,
    /// Write the page of the tool and of every command into this folder.
    #[arg(long, value_name = "DIR")]
    folder: Option<PathBuf>,
}

/// Prints a page, or writes all of them.
pub(crate) fn run(arguments: &Arguments, mut command: Command) -> io::Result<ExitCode> {
    if let Some(folder) = &arguments.folder {
        let written = std::fs::create_dir_all(folder).and_then(|()| generate_to(command, folder));
        written.map_err(|error| {
            io::Error::other(format!("cannot write to {}: {error}", folder.display()))
        })?;
        tell(format_args!("manual pages: {}", folder.display()));
        return Ok(ExitCode::SUCCESS);
    }
    command.build();
    let page_of = match &arguments.command {
        None => command,
        Some(name) => command.find_subcommand(name).cloned().ok_or_else(|| {
            io::Error::other(format!(
                "there is no command {name}: motionctl --help lists them"
            ))
        })?,
    };
    // A writer that fails ends nothing here: the page is printed as a whole.
    let mut page = Vec::new();
    Man::new(page_of).render(&mut page)?;
    print(String::from_utf8_lossy(&page).trim_end())?;
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_page_is_written_and_an_unknown_command_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let command = || Command::new("tool").subcommand(Command::new("run").about("Runs."));
        let all = Arguments {
            command: None,
            folder: Some(folder.path().join("man1")),
        };
        run(&all, command()).unwrap();
        let page = std::fs::read_to_string(folder.path().join("man1/tool-run.1")).unwrap();
        assert!(page.contains("Runs."), "{page}");
        let unknown = Arguments {
            command: Some("walk".to_owned()),
            folder: None,
        };
        let error = run(&unknown, command()).unwrap_err().to_string();
        assert!(error.contains("no command walk"), "{error}");
    }
}
