//! A PCAN-USB on Windows, through PEAK's library.

use std::time::{Duration, Instant};

use drive_sim::Frame;
use embedded_can::nb::Can;
use embedded_can::{ErrorKind, ExtendedId, Frame as _, Id, StandardId};
use pcan_basic::{Message, Mode, PcanBasic, Status};

use super::channel::Channel;
use super::{Adapter, LinkFault, OpenError};

/// What the name of such an adapter begins with.
const SCHEME: &str = "pcan:";
/// How often is looked for frames: the library waits only on events of Windows, through unsafe calls.
const LOOK: Duration = Duration::from_millis(1);
/// How often is asked whether the adapter is still there.
const CHECK_TIME: Duration = Duration::from_millis(50);

/// The channel that a name means; `None` for a network interface.
pub(super) fn pcan_channel(name: &str) -> Option<&str> {
    name.strip_prefix(SCHEME)
}

/// Whether a name is that of a network interface, as logs have it.
pub(crate) fn is_interface(name: &str) -> bool {
    pcan_channel(name).is_none()
}

/// An open channel.
#[derive(Debug)]
pub(super) struct Pcan {
    channel: pcan_basic::Channel,
    received: Option<Frame>,
    checked: Instant,
    fault: Option<LinkFault>,
}

impl Pcan {
    /// Opens a channel.
    ///
    /// # Errors
    /// [`OpenError`] says what is missing.
    pub(super) fn open(name: &str, kbit_per_s: u32, channel: Channel) -> Result<Self, OpenError> {
        if !cfg!(windows) {
            let channel = name.to_owned();
            return Err(OpenError::NotWindows { channel });
        }
        Self::open_with(PcanBasic::load, name, kbit_per_s, channel)
    }

    fn open_with(
        library: impl FnOnce() -> Result<PcanBasic, pcan_basic::Error>,
        name: &str,
        kbit_per_s: u32,
        channel: Channel,
    ) -> Result<Self, OpenError> {
        let handle = name.parse().map_err(OpenError::PcanName)?;
        let mode = match channel {
            Channel::Open => Mode::Normal,
            Channel::ListenOnly => Mode::ListenOnly,
        };
        let open = || pcan_basic::Channel::open(library()?, handle, kbit_per_s, mode);
        let channel = open().map_err(|reason| OpenError::Pcan {
            channel: name.to_owned(),
            reason,
        })?;
        Ok(Self {
            channel,
            received: None,
            checked: Instant::now(),
            fault: None,
        })
    }

    /// Notes a final fault and turns a status into an error of the link.
    fn judge(&mut self, status: Status) -> LinkFault {
        let fault = if status.is_lost() {
            LinkFault::Vanished
        } else if status.is_bus_off() {
            LinkFault::BusOff
        } else if status.is_overrun() {
            LinkFault::Bus(ErrorKind::Overrun)
        } else {
            LinkFault::Bus(ErrorKind::Other)
        };
        if fault.is_final() {
            self.fault = Some(fault);
        }
        fault
    }

    fn check(&self) -> nb::Result<(), LinkFault> {
        self.fault
            .map_or(Ok(()), |fault| Err(nb::Error::Other(fault)))
    }

    /// Asks the adapter how it is when it has not been asked for a while: one that was unplugged only receives nothing.
    fn check_adapter(&mut self) {
        if self.checked.elapsed() < CHECK_TIME {
            return;
        }
        self.checked = Instant::now();
        if let Some(status) = self.channel.status()
            && (status.is_lost() || status.is_bus_off())
        {
            self.judge(status);
        }
    }
}

impl Adapter for Pcan {
    fn wait(&mut self, most: Duration) {
        let until = Instant::now() + most;
        while self.fault.is_none() && self.received.is_none() {
            if let Ok(frame) = self.receive() {
                self.received = Some(frame);
                return;
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return;
            }
            std::thread::sleep(left.min(LOOK));
        }
    }

    fn fault(&self) -> Option<LinkFault> {
        self.fault
    }
}

impl Can for Pcan {
    type Frame = Frame;
    type Error = LinkFault;

    /// Hands a frame to the queue of the adapter, unless the adapter gets nothing through: its queue is deep, and set-points that leave it
    /// later would move a motor at a time of their own.
    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, LinkFault> {
        self.check()?;
        match self.channel.status() {
            Some(status) if status.is_lost() || status.is_bus_off() => {
                return Err(nb::Error::Other(self.judge(status)));
            }
            Some(status) if status.is_passive() => return Err(nb::Error::WouldBlock),
            _ => {}
        }
        let message = message(frame).ok_or(nb::Error::Other(LinkFault::Bus(ErrorKind::Other)))?;
        match self.channel.write(&message) {
            Ok(()) => Ok(None),
            Err(status) if status.is_lost() || status.is_bus_off() => {
                Err(nb::Error::Other(self.judge(status)))
            }
            Err(status) if status.is_full() || status.is_passive() => Err(nb::Error::WouldBlock),
            Err(status) => Err(nb::Error::Other(self.judge(status))),
        }
    }

    fn receive(&mut self) -> nb::Result<Frame, LinkFault> {
        if let Some(frame) = self.received.take() {
            return Ok(frame);
        }
        self.check()?;
        match self.channel.read() {
            Ok(Some(message)) => {
                frame(&message).ok_or(nb::Error::Other(LinkFault::Bus(ErrorKind::Other)))
            }
            Ok(None) => {
                self.check_adapter();
                self.check()?;
                Err(nb::Error::WouldBlock)
            }
            Err(status) => Err(nb::Error::Other(self.judge(status))),
        }
    }
}

fn message(frame: &Frame) -> Option<Message> {
    let (id, is_extended) = match frame.id() {
        Id::Standard(id) => (id.as_raw().into(), false),
        Id::Extended(id) => (id.as_raw(), true),
    };
    if frame.is_remote_frame() {
        Message::new_remote(id, is_extended, frame.dlc())
    } else {
        Message::new(id, is_extended, frame.data())
    }
}

fn frame(message: &Message) -> Option<Frame> {
    let id = if message.is_extended() {
        Id::Extended(ExtendedId::new(message.id)?)
    } else {
        Id::Standard(StandardId::new(message.id.try_into().ok()?)?)
    };
    if message.is_remote() {
        Frame::new_remote(id, message.length())
    } else {
        Frame::new(id, message.data())
    }
}

#[cfg(test)]
mod tests;
