//! An open channel.

use crate::library::Parameter;
use crate::{ChannelName, Error, Message, PcanBasic, Status};

/// Values of the registers BTR0 and BTR1 for bit rates in kbit/s (`TPCANBaudrate` in PCANBasic.h).
const BIT_RATES: [(u32, u16); 9] = [
    (1_000, 0x0014),
    (800, 0x0016),
    (500, 0x001C),
    (250, 0x011C),
    (125, 0x031C),
    (100, 0x432F),
    (50, 0x472F),
    (20, 0x532F),
    (10, 0x672F),
];

/// How a channel takes part in the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// It sends and acknowledges.
    Normal,
    /// It only listens, and does not even acknowledge.
    ListenOnly,
}

/// An open channel, which is closed when this is dropped.
#[derive(Debug)]
pub struct Channel {
    library: PcanBasic,
    handle: u16,
}

impl Channel {
    /// Opens a channel at a bit rate.
    ///
    /// # Errors
    /// [`Error`]; nothing was sent, and a channel of another program is as it was.
    pub fn open(
        library: PcanBasic,
        name: ChannelName,
        kbit_per_s: u32,
        mode: Mode,
    ) -> Result<Self, Error> {
        let rate = BIT_RATES.iter().find(|(rate, _)| *rate == kbit_per_s);
        let &(_, registers) = rate.ok_or(Error::BitRate { kbit_per_s })?;
        let handle = name.handle();
        // Before the channel is on the bus: afterwards it would have acknowledged already.
        let listens = u32::from(mode == Mode::ListenOnly);
        let status = library.set_value(handle, Parameter::ListenOnly, listens);
        if mode == Mode::ListenOnly && status.0 != Status::OK {
            return Err(match refusal(&library, name, status) {
                Error::Other { status, .. } => Error::NoListenOnly {
                    channel: name,
                    status,
                },
                reason => reason,
            });
        }
        let status = library.initialize(handle, registers);
        if status.is_caution() {
            // It runs, at the rate of another program: leave it to that one.
            let actual = library.value(handle, Parameter::BitsPerS).ok();
            library.uninitialize(handle);
            return Err(Error::OtherBitRate {
                channel: name,
                kbit_per_s,
                actual,
            });
        }
        if status.0 != Status::OK {
            return Err(refusal(&library, name, status));
        }
        Ok(Self { library, handle })
    }

    /// The next frame that was received; `None` when there is none at the moment.
    ///
    /// # Errors
    /// [`Status`] of the bus or of the adapter.
    pub fn read(&self) -> Result<Option<Message>, Status> {
        loop {
            let (status, message) = self.library.read(self.handle);
            return match status {
                Status(Status::OK) if message.is_frame() => Ok(Some(message)),
                // What the adapter tells of itself.
                Status(Status::OK) => continue,
                status if status.is_empty() && !status.is_bus_off() && !status.is_lost() => {
                    Ok(None)
                }
                status => Err(status),
            };
        }
    }

    /// Hands a frame to the adapter.
    ///
    /// # Errors
    /// [`Status`]; [`Status::is_full`] when there is no room at the moment.
    pub fn write(&self, message: &Message) -> Result<(), Status> {
        match self.library.write(self.handle, message) {
            Status(Status::OK) => Ok(()),
            status => Err(status),
        }
    }

    /// How bus and adapter are; `None` when nothing is to be said.
    #[must_use]
    pub fn status(&self) -> Option<Status> {
        let status = self.library.status(self.handle);
        (status.0 != Status::OK).then_some(status)
    }
}

impl Drop for Channel {
    fn drop(&mut self) {
        // There is nobody left to tell.
        self.library.uninitialize(self.handle);
    }
}

fn refusal(library: &PcanBasic, channel: ChannelName, status: Status) -> Error {
    if status.is_without_driver() {
        Error::NoDriver
    } else if status.is_in_use() {
        Error::Busy { channel }
    } else if status.is_no_such_channel() {
        Error::NoAdapter { channel }
    } else {
        Error::Other {
            text: library.text(status),
            status,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_registers_make_the_bit_rates() {
        // The controller of these adapters (SJA1000) is clocked with 8 MHz: prescaler in BTR0, quanta of both segments in BTR1.
        for (kbit_per_s, registers) in BIT_RATES {
            let prescaler = u32::from(registers >> 8 & 0x3F) + 1;
            let quanta = 1 + u32::from(registers & 0xF) + 1 + u32::from(registers >> 4 & 7) + 1;
            assert_eq!(prescaler * quanta * kbit_per_s, 8_000, "{kbit_per_s}");
        }
    }
}
