//! Virtual CAN bus with exact bit timing, for tests and for a bench without drives.
//!
//! # Why a test against this crate is not circular
//!
//! A simulator proves something only when it cannot share the opinions of what it tests. Therefore:
//!
//! - this crate never imports the master; of the product it knows the codec alone, for simulated drives. It meets the master at
//!   `embedded_can::nb::Can`, the border at which the master meets real controllers, and the master runs on it unmodified;
//! - the bus enforces the law of the wire and of the controller (CAN 2.0, bxCAN reference manual), not what a master would like:
//!   mailboxes fill up, frames are displaced, FIFOs overrun, equal identifiers collide, nobody acknowledges on an empty bus;
//! - the length of every frame is computed from its bits and checked against vectors made by an independent reference;
//! - faults come from outside, from a [`FaultModel`] that the test owns. The bus itself draws no random numbers and reads no clock, so
//!   the same inputs give the same log, bit for bit.
//!
//! # Modules
//!
//! | Module | Law it enforces |
//! |---|---|
//! | [`frame`] | what a classic CAN frame may contain, and which of two frames wins arbitration |
//! | [`wire`] | CRC-15, bit stuffing, exact length on the wire |
//! | [`mailbox`] | three transmit mailboxes: order, displacement, abort |
//! | [`receive`] | acceptance filter and three-deep receive FIFO with overrun |
//! | [`confinement`] | error counters, error-passive, bus-off |
//! | [`controller`] | one node's controller, behind `embedded_can::nb::Can` |
//! | [`port`] | one node's connection to the bus: what software on that node may do |
//! | [`arbitration`] | what happens when several nodes send the same identifier at once |
//! | [`fault`], [`script`] | faults on single frames, from outside |
//! | [`outage`] | time windows in which the bus is blocked or disturbed |
//! | [`bus`] | virtual time, arbitration, delivery, retransmission, load |
//! | [`log`], [`candump`] | what was on the wire, and its text form |
//! | [`dyn_drive`], [`zlac_drive`] | simulated drives: DYN2/DYN4, and ZLAC8030L on CANopen |
//! | [`serial_line`] | byte times of a serial line, and what the relays of a chain add |
//! | [`device`], [`mod@bench`] | simulated devices and masters on one bus, in correct time order |
//!
//! # Example
//!
//! ```
//! use drive_sim::{BitRate, Bus, ControllerConfig, Frame, TxOrder};
//! use embedded_can::{Frame as _, StandardId, nb::Can};
//!
//! let mut bus = Bus::new(BitRate::Kbit1000);
//! let master = bus.add_node(ControllerConfig::bxcan(TxOrder::Fifo));
//! let drive = bus.add_node(ControllerConfig::device());
//!
//! let frame = Frame::new(StandardId::new(0x03C).unwrap(), &[0xFF, 0x88]).unwrap();
//! bus.port(master).transmit(&frame).unwrap();
//! bus.advance_to(100_000);
//! assert_eq!(bus.port(drive).receive(), Ok(frame));
//! ```
//!
//! The same with a simulated drive in place of a bare controller:
//!
//! ```
//! use drive_sim::{Bench, BitRate, ControllerConfig, DynDriveConfig, Frame, TxOrder};
//! use embedded_can::{Frame as _, StandardId, nb::Can};
//!
//! let (mut bench, drives) = Bench::with_drives(BitRate::Kbit1000, [DynDriveConfig::numbered(1).unwrap()]);
//! let master = bench.add_master(ControllerConfig::bxcan(TxOrder::Fifo));
//! bench.advance_to(150_000_000);
//!
//! // One streamed set-point of -120 counts.
//! let frame = Frame::new(StandardId::new(0x03C).unwrap(), &[0xFF, 0x88]).unwrap();
//! bench.port(master).transmit(&frame).unwrap();
//! bench.advance_to(300_000_000);
//! let drive = bench.device(drives[0]);
//! assert_eq!((drive.commanded_counts(), drive.position_counts(bench.now_ns())), (-120, -120));
//! ```

#![forbid(unsafe_code)]

pub mod arbitration;
pub mod bench;
pub mod bus;
pub mod candump;
pub mod confinement;
pub mod controller;
pub mod device;
pub mod dyn_drive;
pub mod fault;
pub mod frame;
pub mod log;
pub mod mailbox;
mod node;
pub mod outage;
pub mod port;
pub mod receive;
pub mod script;
pub mod serial_line;
pub mod split_mix;
pub mod wire;
pub mod zlac_drive;

pub use bench::{Bench, DeviceId};
pub use bus::{Bus, LoadMark};
pub use can_frame::{BitRate, UnsupportedBitRate};
pub use candump::CandumpLine;
pub use confinement::ErrorState;
pub use controller::{
    Controller, ControllerConfig, ControllerError, ControllerState, Counters, TxQueue,
};
pub use device::Device;
pub use dyn_drive::{
    Books, CoastDeceleration, DriveFaults, DynConfigError, DynDrive, DynDriveConfig, EepromWrites,
    EndStops, Mechanics, PositionAfterPower, PositionOverflow, RangeErrors, Reaction, ReadBackUnit,
    ResponseDelay, ServoDynamics, ServoLimits, ServoLoop, Switch, SwitchSide,
};
pub use fault::{Attempt, AttemptOutcome, Delivery, DeliveryOutcome, FaultModel, NoFaults};
pub use frame::Frame;
pub use log::{LogMode, Outcome, Record, TrafficLog};
pub use mailbox::TxOrder;
pub use node::NodeId;
pub use outage::{EmptyOutage, Outage, OutageKind};
pub use port::{NotBusOff, Port};
pub use receive::{AcceptanceFilter, Overrun, RxQueue};
pub use script::{FrameMatch, ScriptedFaults};
pub use serial_line::{SerialDevice, SerialLine};
pub use split_mix::SplitMix64;
pub use wire::WireLength;
pub use zlac_drive::{
    EepromWear, OfflineReaction, ReplyDamage, ZlacBooks, ZlacDrive, ZlacDriveConfig, ZlacFaults,
    ZlacLoop, ZlacMechanics, ZlacQuirks, ZlacSurroundings,
};
