//! STM32G474RE, as on the Nucleo board: 24 MHz crystal, 160 MHz core, FDCAN1 on PA11 (receive) and PA12 (transmit), status LED on PA5
//! (high level lights it), stop circuit on PC0, enable on PC1, run on PC2 (3.3 V is closed, active).

use core::num::{NonZeroU8, NonZeroU16};

use embassy_executor::InterruptExecutor;
use embassy_stm32::can::config::NominalBitTiming;
use embassy_stm32::can::{CanConfigurator, IT0InterruptHandler, IT1InterruptHandler};
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::peripherals::FDCAN1;
use embassy_stm32::time::Hertz;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{Config, bind_interrupts, pac, rcc};

use super::{Board, InputPins, StatusLed, WATCHDOG_US, Watchdog};
use crate::bus::Bus;
use crate::config::MASTER;
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
const BIT_RATE: u32 = MASTER.bus.bit_rate.kbit_per_s() * 1_000;
const PRESCALER: u16 = (CORE_HZ / BIT_RATE / QUANTA_PER_BIT) as u16;
const _: () = assert!(
    PRESCALER as u32 * QUANTA_PER_BIT * BIT_RATE == CORE_HZ,
    "the bit rate is not exact"
);

/// 2.8 V, the highest level: the chip stays in reset below it (RM0440, section 6.1.7).
const BROWN_OUT_LEVEL_4: u8 = 4;
/// Unlock the flash and then the option bytes, in this order (RM0440, sections 3.3.5 and 3.4.2).
const FLASH_KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
const OPTION_KEYS: [u32; 2] = [0x0819_2A3B, 0x4C5D_6E7F];

bind_interrupts!(struct Interrupts {
    FDCAN1_IT0 => IT0InterruptHandler<FDCAN1>;
    FDCAN1_IT1 => IT1InterruptHandler<FDCAN1>;
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
    if cause == Cause::PowerOn {
        set_brown_out_level();
    }
    // A processor that a debug probe has halted must not be reset while somebody looks at it.
    pac::DBGMCU
        .apb1lfzr()
        .modify(|freeze| freeze.set_iwdg(true));
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();
    }

    let mut can = CanConfigurator::new(
        peripherals.FDCAN1,
        peripherals.PA11,
        peripherals.PA12,
        Interrupts,
    );
    can.set_config(can.config().set_nominal_bit_timing(bit_timing()));

    interrupt::UART5.set_priority(CYCLE_PRIORITY);
    Board {
        bus: Bus::new(can, pac::FDCAN1),
        inputs: InputPins {
            stop: Input::new(peripherals.PC0, Pull::Down),
            enable: Input::new(peripherals.PC1, Pull::Down),
            run: Input::new(peripherals.PC2, Pull::Down),
        },
        status_led: StatusLed {
            pin: Output::new(peripherals.PA5, Level::Low, Speed::Low),
            active_low: false,
        },
        watchdog: Watchdog(IndependentWatchdog::new(peripherals.IWDG, WATCHDOG_US)),
        cycle: CYCLE.start(interrupt::UART5),
        cause,
    }
}

/// Reads why the chip started and forgets it, so that the next start tells its own cause (RM0440, section 7.4.28).
fn take_cause() -> Cause {
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

/// Written once in the life of the chip, because the option bytes keep it; it takes effect at the next power-on.
fn set_brown_out_level() {
    if pac::FLASH.optr().read().bor_lev() == BROWN_OUT_LEVEL_4 {
        return;
    }
    FLASH_KEYS
        .into_iter()
        .for_each(|key| pac::FLASH.keyr().write_value(key));
    OPTION_KEYS
        .into_iter()
        .for_each(|key| pac::FLASH.optkeyr().write_value(key));
    pac::FLASH
        .optr()
        .modify(|options| options.set_bor_lev(BROWN_OUT_LEVEL_4));
    pac::FLASH.cr().modify(|control| control.set_optstrt(true));
    while pac::FLASH.sr().read().bsy() {}
    pac::FLASH.cr().modify(|control| {
        control.set_optlock(true);
        control.set_lock(true);
    });
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
