//! The options that say how the drives are connected.

use std::num::NonZeroU8;

use super::can::CanDrives;
use super::serial::{Line, SerialDrives};
use super::{Drives, Frames};
use crate::link::{Link, OpenError, SpeedOptions};
use crate::station::AxisOptions;

/// How the drives are connected.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct DrivesOptions {
    #[command(flatten)]
    connection: Connection,
    #[command(flatten)]
    speeds: SpeedOptions,
    /// Number of drives that are chained behind the serial port, each of which passes on what is not for itself.
    #[arg(long, value_name = "N", default_value = "1", requires = "serial")]
    chain: NonZeroU8,
}

/// One of the three kinds of connections.
#[derive(Debug, Clone, clap::Args)]
#[group(required = true, multiple = false)]
struct Connection {
    /// Serial port of a Lawicel (slcan) adapter (COM3 on Windows), or terminal or tcp:PORT of `motionctl bench --slcan`.
    #[arg(long, value_name = "TTY")]
    slcan: Option<String>,
    /// CAN network interface, on Linux; pcan:PCAN_USBBUS1 is a PCAN-USB, on Windows.
    #[arg(long, value_name = "INTERFACE")]
    can: Option<String>,
    /// Serial port of the drives themselves (RS232 or RS485, 38400 8N1), COM3 on Windows, or terminal or tcp:PORT of `motionctl bench
    /// --serial`.
    #[arg(long, value_name = "TTY")]
    serial: Option<String>,
}

impl DrivesOptions {
    /// Opens the connection.
    ///
    /// # Errors
    /// [`OpenError`]; nothing was sent to a drive.
    pub(crate) fn open(&self, axes: AxisOptions) -> Result<Box<dyn Drives>, OpenError> {
        if let Some(drives) = self.open_serial(axes)? {
            return Ok(Box::new(drives));
        }
        Ok(Box::new(CanDrives::new(self.open_can()?, axes)))
    }

    /// Opens the serial port of the drives; `None` when they are on CAN.
    ///
    /// # Errors
    /// [`OpenError`]; nothing was sent to a drive.
    pub(crate) fn open_serial(&self, axes: AxisOptions) -> Result<Option<SerialDrives>, OpenError> {
        let Some(port) = &self.connection.serial else {
            return Ok(None);
        };
        let line = Line::open(port, self.speeds.port(), self.chain)?;
        Ok(Some(SerialDrives::new(line, axes)))
    }

    /// Opens the CAN bus of the drives.
    ///
    /// # Errors
    /// [`OpenError`]; nothing was sent to a drive.
    pub(crate) fn open_can(&self) -> Result<Link, OpenError> {
        self.open_bus(&self.speeds)
    }

    /// Opens a CAN bus of CANopen nodes, and says its bit rate in kbit/s.
    ///
    /// # Errors
    /// [`OpenError`]; nothing was sent to a node.
    pub(crate) fn open_canopen(&self) -> Result<(Link, u32), OpenError> {
        let speeds = self.speeds.of_drives_with(zlac8030l::FACTORY_BIT_RATE);
        Ok((self.open_bus(&speeds)?, speeds.kbit_per_s()))
    }

    fn open_bus(&self, speeds: &SpeedOptions) -> Result<Link, OpenError> {
        match (&self.connection.slcan, &self.connection.can) {
            (Some(port), _) => speeds.open_slcan(port),
            (None, interface) => speeds.open_interface(interface.as_deref().unwrap_or_default()),
        }
    }

    /// The frames of this kind of connection.
    pub(crate) fn frames(&self) -> Frames {
        if self.is_serial() {
            Frames::Serial
        } else {
            Frames::Can
        }
    }

    /// The drives are behind a serial port of their own.
    pub(crate) fn is_serial(&self) -> bool {
        self.connection.serial.is_some()
    }
}
