//! What can happen to an open link.

use core::fmt;

use embedded_can::ErrorKind;

/// Something that happened to an open link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LinkFault {
    /// The adapter, or the program behind its terminal, is gone.
    Vanished,
    /// The network interface was set down.
    #[cfg_attr(not(target_os = "linux"), expect(dead_code, reason = "of Linux"))]
    Down,
    /// The adapter's controller is bus-off.
    BusOff,
    /// An error on the bus; the link goes on.
    Bus(ErrorKind),
}

impl LinkFault {
    /// Nothing gets through any more.
    pub(crate) const fn is_final(self) -> bool {
        !matches!(self, Self::Bus(_))
    }
}

impl embedded_can::Error for LinkFault {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Bus(kind) => *kind,
            Self::Vanished | Self::Down | Self::BusOff => ErrorKind::Other,
        }
    }
}

impl fmt::Display for LinkFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Vanished => f.write_str("the adapter is gone: unplugged, or its program ended"),
            Self::Down => f.write_str("the network interface is down or gone"),
            Self::BusOff => f.write_str(
                "the adapter is bus-off: check bit rate, termination and wiring, then restart the interface",
            ),
            Self::Bus(kind) => write!(f, "error on the bus: {kind}"),
        }
    }
}

impl std::error::Error for LinkFault {}
