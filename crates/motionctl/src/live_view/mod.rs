//! A view of a motion in the terminal: of a simulation and of a run on a real bus.

mod screen;
mod taken_terminal;

pub(crate) use screen::{LOAD_WINDOW_US, Screen};
pub(crate) use taken_terminal::TakenTerminal;
