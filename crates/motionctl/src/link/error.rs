//! Why a link cannot be opened.

use core::fmt;
use std::io::{self, ErrorKind};

use crate::system::{serial_port_exists, serial_ports_hint};

/// A link that cannot be opened; nothing was sent to a drive.
#[derive(Debug)]
pub(crate) enum OpenError {
    /// Nothing is at this path.
    NoSuchPort { port: String },
    /// The user may not open the port.
    NotAllowed { port: String },
    /// Another program uses the port.
    Busy { port: String },
    /// The port is no serial port.
    NotSerial { port: String, source: io::Error },
    /// What is on the port does not answer as a Lawicel adapter.
    NoAdapter { port: String, heard: Vec<u8> },
    /// The adapter refuses a command that every adapter has.
    CommandRefused { port: String, command: String },
    /// The adapter cannot listen without acknowledging.
    NoListenOnly { port: String },
    /// The Lawicel protocol has no such bit rate.
    BitRate { kbit_per_s: u32 },
    /// The kernel has no CAN.
    #[cfg_attr(not(target_os = "linux"), expect(dead_code, reason = "of Linux"))]
    NoCanInKernel { interface: String },
    /// There is no such network interface, or it is no CAN interface.
    #[cfg_attr(not(target_os = "linux"), expect(dead_code, reason = "of Linux"))]
    NoSuchInterface { interface: String },
    /// The network interface is down.
    #[cfg_attr(not(target_os = "linux"), expect(dead_code, reason = "of Linux"))]
    InterfaceDown { interface: String },
    /// Only Linux has CAN network interfaces.
    #[cfg_attr(target_os = "linux", expect(dead_code, reason = "Linux has them"))]
    NotLinux { interface: String },
    /// A TCP port that is not one of this machine.
    NoLoopback { reason: String },
    /// Nobody listens at a TCP port of this machine.
    NobodyListens { port: String },
    /// A PCAN adapter cannot be opened.
    Pcan {
        channel: String,
        reason: pcan_basic::Error,
    },
    /// Not a channel of a PCAN adapter.
    PcanName(pcan_basic::BadName),
    /// PCAN-Basic is for Windows.
    NotWindows { channel: String },
    /// Something else.
    System { name: String, source: io::Error },
}

impl OpenError {
    /// What is wrong with a serial port that cannot be opened.
    pub(crate) fn of_port(name: &str, error: &serialport::Error) -> Self {
        let port = name.to_owned();
        match error.kind() {
            serialport::ErrorKind::Io(ErrorKind::NotFound) => Self::NoSuchPort { port },
            serialport::ErrorKind::Io(ErrorKind::PermissionDenied) => Self::NotAllowed { port },
            // The library reports a port that is locked as one that is not there.
            serialport::ErrorKind::NoDevice if serial_port_exists(name) => Self::Busy { port },
            serialport::ErrorKind::NoDevice => Self::NoSuchPort { port },
            _ => Self::NotSerial {
                port,
                source: io::Error::other(error.to_string()),
            },
        }
    }

    /// What is wrong with a TCP port of this machine.
    pub(super) fn of_tcp(name: &str, error: io::Error) -> Self {
        let port = name.to_owned();
        match error.kind() {
            ErrorKind::ConnectionRefused => Self::NobodyListens { port },
            _ => Self::System {
                name: port,
                source: error,
            },
        }
    }
}

impl fmt::Display for OpenError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSuchPort { port } => {
                write!(
                    f,
                    "there is no port {port}: is the adapter plugged in?{}",
                    serial_ports_hint()
                )
            }
            Self::NotAllowed { port } => write!(
                f,
                "{port} may not be opened by this user: on most systems membership in the group dialout is needed"
            ),
            Self::Busy { port } => {
                write!(f, "{port} is in use by another program: end that one first")
            }
            Self::NotSerial { port, source } => {
                write!(f, "{port} cannot be used as a serial port: {source}")
            }
            Self::NoAdapter { port, heard } if heard.is_empty() => write!(
                f,
                "no Lawicel (slcan) adapter answers on {port}: it was asked to close its channel and for its version, and stayed silent for 4 s; is this the right port? An adapter that answers nothing at all needs --no-answers"
            ),
            Self::NoAdapter { port, heard } => write!(
                f,
                "no Lawicel (slcan) adapter answers on {port}: it was asked to close its channel and said \"{}\", expected CR or BEL; is this the right port?",
                heard.escape_ascii()
            ),
            Self::CommandRefused { port, command } if command.starts_with('S') => write!(
                f,
                "the adapter on {port} answers BEL to {command}, expected CR: it does not have this bit rate, or it keeps its channel open; choose another --bit-rate, or unplug it and plug it in"
            ),
            Self::CommandRefused { port, command } => write!(
                f,
                "the adapter on {port} answers BEL to {command}, expected CR: unplug it and plug it in"
            ),
            Self::NoListenOnly { port } => write!(
                f,
                "the adapter on {port} answers BEL to L, expected CR: it cannot listen without acknowledging. --acknowledge lets it acknowledge; with a wrong --bit-rate that disturbs the bus"
            ),
            Self::BitRate { kbit_per_s } => write!(
                f,
                "Lawicel adapters know 10, 20, 50, 100, 125, 250, 500, 800 and 1000 kbit/s, not {kbit_per_s}"
            ),
            Self::NoCanInKernel { interface } => write!(
                f,
                "cannot open {interface}: this kernel has no CAN support (modules can and can_raw); use --slcan with a serial adapter instead"
            ),
            Self::NoSuchInterface { interface } => write!(
                f,
                "there is no CAN interface {interface}: `ip link` lists those that are there"
            ),
            Self::InterfaceDown { interface } => write!(
                f,
                "{interface} is down: `ip link set {interface} up type can bitrate 1000000` brings it up"
            ),
            Self::NotLinux { interface } => write!(
                f,
                "cannot open {interface}: only Linux has CAN network interfaces; use --slcan with a serial adapter instead, or --can pcan:PCAN_USBBUS1 with a PCAN-USB on Windows"
            ),
            Self::NoLoopback { reason } => f.write_str(reason),
            Self::NobodyListens { port } => write!(
                f,
                "nobody listens at {port}: expected `motionctl bench --slcan {port}` in another terminal"
            ),
            Self::Pcan { channel, reason } => write!(f, "cannot open pcan:{channel}: {reason}"),
            Self::PcanName(reason) => write!(f, "pcan: {reason}"),
            Self::NotWindows { channel } => write!(
                f,
                "cannot open pcan:{channel}: PCAN-Basic is used on Windows alone. On Linux a PCAN-USB is a network interface (driver peak_usb of the kernel): `ip link set can0 up type can bitrate 1000000` brings it up, --can can0 takes it"
            ),
            Self::System { name, source } => write!(f, "cannot open {name}: {source}"),
        }
    }
}

impl std::error::Error for OpenError {}
