//! The options that say which bus to use.

use drive_sim::BitRate;

use super::slcan::{Channel, Slcan};
use super::{Link, OpenError};
use crate::virtual_drives::bit_rate;

/// What most adapters with a real serial port use; those on USB ignore it.
const DEFAULT_BAUD: u32 = 115_200;

/// Which bus to use.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct LinkOptions {
    #[command(flatten)]
    adapter: Adapter,
    #[command(flatten)]
    speeds: SpeedOptions,
}

/// How fast an adapter is.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct SpeedOptions {
    /// Bit rate in kbit/s that a serial adapter is set to; that of a network interface is set with `ip link`.
    #[arg(long, value_name = "KBIT", default_value = "1000", value_parser = bit_rate)]
    bit_rate: BitRate,
    /// Speed of the serial port in baud; adapters on USB ignore it.
    #[arg(long, value_name = "BAUD", default_value_t = DEFAULT_BAUD)]
    baud: u32,
}

/// One of the two kinds of adapters.
#[derive(Debug, Clone, clap::Args)]
#[group(required = true, multiple = false)]
struct Adapter {
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
        match (&self.adapter.slcan, &self.adapter.can) {
            (Some(port), _) => self.speeds.open_slcan(port),
            (None, interface) => open_interface(interface.as_deref().unwrap_or_default()),
        }
    }
}

impl SpeedOptions {
    /// Opens a Lawicel adapter.
    ///
    /// # Errors
    /// [`OpenError`]; nothing was sent to a drive.
    pub(crate) fn open_slcan(&self, port: &str) -> Result<Link, OpenError> {
        let kbit_per_s = self.bit_rate.kbit_per_s();
        Slcan::open(port, self.baud, kbit_per_s, Channel::Open).map(Link::Slcan)
    }
}

/// Opens a Lawicel adapter on USB that only listens: it sends nothing and acknowledges nothing.
///
/// # Errors
/// [`OpenError`].
pub(crate) fn listen_to_slcan(port: &str, kbit_per_s: u32) -> Result<Link, OpenError> {
    Slcan::open(port, DEFAULT_BAUD, kbit_per_s, Channel::ListenOnly).map(Link::Slcan)
}

/// Opens a CAN network interface.
///
/// # Errors
/// [`OpenError`]; nothing was sent to a drive.
#[cfg(target_os = "linux")]
pub(crate) fn open_interface(interface: &str) -> Result<Link, OpenError> {
    super::SocketCan::open(interface).map(Link::SocketCan)
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn open_interface(interface: &str) -> Result<Link, OpenError> {
    let interface = interface.to_owned();
    Err(OpenError::NotLinux { interface })
}
