//! USB of the STM32F405: OTG_FS as a device at full speed (RM0090, section 34), D- on PA11 and D+ on PA12. Its 48 MHz are those of the PLL, see
//! the file of the board.

use embassy_stm32::interrupt::{self, InterruptExt};
use embassy_stm32::peripherals::{PA11, PA12, USB_OTG_FS};
use embassy_stm32::{Peri, bind_interrupts, usb};

use super::{PRIORITY, RECEIVED_PACKETS_BYTES};

bind_interrupts!(struct Interrupts {
    OTG_FS => usb::InterruptHandler<USB_OTG_FS>;
});

/// Whether the controller looks for the 5 V of the cable at PA9. A board with a supply of its own should (USB 2.0, section 7.1.5); one whose PA9 is
/// not connected would never answer, so it is off.
const LOOKS_FOR_VBUS: bool = false;

/// What the driver of this chip is called.
pub(super) type Driver<'d> = usb::Driver<'d, USB_OTG_FS>;

/// What the port has of the chip.
pub(crate) struct Pins {
    /// The controller.
    pub(crate) controller: Peri<'static, USB_OTG_FS>,
    /// D+.
    pub(crate) plus: Peri<'static, PA12>,
    /// D-.
    pub(crate) minus: Peri<'static, PA11>,
}

/// The driver, which has not started yet.
pub(super) fn driver(pins: Pins, packets: &mut [u8; RECEIVED_PACKETS_BYTES]) -> Driver<'_> {
    // Before the driver enables it.
    interrupt::OTG_FS.set_priority(PRIORITY);
    let mut config = usb::Config::default();
    config.vbus_detection = LOOKS_FOR_VBUS;
    usb::Driver::new_fs(
        pins.controller,
        Interrupts,
        pins.plus,
        pins.minus,
        packets,
        config,
    )
}
