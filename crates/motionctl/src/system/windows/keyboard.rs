//! Single keys of the console. Ctrl-C stays what it is.

use std::io;
use std::time::Duration;

use ratatui::crossterm::event::{self, Event, KeyCode, KeyEventKind};
use ratatui::crossterm::terminal;

/// The console gives single keys in any mode.
#[derive(Debug)]
pub(crate) struct Keyboard;

impl Keyboard {
    /// Takes the keys.
    ///
    /// # Errors
    /// Never; other systems must set up their terminal.
    pub(crate) fn take() -> io::Result<Option<Self>> {
        Ok(Some(Self))
    }

    /// Waits for a key, at most so long.
    ///
    /// # Errors
    /// When there are no keys any more.
    pub(crate) fn key(most: Duration) -> io::Result<Option<u8>> {
        if !event::poll(most)? {
            return Ok(None);
        }
        let Event::Key(key) = event::read()? else {
            return Ok(None);
        };
        match key.code {
            KeyCode::Char(letter) if key.kind != KeyEventKind::Release => {
                Ok(u8::try_from(letter).ok())
            }
            _ => Ok(None),
        }
    }
}

/// Lets Ctrl-C stay a signal while a view has the console: single keys arrive without the raw mode as well.
///
/// # Errors
/// When the console cannot be set.
pub(crate) fn keep_signals() -> io::Result<()> {
    terminal::disable_raw_mode()
}
