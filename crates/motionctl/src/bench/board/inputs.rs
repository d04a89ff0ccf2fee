//! What is at the terminals of the board, and who changes it.

use std::io::BufRead as _;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use super::options::BoardOptions;
use crate::output::tell;

/// The inputs, debounced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Levels {
    pub(super) stop_closed: bool,
    pub(super) enable: bool,
}

/// Something that somebody does at the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Deed {
    Stop { closed: bool },
    Enable { active: bool },
    Reset,
}

/// The inputs, and the lines that change them.
#[derive(Debug)]
pub(super) struct Inputs {
    levels: Levels,
    deeds: Option<Receiver<Deed>>,
    resets: u64,
}

impl Inputs {
    /// As the options say; lines are taken from now on.
    pub(super) fn new(options: &BoardOptions) -> std::io::Result<Self> {
        Ok(Self {
            levels: Levels {
                stop_closed: !options.stop_open,
                enable: !options.enable_inactive,
            },
            deeds: options.inputs.then(listen).transpose()?,
            resets: 0,
        })
    }

    pub(super) const fn levels(&self) -> Levels {
        self.levels
    }

    /// Resets so far.
    pub(super) const fn resets(&self) -> u64 {
        self.resets
    }

    /// The board loses its power, or somebody presses its button.
    pub(super) const fn reset(&mut self) {
        self.resets += 1;
    }

    /// Does what was asked for meanwhile.
    pub(super) fn update(&mut self) {
        while let Some(deeds) = &self.deeds {
            match deeds.try_recv() {
                Ok(Deed::Stop { closed }) => self.levels.stop_closed = closed,
                Ok(Deed::Enable { active }) => self.levels.enable = active,
                Ok(Deed::Reset) => self.resets += 1,
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => self.deeds = None,
            }
        }
    }
}

fn listen() -> std::io::Result<Receiver<Deed>> {
    let (sender, receiver) = channel();
    std::thread::Builder::new().spawn(move || {
        for line in std::io::stdin().lock().lines() {
            let Ok(line) = line else { return };
            let is_heard = match deed(&line) {
                Some(deed) => sender.send(deed).is_ok(),
                None => {
                    tell(format_args!(
                        "expected stop open, stop closed, enable inactive, enable active or reset, got {line:?}"
                    ));
                    true
                }
            };
            if !is_heard {
                return;
            }
        }
    })?;
    Ok(receiver)
}

fn deed(line: &str) -> Option<Deed> {
    let words: Vec<&str> = line.split_whitespace().collect();
    Some(match words[..] {
        ["stop", "open"] => Deed::Stop { closed: false },
        ["stop", "closed"] => Deed::Stop { closed: true },
        ["enable", "inactive"] => Deed::Enable { active: false },
        ["enable", "active"] => Deed::Enable { active: true },
        ["reset"] => Deed::Reset,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_one_deed_or_none() {
        assert_eq!(deed("stop open"), Some(Deed::Stop { closed: false }));
        assert_eq!(
            deed("  enable  active "),
            Some(Deed::Enable { active: true })
        );
        assert_eq!(deed("reset"), Some(Deed::Reset));
        for line in ["", "stop", "stop closed now", "enable 1"] {
            assert_eq!(deed(line), None, "{line}");
        }
    }
}
