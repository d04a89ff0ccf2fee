//! The drives' bus: `embedded_can::nb::Can` over the registers of the board's controller.
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

use embedded_can::ErrorKind;

#[cfg(feature = "stm32f405")]
pub(crate) use bxcan::{Bus, Controller, on_error, on_traffic};
#[cfg(feature = "stm32g474")]
pub(crate) use fdcan::{Bus, Controller, on_traffic};

/// Low bits of an identifier: the function code. CAN specification 1.6A, "CAN ID".
const FUNCTION_CODE_MASK: u16 = 0x1F;
/// Function code of the frames a drive sends unasked: alarm and data error. CAN specification 1.6A, `Drive_Error`.
const DRIVE_ERROR: u16 = 0x1D;

/// Length of a bit in time quanta; synchronisation is one more.
pub(crate) struct BitTiming {
    /// Clocks of the controller in a quantum.
    pub(crate) prescaler: u16,
    /// Propagation and phase segment 1.
    pub(crate) segment_1: u8,
    /// Phase segment 2.
    pub(crate) segment_2: u8,
    /// Longest resynchronisation.
    pub(crate) jump_width: u8,
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
}

impl BusError {
    /// The last error code of either controller (RM0090, section 32.9.2, ESR; RM0440, section 44.4.12, PSR); `None` when there was no error.
    const fn from_code(code: u8) -> Option<Self> {
        match code {
            1 => Some(Self::Stuff),
            2 => Some(Self::Form),
            3 => Some(Self::Acknowledge),
            4 | 5 => Some(Self::Bit),
            6 => Some(Self::Crc),
            _ => None,
        }
    }
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
            Self::BusOff => ErrorKind::Other,
        }
    }
}
