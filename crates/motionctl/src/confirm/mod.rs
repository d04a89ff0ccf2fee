//! Asking before something moves or is changed for good.

use core::fmt;
use std::io::{self, IsTerminal, Write};

/// Nothing was done, because nobody agreed.
#[derive(Debug)]
pub(crate) enum NotConfirmed {
    /// The user said no.
    Declined,
    /// There is no terminal to ask on.
    NobodyToAsk,
    /// The terminal failed.
    Terminal(io::Error),
}

impl fmt::Display for NotConfirmed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Declined => f.write_str("not confirmed; nothing was done"),
            Self::NobodyToAsk => f.write_str(
                "this needs a confirmation and there is no terminal to ask on; nothing was done. Scripts confirm with --yes",
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
    if yes {
        return Ok(());
    }
    if !io::stdin().is_terminal() {
        return Err(NotConfirmed::NobodyToAsk);
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
