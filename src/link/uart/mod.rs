//! The serial port: circular DMA for what comes in, one transfer after the other for what goes out, and no interrupt. The thread looks at
//! least once a cycle.
//!
//! A byte that the port could not read, or lost, is counted; the frame around it fails its checksum. What comes faster than the thread
//! takes it overwrites what is older, which the checksum of the frames tells, too.

#[cfg(feature = "stm32g474")]
mod lpuart;
#[cfg(feature = "stm32f405")]
mod usart;

use core::sync::atomic::{AtomicU8, Ordering, fence};

use embassy_stm32::gpio::{AfType, Flex, OutputType, Pull, Speed};

#[cfg(feature = "stm32g474")]
use lpuart as chosen;
#[cfg(feature = "stm32f405")]
use usart as chosen;

/// Bit rate in bit/s, 8 data bits, no parity, 1 stop bit. The nearest that the dividers of the boards make are 913,043 bit/s (STM32F405,
/// 0.9 % slower) and 921,608 bit/s (STM32G474); a frame bears more than 3 %.
const BIT_RATE: u32 = 921_600;

/// What has come in: 11 ms at that rate.
const RECEIVE_BYTES: usize = 1_024;
/// What goes out in one transfer: 2.8 ms at that rate.
const TRANSMIT_BYTES: usize = 256;

/// Only the controller of the DMA writes to it.
static RECEIVED: [AtomicU8; RECEIVE_BYTES] = [const { AtomicU8::new(0) }; RECEIVE_BYTES];
/// Written while no transfer is under way.
static TRANSMITTED: [AtomicU8; TRANSMIT_BYTES] = [const { AtomicU8::new(0) }; TRANSMIT_BYTES];

/// The port, running.
pub(crate) struct Port {
    /// The next byte to take.
    taken: usize,
    /// The status showed an error when it was looked at last.
    had_error: bool,
    /// Errors that were seen; several between two looks are one.
    errors: u32,
    _pins: [Flex<'static>; 2],
}

impl Port {
    /// Starts the port on its pins.
    pub(crate) fn start(mut transmit: Flex<'static>, mut receive: Flex<'static>) -> Self {
        // A line that is not connected is idle, and no break.
        receive.set_as_af_unchecked(chosen::PIN_FUNCTION, AfType::input(Pull::Up));
        transmit.set_as_af_unchecked(
            chosen::PIN_FUNCTION,
            AfType::output(OutputType::PushPull, Speed::High),
        );
        chosen::start(address(&RECEIVED), RECEIVE_BYTES);
        Self {
            taken: 0,
            had_error: false,
            errors: 0,
            _pins: [transmit, receive],
        }
    }

    /// Takes bytes that have come in, oldest first; returns how many.
    pub(crate) fn take(&mut self, bytes: &mut [u8]) -> usize {
        self.look_for_errors();
        let end = RECEIVE_BYTES.saturating_sub(chosen::receive_left()) % RECEIVE_BYTES;
        // What the counter tells is in memory.
        fence(Ordering::SeqCst);
        let mut count = 0;
        for byte in bytes {
            if self.taken == end {
                break;
            }
            if let Some(received) = RECEIVED.get(self.taken) {
                *byte = received.load(Ordering::Relaxed);
            }
            self.taken = (self.taken + 1) % RECEIVE_BYTES;
            count += 1;
        }
        count
    }

    /// Sends the first of these bytes, unless a transfer is under way; returns how many.
    pub(crate) fn send(&mut self, bytes: &[u8]) -> usize {
        if bytes.is_empty() || !chosen::is_transmit_over() {
            return 0;
        }
        let count = bytes.len().min(TRANSMIT_BYTES);
        for (place, byte) in TRANSMITTED.iter().zip(bytes) {
            place.store(*byte, Ordering::Relaxed);
        }
        fence(Ordering::SeqCst);
        chosen::transmit(address(&TRANSMITTED), count);
        count
    }

    /// Errors of the port so far.
    pub(crate) const fn errors(&self) -> u32 {
        self.errors
    }

    fn look_for_errors(&mut self) {
        let has_error = chosen::take_error();
        if has_error && !self.had_error {
            self.errors = self.errors.saturating_add(1);
        }
        self.had_error = has_error;
    }
}

/// Where the controller of the DMA finds a buffer: in its reach, as all memory of the images.
fn address(buffer: &'static [AtomicU8]) -> u32 {
    buffer.as_ptr() as u32
}
