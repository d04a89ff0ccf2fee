//! The bytes: a serial port, a pseudo-terminal, or a TCP port of this machine.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{IpAddr, SocketAddr, TcpStream};
use std::time::Duration;

use serialport::SerialPort;

/// A read waits no longer: what is to be sent waits as long.
const PATIENCE: Duration = Duration::from_millis(1);
const CONNECT: Duration = Duration::from_secs(3);

/// An open port.
pub(super) enum Port {
    Serial(Box<dyn SerialPort>),
    Tcp(TcpStream),
}

impl Port {
    /// Opens `tcp:PORT`, `tcp:127.0.0.1:PORT`, or else a serial port.
    pub(super) fn open(address: &str, baud: u32) -> Result<Self, String> {
        match address.strip_prefix("tcp:") {
            Some(place) => Self::connect(address, place),
            None => serialport::new(address, baud)
                .timeout(PATIENCE)
                .open()
                .map(Self::Serial)
                .map_err(|error| format!("cannot open {address}: {error}")),
        }
    }

    fn connect(address: &str, place: &str) -> Result<Self, String> {
        let place = place_of(place).ok_or_else(|| {
            format!(
                "expected tcp:PORT or tcp:127.0.0.1:PORT, an address of this machine, got {address}"
            )
        })?;
        let connect = || {
            let stream = TcpStream::connect_timeout(&place, CONNECT)?;
            stream.set_nodelay(true)?;
            stream.set_read_timeout(Some(PATIENCE))?;
            stream.set_write_timeout(Some(PATIENCE))?;
            Ok(stream)
        };
        connect()
            .map(Self::Tcp)
            .map_err(|error: io::Error| format!("cannot connect to {address}: {error}"))
    }

    /// Waits a moment for bytes; an error is a port that is gone.
    pub(super) fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = match self {
            Self::Serial(port) => port.read(buffer),
            Self::Tcp(stream) => stream.read(buffer),
        };
        // Nothing in time is an error of its own: no byte is the end of it.
        let read = match read {
            Ok(0) => Err(ErrorKind::UnexpectedEof.into()),
            other => other,
        };
        or_nothing(read)
    }

    /// Writes what there is room for.
    pub(super) fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        or_nothing(match self {
            Self::Serial(port) => port.write(bytes),
            Self::Tcp(stream) => stream.write(bytes),
        })
    }
}

fn or_nothing(result: io::Result<usize>) -> io::Result<usize> {
    match result {
        Err(error)
            if matches!(
                error.kind(),
                ErrorKind::WouldBlock | ErrorKind::Interrupted | ErrorKind::TimedOut
            ) =>
        {
            Ok(0)
        }
        other => other,
    }
}

/// A board is commanded without a password: only from this machine.
fn place_of(text: &str) -> Option<SocketAddr> {
    let place = match text.parse::<u16>() {
        Ok(port) => SocketAddr::new(IpAddr::from([127, 0, 0, 1]), port),
        Err(_) => text.replace("localhost", "127.0.0.1").parse().ok()?,
    };
    place.ip().is_loopback().then_some(place)
}
