//! The end of the board: bytes in, bytes out, commands for the application.
//!
//! Everything here runs in the thread. [`Board`] is what all ports share: who commands, what was admitted, what has happened. A [`Link`] is
//! one port: bytes of one host. Neither reads a clock: `now` is the cycle of the board.

mod application;
mod commands;
mod events;
mod link;
mod requests;
mod settings;
mod shared;
mod slots;

pub use application::{Application, Command, Machine};
pub use link::Link;
pub use shared::{Board, BoardConfig};
