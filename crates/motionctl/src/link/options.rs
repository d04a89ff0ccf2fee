//! The options that say which bus to use.

use drive_sim::BitRate;

use super::channel::Channel;
use super::pcan::{Pcan, is_interface, pcan_channel};
use super::slcan::{Settings, Slcan};
use super::{Adapter, Link, OpenError};
use crate::virtual_drives::bit_rate;

/// What most adapters with a real serial port use; those on USB ignore it.
const ADAPTER_BAUD: u32 = 115_200;

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
    #[command(flatten)]
    port: PortOptions,
}

/// How a serial port is used.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub(crate) struct PortOptions {
    /// Speed of the serial port in baud; adapters on USB ignore it. Default: 115200 for a CAN adapter, 38400 for the drives' own
    /// ports.
    #[arg(long, value_name = "BAUD", value_parser = clap::value_parser!(u32).range(300..=4_000_000))]
    baud: Option<u32>,
    /// The adapter answers no command at all, as a CANtact: without this it is taken for the wrong port.
    #[arg(long)]
    no_answers: bool,
}

impl PortOptions {
    /// The speed of a port that has this one by default.
    pub(crate) fn baud_or(&self, default: u32) -> u32 {
        self.baud.unwrap_or(default)
    }

    fn settings(&self, kbit_per_s: u32) -> Settings {
        Settings {
            baud: self.baud_or(ADAPTER_BAUD),
            kbit_per_s,
            expects_answers: !self.no_answers,
        }
    }
}

/// One of the two kinds of adapters.
#[derive(Debug, Clone, clap::Args)]
#[group(required = true, multiple = false)]
struct Port {
    /// Serial port of a Lawicel (slcan) adapter (COM3 on Windows), or terminal or tcp:PORT of `motionctl bench`.
    #[arg(long, value_name = "TTY")]
    slcan: Option<String>,
    /// CAN network interface, on Linux; pcan:PCAN_USBBUS1 is a PCAN-USB, on Windows.
    #[arg(long, value_name = "INTERFACE")]
    can: Option<String>,
}

impl LinkOptions {
    /// Opens the bus.
    ///
    /// # Errors
    /// [`OpenError`]; nothing was sent to a drive.
    pub(crate) fn open(&self) -> Result<Link, OpenError> {
        self.open_at(&self.speeds)
    }

    /// Opens the bus of drives that come with another bit rate.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub(crate) fn open_of_drives_with(&self, usual: BitRate) -> Result<Link, OpenError> {
        self.open_at(&self.speeds.of_drives_with(usual))
    }

    /// The CAN network interface, when it is one.
    pub(crate) fn interface(&self) -> Option<&str> {
        self.port.can.as_deref().filter(|name| is_interface(name))
    }

    fn open_at(&self, speeds: &SpeedOptions) -> Result<Link, OpenError> {
        match (&self.port.slcan, &self.port.can) {
            (Some(port), _) => speeds.open_slcan(port),
            (None, interface) => speeds.open_interface(interface.as_deref().unwrap_or_default()),
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
        let settings = self.port.settings(self.kbit_per_s());
        open_slcan(port, settings, Channel::Open)
    }

    /// How a serial port is used.
    pub(crate) fn port(&self) -> PortOptions {
        self.port
    }

    /// Opens a CAN network interface.
    ///
    /// # Errors
    /// [`OpenError`]; nothing was sent to a drive.
    pub(crate) fn open_interface(&self, interface: &str) -> Result<Link, OpenError> {
        open_interface(interface, self.kbit_per_s(), Channel::Open)
    }
}

/// Opens a Lawicel adapter to listen to it: it sends nothing, and acknowledges nothing unless that is allowed.
///
/// # Errors
/// [`OpenError`].
pub(crate) fn listen_to_slcan(
    port: &str,
    options: PortOptions,
    kbit_per_s: u32,
    acknowledge: bool,
) -> Result<Link, OpenError> {
    let channel = if acknowledge {
        Channel::Open
    } else {
        Channel::ListenOnly
    };
    open_slcan(port, options.settings(kbit_per_s), channel)
}

/// Opens a CAN network interface to listen to it.
///
/// # Errors
/// [`OpenError`].
pub(crate) fn listen_to_interface(interface: &str, kbit_per_s: u32) -> Result<Link, OpenError> {
    open_interface(interface, kbit_per_s, Channel::ListenOnly)
}

fn open_slcan(port: &str, settings: Settings, channel: Channel) -> Result<Link, OpenError> {
    let slcan = Slcan::open(port, settings, channel)?;
    Ok(Link::new(Box::new(slcan), settings.kbit_per_s))
}

fn open_interface(interface: &str, kbit_per_s: u32, channel: Channel) -> Result<Link, OpenError> {
    let adapter = match pcan_channel(interface) {
        Some(name) => Box::new(Pcan::open(name, kbit_per_s, channel)?),
        None => network_interface(interface)?,
    };
    Ok(Link::new(adapter, kbit_per_s))
}

#[cfg(target_os = "linux")]
fn network_interface(name: &str) -> Result<Box<dyn Adapter>, OpenError> {
    Ok(Box::new(super::socket_can::SocketCan::open(name)?))
}

#[cfg(not(target_os = "linux"))]
fn network_interface(name: &str) -> Result<Box<dyn Adapter>, OpenError> {
    let interface = name.to_owned();
    Err(OpenError::NotLinux { interface })
}
