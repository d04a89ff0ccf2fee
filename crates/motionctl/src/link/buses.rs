//! The options of a motion that may have its drives on several buses.

use core::str::FromStr;

use dyn_can::DriveId;

use super::{Link, OpenError, SpeedOptions, is_interface};
use crate::drive_ids::drive_ids;

/// One bus with --slcan or --can, or several with --bus.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct BusesOptions {
    #[command(flatten)]
    port: Ports,
    #[command(flatten)]
    speeds: SpeedOptions,
}

#[derive(Debug, Clone, clap::Args)]
#[group(required = true, multiple = false)]
struct Ports {
    /// Serial port of a Lawicel (slcan) adapter (COM3 on Windows), or terminal or tcp:PORT of `motionctl bench`.
    #[arg(long, value_name = "TTY")]
    slcan: Option<String>,
    /// CAN network interface, on Linux; pcan:PCAN_USBBUS1 is a PCAN-USB, on Windows.
    #[arg(long, value_name = "INTERFACE")]
    can: Option<String>,
    /// A bus with its drives, once for each: can:INTERFACE=IDS, slcan:TTY=IDS or pcan:CHANNEL=IDS. The first columns are for the drives of the first bus. All
    /// start together, and what stops one stops all.
    #[arg(long, value_name = "LINK=IDS", conflicts_with = "drives")]
    bus: Vec<BusChoice>,
}

/// A bus and its drives, in the order of the columns.
#[derive(Debug, Clone, PartialEq, Eq)]
struct BusChoice {
    port: Port,
    drives: Vec<DriveId>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Port {
    Slcan(String),
    Can(String),
}

impl FromStr for BusChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || {
            format!(
                "expected can:INTERFACE=IDS, slcan:TTY=IDS or pcan:CHANNEL=IDS, as in can:can0=1,2, got {text}"
            )
        };
        let (link, ids) = text.rsplit_once('=').ok_or_else(expected)?;
        let port = match link.split_once(':') {
            Some(("can", name)) if !name.is_empty() => Port::Can(name.to_owned()),
            Some(("pcan", name)) if !name.is_empty() => Port::Can(link.to_owned()),
            Some(("slcan", name)) if !name.is_empty() => Port::Slcan(name.to_owned()),
            _ => return Err(expected()),
        };
        let drives = drive_ids(ids)?;
        Ok(Self { port, drives })
    }
}

/// A bus that is open.
#[derive(Debug)]
pub(crate) struct OpenBus {
    pub(crate) link: Link,
    /// As the user named it; empty for the only one.
    pub(crate) name: String,
    /// The network interface, when it is one.
    pub(crate) interface: Option<String>,
    /// How many drives it has, where the option says so.
    pub(crate) axes: Option<usize>,
}

impl BusesOptions {
    /// The drives of every bus in the order of the columns, where the options name them with their buses.
    pub(crate) fn drives(&self) -> Option<Vec<DriveId>> {
        let drives = self.port.bus.iter().flat_map(|bus| &bus.drives);
        (!self.port.bus.is_empty()).then(|| drives.copied().collect())
    }

    /// The bit rate of every bus in kbit/s.
    pub(crate) fn bit_rate_kbit(&self) -> u32 {
        self.speeds.kbit_per_s()
    }

    /// Opens every bus.
    ///
    /// # Errors
    /// [`OpenError`] of the first that cannot be opened; nothing was sent to a drive.
    pub(crate) fn open(&self) -> Result<Vec<OpenBus>, OpenError> {
        let only = |link, interface: Option<&String>| {
            Ok(vec![OpenBus {
                link,
                name: String::new(),
                interface: interface.filter(|name| is_interface(name)).cloned(),
                axes: None,
            }])
        };
        match (&self.port.slcan, &self.port.can) {
            (Some(port), _) => only(self.speeds.open_slcan(port)?, None),
            (None, Some(interface)) => {
                only(self.speeds.open_interface(interface)?, Some(interface))
            }
            (None, None) => self.port.bus.iter().map(|bus| self.open_one(bus)).collect(),
        }
    }

    fn open_one(&self, bus: &BusChoice) -> Result<OpenBus, OpenError> {
        let (link, name, interface) = match &bus.port {
            Port::Slcan(port) => (self.speeds.open_slcan(port)?, port, None),
            Port::Can(name) => (self.speeds.open_interface(name)?, name, Some(name)),
        };
        Ok(OpenBus {
            link,
            name: name.clone(),
            interface: interface.filter(|name| is_interface(name)).cloned(),
            axes: Some(bus.drives.len()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bus_is_a_link_and_its_drives() {
        let bus: BusChoice = "slcan:/dev/tty=A=5,1-2".parse().unwrap();
        assert_eq!(bus.port, Port::Slcan("/dev/tty=A".to_owned()));
        let pcan: BusChoice = "pcan:PCAN_USBBUS1=3".parse().unwrap();
        assert_eq!(pcan.port, Port::Can("pcan:PCAN_USBBUS1".to_owned()));
        let ids: Vec<u8> = bus.drives.iter().map(|drive| drive.get()).collect();
        assert_eq!(ids, [5, 1, 2]);
        for text in [
            "can0=1",
            "can:=1",
            "can:can0",
            "can:can0=",
            "can:can0=0",
            "usb:x=1",
        ] {
            assert!(text.parse::<BusChoice>().is_err(), "{text}");
        }
    }
}
