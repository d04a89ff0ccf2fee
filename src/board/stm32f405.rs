//! STM32F405RG: 8 MHz crystal, 168 MHz core, CAN1 on PA11 (receive) and PA12 (transmit), status LED on PC12 (low level lights it),
//! stop circuit on PC0, enable on PC1, run on PC2 (3.3 V is closed, active).

use core::num::{NonZeroU8, NonZeroU16};

use embassy_executor::InterruptExecutor;
use embassy_stm32::can::util::NominalBitTiming;
use embassy_stm32::can::{
    Can, Rx0InterruptHandler, Rx1InterruptHandler, SceInterruptHandler, TxInterruptHandler,
};
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::peripherals::CAN1;
use embassy_stm32::time::Hertz;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{Config, bind_interrupts, pac, rcc};

use super::{Board, InputPins, StatusLed, WATCHDOG_US, Watchdog};
use crate::bus::Bus;
use crate::config::MASTER;
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
const BIT_RATE: u32 = MASTER.bus.bit_rate.kbit_per_s() * 1_000;
const PRESCALER: u16 = (PCLK1_HZ / BIT_RATE / QUANTA_PER_BIT) as u16;
const _: () = assert!(
    PRESCALER as u32 * QUANTA_PER_BIT * BIT_RATE == PCLK1_HZ,
    "the bit rate is not exact"
);

const BROWN_OUT_LEVEL_3: u8 = 0;
/// Unlock the option bytes, in this order (RM0090, section 3.6.2).
const OPTION_KEYS: [u32; 2] = [0x0819_2A3B, 0x4C5D_6E7F];

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

/// Starts clocks, pins, bus and the executor of the cycle. To be called once: a second call panics.
pub(crate) fn init() -> Board {
    let cause = take_cause();
    let peripherals = embassy_stm32::init(clocks());
    set_brown_out_level();
    // A processor that a debug probe has halted must not be reset while somebody looks at it.
    pac::DBGMCU.apb1fzr().modify(|freeze| freeze.set_iwdg(true));
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();
    }

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
        inputs: InputPins {
            stop: Input::new(peripherals.PC0, Pull::Down),
            enable: Input::new(peripherals.PC1, Pull::Down),
            run: Input::new(peripherals.PC2, Pull::Down),
        },
        status_led: StatusLed {
            pin: Output::new(peripherals.PC12, Level::High, Speed::Low),
            active_low: true,
        },
        watchdog: Watchdog(IndependentWatchdog::new(peripherals.IWDG, WATCHDOG_US)),
        cycle: CYCLE.start(interrupt::UART5),
        cause,
    }
}

/// Reads why the chip started and forgets it, so that the next start tells its own cause (RM0090, section 7.3.21).
fn take_cause() -> Cause {
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

/// The chip stays in reset while its supply is below 2.7 V, the highest level (RM0090, section 3.6.2): below it the flash and the clock are
/// not specified for 168 MHz. Written once in the life of the chip, because the option bytes keep it.
fn set_brown_out_level() {
    if pac::FLASH.optcr().read().bor_lev() == BROWN_OUT_LEVEL_3 {
        return;
    }
    OPTION_KEYS
        .into_iter()
        .for_each(|key| pac::FLASH.optkeyr().write_value(key));
    pac::FLASH
        .optcr()
        .modify(|options| options.set_bor_lev(BROWN_OUT_LEVEL_3));
    pac::FLASH
        .optcr()
        .modify(|options| options.set_optstrt(true));
    while pac::FLASH.sr().read().bsy() {}
    pac::FLASH
        .optcr()
        .modify(|options| options.set_optlock(true));
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
