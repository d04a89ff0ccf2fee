//! `motionctl completions`: a script that completes the command line in a shell.

use std::process::ExitCode;

use clap::Command;
use clap_complete::{Shell, generate};

use crate::output::print;

const EXAMPLES: &str = "\
Examples:
  motionctl completions bash > ~/.local/share/bash-completion/completions/motionctl
  motionctl completions zsh > ~/.zfunc/_motionctl
  motionctl completions fish > ~/.config/fish/completions/motionctl.fish";

/// Options of `motionctl completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

/// Prints the script for the tool's command line.
pub(crate) fn run(arguments: &Arguments, mut command: Command) -> std::io::Result<ExitCode> {
    let name = command.get_name().to_owned();
    // A writer that fails ends the generator with a panic, so it gets one that does not.
    let mut script = Vec::new();
    generate(arguments.shell, &mut command, name, &mut script);
    print(String::from_utf8_lossy(&script).trim_end())?;
    Ok(ExitCode::SUCCESS)
}
