//! The terminal while a view owns it.

use std::io::{self, IsTerminal};

use ratatui::DefaultTerminal;

use super::screen::Screen;
use crate::output;
use crate::system;

/// A terminal that shows a view; it is itself again when this is dropped. Messages are kept until then.
pub(crate) struct TakenTerminal {
    terminal: DefaultTerminal,
}

impl TakenTerminal {
    /// Takes the terminal.
    ///
    /// # Errors
    /// When standard input and output are no terminal.
    pub(crate) fn take() -> io::Result<Self> {
        if !io::stdout().is_terminal() || !io::stdin().is_terminal() {
            return Err(io::Error::other(
                "standard input and output are no terminal",
            ));
        }
        let terminal = ratatui::try_init()?;
        output::hold();
        Ok(Self { terminal })
    }

    /// Lets Ctrl-C and its relatives stay signals: they stop a motion even when the view hangs.
    ///
    /// # Errors
    /// When the terminal cannot be set.
    pub(crate) fn keep_signals(&self) -> io::Result<()> {
        system::keep_signals()
    }

    /// Shows a picture.
    ///
    /// # Errors
    /// When the terminal takes nothing any more.
    pub(crate) fn draw(&mut self, screen: &Screen<'_>) -> io::Result<()> {
        self.terminal.draw(|frame| screen.draw(frame)).map(drop)
    }
}

impl Drop for TakenTerminal {
    fn drop(&mut self) {
        ratatui::restore();
        output::release();
    }
}
