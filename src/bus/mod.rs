//! The drives' bus: `embedded_can::nb::Can` over the unbuffered driver of the board's controller.
//!
//! Unbuffered on purpose: the controller's three transmit places are the only queue, so what the master hands over next waits for three
//! frames at most, and the master always knows what was not sent. Each controller is one file; the board chooses it by its feature.
//!
//! # When an axis must stop at once
//!
//! bxCAN gives back what waits in its mailboxes, all but the frame that goes next; FDCAN cannot, and its three frames still go out:
//! 0.2 ms of set-points at 1 Mbit/s.
//!
//! # When nobody acknowledges
//!
//! With all drives off a controller repeats a frame for ever without going bus-off (ISO 11898-1, 12.1.4.2), and sends it when a drive is
//! switched on much later. So a frame that waits longer than 20 ms is a failure of the bus like bus-off:
//! everything is thrown away, and the master is told that the fate of its frames is not known.

#[cfg(feature = "stm32f405")]
mod bxcan;
#[cfg(feature = "stm32g474")]
mod fdcan;

use core::fmt;

use embassy_stm32::can::enums::BusError as LineError;
use embassy_stm32::can::frame::{Frame, Header};
use embedded_can::{ErrorKind, StandardId};

#[cfg(feature = "stm32f405")]
pub(crate) use bxcan::Bus;
#[cfg(feature = "stm32g474")]
pub(crate) use fdcan::Bus;

/// Low bits of an identifier: the function code. CAN specification 1.6A, "CAN ID".
const FUNCTION_CODE_MASK: StandardId = standard_id(0x1F);
/// Function code of the frames a drive sends unasked: alarm and data error. CAN specification 1.6A, `Drive_Error`.
const DRIVE_ERROR: StandardId = standard_id(0x1D);
/// Most data bytes of a frame; a data length code of 9..15 on the wire also means 8.
const MAX_DATA_BYTES: u8 = 8;

/// An identifier known when the firmware is built; one that does not fit 11 bits stops the build when used in a constant.
const fn standard_id(raw: u16) -> StandardId {
    match StandardId::new(raw) {
        Some(id) => id,
        None => panic!("a standard identifier has 11 bits"),
    }
}

/// What went wrong on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
#[non_exhaustive]
pub(crate) enum BusError {
    /// More than five equal bits where stuffing was expected.
    Stuff,
    /// A fixed bit had the wrong level.
    Form,
    /// Nobody acknowledged a transmitted frame.
    Acknowledge,
    /// The level read back was not the level sent.
    Bit,
    /// The checksum of a received frame was wrong.
    Crc,
    /// The receive FIFO of this number, 0 or 1, was full and a frame was lost: read faster.
    Overrun(usize),
    /// The controller is off the bus: nothing was queued. [`Bus::recover`] brings it back.
    BusOff,
    /// The controller gave an error code without a meaning.
    Unspecified,
}

impl fmt::Display for BusError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stuff => f.write_str("stuff error on the bus"),
            Self::Form => f.write_str("form error on the bus"),
            Self::Acknowledge => f.write_str(
                "no node acknowledged the frame: check wiring, termination and the drives' supply",
            ),
            Self::Bit => f.write_str("bit error on the bus"),
            Self::Crc => f.write_str("checksum error on the bus"),
            Self::Overrun(fifo) => write!(f, "receive FIFO {fifo} overrun: a frame was lost"),
            Self::BusOff => f.write_str("the controller is bus-off: recover it before sending"),
            Self::Unspecified => f.write_str("unspecified bus error"),
        }
    }
}

impl core::error::Error for BusError {}

impl embedded_can::Error for BusError {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Stuff => ErrorKind::Stuff,
            Self::Form => ErrorKind::Form,
            Self::Acknowledge => ErrorKind::Acknowledge,
            Self::Bit => ErrorKind::Bit,
            Self::Crc => ErrorKind::Crc,
            Self::Overrun(_) => ErrorKind::Overrun,
            Self::BusOff | Self::Unspecified => ErrorKind::Other,
        }
    }
}

impl From<LineError> for BusError {
    fn from(error: LineError) -> Self {
        match error {
            LineError::Stuff => Self::Stuff,
            LineError::Form => Self::Form,
            LineError::Acknowledge => Self::Acknowledge,
            LineError::BitRecessive | LineError::BitDominant => Self::Bit,
            LineError::Crc => Self::Crc,
            LineError::Software => Self::Unspecified,
        }
    }
}

/// Fault confinement state of the controller (ISO 11898-1), and whether it gets its frames through at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub(crate) enum FaultState {
    /// Normal: both error counters below 128.
    ErrorActive,
    /// One error counter at 128 or above: the controller takes part but can no longer enforce its errors.
    ErrorPassive,
    /// A frame waited too long: nobody acknowledges, or the bus is never free. What waited was thrown away.
    Stuck,
    /// The transmit error counter went over 255, and the controller has not been brought back since.
    BusOff,
}

impl FaultState {
    /// The controller does not send, and the fate of what it was given is not known.
    pub(crate) const fn is_down(self) -> bool {
        matches!(self, Self::Stuck | Self::BusOff)
    }
}

/// The frame with a length of at most 8: the driver passes a data length code of 9..15 on, and reading the data of such a frame panics.
fn with_valid_length(frame: Frame) -> Frame {
    let header = frame.header();
    if header.len() <= MAX_DATA_BYTES {
        return frame;
    }
    let header = Header::new(*header.id(), MAX_DATA_BYTES, header.rtr());
    // The raw buffer has exactly 8 bytes, the only length `new` checks.
    Frame::new(header, frame.raw_data()).unwrap_or(frame)
}
