//! A board with drives: the wiring of the default board.

use std::env;
use std::path::PathBuf;

use drive_sim::{
    BitRate, Bus, ControllerConfig, DynDrive, DynDriveConfig, Frame, LogMode, NodeId, Record,
    ScriptedFaults,
};
use embedded_can::nb::Can;

use crate::board::{Board, Stop};
use crate::bxcan::Wire;
use crate::image::{Image, ImageError};

/// Crystal of the default board.
const HSE_HZ: u64 = 8_000_000;
/// Nanoseconds in a millisecond.
pub const MS: u64 = 1_000_000;

/// A board with drives on its bus.
pub struct Rig {
    board: Board,
    /// A node beside the drives, for frames that no drive sends.
    stranger: NodeId,
}

impl Rig {
    /// A board that has just got its supply, with the drives 1, 2, 3 and so on, as many as `drives`.
    ///
    /// # Panics
    /// When there are more drives than ids, or Unicorn fails.
    #[must_use]
    pub fn with_numbered_drives(image: Image, drives: i32) -> Self {
        let configs =
            (1..=drives).map(|id| DynDriveConfig::numbered(id).expect("an id is 1 to 63"));
        Self::with_drives(image, configs)
    }

    /// A board that has just got its supply, with these drives.
    ///
    /// # Panics
    /// When Unicorn fails.
    #[must_use]
    pub fn with_drives(image: Image, drives: impl IntoIterator<Item = DynDriveConfig>) -> Self {
        let mut bus = Bus::with_faults(BitRate::Kbit1000, ScriptedFaults::new());
        bus.set_log(LogMode::Full);
        let mut wire = Wire::new(bus);
        for drive in drives {
            wire.add_device(DynDrive::new(drive), ControllerConfig::device());
        }
        let stranger = wire.add_master(ControllerConfig::device());
        let board = Board::new(image, HSE_HZ, wire).expect("the emulator works");
        Self { board, stranger }
    }

    /// The board.
    #[must_use]
    pub fn board(&self) -> &Board {
        &self.board
    }

    /// The board, to change it.
    pub fn board_mut(&mut self) -> &mut Board {
        &mut self.board
    }

    /// The bus with its drives.
    #[must_use]
    pub fn wire(&self) -> &Wire {
        &self.board.soc().wire
    }

    /// The bus with its drives, to change them.
    pub fn wire_mut(&mut self) -> &mut Wire {
        &mut self.board.soc_mut().wire
    }

    /// The time since power-on.
    #[must_use]
    pub fn now_ms(&self) -> u64 {
        self.board.soc().now_ns() / MS
    }

    /// Lets time pass.
    pub fn run_ms(&mut self, ms: u64) -> Stop {
        let until_ns = self.board.soc().now_ns() + ms * MS;
        self.board.run_until_ns(until_ns)
    }

    /// Lets time pass until a line of the log contains `text`; false when it does not come within `ms`.
    pub fn run_until_logged(&mut self, text: &str, ms: u64) -> bool {
        let from = self.board.log().len();
        for _ in 0..ms {
            self.run_ms(1);
            if self.board.log()[from..]
                .iter()
                .any(|line| line.contains(text))
            {
                return true;
            }
        }
        false
    }

    /// Whether a line of the log contains `text`.
    #[must_use]
    pub fn has_logged(&self, text: &str) -> bool {
        self.board.log().iter().any(|line| line.contains(text))
    }

    /// Puts a frame on the bus that comes from no drive.
    ///
    /// # Panics
    /// Never: the node beside the drives has an unbounded queue.
    pub fn send(&mut self, frame: &Frame) {
        let stranger = self.stranger;
        let sent = self.wire_mut().port(stranger).transmit(frame);
        sent.expect("an unbounded queue has room");
    }

    /// Everything that the board has put on the wire so far, errors included.
    pub fn from_board(&self) -> impl Iterator<Item = &Record> {
        let node = self.board.soc().can.node();
        self.wire()
            .bus()
            .log()
            .iter()
            .filter(move |record| record.node == node)
    }
}

/// The image that the environment variable names, else the one that `cargo fw` leaves.
///
/// # Errors
/// [`ImageError`] when it cannot be read.
pub fn image(variable: &str, name: &str) -> Result<Image, ImageError> {
    let built = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../target/thumb/thumbv7em-none-eabihf/release");
    let path = env::var_os(variable).map_or_else(|| built.join(name), PathBuf::from);
    Image::read(&path)
}
