//! What differs between the chips, as a table: where registers are, which bits of the clock control mean what, what a reset leaves.

use core::ops::Range;

use crate::dma;
use crate::flash;
use crate::gpio::Pin;
use crate::soc::ResetCause;
use crate::usart;

/// The kind of CAN controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Controller {
    /// bxCAN, of the STM32F4.
    BxCan,
    /// FDCAN, of the STM32G4.
    FdCan,
}

/// A bit of a register that hardware sets when another, which software sets, was set before: an oscillator is ready.
#[derive(Debug, Clone, Copy)]
pub struct ReadyBit {
    /// The register.
    pub register: u32,
    /// The bits that software sets.
    pub asked: u32,
    /// How much higher the answers are.
    pub shift: u32,
}

/// Fields of the PLL's register: lowest bit and number of bits.
#[derive(Debug, Clone, Copy)]
pub struct Pll {
    /// Which source; the value that means the crystal.
    pub source: (u32, u32, u32),
    /// Divider of the source, and what is added to the field.
    pub divider: (u32, u32, u64),
    /// Multiplier.
    pub multiplier: (u32, u32),
    /// Divider of the output that clocks the core: twice the field and one more.
    pub output: (u32, u32),
    /// The value of the clock switch that means it, the one that means the crystal; anything else is the internal oscillator.
    pub switch: (u32, u32),
}

/// The serial port that the board uses.
#[derive(Debug)]
pub struct Serial {
    /// Kind of its registers.
    pub registers: usart::Registers,
    /// First address.
    pub base: u32,
    /// Number of its interrupt.
    pub interrupt: u16,
    /// Register and bit that switch its clock on; register and bit that reset it.
    pub enable: (u32, u32),
    /// As above.
    pub reset: (u32, u32),
    /// Register and lowest bit of the choice of its clock; `None` when it is that of peripheral bus 1.
    pub clock_choice: Option<(u32, u32)>,
    /// Pins of the board for it, receive and transmit, and their alternate function.
    pub pins: ([Pin; 2], u32),
    /// How it asks for DMA transfers, of received bytes and of bytes to send.
    pub requests: [DmaRequest; 2],
}

/// How a peripheral asks for DMA transfers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DmaRequest {
    /// By a stream of a controller, both counted from 0 and 1 as in the manual, with a channel selection.
    Stream {
        /// The controller, 1 or 2.
        controller: usize,
        /// The stream.
        stream: usize,
        /// The channel selection.
        channel: u32,
    },
    /// By a number of the request multiplexer.
    Mux(u32),
}

/// The DMA controllers.
#[derive(Debug)]
pub struct DmaPart {
    /// DMA1 and DMA2.
    pub controllers: [dma::Wiring; 2],
    /// Clock enable and reset register of AHB1.
    pub enable: u32,
    /// As above.
    pub reset: u32,
    /// First address of the request multiplexer, and its bit in the clock enable register.
    pub mux: Option<(u32, u32)>,
}

/// A chip on its board.
#[derive(Debug)]
pub struct Chip {
    /// Its name, as the board is called in the firmware.
    pub name: &'static str,
    /// Its CAN controller.
    pub controller: Controller,
    /// Number of reset register and bit that reset it.
    pub can_reset: (u32, u32),
    /// First address of the clock control, of the flash's registers, of port A.
    pub rcc: u32,
    /// As above.
    pub gpio: u32,
    /// Access control of the flash: wait states, caches, prefetch.
    pub flash_access: u32,
    /// Option bytes, the bits of the brown-out level in them, what they hold when the chip is new.
    pub option_bytes: (u32, u32, u32),
    /// Those bits for the highest level.
    pub highest_brown_out_level: u32,
    /// Clock configuration, configuration of the PLL, clock interrupts with the mark of a lost clock, cause of the reset.
    pub configuration: u32,
    /// As above.
    pub pll_configuration: u32,
    /// As above.
    pub clock_lost: (u32, u32),
    /// As above.
    pub reset_cause: u32,
    /// Lowest bits of the dividers of peripheral buses 1 and 2.
    pub bus_dividers: [u32; 2],
    /// The PLL.
    pub pll: Pll,
    /// Oscillators.
    pub ready: &'static [ReadyBit],
    /// Reset registers of peripheral buses 1 and 2.
    pub resets: [u32; 2],
    /// Register and bit that switch the voltage detector on; register and bit of what it says.
    pub detector: [(u32, u32); 2],
    /// Plain registers after a reset.
    pub reset_values: &'static [(u32, u32)],
    /// Flags of the cause of a reset: supply, pin, software, watchdog.
    pub causes: [u32; 4],
    /// Modes of the pins of port A, port B and the others after a reset.
    pub pin_modes: [u32; 3],
    /// The flash.
    pub flash: flash::Part,
    /// Crystal of the board.
    pub crystal_hz: u64,
    /// Pins of the board for the controller, receive and transmit, and their alternate function.
    pub can_pins: ([Pin; 2], u32),
    /// The serial port.
    pub serial: Serial,
    /// The DMA controllers.
    pub dma: DmaPart,
    /// Status LED of the board, and the level that lights it.
    pub led: (Pin, bool),
}

impl Chip {
    /// Every chip.
    pub const ALL: [&'static Self; 2] = [&STM32F405, &STM32G474];

    /// The chip of a board, by its name in the firmware.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        Self::ALL.into_iter().find(|chip| chip.name == name)
    }

    /// Control of the oscillators, the first register of the clock control.
    #[must_use]
    pub const fn control(&self) -> u32 {
        self.rcc
    }

    /// The flags of a reset's cause.
    #[must_use]
    pub const fn cause(&self, cause: ResetCause) -> u32 {
        let [supply, pin, software, watchdog] = self.causes;
        // Every reset inside the chip also pulls its reset pin.
        match cause {
            ResetCause::PowerOn => supply,
            ResetCause::Pin => pin,
            ResetCause::Software => software | pin,
            ResetCause::Watchdog => watchdog | pin,
        }
    }
}

const MS: u64 = 1_000_000;
const F4_RCC: u32 = 0x4002_3800;
const G4_RCC: u32 = 0x4002_1000;
const PWR: u32 = 0x4000_7000;
const DEVICE_ID: u32 = 0xE004_2000;

/// DMA1's peripheral side reaches the first peripheral bus alone; neither controller reaches the core-coupled memory
/// (RM0090, section 2.1).
const fn f4_dma(number: usize, interrupts: [u16; 8], peripherals: Range<u32>) -> dma::Wiring {
    dma::Wiring {
        number,
        registers: dma::Registers::Streams,
        base: 0x4002_6000 + 0x400 * (number as u32 - 1),
        bit: 20 + number as u32,
        interrupts,
        flash: 0x0800_0000..0x0810_0000,
        memory: [0x2000_0000..0x2001_C000, 0x2001_C000..0x2002_0000],
        peripherals,
    }
}

/// Every memory is within reach, the core-coupled one at both of its places too (RM0440, section 2.1).
const fn g4_dma(number: usize, interrupts: [u16; 8]) -> dma::Wiring {
    dma::Wiring {
        number,
        registers: dma::Registers::Channels,
        base: 0x4002_0000 + 0x400 * (number as u32 - 1),
        bit: number as u32 - 1,
        interrupts,
        flash: 0x0800_0000..0x0808_0000,
        memory: [0x1000_0000..0x1000_8000, 0x2000_0000..0x2002_0000],
        peripherals: 0x4000_0000..0x5006_1000,
    }
}

/// STM32F405 with an 8 MHz crystal (RM0090).
pub static STM32F405: Chip = Chip {
    name: "stm32f405",
    controller: Controller::BxCan,
    can_reset: (F4_RCC + 0x20, 25),
    rcc: F4_RCC,
    gpio: 0x4002_0000,
    flash_access: 0x4002_3C00,
    option_bytes: (0x4002_3C14, 0b11 << 2, 0x0FFF_AAED),
    highest_brown_out_level: 0,
    configuration: F4_RCC + 0x08,
    pll_configuration: F4_RCC + 0x04,
    clock_lost: (F4_RCC + 0x0C, 1 << 7),
    reset_cause: F4_RCC + 0x74,
    bus_dividers: [10, 13],
    pll: Pll {
        source: (22, 1, 1),
        divider: (0, 6, 0),
        multiplier: (6, 9),
        output: (16, 2),
        switch: (2, 1),
    },
    ready: &[
        // HSI, HSE, PLL and PLLI2S.
        ReadyBit {
            register: F4_RCC,
            asked: 0x0501_0001,
            shift: 1,
        },
        // The clock switch.
        ReadyBit {
            register: F4_RCC + 0x08,
            asked: 3,
            shift: 2,
        },
        // LSE and LSI.
        ReadyBit {
            register: F4_RCC + 0x70,
            asked: 1,
            shift: 1,
        },
        ReadyBit {
            register: F4_RCC + 0x74,
            asked: 1,
            shift: 1,
        },
    ],
    resets: [F4_RCC + 0x20, F4_RCC + 0x24],
    detector: [(PWR, 1 << 4), (PWR + 4, 1 << 2)],
    reset_values: &[
        (F4_RCC, 0x83),
        (F4_RCC + 0x04, 0x2400_3010),
        // VOSRDY.
        (PWR + 4, 1 << 14),
        (DEVICE_ID, 0x1007_6413),
    ],
    causes: [0x0E00_0000, 1 << 26, 1 << 28, 1 << 29],
    pin_modes: [0xA800_0000, 0x0000_0280, 0],
    // Times: data sheet DS8626, section 5.3.12.
    flash: flash::Part {
        registers: flash::Registers::Sectors,
        interrupt: 4,
        banks: 1,
        sectors: &[(4, 0x4000), (1, 0x1_0000), (7, 0x2_0000)],
        program_ns: 100_000,
        erase_ns: &[
            (0x4000, [800 * MS, 600 * MS, 500 * MS]),
            (0x1_0000, [2_400 * MS, 1_400 * MS, 1_100 * MS]),
            (0x2_0000, [4_000 * MS, 2_600 * MS, 2_000 * MS]),
        ],
    },
    crystal_hz: 8_000_000,
    can_pins: ([Pin::new('B', 8), Pin::new('B', 9)], 9),
    // USART2; its DMA requests are in RM0090, table 42.
    serial: Serial {
        registers: usart::Registers::Classic,
        base: 0x4000_4400,
        interrupt: 38,
        enable: (F4_RCC + 0x40, 17),
        reset: (F4_RCC + 0x20, 17),
        clock_choice: None,
        pins: ([Pin::new('A', 3), Pin::new('A', 2)], 7),
        requests: [
            DmaRequest::Stream {
                controller: 1,
                stream: 5,
                channel: 4,
            },
            DmaRequest::Stream {
                controller: 1,
                stream: 6,
                channel: 4,
            },
        ],
    },
    dma: DmaPart {
        controllers: [
            f4_dma(
                1,
                [11, 12, 13, 14, 15, 16, 17, 47],
                0x4000_0000..0x4001_0000,
            ),
            f4_dma(
                2,
                [56, 57, 58, 59, 60, 68, 69, 70],
                0x4000_0000..0x5006_1000,
            ),
        ],
        enable: F4_RCC + 0x30,
        reset: F4_RCC + 0x10,
        mux: None,
    },
    led: (Pin::new('C', 12), false),
};

/// STM32G474 with a 24 MHz crystal (RM0440).
pub static STM32G474: Chip = Chip {
    name: "stm32g474",
    controller: Controller::FdCan,
    can_reset: (G4_RCC + 0x38, 25),
    rcc: G4_RCC,
    gpio: 0x4800_0000,
    flash_access: 0x4002_2000,
    option_bytes: (0x4002_2020, 0b111 << 8, 0xFFEF_F8AA),
    highest_brown_out_level: 4 << 8,
    configuration: G4_RCC + 0x08,
    pll_configuration: G4_RCC + 0x0C,
    clock_lost: (G4_RCC + 0x1C, 1 << 8),
    reset_cause: G4_RCC + 0x94,
    bus_dividers: [8, 11],
    pll: Pll {
        source: (0, 2, 3),
        divider: (4, 4, 1),
        multiplier: (8, 7),
        output: (25, 2),
        switch: (3, 2),
    },
    ready: &[
        // HSI.
        ReadyBit {
            register: G4_RCC,
            asked: 1 << 8,
            shift: 2,
        },
        // HSE and PLL.
        ReadyBit {
            register: G4_RCC,
            asked: 0x0101_0000,
            shift: 1,
        },
        // The clock switch.
        ReadyBit {
            register: G4_RCC + 0x08,
            asked: 3,
            shift: 2,
        },
        // LSE, LSI, HSI48.
        ReadyBit {
            register: G4_RCC + 0x90,
            asked: 1,
            shift: 1,
        },
        ReadyBit {
            register: G4_RCC + 0x94,
            asked: 1,
            shift: 1,
        },
        ReadyBit {
            register: G4_RCC + 0x98,
            asked: 1,
            shift: 1,
        },
    ],
    resets: [G4_RCC + 0x38, G4_RCC + 0x40],
    detector: [(PWR + 4, 1), (PWR + 0x14, 1 << 11)],
    reset_values: &[
        (G4_RCC, 1 << 8),
        (G4_RCC + 0x08, 1),
        (G4_RCC + 0x0C, 0x1000),
        (0x4002_2000, 0x0004_0600),
        (DEVICE_ID, 0x2001_6469),
    ],
    causes: [1 << 27 | 1 << 26, 1 << 26, 1 << 28, 1 << 29],
    pin_modes: [0xABFF_FFFF, 0xFFFF_FEBF, 0xFFFF_FFFF],
    // Times: data sheet DS12288, section 5.3.10.
    flash: flash::Part {
        registers: flash::Registers::Pages,
        interrupt: 4,
        banks: 2,
        sectors: &[(256, 0x800)],
        program_ns: 83_350,
        erase_ns: &[(0x800, [24_470_000; 3])],
    },
    crystal_hz: 24_000_000,
    can_pins: ([Pin::new('A', 11), Pin::new('A', 12)], 9),
    // LPUART1; its DMA requests are in RM0440, section 13.3.2.
    serial: Serial {
        registers: usart::Registers::LowPower,
        base: 0x4000_8000,
        interrupt: 91,
        enable: (G4_RCC + 0x5C, 0),
        reset: (G4_RCC + 0x3C, 0),
        clock_choice: Some((G4_RCC + 0x88, 10)),
        pins: ([Pin::new('A', 3), Pin::new('A', 2)], 12),
        requests: [DmaRequest::Mux(34), DmaRequest::Mux(35)],
    },
    dma: DmaPart {
        controllers: [
            g4_dma(1, [11, 12, 13, 14, 15, 16, 17, 96]),
            g4_dma(2, [56, 57, 58, 59, 60, 97, 98, 99]),
        ],
        enable: G4_RCC + 0x48,
        reset: G4_RCC + 0x28,
        mux: Some((0x4002_0800, 2)),
    },
    led: (Pin::new('A', 5), true),
};
