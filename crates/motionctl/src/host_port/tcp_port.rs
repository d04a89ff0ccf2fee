//! A TCP port of this machine in the place of a serial port: one host at a time, as a cable has one end.

use core::fmt;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};

use crate::output::tell;
use crate::system::Input;

/// A port that is listened at, and the host that has come.
#[derive(Debug)]
pub(crate) struct TcpPort {
    listener: TcpListener,
    address: SocketAddr,
    host: Option<TcpStream>,
    /// What is behind it.
    what: &'static str,
}

impl TcpPort {
    /// Listens; port 0 takes one that is free.
    pub(super) fn open(address: SocketAddr, what: &'static str) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            address: listener.local_addr()?,
            listener,
            host: None,
            what,
        })
    }

    /// Reads what the host has sent, and lets in the next one when it has gone.
    pub(super) fn read<'a>(&mut self, buffer: &'a mut [u8]) -> io::Result<&'a [u8]> {
        // First the one who is there: it may have made room.
        let length = self.read_host(buffer);
        self.let_in()?;
        Ok(&buffer[..length])
    }

    fn read_host(&mut self, buffer: &mut [u8]) -> usize {
        let Some(host) = &mut self.host else {
            return 0;
        };
        match host.read(buffer) {
            Ok(length) if length > 0 => length,
            Err(error) if is_transient(&error) => 0,
            // It has hung up, or was cut off.
            Ok(_) | Err(_) => {
                self.host = None;
                0
            }
        }
    }

    fn let_in(&mut self) -> io::Result<()> {
        loop {
            let (stream, peer) = match self.listener.accept() {
                Ok(accepted) => accepted,
                Err(error) if is_transient(&error) => return Ok(()),
                // Whoever came has gone again.
                Err(error) if error.kind() == ErrorKind::ConnectionAborted => continue,
                Err(error) => return Err(error),
            };
            if self.host.is_some() {
                tell(format_args!(
                    "refused {peer} at {self}: {} has one host at a time, and another program is connected",
                    self.what
                ));
                continue;
            }
            // A command must not wait for the next one.
            let set_up = stream
                .set_nonblocking(true)
                .and_then(|()| stream.set_nodelay(true));
            self.host = set_up.is_ok().then_some(stream);
        }
    }

    /// Writes what there is room for; what is for a host that is not there is gone, as in a port whose cable is pulled.
    pub(super) fn write(&mut self, bytes: &[u8]) -> usize {
        let Some(host) = &mut self.host else {
            return bytes.len();
        };
        match host.write(bytes) {
            Ok(length) => length,
            Err(error) if is_transient(&error) => 0,
            Err(_) => {
                self.host = None;
                bytes.len()
            }
        }
    }

    pub(super) fn inputs(&self) -> Vec<Input<'_>> {
        let host = self.host.iter().map(Input::Stream);
        host.chain([Input::Listener(&self.listener)]).collect()
    }
}

impl fmt::Display for TcpPort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "tcp:{}", self.address)
    }
}

fn is_transient(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::WouldBlock | ErrorKind::Interrupted | ErrorKind::TimedOut
    )
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;
    use crate::system::wait_for_input;

    const PATIENCE: Duration = Duration::from_secs(10);

    fn port() -> TcpPort {
        TcpPort::open("127.0.0.1:0".parse().unwrap(), "the adapter").unwrap()
    }

    fn connect(port: &TcpPort) -> TcpStream {
        let stream = TcpStream::connect(port.address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// Reads until so many bytes have come.
    fn hear(port: &mut TcpPort, expected: &[u8]) {
        let (start, mut heard) = (Instant::now(), Vec::new());
        while heard.len() < expected.len() {
            assert!(start.elapsed() < PATIENCE, "heard {heard:?} alone");
            wait_for_input(&port.inputs(), PATIENCE).unwrap();
            heard.extend_from_slice(port.read(&mut [0; 64]).unwrap());
        }
        assert_eq!(heard, expected);
    }

    #[test]
    fn bytes_cross_it_unchanged_both_ways() {
        let mut port = port();
        let mut host = connect(&port);
        host.write_all(b"V\r\x03\n\x07").unwrap();
        hear(&mut port, b"V\r\x03\n\x07");
        assert_eq!(port.write(b"V1013\r\x07"), 7);
        let mut heard = [0; 7];
        host.read_exact(&mut heard).unwrap();
        assert_eq!(&heard, b"V1013\r\x07");
    }

    #[test]
    fn a_second_host_is_cut_off_and_the_first_stays() {
        let mut port = port();
        let mut first = connect(&port);
        first.write_all(b"1").unwrap();
        hear(&mut port, b"1");
        let mut second = connect(&port);
        wait_for_input(&port.inputs(), PATIENCE).unwrap();
        assert_eq!(port.read(&mut [0; 8]).unwrap(), b"");
        // It is told by an end or by an error, and not by silence.
        let told = second.read(&mut [0; 8]).map_err(|error| error.kind());
        assert!(
            !matches!(
                told,
                Err(ErrorKind::WouldBlock | ErrorKind::TimedOut) | Ok(1..)
            ),
            "{told:?}"
        );
        first.write_all(b"2").unwrap();
        hear(&mut port, b"2");
    }

    #[test]
    fn a_host_that_comes_back_is_let_in_and_hears_nothing_of_the_time_between() {
        let mut port = port();
        let mut host = connect(&port);
        host.write_all(b"1").unwrap();
        hear(&mut port, b"1");
        drop(host);
        while port.host.is_some() {
            wait_for_input(&port.inputs(), PATIENCE).unwrap();
            assert_eq!(port.read(&mut [0; 8]).unwrap(), b"");
        }
        assert_eq!(port.write(b"lost"), 4);
        let mut host = connect(&port);
        host.write_all(b"2").unwrap();
        hear(&mut port, b"2");
        assert_eq!(port.write(b"new"), 3);
        let mut heard = [0; 3];
        host.read_exact(&mut heard).unwrap();
        assert_eq!(&heard, b"new");
    }
}
