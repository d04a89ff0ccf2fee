//! NUCLEO-G474RE with a CAN transceiver at its pin header: STM32G474RE, 24 MHz crystal, 160 MHz core.
//!
//! | Pin | What |
//! |---|---|
//! | PA11, PA12 | FDCAN1 receive, transmit. PB8, the other pin to receive, is also BOOT0: an idle bus would start the boot loader |
//! | PA5 | status LED of the board, a high level lights it |
//! | PA2, PA3 | serial port to the host, with `link`: transmit, receive |
//! | PA11, PA12 | with `link-usb` in the place of both: D-, D+ of USB, which this chip has at no other pins and this board at no socket |
//! | PB12, PB13 | with `link-usb`: FDCAN2 receive, transmit |
//! | PC0, PC1, PC2 | stop circuit, enable, run: 3.3 V is closed, active |

use can_motion::plan::BitRate;
use embassy_stm32::gpio::{AfType, Flex, Input, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::pac::can::Fdcan;
use embassy_stm32::pac::can::regs::Psr;
use embassy_stm32::pac::fdcanram::Fdcanram;
use embassy_stm32::pac::gpio::vals::Moder;
use embassy_stm32::time::Hertz;
use embassy_stm32::{Config, pac, rcc};

use super::{Board, InputPins, Start, StatusLed, Watchdog, count_clocks, start_crystal};
use crate::bus::{BitTiming, Bus, Controller};
#[cfg(not(feature = "link"))]
use crate::config;
use crate::duty;
use crate::machine;
use crate::misbehaviour::{self, Fault};
use crate::start::Cause;

/// Frequency of the core, and of the controller. The chip could do 170 MHz; 160 MHz makes every bit rate of the drives exactly.
pub(crate) const CORE_HZ: u32 = 160_000_000;
/// Crystal at the HSE pins.
const HSE_HZ: u32 = 24_000_000;

/// Time quanta of one bit: synchronisation, segment 1 (propagation and phase 1), segment 2. The sample point is at 34/40 = 85 %.
const SEGMENT_1_QUANTA: u8 = 33;
const SEGMENT_2_QUANTA: u8 = 6;
/// All of segment 2 may be used to resynchronise: the drives' clock tolerance is not in their documents.
const JUMP_WIDTH_QUANTA: u8 = 6;
const QUANTA_PER_BIT: u32 = 1 + SEGMENT_1_QUANTA as u32 + SEGMENT_2_QUANTA as u32;
#[cfg(not(feature = "link"))]
const _: () = assert!(
    prescaler(config::BIT_RATE).is_some(),
    "the bit rate is not exact"
);

/// The prescaler of a bit rate; `None` when the clock does not make it exactly.
pub(crate) const fn prescaler(bit_rate: BitRate) -> Option<u16> {
    let quanta_per_s = bit_rate.kbit_per_s() * 1_000 * QUANTA_PER_BIT;
    if CORE_HZ.is_multiple_of(quanta_per_s) {
        Some((CORE_HZ / quanta_per_s) as u16)
    } else {
        None
    }
}

/// Alternate function of FDCAN1 and FDCAN2 on their pins (STM32G474 data sheet, table 13).
const CAN_FUNCTION: u8 = 9;
/// The last pin of port C that a switch may hang on; 13 to 15 are those of the button and of the slow crystal.
pub(crate) const LAST_SWITCH_PIN: u8 = 12;
/// The pin of the status LED, on port A.
const LED_PIN: usize = 5;

/// Priority of the cycle and of the bus: below the marks of errors (priority 0).
pub(crate) const CYCLE_PRIORITY: Priority = Priority::P6;

/// The controller of the bus and its message memory.
#[cfg(not(feature = "link-usb"))]
const CAN: (Fdcan, Fdcanram) = (pac::FDCAN1, pac::FDCANRAM1);
#[cfg(not(feature = "link-usb"))]
const CAN_INTERRUPT: interrupt::Interrupt = interrupt::FDCAN1_IT0;
/// USB has the pins of the first one.
#[cfg(feature = "link-usb")]
const CAN: (Fdcan, Fdcanram) = (pac::FDCAN2, pac::FDCANRAM2);
#[cfg(feature = "link-usb")]
const CAN_INTERRUPT: interrupt::Interrupt = interrupt::FDCAN2_IT0;

#[cfg(feature = "link-usb")]
#[embassy_stm32::interrupt]
fn FDCAN2_IT0() {
    // SAFETY: this interrupt has the priority of the cycle.
    unsafe { duty::on_traffic() };
}

#[cfg(not(feature = "link-usb"))]
#[embassy_stm32::interrupt]
fn FDCAN1_IT0() {
    // SAFETY: this interrupt has the priority of the cycle.
    unsafe { duty::on_traffic() };
}

/// Starts watchdog, LED, clocks, pins and bus, in this order: what may wait comes after what shows and ends
/// it. To be called once: a second call panics.
pub(crate) fn init() -> Start {
    count_clocks();
    let mut watchdog = Watchdog::start();
    // A processor that a debug probe has halted must not be reset while somebody looks at it.
    pac::DBGMCU
        .apb1lfzr()
        .modify(|freeze| freeze.set_iwdg(true));
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
        #[cfg(not(feature = "link-usb"))]
        bus: Bus::new(controller(
            Flex::new(peripherals.PA11),
            Flex::new(peripherals.PA12),
        )),
        #[cfg(feature = "link-usb")]
        bus: Bus::new(controller(
            Flex::new(peripherals.PB12),
            Flex::new(peripherals.PB13),
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
            controller: peripherals.USB,
            plus: peripherals.PA12,
            minus: peripherals.PA11,
        }),
    });
    Start {
        status_led: StatusLed {
            pin: Output::new(peripherals.PA5, Level::Low, Speed::Low),
            active_low: false,
            lit: None,
        },
        watchdog,
        board,
    }
}

/// Lets the cycle and the bus begin.
pub(crate) fn enable_interrupts() {
    for interrupt in [interrupt::TIM2, CAN_INTERRUPT] {
        interrupt.set_priority(CYCLE_PRIORITY);
        // SAFETY: no critical section relies on it being off, and what the handlers of this priority share is in its place.
        unsafe { interrupt.enable() };
    }
}

/// Shows that the board has its supply, before the first thing that can wait: straight in the registers, because the vendor's drivers
/// come with the clocks.
fn light_led() {
    pac::RCC.ahb2enr().modify(|clocks| clocks.set_gpioaen(true));
    pac::GPIOA.bsrr().write(|pins| pins.set_bs(LED_PIN, true));
    pac::GPIOA
        .moder()
        .modify(|pins| pins.set_moder(LED_PIN, Moder::OUTPUT));
}

/// Caches, on after a reset, and prefetch, off (RM0440, section 3.7.1). The image lies in one bank, see the memory map: chips of this
/// family fail to prefetch over the border of banks in rare cases (ES0548 of the STM32G0B1, section 2.2.10).
fn accelerate_flash() {
    pac::FLASH.acr().modify(|access| {
        access.set_icen(true);
        access.set_dcen(true);
        access.set_prften(true);
    });
}

fn controller(mut receive: Flex<'static>, mut transmit: Flex<'static>) -> Controller {
    receive.set_as_af_unchecked(CAN_FUNCTION, AfType::input(Pull::None));
    transmit.set_as_af_unchecked(
        CAN_FUNCTION,
        AfType::output(OutputType::PushPull, Speed::VeryHigh),
    );
    pac::RCC
        .apb1enr1()
        .modify(|clocks| clocks.set_fdcanen(true));
    Controller {
        registers: CAN.0,
        memory: CAN.1,
        reset: || {
            // All three controllers of the chip; this board uses one.
            let resets = pac::RCC.apb1rstr1();
            resets.modify(|resets| resets.set_fdcanrst(true));
            resets.modify(|resets| resets.set_fdcanrst(false));
        },
        timing: BitTiming {
            // Without one the bit rate was refused before.
            prescaler: prescaler(machine::bit_rate()).unwrap_or(u16::MAX),
            segment_1: SEGMENT_1_QUANTA,
            segment_2: SEGMENT_2_QUANTA,
            jump_width: JUMP_WIDTH_QUANTA,
        },
        _pins: [receive, transmit],
        status: Psr(0),
    }
}

/// Whether the clock security found that the crystal has stopped (RM0440, section 7.2.9). The chip then runs from its internal oscillator.
pub(crate) fn has_lost_clock() -> bool {
    pac::RCC.cifr().read().cssf()
}

/// Reads why the chip started and forgets it, so that the next start tells its own cause (RM0440, section 7.4.28).
pub(crate) fn take_cause() -> Cause {
    let flags = pac::RCC.csr().read();
    pac::RCC.csr().modify(|csr| csr.set_rmvf(true));
    // Every reset also sets the flag of the pin, so it is asked last; power-on is a brown-out to this chip.
    if flags.iwdgrstf() || flags.wwdgrstf() {
        Cause::Watchdog
    } else if flags.sftrstf() {
        Cause::Software
    } else if flags.borrstf() {
        Cause::PowerOn
    } else {
        Cause::Pin
    }
}

/// 24 MHz / 6 x 80 = 320 MHz, halved for the core and both buses.
fn clocks() -> Config {
    let mut config = Config::default();
    config.rcc.hse = Some(rcc::Hse {
        freq: Hertz(HSE_HZ),
        mode: rcc::HseMode::Oscillator,
    });
    config.rcc.pll = Some(rcc::Pll {
        source: rcc::PllSource::HSE,
        prediv: rcc::PllPreDiv::DIV6,
        mul: rcc::PllMul::MUL80,
        divp: None,
        divq: None,
        divr: Some(rcc::PllRDiv::DIV2),
    });
    config.rcc.sys = rcc::Sysclk::PLL1_R;
    // Above 150 MHz the core's supply must be raised (RM0440, section 6.1.5).
    config.rcc.boost = true;
    config.rcc.mux.fdcansel = rcc::mux::Fdcansel::PCLK1;
    #[cfg(feature = "link-usb")]
    {
        // No divider makes 48 MHz of 320 MHz. The oscillator for USB is exact enough once the frames of the host, one a millisecond, trim it
        // (RM0440, section 7.2.14 and chapter 8); nothing else is clocked by it.
        let sync_from_usb = true;
        config.rcc.hsi48 = Some(rcc::Hsi48Config { sync_from_usb });
        config.rcc.mux.clk48sel = rcc::mux::Clk48sel::HSI48;
    }
    config
}
