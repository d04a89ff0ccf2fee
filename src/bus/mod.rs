//! The drives' bus: the sink of the master over the registers of the board's controller.
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

use can_motion::BusErrorKind;

#[cfg(feature = "stm32f405")]
pub(crate) use bxcan::{Bus, Controller, on_error};
#[cfg(feature = "stm32g474")]
pub(crate) use fdcan::{Bus, Controller};

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

/// The last error code of either controller (RM0090, section 32.9.2, ESR; RM0440, section 44.4.12, PSR); `None` when there was no error.
const fn error_of_code(code: u8) -> Option<BusErrorKind> {
    match code {
        1 => Some(BusErrorKind::Stuff),
        2 => Some(BusErrorKind::Form),
        3 => Some(BusErrorKind::Acknowledge),
        4 | 5 => Some(BusErrorKind::Bit),
        6 => Some(BusErrorKind::Crc),
        _ => None,
    }
}
