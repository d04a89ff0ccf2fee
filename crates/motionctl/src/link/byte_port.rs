//! The bytes of an adapter or of drives: a serial port, or a TCP port of this machine in its place.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use serialport::{ClearBuffer, SerialPort};

use super::OpenError;
use crate::loopback::loopback;
use crate::system::{Input, read_serial, wait_for_input};

/// How long a program of this machine may take to let this one in.
const CONNECT_TIME: Duration = Duration::from_secs(2);

/// An open port.
pub(crate) enum BytePort {
    Serial(Box<dyn SerialPort>),
    Tcp(TcpStream),
}

impl BytePort {
    /// Opens `tcp:PORT`, or a serial port at a speed.
    ///
    /// # Errors
    /// [`OpenError`] says what is wrong with it.
    pub(crate) fn open(name: &str, baud: u32) -> Result<Self, OpenError> {
        match loopback(name) {
            Some(Ok(address)) => connect(address)
                .map(Self::Tcp)
                .map_err(|error| OpenError::of_tcp(name, error)),
            Some(Err(reason)) => Err(OpenError::NoLoopback { reason }),
            None => serialport::new(name, baud)
                .open()
                .map(Self::Serial)
                .map_err(|error| OpenError::of_port(name, &error)),
        }
    }

    /// Reads what is there, or what comes first within `most`.
    ///
    /// # Errors
    /// [`ErrorKind::TimedOut`] or [`ErrorKind::WouldBlock`] when nothing came. A port that is gone reads as its end, or fails.
    pub(crate) fn read_within(&mut self, buffer: &mut [u8], most: Duration) -> io::Result<usize> {
        match self {
            Self::Serial(port) => read_serial(port.as_mut(), buffer, most),
            Self::Tcp(stream) => {
                wait_for_input(&[Input::Stream(stream)], most)?;
                stream.read(buffer)
            }
        }
    }

    /// Writes a part of the bytes, or as many as there is room for within `most`.
    ///
    /// # Errors
    /// [`ErrorKind::TimedOut`] or [`ErrorKind::WouldBlock`] when there was no room.
    pub(crate) fn write_within(&mut self, bytes: &[u8], most: Duration) -> io::Result<usize> {
        match self {
            Self::Serial(port) => {
                port.set_timeout(most)?;
                port.write(bytes)
            }
            Self::Tcp(stream) => {
                let until = Instant::now() + most;
                loop {
                    match stream.write(bytes) {
                        Err(error)
                            if error.kind() == ErrorKind::WouldBlock && Instant::now() < until =>
                        {
                            std::thread::sleep(Duration::from_millis(1));
                        }
                        written => return written,
                    }
                }
            }
        }
    }

    /// Writes every byte.
    ///
    /// # Errors
    /// As [`Self::write_within`]; a part may have been written.
    pub(crate) fn write_all_within(&mut self, bytes: &[u8], most: Duration) -> io::Result<()> {
        let mut rest = bytes;
        while !rest.is_empty() {
            match self.write_within(rest, most)? {
                0 => return Err(ErrorKind::WriteZero.into()),
                written => rest = rest.get(written..).unwrap_or_default(),
            }
        }
        Ok(())
    }

    /// Waits until the bytes have left.
    ///
    /// # Errors
    /// When the port is gone.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Serial(port) => port.flush(),
            Self::Tcp(stream) => stream.flush(),
        }
    }

    /// Forgets what has come in.
    ///
    /// # Errors
    /// When the port is gone.
    pub(crate) fn clear_input(&mut self) -> io::Result<()> {
        if let Self::Serial(port) = self {
            return Ok(port.clear(ClearBuffer::Input)?);
        }
        while self.has_input()? {
            if self.read_within(&mut [0; 1_024], Duration::ZERO)? == 0 {
                return Err(ErrorKind::UnexpectedEof.into());
            }
        }
        Ok(())
    }

    /// Whether something has come in.
    ///
    /// # Errors
    /// When the port is gone.
    pub(crate) fn has_input(&self) -> io::Result<bool> {
        match self {
            Self::Serial(port) => Ok(port.bytes_to_read()? > 0),
            Self::Tcp(stream) => match stream.peek(&mut [0]) {
                // Its end is to be read.
                Ok(_) => Ok(true),
                Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(false),
                Err(error) => Err(error),
            },
        }
    }
}

fn connect(address: SocketAddr) -> io::Result<TcpStream> {
    let stream = TcpStream::connect_timeout(&address, CONNECT_TIME)?;
    stream.set_nodelay(true)?;
    stream.set_nonblocking(true)?;
    Ok(stream)
}
