//! What differs between systems: a folder for each, with the same names.

#[cfg(unix)]
mod unix;
#[cfg(windows)]
mod windows;

use std::net::{TcpListener, TcpStream};

#[cfg(unix)]
use unix as this;
#[cfg(windows)]
use windows as this;

pub(crate) use this::{
    Keyboard, Pty, SocketFile, SocketFileListener, SocketFileStream, keep_signals, note_endings,
    note_endings_in_motion, note_power_cycles, read_at, read_serial, serial_port_exists,
    serial_ports_hint, wait_for_input,
};

/// Something that brings bytes from other programs.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Input<'a> {
    /// A pseudo-terminal.
    Terminal(&'a Pty),
    /// A connection.
    Stream(&'a TcpStream),
    /// A port at which programs connect.
    Listener(&'a TcpListener),
}
