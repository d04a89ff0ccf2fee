//! The CAN controller of the chip, whichever it has.

use drive_sim::{Bench, Frame, NodeId, ScriptedFaults};

use crate::bxcan::BxCan;
use crate::chip::{Chip, Controller};
use crate::clock::Clock;
use crate::drive::Drive;
use crate::fdcan::FdCan;

/// The bus with its drives, and faults that a test scripts.
pub type Wire = Bench<Drive, ScriptedFaults>;

/// Number and level of an interrupt line.
pub type Line = (u16, bool);

/// The controller.
#[derive(Debug, Clone)]
pub enum Can {
    /// That of the STM32F4.
    Bx(Box<BxCan>),
    /// That of the STM32G4.
    Fd(Box<FdCan>),
}

macro_rules! either {
    ($self:expr, $can:ident => $what:expr) => {
        match $self {
            Self::Bx($can) => $what,
            Self::Fd($can) => $what,
        }
    };
}

impl Can {
    /// Adds the controller of a chip to a bus, as after a reset.
    #[must_use]
    pub fn new(chip: &Chip, wire: &mut Wire) -> Self {
        match chip.controller {
            Controller::BxCan => Self::Bx(Box::new(BxCan::new(wire))),
            Controller::FdCan => Self::Fd(Box::new(FdCan::new(wire))),
        }
    }

    /// Its node.
    #[must_use]
    pub fn node(&self) -> NodeId {
        either!(self, can => can.node())
    }

    /// The frames that wait to be sent.
    #[must_use]
    pub fn waiting(&self) -> Vec<Frame> {
        either!(self, can => can.waiting())
    }

    /// Received frames that no filter passed.
    #[must_use]
    pub fn unfiltered(&self) -> u64 {
        either!(self, can => can.unfiltered())
    }

    /// Frames lost because a receive FIFO was full.
    #[must_use]
    pub fn overruns(&self) -> u64 {
        either!(self, can => can.overruns())
    }

    /// Breaks the controller on purpose: it never gives a frame up.
    pub fn keep_frames(&mut self, kept: bool) {
        either!(self, can => can.keep_frames(kept));
    }

    /// Holds the line from the transceiver dominant, or lets it go.
    ///
    /// # Panics
    /// When the controller is on the bus: only the start is modelled.
    pub fn hold_dominant(&mut self, wire: &Wire, clock: &Clock, held: bool) {
        either!(self, can => can.hold_dominant(wire, clock, held));
    }

    /// A reset: off the bus, everything forgotten.
    pub fn reset(&mut self, wire: &mut Wire) {
        either!(self, can => can.reset(wire));
    }

    /// Lets the bus run up to `now_ns`.
    pub fn advance(&mut self, wire: &mut Wire, now_ns: u64) {
        either!(self, can => can.advance(wire, now_ns));
    }

    /// The next instant at which something changes by itself.
    #[must_use]
    pub fn next_event_ns(&self, wire: &Wire) -> Option<u64> {
        either!(self, can => can.next_event_ns(wire))
    }

    /// Its interrupt lines.
    #[must_use]
    pub fn lines(&self) -> Vec<Line> {
        either!(self, can => can.lines().to_vec())
    }

    /// Reads a register, some of which are changed by that.
    pub fn read(&mut self, wire: &Wire, offset: u32) -> u32 {
        match self {
            Self::Bx(can) => can.read(wire, offset),
            Self::Fd(can) => can.read(wire, offset),
        }
    }

    /// Writes a register.
    ///
    /// # Panics
    /// When the firmware uses what is not modelled.
    pub fn write(&mut self, wire: &mut Wire, offset: u32, value: u32, clock: &Clock) {
        either!(self, can => can.write(wire, offset, value, clock));
    }

    /// The message memory; `None` when the controller has none.
    pub fn memory(&mut self) -> Option<&mut [u32]> {
        match self {
            Self::Bx(_) => None,
            Self::Fd(can) => Some(can.memory()),
        }
    }
}
