//! The options that say which bus to use.

use drive_sim::BitRate;

use super::slcan::{Channel, Slcan};
use super::{Adapter, Link, OpenError};
use crate::virtual_drives::bit_rate;

/// What most adapters with a real serial port use; those on USB ignore it.
const DEFAULT_BAUD: u32 = 115_200;

/// Which bus to use.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct LinkOptions {
    #[command(flatten)]
    port: Port,
    #[command(flatten)]
    speeds: SpeedOptions,
}

/// How fast an adapter is.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct SpeedOptions {
    /// Bit rate of the bus in kbit/s. A serial adapter is set to it; a network interface is set with `ip link`. Default: 1000, and 500
    /// for CANopen nodes.
    #[arg(long, value_name = "KBIT", value_parser = bit_rate)]
    bit_rate: Option<BitRate>,
    /// Speed of the serial port in baud; adapters on USB ignore it.
    #[arg(long, value_name = "BAUD", default_value_t = DEFAULT_BAUD)]
    baud: u32,
}

/// One of the two kinds of adapters.
#[derive(Debug, Clone, clap::Args)]
#[group(required = true, multiple = false)]
struct Port {
    /// Serial port of a Lawicel (slcan) adapter, or terminal of `motionctl bench`.
    #[arg(long, value_name = "TTY")]
    slcan: Option<String>,
    /// CAN network interface, on Linux.
    #[arg(long, value_name = "INTERFACE")]
    can: Option<String>,
}

impl LinkOptions {
    /// Opens the bus.
    ///
    /// # Errors
    /// [`OpenError`]; nothing was sent to a drive.
    pub(crate) fn open(&self) -> Result<Link, OpenError> {
        match (&self.port.slcan, &self.port.can) {
            (Some(port), _) => self.speeds.open_slcan(port),
            (None, interface) => self
                .speeds
                .open_interface(interface.as_deref().unwrap_or_default()),
        }
    }
}

impl SpeedOptions {
    /// The same, for drives that come with another bit rate.
    pub(crate) fn of_drives_with(&self, usual: BitRate) -> Self {
        Self {
            bit_rate: self.bit_rate.or(Some(usual)),
            ..self.clone()
        }
    }

    /// The bit rate in force, in kbit/s.
    pub(crate) fn kbit_per_s(&self) -> u32 {
        self.bit_rate.unwrap_or(BitRate::Kbit1000).kbit_per_s()
    }

    /// Opens a Lawicel adapter.
    ///
    /// # Errors
    /// [`OpenError`]; nothing was sent to a drive.
    pub(crate) fn open_slcan(&self, port: &str) -> Result<Link, OpenError> {
        open_slcan(port, self.baud, self.kbit_per_s(), Channel::Open)
    }

    /// Opens a CAN network interface.
    ///
    /// # Errors
    /// [`OpenError`]; nothing was sent to a drive.
    pub(crate) fn open_interface(&self, interface: &str) -> Result<Link, OpenError> {
        open_interface(interface, self.kbit_per_s())
    }
}

/// Opens a Lawicel adapter on USB that only listens: it sends nothing and acknowledges nothing.
///
/// # Errors
/// [`OpenError`].
pub(crate) fn listen_to_slcan(port: &str, kbit_per_s: u32) -> Result<Link, OpenError> {
    open_slcan(port, DEFAULT_BAUD, kbit_per_s, Channel::ListenOnly)
}

/// Opens a CAN network interface to listen to it.
///
/// # Errors
/// [`OpenError`].
pub(crate) fn listen_to_interface(interface: &str, kbit_per_s: u32) -> Result<Link, OpenError> {
    open_interface(interface, kbit_per_s)
}

fn open_slcan(port: &str, baud: u32, kbit_per_s: u32, channel: Channel) -> Result<Link, OpenError> {
    let slcan = Slcan::open(port, baud, kbit_per_s, channel)?;
    Ok(Link::new(Adapter::Slcan(slcan), kbit_per_s))
}

#[cfg(target_os = "linux")]
fn open_interface(interface: &str, kbit_per_s: u32) -> Result<Link, OpenError> {
    let socket = super::SocketCan::open(interface)?;
    Ok(Link::new(Adapter::SocketCan(socket), kbit_per_s))
}

#[cfg(not(target_os = "linux"))]
fn open_interface(interface: &str, _: u32) -> Result<Link, OpenError> {
    let interface = interface.to_owned();
    Err(OpenError::NotLinux { interface })
}
