//! What other programs open like a serial port: a pseudo-terminal, or a TCP port of this machine.

mod tcp_port;

use core::fmt;
use core::str::FromStr;
use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;

use crate::loopback::loopback;
use crate::system::{Input, Pty};
use tcp_port::TcpPort;

/// Where programs find it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Place {
    /// A link that does not exist yet.
    Path(PathBuf),
    /// A port of this machine; 0 for one that is free.
    Tcp(SocketAddr),
}

impl FromStr for Place {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match loopback(text) {
            Some(address) => address.map(Self::Tcp),
            None => Ok(Self::Path(text.into())),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Path(path) => path.display().fmt(f),
            Self::Tcp(address) => write!(f, "tcp:{address}"),
        }
    }
}

/// The side of the device.
#[derive(Debug)]
pub(crate) enum HostPort {
    Terminal(Pty),
    Tcp(TcpPort),
}

impl HostPort {
    /// Makes it; `what` is behind it, for messages.
    ///
    /// # Errors
    /// When the system has no such port, or something else is there already.
    pub(crate) fn create(place: &Place, what: &'static str) -> io::Result<Self> {
        Ok(match place {
            Place::Path(path) => Self::Terminal(Pty::create(path)?),
            Place::Tcp(address) => Self::Tcp(TcpPort::open(*address, what)?),
        })
    }

    /// Reads what the host has written; an empty slice when there is nothing.
    ///
    /// # Errors
    /// When nobody can come any more.
    pub(crate) fn read<'a>(&mut self, buffer: &'a mut [u8]) -> io::Result<&'a [u8]> {
        match self {
            Self::Terminal(terminal) => terminal.read(buffer),
            Self::Tcp(port) => port.read(buffer),
        }
    }

    /// Writes as much as there is room for and returns how much that was.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub(crate) fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Terminal(terminal) => terminal.write(bytes),
            Self::Tcp(port) => Ok(port.write(bytes)),
        }
    }

    /// What to wait for.
    pub(crate) fn inputs(&self) -> Vec<Input<'_>> {
        match self {
            Self::Terminal(terminal) => vec![Input::Terminal(terminal)],
            Self::Tcp(port) => port.inputs(),
        }
    }
}

impl fmt::Display for HostPort {
    /// Where the host finds it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Terminal(terminal) => terminal.fmt(f),
            Self::Tcp(port) => port.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_a_port_of_this_machine_or_a_path() {
        let place = |text: &str| text.parse::<Place>();
        assert_eq!(place("tcp:7000").unwrap().to_string(), "tcp:127.0.0.1:7000");
        assert_eq!(place("tcp:[::1]:0").unwrap().to_string(), "tcp:[::1]:0");
        assert_eq!(place("/tmp/x"), Ok(Place::Path("/tmp/x".into())));
        assert!(place("tcp:0.0.0.0:7000").is_err());
    }
}
