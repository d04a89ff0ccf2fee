//! USB of the STM32G474: a device at full speed (RM0440, section 45), D- on PA11 and D+ on PA12. Its 48 MHz are those of the internal oscillator,
//! which the clock recovery holds to the frames of the host, see the file of the board.

use embassy_stm32::interrupt::{self, InterruptExt};
use embassy_stm32::peripherals::{PA11, PA12, USB};
use embassy_stm32::{Peri, bind_interrupts, usb};

use super::{PRIORITY, RECEIVED_PACKETS_BYTES};

bind_interrupts!(struct Interrupts {
    USB_LP => usb::InterruptHandler<USB>;
});

/// What the driver of this chip is called.
pub(super) type Driver<'d> = usb::Driver<'d, USB>;

/// What the port has of the chip.
pub(crate) struct Pins {
    /// The controller.
    pub(crate) controller: Peri<'static, USB>,
    /// D+.
    pub(crate) plus: Peri<'static, PA12>,
    /// D-.
    pub(crate) minus: Peri<'static, PA11>,
}

/// The driver, which has not started yet. Packets come in through the memory of the controller: it needs no other.
pub(super) fn driver(pins: Pins, _packets: &mut [u8; RECEIVED_PACKETS_BYTES]) -> Driver<'_> {
    // Before the driver enables it.
    interrupt::USB_LP.set_priority(PRIORITY);
    usb::Driver::new(pins.controller, Interrupts, pins.plus, pins.minus)
}
