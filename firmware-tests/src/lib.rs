//! Runs the real image of the firmware without a board.
//!
//! The unmodified ELF file executes instruction by instruction on an emulated Cortex-M4 against register models of the STM32F405 or the STM32G474, and its
//! CAN controller is a node on drive-sim's bus with simulated drives. README.md says what is modelled, what is approximated and
//! what is not there.
//!
//! # Why a test against this is not circular
//!
//! The models are written from the reference manuals (RM0090, RM0440) and the architecture manual (ARMv7-M), and know nothing of the firmware
//! but what its ELF file says: segments, symbols for the log. The wire belongs to drive-sim, which never saw the master either.
//!
//! # Modules
//!
//! | Module | What |
//! |---|---|
//! | [`image`] | the ELF file: what lies where |
//! | [`board`] | the run loop: processor, peripherals, resets |
//! | [`soc`] | everything but the processor; the address map |
//! | [`cpu`] | exception entry and return |
//! | [`hooks`], [`instructions`] | what is done before each straight run of code; counting |
//! | [`nvic`], [`clock`], [`timer`], [`watchdog`], [`gpio`], [`storage`] | register models |
//! | [`usart`] | register models of the serial ports, and the wire with the device at its other end |
//! | [`serial_bridge`] | byte queues from that wire to something in real time |
//! | [`dma`], [`transfers`] | register models of the DMA controllers; memory for their transfers |
//! | [`flash`], [`flash_memory`] | programming and erasing the flash; the flash as memory, and waiting for it |
//! | [`chip`] | what differs between the chips, as a table |
//! | [`can`], [`bxcan`], [`fdcan`] | register models of the CAN controllers, on a node of drive-sim |
//! | [`load`] | how many instructions each handler took |
//! | [`motion`] | standing and moving axes whose instructions are counted |
//! | [`profile`], [`names`] | which instructions ran how often, and the functions that they belong to |
//! | [`log`] | the firmware's log |
//! | [`host`], [`orders`], [`motion_file`] | a host at the serial port, the board that takes its orders, and what it sends |
//! | [`rig`], [`scenario`] | a board with drives, the wiring of the default board, and how to bring it up |

#![forbid(unsafe_code)]

pub mod board;
pub mod bxcan;
pub mod can;
pub mod chip;
pub mod clock;
mod connection;
pub mod cpu;
pub mod dma;
pub mod drive;
pub mod fdcan;
pub mod flash;
pub mod flash_memory;
pub mod gpio;
pub mod hooks;
pub mod host;
pub mod image;
pub mod instructions;
pub mod load;
pub mod log;
pub mod motion;
pub mod motion_file;
pub mod names;
pub mod nvic;
pub mod orders;
pub mod profile;
pub mod records;
pub mod rig;
pub mod scenario;
pub mod serial_bridge;
pub mod soc;
pub mod storage;
pub mod timer;
pub mod transfers;
pub mod usart;
pub mod watchdog;

/// Mistakes that the image with failures on command can make, for [`Rig::put_back`]: the numbers of `src/misbehaviour`.
pub mod fault {
    /// A recovery leaves in the controller what waits there.
    pub const KEEP_OLD_FRAMES: u16 = 1;
    /// The start waits for the bus before anything else.
    pub const WAIT_FOR_THE_BUS: u16 = 2;
    /// The start waits for the crystal without an end.
    pub const WAIT_FOR_THE_CRYSTAL: u16 = 4;
    /// Drives that do not confirm their disable command are not shown.
    pub const HIDE_UNCONFIRMED: u16 = 8;
    /// A crystal that stops is not watched.
    pub const NO_CLOCK_SECURITY: u16 = 16;
    /// The stop circuit is looked at in one of sixteen cycles.
    pub const SELDOM_STOP: u16 = 32;
}

pub use board::{Board, Stop};
pub use image::Image;
pub use load::Load;
pub use rig::{Contact, Rig};
pub use serial_bridge::SerialBridge;
pub use soc::ResetCause;
