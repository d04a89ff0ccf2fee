//! A view of a motion in the terminal: of a simulation and of a run on a real bus.

mod on_the_bus;
mod screen;
mod taken_terminal;

pub(crate) use on_the_bus::BusView;
pub(crate) use screen::{LOAD_WINDOW_US, Screen};
pub(crate) use taken_terminal::TakenTerminal;
