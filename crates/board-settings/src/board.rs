//! What is built into a board, and settings must fit.

use can_motion::plan::{BitRate, TxOrder};

/// What is built into a board. A host that knows the board checks settings as the board itself does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Board {
    /// What it calls itself.
    pub name: &'static str,
    /// Time from one cycle to the next in microseconds.
    pub cycle_us: u32,
    /// The bit rates that its clock makes exactly, ascending.
    pub bit_rates: &'static [BitRate],
    /// In which order its controller sends what waits in it.
    pub order: TxOrder,
    /// The last pin of port C that a switch may hang on; the first is 3.
    pub last_switch_pin: u8,
}

impl Board {
    /// CAN from 42 MHz in 14 quanta: every rate of the drives but 800 kbit/s. PC12 has its status LED.
    pub const STM32F405: Self = Self {
        name: "STM32F405",
        cycle_us: 1_000,
        bit_rates: &[
            BitRate::Kbit10,
            BitRate::Kbit20,
            BitRate::Kbit50,
            BitRate::Kbit125,
            BitRate::Kbit250,
            BitRate::Kbit500,
            BitRate::Kbit1000,
        ],
        order: TxOrder::Fifo,
        last_switch_pin: 11,
    };

    /// CAN from 160 MHz in 40 quanta: every rate of the drives.
    pub const STM32G474: Self = Self {
        name: "STM32G474",
        cycle_us: 1_000,
        bit_rates: &dyn_can::BIT_RATES,
        order: TxOrder::Fifo,
        last_switch_pin: 12,
    };

    /// The boards that this version knows.
    pub const ALL: [Self; 2] = [Self::STM32F405, Self::STM32G474];

    /// The board that calls itself so, in any case.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|board| board.name.eq_ignore_ascii_case(name))
    }
}
