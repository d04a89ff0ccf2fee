//! Asking before something moves or is changed for good.

use core::fmt;
use std::io::{self, IsTerminal, Write};

/// Nothing was done, because nobody agreed.
#[derive(Debug)]
pub(crate) enum NotConfirmed {
    /// The user said no.
    Declined,
    /// There is no terminal to ask on.
    NobodyToAsk {
        /// The option that gives the answer.
        option: &'static str,
    },
    /// The terminal failed.
    Terminal(io::Error),
}

impl fmt::Display for NotConfirmed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Declined => f.write_str("not confirmed; nothing was done"),
            Self::NobodyToAsk { option } => write!(
                f,
                "this needs a confirmation and there is no terminal to ask on; nothing was done. Scripts confirm with {option}"
            ),
            Self::Terminal(source) => write!(f, "cannot ask for a confirmation: {source}"),
        }
    }
}

impl std::error::Error for NotConfirmed {}

/// Asks on the terminal whether to go on; `yes` is the answer given on the command line.
///
/// # Errors
/// [`NotConfirmed`] unless the answer is yes.
pub(crate) fn confirm(question: &str, yes: bool) -> Result<(), NotConfirmed> {
    confirm_by(question, yes, "--yes")
}

/// The same with an option of its own, for what `--yes` shall not cover.
///
/// # Errors
/// [`NotConfirmed`] unless the answer is yes.
pub(crate) fn confirm_by(
    question: &str,
    is_given: bool,
    option: &'static str,
) -> Result<(), NotConfirmed> {
    if is_given {
        return Ok(());
    }
    if !io::stdin().is_terminal() {
        return Err(NotConfirmed::NobodyToAsk { option });
    }
    let mut terminal = io::stderr().lock();
    write!(terminal, "{question} [y/N] ")
        .and_then(|()| terminal.flush())
        .map_err(NotConfirmed::Terminal)?;
    drop(terminal);
    let mut answer = String::new();
    io::stdin()
        .read_line(&mut answer)
        .map_err(NotConfirmed::Terminal)?;
    match answer.trim().to_ascii_lowercase().as_str() {
        "y" | "yes" => Ok(()),
        _ => Err(NotConfirmed::Declined),
    }
}
