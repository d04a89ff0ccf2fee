//! Serial ports.

use std::io;
use std::path::Path;
use std::time::Duration;

use serialport::SerialPort;

/// Whether the system has a serial port of this name, used or not.
pub(crate) fn serial_port_exists(name: &str) -> bool {
    Path::new(name).exists()
}

/// Whoever misses a port finds the others in `/dev`.
pub(crate) fn serial_ports_hint() -> String {
    String::new()
}

/// Reads what is there, or what comes first within `most`.
///
/// # Errors
/// [`io::ErrorKind::TimedOut`] when nothing came; others when the port is gone.
pub(crate) fn read_serial(
    port: &mut dyn SerialPort,
    buffer: &mut [u8],
    most: Duration,
) -> io::Result<usize> {
    port.set_timeout(most)?;
    port.read(buffer)
}
