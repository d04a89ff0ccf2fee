//! A port or a socket file that is listened at, and whoever comes.

use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::time::Duration;

use super::{Endpoint, EndpointError, address};
use crate::system::{SocketFile, SocketFileListener, SocketFileStream};

/// Somebody who does not read for so long is not written to any more.
const WRITE_PATIENCE: Duration = Duration::from_secs(1);

/// Open for others.
#[derive(Debug)]
pub(crate) enum Listener {
    Tcp(TcpListener),
    Unix {
        listener: SocketFileListener,
        /// Removes the file.
        _file: SocketFile,
    },
}

/// Somebody who has come.
#[derive(Debug)]
pub(crate) enum Peer {
    Tcp(TcpStream),
    Unix(SocketFileStream),
}

impl Listener {
    /// Listens; nobody is let in yet.
    ///
    /// # Errors
    /// [`EndpointError`]. Standard input is nothing to listen at.
    pub(crate) fn open(endpoint: &Endpoint, allow_remote: bool) -> Result<Self, EndpointError> {
        let failed = |source: io::Error| match source.kind() {
            io::ErrorKind::AddrInUse => EndpointError::InUse {
                endpoint: endpoint.to_string(),
            },
            _ => EndpointError::Open {
                endpoint: endpoint.to_string(),
                source,
            },
        };
        match endpoint {
            Endpoint::StandardInput => Err(failed(io::Error::other(
                "standard input is for one writer, who is there already",
            ))),
            Endpoint::Tcp { host, port } => {
                let address = address(host.as_deref(), *port, allow_remote)?;
                TcpListener::bind(address).map(Self::Tcp).map_err(failed)
            }
            Endpoint::Unix(path) => {
                let (listener, file) =
                    SocketFile::bind(path).map_err(|source| match source.kind() {
                        io::ErrorKind::AlreadyExists => {
                            EndpointError::NoSocket { path: path.into() }
                        }
                        _ => failed(source),
                    })?;
                Ok(Self::Unix {
                    listener,
                    _file: file,
                })
            }
        }
    }

    /// The same once more, for a thread that lets people in.
    ///
    /// # Errors
    /// When the system has no handle left.
    pub(crate) fn handle(&self) -> io::Result<Door> {
        Ok(match self {
            Self::Tcp(listener) => Door::Tcp(listener.try_clone()?),
            Self::Unix { listener, .. } => Door::Unix(listener.try_clone()?),
        })
    }

    /// The port that was opened, where there is one.
    pub(crate) fn port(&self) -> Option<u16> {
        match self {
            Self::Tcp(listener) => Some(listener.local_addr().ok()?.port()),
            Self::Unix { .. } => None,
        }
    }
}

/// Lets people in.
#[derive(Debug)]
pub(crate) enum Door {
    Tcp(TcpListener),
    Unix(SocketFileListener),
}

impl Door {
    /// Waits for the next one.
    ///
    /// # Errors
    /// When nobody can come any more.
    pub(crate) fn next(&self) -> io::Result<Peer> {
        Ok(match self {
            Self::Tcp(listener) => {
                let (stream, _) = listener.accept()?;
                // Answers are short and wanted at once.
                let _ = stream.set_nodelay(true);
                let _ = stream.set_write_timeout(Some(WRITE_PATIENCE));
                Peer::Tcp(stream)
            }
            Self::Unix(listener) => {
                let (stream, _) = listener.accept()?;
                let _ = stream.set_write_timeout(Some(WRITE_PATIENCE));
                Peer::Unix(stream)
            }
        })
    }
}

impl Peer {
    /// A second handle, to write while another thread reads.
    ///
    /// # Errors
    /// When the system has no handle left.
    pub(crate) fn again(&self) -> io::Result<Self> {
        Ok(match self {
            Self::Tcp(stream) => Self::Tcp(stream.try_clone()?),
            Self::Unix(stream) => Self::Unix(stream.try_clone()?),
        })
    }

    /// Says a last word and ends the connection.
    pub(crate) fn dismiss(mut self, word: &str) {
        // Whoever does not listen has gone.
        let _ = writeln!(self, "{word}");
        self.close();
    }

    /// Ends the connection, for every handle.
    pub(crate) fn close(self) {
        let _ = match &self {
            Self::Tcp(stream) => stream.shutdown(Shutdown::Both),
            Self::Unix(stream) => stream.shutdown(Shutdown::Both),
        };
    }
}

impl Read for Peer {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Tcp(stream) => stream.read(bytes),
            Self::Unix(stream) => stream.read(bytes),
        }
    }
}

impl Write for Peer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Tcp(stream) => stream.write(bytes),
            Self::Unix(stream) => stream.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
