//! Windows.

mod absent;
mod endings;
mod files;
mod keyboard;
mod serial_port;
mod waiting;

pub(crate) use absent::{Pty, SocketFile, SocketFileListener, SocketFileStream};
pub(crate) use endings::{note_endings, note_endings_in_motion, note_power_cycles};
pub(crate) use files::read_at;
pub(crate) use keyboard::{Keyboard, keep_signals};
pub(crate) use serial_port::{read_serial, serial_port_exists, serial_ports_hint};
pub(crate) use waiting::wait_for_input;
