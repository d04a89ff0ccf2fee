//! A board with drives.

use std::collections::BTreeSet;
use std::env;
use std::path::PathBuf;

use drive_sim::{
    BitRate, Bus, ControllerConfig, DeviceId, DynDrive, DynDriveConfig, Frame, LogMode, NodeId,
    Record, ScriptedFaults, ZlacDrive, ZlacDriveConfig,
};
use embedded_can::nb::Can;

use crate::board::{Board, Stop};
use crate::can::Wire;
use crate::chip::{Chip, STM32F405};
use crate::drive::Drive;
use crate::gpio::Pin;
use crate::image::Image;
use crate::serial_bridge::SerialBridge;
use crate::usart::SerialLine;

/// Nanoseconds in a millisecond.
pub const MS: u64 = 1_000_000;

/// What is connected to the pins of the boards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contact {
    /// The stop circuit.
    Stop,
    /// The enable switch.
    Enable,
    /// The run switch.
    Run,
    /// The switch of a homing, on the pin that `configs/homing.rs` names.
    Homing,
}

impl Contact {
    const fn pin(self) -> Pin {
        match self {
            Self::Stop => Pin::new('C', 0),
            Self::Enable => Pin::new('C', 1),
            Self::Run => Pin::new('C', 2),
            Self::Homing => Pin::new('C', 3),
        }
    }
}

/// A board with drives on its bus.
pub struct Rig {
    board: Board,
    drives: Vec<DeviceId>,
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
        let config = |id| DynDriveConfig::numbered(id).expect("an id is 1 to 63");
        Self::with_drives(image, (1..=drives).map(config))
    }

    /// A board that has just got its supply, with these drives.
    ///
    /// # Panics
    /// When Unicorn fails.
    #[must_use]
    pub fn with_drives(image: Image, drives: impl IntoIterator<Item = DynDriveConfig>) -> Self {
        let drives = drives.into_iter().map(|drive| DynDrive::new(drive).into());
        Self::with_crystal(image, BitRate::Kbit1000, drives, chip().crystal_hz)
    }

    /// A board that has just got its supply, with these hub motors, on a bus of 500 kbit/s.
    ///
    /// # Panics
    /// When Unicorn fails.
    #[must_use]
    pub fn with_hub_motors(
        image: Image,
        drives: impl IntoIterator<Item = ZlacDriveConfig>,
    ) -> Self {
        let drives = drives.into_iter().map(|drive| ZlacDrive::new(drive).into());
        Self::with_crystal(image, BitRate::Kbit500, drives, chip().crystal_hz)
    }

    /// A board that has just got its supply and whose crystal does not run, with the drives 1 and 2.
    ///
    /// # Panics
    /// When Unicorn fails.
    #[must_use]
    pub fn without_crystal(image: Image) -> Self {
        let config = |id| DynDriveConfig::numbered(id).expect("an id is 1 to 63");
        let drives = [1, 2].map(|id| DynDrive::new(config(id)).into());
        Self::with_crystal(image, BitRate::Kbit1000, drives, 0)
    }

    fn with_crystal(
        image: Image,
        bit_rate: BitRate,
        drives: impl IntoIterator<Item = Drive>,
        hse_hz: u64,
    ) -> Self {
        let mut bus = Bus::with_faults(bit_rate, ScriptedFaults::new());
        bus.set_log(LogMode::Full);
        let mut wire = Wire::new(bus);
        let drives = drives
            .into_iter()
            .map(|drive| wire.add_device(drive, ControllerConfig::device()))
            .collect();
        let stranger = wire.add_master(ControllerConfig::device());
        let board = Board::new(chip(), image, hse_hz, wire).expect("the emulator works");
        Self {
            board,
            drives,
            stranger,
        }
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

    /// The drives, in the order of their ids.
    #[must_use]
    pub fn drives(&self) -> &[DeviceId] {
        &self.drives
    }

    /// The servo drives.
    pub fn servos(&self) -> impl Iterator<Item = &DynDrive> {
        self.wire().devices().filter_map(Drive::servo)
    }

    /// A servo drive.
    ///
    /// # Panics
    /// When it is none.
    #[must_use]
    pub fn servo(&self, id: DeviceId) -> &DynDrive {
        self.wire().device(id).servo().expect("a servo drive")
    }

    /// A servo drive, to change it.
    ///
    /// # Panics
    /// When it is none.
    pub fn servo_mut(&mut self, id: DeviceId) -> &mut DynDrive {
        let drive = self.wire_mut().device_mut(id);
        drive.servo_mut().expect("a servo drive")
    }

    /// The hub motors.
    pub fn hub_motors(&self) -> impl Iterator<Item = &ZlacDrive> {
        self.wire().devices().filter_map(Drive::hub_motor)
    }

    /// A hub motor, to change it.
    ///
    /// # Panics
    /// When it is none.
    pub fn hub_motor_mut(&mut self, id: DeviceId) -> &mut ZlacDrive {
        let drive = self.wire_mut().device_mut(id);
        drive.hub_motor_mut().expect("a hub motor")
    }

    /// The node beside the drives.
    #[must_use]
    pub fn stranger(&self) -> NodeId {
        self.stranger
    }

    /// The time since power-on.
    #[must_use]
    pub fn now_ms(&self) -> u64 {
        self.board.soc().now_ns() / MS
    }

    /// Lets time pass.
    pub fn run_ms(&mut self, ms: u64) -> Stop {
        self.run_us(1_000 * ms)
    }

    /// Lets time pass.
    pub fn run_us(&mut self, us: u64) -> Stop {
        let until_ns = self.board.soc().now_ns() + 1_000 * us;
        self.board.run_until_ns(until_ns)
    }

    /// Lets `us` pass, cuts the supply of the board there and brings it back `off_us` later; the drives go on. `seed` decides what an
    /// operation of the flash that was under way leaves.
    ///
    /// # Panics
    /// When Unicorn fails.
    pub fn cut_power(&mut self, us: u64, off_us: u64, seed: u64) -> Stop {
        let at_ns = self.board.soc().now_ns() + 1_000 * us;
        let stop = self.board.cut_power_at_ns(at_ns, 1_000 * off_us, seed);
        stop.expect("memory is mapped")
    }

    /// Holds the line from the transceiver dominant, or lets it go.
    pub fn hold_dominant(&mut self, held: bool) {
        let soc = self.board.soc_mut();
        soc.can.hold_dominant(&soc.wire, &soc.clock, held);
        // The processor looks anew at what comes next.
        soc.process();
    }

    /// The wire of the serial port, with the device at its other end.
    pub fn serial_mut(&mut self) -> &mut SerialLine {
        &mut self.board.soc_mut().serial.line
    }

    /// The device at the other end of the serial port sends bytes, from now on.
    pub fn send_serial(&mut self, bytes: &[u8]) {
        let now_ns = self.board.soc().now_ns();
        self.serial_mut().send_bytes(now_ns, bytes);
    }

    /// The bytes that came out of the serial port since the last call, as the other device reads them.
    pub fn received_serial(&mut self) -> Vec<u8> {
        let received = self.serial_mut().take_received().into_iter();
        received.map(|received| received.byte).collect()
    }

    /// Moves bytes between the serial port and the queues of a bridge: in real time, after each step.
    pub fn exchange(&mut self, bridge: &SerialBridge) {
        let now_ns = self.board.soc().now_ns();
        bridge.exchange(self.serial_mut(), now_ns);
    }

    /// How long the status LED is lit in two seconds, the length of every pattern, in milliseconds.
    pub fn lit_ms(&mut self) -> usize {
        (0..2_000)
            .filter(|_| {
                self.run_ms(1);
                self.is_led_lit() == Some(true)
            })
            .count()
    }

    /// The different lengths of the flashes of the status LED, in milliseconds and to the next eighth of a second.
    pub fn flashes_ms(&mut self) -> Vec<usize> {
        const EIGHTH_MS: usize = 125;
        let levels: Vec<bool> = (0..4_000)
            .map(|_| {
                self.run_ms(1);
                self.is_led_lit() == Some(true)
            })
            .collect();
        let mut runs: Vec<&[bool]> = levels.chunk_by(|before, after| before == after).collect();
        // The first and the last are cut off.
        runs.pop();
        let lit = runs.into_iter().skip(1).filter(|run| run[0]);
        let eighths = lit.map(|run| (run.len() + EIGHTH_MS / 2) / EIGHTH_MS);
        let lengths: BTreeSet<usize> = eighths.map(|eighths| eighths * EIGHTH_MS).collect();
        lengths.into_iter().collect()
    }

    /// Puts mistakes back that the image with failures on command knows, before its first instruction: see `src/misbehaviour`.
    ///
    /// # Panics
    /// When it is another image.
    pub fn put_back(&mut self, faults: u16) {
        let [low, high] = faults.to_le_bytes();
        self.board.poke_bytes("FAULTS", &[low, high, 0x17, 0xFA]);
    }

    /// Closes a contact.
    pub fn close(&mut self, contact: Contact) {
        self.board.soc_mut().gpio.drive(contact.pin(), true);
    }

    /// Opens a contact.
    pub fn open(&mut self, contact: Contact) {
        self.board.soc_mut().gpio.drive(contact.pin(), false);
    }

    /// Whether the status LED is lit; `None` while its pin is no output.
    #[must_use]
    pub fn is_led_lit(&self) -> Option<bool> {
        let soc = self.board.soc();
        let (pin, lit) = soc.chip.led;
        soc.gpio.driven(pin).map(|level| level == lit)
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

/// The folder with the images that `cargo xtask firmware-tests` has built, one folder for each board in it.
const FOLDER: &str = "FIRMWARE_IMAGES";
/// The board whose images are tested.
const BOARD: &str = "FIRMWARE_BOARD";

/// The chip of the board whose images are tested: the default board when the variable `FIRMWARE_BOARD` is not set.
///
/// # Panics
/// When there is no such board.
#[must_use]
pub fn chip() -> &'static Chip {
    let Ok(name) = env::var(BOARD) else {
        return &STM32F405;
    };
    Chip::named(&name).unwrap_or_else(|| panic!("{BOARD}={name} is none of the boards"))
}

/// One of the images for the tests.
///
/// # Panics
/// When it is not there: the tests are run by `cargo xtask firmware-tests`, which builds it.
#[must_use]
pub fn image(name: &str) -> Image {
    let folder = env::var_os(FOLDER).map(PathBuf::from);
    let folder =
        folder.unwrap_or_else(|| panic!("{FOLDER} is not set: run `cargo xtask firmware-tests`"));
    let path = folder.join(chip().name).join(name);
    Image::read(&path).unwrap_or_else(|error| panic!("{error}"))
}
