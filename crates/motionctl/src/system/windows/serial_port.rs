//! Serial ports, `COM1` and so on.

use std::io;
use std::time::Duration;

use serialport::SerialPort;

/// The system counts the time of a read in whole milliseconds, and takes less than one for ever.
const SHORTEST_READ: Duration = Duration::from_millis(1);

/// Whether the system has a serial port of this name, used or not.
pub(crate) fn serial_port_exists(name: &str) -> bool {
    // Ports are also written \\.\COM10.
    let name = name.strip_prefix(r"\\.\").unwrap_or(name);
    serialport::available_ports().is_ok_and(|ports| {
        ports
            .iter()
            .any(|port| port.port_name.eq_ignore_ascii_case(name))
    })
}

/// Which ports are there, for whoever misses one.
pub(crate) fn serial_ports_hint() -> String {
    let ports = serialport::available_ports().unwrap_or_default();
    let names: Vec<&str> = ports.iter().map(|port| port.port_name.as_str()).collect();
    match names.as_slice() {
        [] => " This computer has no serial port".to_owned(),
        names => format!(" This computer has {}", names.join(", ")),
    }
}

/// Reads what is there, or what comes first within `most`.
///
/// # Errors
/// [`io::ErrorKind::TimedOut`] or [`io::ErrorKind::WouldBlock`] when nothing came; others when the port is gone.
pub(crate) fn read_serial(
    port: &mut dyn SerialPort,
    buffer: &mut [u8],
    most: Duration,
) -> io::Result<usize> {
    if most < SHORTEST_READ && port.bytes_to_read()? == 0 {
        std::thread::sleep(most);
        return Err(io::ErrorKind::WouldBlock.into());
    }
    port.set_timeout(most.max(SHORTEST_READ))?;
    port.read(buffer)
}
