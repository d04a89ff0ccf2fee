//! Olimex STM32-H405 with a CAN transceiver at its pin header: STM32F405RG, 8 MHz crystal, 168 MHz core.
//!
//! | Pin | What |
//! |---|---|
//! | PB8, PB9 | CAN1 receive, transmit; PA11 and PA12, its other pins, are those of the USB socket |
//! | PC12 | status LED of the board, a low level lights it |
//! | PA2, PA3 | serial port to the host, with `link`: transmit, receive |
//! | PA11, PA12 | USB to the host, with `link-usb` in the place of the serial port: D-, D+ |
//! | PC0, PC1, PC2 | stop circuit, enable, run: 3.3 V is closed, active |

use can_motion::plan::BitRate;
use embassy_stm32::gpio::{AfType, Flex, Input, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::pac::gpio::vals::Moder;
use embassy_stm32::time::Hertz;
use embassy_stm32::{Config, pac, rcc};

use super::{Board, InputPins, Start, StatusLed, Watchdog, count_clocks, start_crystal};
use crate::bus::{BitTiming, Bus, Controller, on_error};
#[cfg(not(feature = "link"))]
use crate::config;
use crate::duty;
use crate::machine;
use crate::misbehaviour::{self, Fault};
use crate::start::Cause;

/// Frequency of the core.
pub(crate) const CORE_HZ: u32 = 168_000_000;

/// Crystal at the HSE pins.
const HSE_HZ: u32 = 8_000_000;
/// APB1, which clocks CAN1: 168 MHz / 4, the most that bus allows (RM0090, section 7.2).
const PCLK1_HZ: u32 = 42_000_000;

/// Time quanta of one bit: synchronisation, segment 1 (propagation and phase 1), segment 2. The sample point is at 12/14 = 85.7 %.
const SEGMENT_1_QUANTA: u8 = 11;
const SEGMENT_2_QUANTA: u8 = 2;
/// Both segment 2 quanta may be used to resynchronise: the drives' clock tolerance is not in their documents.
const JUMP_WIDTH_QUANTA: u8 = 2;
const QUANTA_PER_BIT: u32 = 1 + SEGMENT_1_QUANTA as u32 + SEGMENT_2_QUANTA as u32;
#[cfg(not(feature = "link"))]
const _: () = assert!(
    prescaler(config::BIT_RATE).is_some(),
    "the bit rate is not exact"
);

/// The prescaler of a bit rate; `None` when the clock does not make it exactly.
pub(crate) const fn prescaler(bit_rate: BitRate) -> Option<u16> {
    let quanta_per_s = bit_rate.kbit_per_s() * 1_000 * QUANTA_PER_BIT;
    if PCLK1_HZ.is_multiple_of(quanta_per_s) {
        Some((PCLK1_HZ / quanta_per_s) as u16)
    } else {
        None
    }
}

/// Alternate function of CAN1 on its pins (STM32F405 data sheet, table 9).
const CAN_FUNCTION: u8 = 9;
/// The last pin of port C that a switch may hang on; the status LED is on 12.
pub(crate) const LAST_SWITCH_PIN: u8 = 11;
/// The pin of the status LED, on port C.
const LED_PIN: usize = 12;
/// Revision A of the chip, in which the prefetch must stay off (ES0182).
const REVISION_A: u16 = 0x1000;

/// 336 MHz / 7: the 48 MHz of USB, which must be exact to 0.25 % (USB 2.0, section 7.1.11) and follow the crystal.
#[cfg(feature = "link-usb")]
const USB_DIVIDER: Option<rcc::PllQDiv> = Some(rcc::PllQDiv::DIV7);
#[cfg(not(feature = "link-usb"))]
const USB_DIVIDER: Option<rcc::PllQDiv> = None;

/// Priority of the cycle and of the bus: below the marks of errors (priority 0).
pub(crate) const CYCLE_PRIORITY: Priority = Priority::P6;

#[embassy_stm32::interrupt]
fn CAN1_TX() {
    // SAFETY: this interrupt has the priority of the cycle.
    unsafe { duty::on_traffic() };
}

#[embassy_stm32::interrupt]
fn CAN1_RX0() {
    // SAFETY: this interrupt has the priority of the cycle.
    unsafe { duty::on_traffic() };
}

#[embassy_stm32::interrupt]
fn CAN1_RX1() {
    // SAFETY: this interrupt has the priority of the cycle.
    unsafe { duty::on_traffic() };
}

#[embassy_stm32::interrupt]
fn CAN1_SCE() {
    on_error(pac::CAN1);
}

/// Starts watchdog, LED, clocks, pins and bus, in this order: what may wait comes after what shows and ends
/// it. To be called once: a second call panics.
pub(crate) fn init() -> Start {
    count_clocks();
    let mut watchdog = Watchdog::start();
    // A processor that a debug probe has halted must not be reset while somebody looks at it.
    pac::DBGMCU.apb1fzr().modify(|freeze| freeze.set_iwdg(true));
    light_led();
    let has_crystal = start_crystal(
        &mut watchdog,
        || pac::RCC.cr().modify(|control| control.set_hseon(true)),
        || pac::RCC.cr().read().hserdy(),
    );
    // From here on a crystal that stops is noticed by the chip, which changes to the internal oscillator: see `has_lost_clock`.
    if has_crystal && !misbehaviour::has(Fault::NoClockSecurity) {
        pac::RCC.cr().modify(|control| control.set_csson(true));
    }
    let peripherals = embassy_stm32::init(if has_crystal {
        clocks()
    } else {
        Config::default()
    });
    watchdog.feed();
    accelerate_flash();
    #[cfg(feature = "link")]
    {
        machine::load();
        watchdog.feed();
    }
    let board = has_crystal.then(|| Board {
        bus: Bus::new(controller(
            Flex::new(peripherals.PB8),
            Flex::new(peripherals.PB9),
        )),
        inputs: InputPins {
            stop: Input::new(peripherals.PC0, Pull::Down),
            enable: Input::new(peripherals.PC1, Pull::Down),
            run: Input::new(peripherals.PC2, Pull::Down),
        },
        #[cfg(all(feature = "link", not(feature = "link-usb")))]
        port: crate::link::Port::start(Flex::new(peripherals.PA2), Flex::new(peripherals.PA3)),
        #[cfg(feature = "link-usb")]
        port: crate::link::Port::new(crate::link::usb::Pins {
            controller: peripherals.USB_OTG_FS,
            plus: peripherals.PA12,
            minus: peripherals.PA11,
        }),
    });
    Start {
        status_led: StatusLed {
            pin: Output::new(peripherals.PC12, Level::High, Speed::Low),
            active_low: true,
            lit: None,
        },
        watchdog,
        board,
    }
}

/// Lets the cycle and the bus begin.
pub(crate) fn enable_interrupts() {
    let of_the_cycle = [
        interrupt::TIM2,
        interrupt::CAN1_TX,
        interrupt::CAN1_RX0,
        interrupt::CAN1_RX1,
    ];
    for interrupt in of_the_cycle {
        interrupt.set_priority(CYCLE_PRIORITY);
        // SAFETY: no critical section relies on it being off, and what the handlers of this priority share is in its place.
        unsafe { interrupt.enable() };
    }
    // SAFETY: as above; its handler touches atomics and the marks of errors.
    unsafe { interrupt::CAN1_SCE.enable() };
}

/// Shows that the board has its supply, before the first thing that can wait: straight in the registers, because the vendor's drivers
/// come with the clocks.
fn light_led() {
    pac::RCC.ahb1enr().modify(|clocks| clocks.set_gpiocen(true));
    pac::GPIOC.bsrr().write(|pins| pins.set_br(LED_PIN, true));
    pac::GPIOC
        .moder()
        .modify(|pins| pins.set_moder(LED_PIN, Moder::OUTPUT));
}

/// Caches and prefetch. The vendor's clock set-up writes the whole register for its wait states, 5 of them, and leaves all three off
/// (RM0090, section 3.5.1).
fn accelerate_flash() {
    let is_first_revision = pac::DBGMCU.idcode().read().rev_id() == REVISION_A;
    pac::FLASH.acr().modify(|access| {
        access.set_icen(true);
        access.set_dcen(true);
        access.set_prften(!is_first_revision);
    });
}

fn controller(mut receive: Flex<'static>, mut transmit: Flex<'static>) -> Controller {
    receive.set_as_af_unchecked(CAN_FUNCTION, AfType::input(Pull::None));
    transmit.set_as_af_unchecked(
        CAN_FUNCTION,
        AfType::output(OutputType::PushPull, Speed::VeryHigh),
    );
    pac::RCC.apb1enr().modify(|clocks| clocks.set_can1en(true));
    Controller {
        registers: pac::CAN1,
        reset: || {
            let resets = pac::RCC.apb1rstr();
            resets.modify(|resets| resets.set_can1rst(true));
            resets.modify(|resets| resets.set_can1rst(false));
        },
        timing: BitTiming {
            // Without one the bit rate was refused before.
            prescaler: prescaler(machine::bit_rate()).unwrap_or(u16::MAX),
            segment_1: SEGMENT_1_QUANTA,
            segment_2: SEGMENT_2_QUANTA,
            jump_width: JUMP_WIDTH_QUANTA,
        },
        _pins: [receive, transmit],
    }
}

/// Whether the clock security found that the crystal has stopped (RM0090, section 7.2.7). The chip then runs from its internal oscillator.
pub(crate) fn has_lost_clock() -> bool {
    pac::RCC.cir().read().cssf()
}

/// Reads why the chip started and forgets it, so that the next start tells its own cause (RM0090, section 7.3.21).
pub(crate) fn take_cause() -> Cause {
    let flags = pac::RCC.csr().read();
    pac::RCC.csr().modify(|csr| csr.set_rmvf(true));
    // Every reset also sets the flag of the pin, so it is asked last.
    if flags.wdgrstf() || flags.wwdgrstf() {
        Cause::Watchdog
    } else if flags.sftrstf() {
        Cause::Software
    } else if flags.porrstf() || flags.borrstf() {
        Cause::PowerOn
    } else {
        Cause::Pin
    }
}

/// 8 MHz / 4 x 168 = 336 MHz, halved for the core; APB1 a quarter and APB2 half of it, their limits.
fn clocks() -> Config {
    let mut config = Config::default();
    config.rcc.hse = Some(rcc::Hse {
        freq: Hertz(HSE_HZ),
        mode: rcc::HseMode::Oscillator,
    });
    config.rcc.pll_src = rcc::PllSource::HSE;
    config.rcc.pll = Some(rcc::Pll {
        prediv: rcc::PllPreDiv::DIV4,
        mul: rcc::PllMul::MUL168,
        divp: Some(rcc::PllPDiv::DIV2),
        divq: USB_DIVIDER,
        divr: None,
    });
    config.rcc.sys = rcc::Sysclk::PLL1_P;
    config.rcc.ahb_pre = rcc::AHBPrescaler::DIV1;
    config.rcc.apb1_pre = rcc::APBPrescaler::DIV4;
    config.rcc.apb2_pre = rcc::APBPrescaler::DIV2;
    config
}
