//! What a board is told, apart from its axes.

use serde::{Deserialize, Serialize};

use crate::axis::AxisSettings;

/// Most axes of a board.
pub const MOST_AXES: usize = board_link::segment::MOST_AXES;

/// The name of a board: at most 24 bytes.
pub type Name = heapless::String<24>;

/// Everything that a board is told. Numbers are as they were written: [`Settings::configs`] says whether they make a board that works.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Settings {
    /// What the user calls the board; may be empty.
    pub name: Name,
    /// The bus of the drives.
    pub bus: BusSettings,
    /// The inputs.
    pub inputs: Inputs,
    /// The axes, in ascending order of drive id.
    pub axes: heapless::Vec<AxisSettings, MOST_AXES>,
}

/// The bus of the drives. In which order frames leave the controller is no setting: it is how the board is built, see
/// [`Board::order`](crate::Board::order).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct BusSettings {
    /// The bit rate that the drives are set to, in kbit/s.
    pub bit_rate_kbit_per_s: u16,
    /// Requests that may go out in one cycle, at least 1.
    pub requests_per_cycle: u8,
    /// Shortest time from the end of a request until the drive answers, in microseconds: as measured, with a margin (D65).
    pub response_min_us: u32,
    /// The longest, in microseconds.
    pub response_max_us: u32,
}

impl BusSettings {
    /// One request a cycle, answers within 2 ms.
    #[must_use]
    pub const fn new(bit_rate_kbit_per_s: u16) -> Self {
        Self {
            bit_rate_kbit_per_s,
            requests_per_cycle: 1,
            response_min_us: 0,
            response_max_us: 2_000,
        }
    }
}

/// The inputs of the machine. The stop circuit is always there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Inputs {
    /// An enable input is connected: nothing is enabled unless it is active.
    pub enable_fitted: bool,
}

impl Default for Inputs {
    fn default() -> Self {
        Self {
            enable_fitted: true,
        }
    }
}
