//! STM32F405RG: 8 MHz crystal, 168 MHz core, CAN1 on PA11 (receive) and PA12 (transmit), status LED on PC12.

use core::num::{NonZeroU8, NonZeroU16};

use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_stm32::can::util::NominalBitTiming;
use embassy_stm32::can::{
    Can, Rx0InterruptHandler, Rx1InterruptHandler, SceInterruptHandler, TxInterruptHandler,
};
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::peripherals::CAN1;
use embassy_stm32::time::Hertz;
use embassy_stm32::{Config, bind_interrupts, pac, rcc};

use crate::bus::Bus;
use crate::config::BIT_RATE;

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
const PRESCALER: u16 = (PCLK1_HZ / BIT_RATE / QUANTA_PER_BIT) as u16;
const _: () = assert!(
    PRESCALER as u32 * QUANTA_PER_BIT * BIT_RATE == PCLK1_HZ,
    "the bit rate is not exact"
);

bind_interrupts!(struct Interrupts {
    CAN1_TX => TxInterruptHandler<CAN1>;
    CAN1_RX0 => Rx0InterruptHandler<CAN1>;
    CAN1_RX1 => Rx1InterruptHandler<CAN1>;
    CAN1_SCE => SceInterruptHandler<CAN1>;
});

/// Runs the cycle, above everything in thread mode and below the drivers' own short interrupts (priority 0).
static CYCLE: InterruptExecutor = InterruptExecutor::new();
const CYCLE_PRIORITY: Priority = Priority::P6;

/// UART5 is not used on this board; its interrupt is the one that polls [`CYCLE`].
#[embassy_stm32::interrupt]
unsafe fn UART5() {
    // SAFETY: this is the only caller, and `CYCLE.start` both initialises the executor and enables this interrupt, in that order.
    unsafe { CYCLE.on_interrupt() }
}

/// What a board hands to the application.
pub(crate) struct Board {
    /// The drives' bus: filters set, joining the traffic.
    pub(crate) bus: Bus,
    /// The status LED, dark.
    pub(crate) status_led: StatusLed,
    /// Starts the task that runs the cycle.
    pub(crate) cycle: SendSpawner,
}

/// The status LED; it hangs between supply and pin, so a low level lights it.
pub(crate) struct StatusLed(Output<'static>);

impl StatusLed {
    /// Lights the LED when it is dark and darkens it when it is lit.
    pub(crate) fn toggle(&mut self) {
        self.0.toggle();
    }
}

/// Starts clocks, pins, bus and the executor of the cycle. To be called once: a second call panics.
pub(crate) fn init() -> Board {
    let peripherals = embassy_stm32::init(clocks());

    let mut can = Can::new(
        peripherals.CAN1,
        peripherals.PA11,
        peripherals.PA12,
        Interrupts,
    );
    // The guard puts the controller into initialisation, the only state where the bit timing can be written, and ends it when dropped.
    can.modify_config().set_bit_timing(bit_timing());

    interrupt::UART5.set_priority(CYCLE_PRIORITY);
    Board {
        bus: Bus::new(can, pac::CAN1),
        status_led: StatusLed(Output::new(peripherals.PC12, Level::High, Speed::Low)),
        cycle: CYCLE.start(interrupt::UART5),
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
        divq: None,
        divr: None,
    });
    config.rcc.sys = rcc::Sysclk::PLL1_P;
    config.rcc.ahb_pre = rcc::AHBPrescaler::DIV1;
    config.rcc.apb1_pre = rcc::APBPrescaler::DIV4;
    config.rcc.apb2_pre = rcc::APBPrescaler::DIV2;
    config
}

/// The bit timing as the driver wants it.
const fn bit_timing() -> NominalBitTiming {
    // Constant evaluation: a zero would stop the build here, not the board.
    const TIMING: NominalBitTiming = NominalBitTiming {
        prescaler: NonZeroU16::new(PRESCALER).unwrap(),
        seg1: NonZeroU8::new(SEGMENT_1_QUANTA).unwrap(),
        seg2: NonZeroU8::new(SEGMENT_2_QUANTA).unwrap(),
        sync_jump_width: NonZeroU8::new(JUMP_WIDTH_QUANTA).unwrap(),
    };
    TIMING
}
