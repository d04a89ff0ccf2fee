//! What Windows does not have; each is refused with what to use in its place, so that no value of these types exists.

use core::fmt;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, SocketAddr};
use std::path::Path;
use std::time::Duration;

/// A terminal that other programs open like a serial port.
#[derive(Debug)]
pub(crate) enum Pty {}

impl Pty {
    pub(crate) fn create(_: &Path) -> io::Result<Self> {
        Err(unsupported(
            "Windows has no pseudo-terminals: use a port in place of a path, as in tcp:7000",
        ))
    }

    pub(crate) fn read<'a>(&self, _: &'a mut [u8]) -> io::Result<&'a [u8]> {
        match *self {}
    }

    pub(crate) fn write(&self, _: &[u8]) -> io::Result<usize> {
        match *self {}
    }
}

impl fmt::Display for Pty {
    fn fmt(&self, _: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {}
    }
}

/// A socket file of this program.
#[derive(Debug)]
pub(crate) enum SocketFile {}

impl SocketFile {
    pub(crate) fn bind(_: &Path) -> io::Result<(SocketFileListener, Self)> {
        Err(unsupported(
            "on Windows this tool knows no socket files: use a port, as in tcp:7001",
        ))
    }
}

/// Listens at a socket file.
#[derive(Debug)]
pub(crate) enum SocketFileListener {}

impl SocketFileListener {
    pub(crate) fn try_clone(&self) -> io::Result<Self> {
        match *self {}
    }

    pub(crate) fn accept(&self) -> io::Result<(SocketFileStream, SocketAddr)> {
        match *self {}
    }
}

/// A connection through a socket file.
#[derive(Debug)]
pub(crate) enum SocketFileStream {}

impl SocketFileStream {
    pub(crate) fn try_clone(&self) -> io::Result<Self> {
        match *self {}
    }

    pub(crate) fn set_write_timeout(&self, _: Option<Duration>) -> io::Result<()> {
        match *self {}
    }

    pub(crate) fn shutdown(&self, _: Shutdown) -> io::Result<()> {
        match *self {}
    }
}

impl Read for SocketFileStream {
    fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
        match *self {}
    }
}

impl Write for SocketFileStream {
    fn write(&mut self, _: &[u8]) -> io::Result<usize> {
        match *self {}
    }

    fn flush(&mut self) -> io::Result<()> {
        match *self {}
    }
}

fn unsupported(text: &'static str) -> io::Error {
    io::Error::new(ErrorKind::Unsupported, text)
}
