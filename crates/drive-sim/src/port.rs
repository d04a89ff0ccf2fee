//! One node's connection to the bus: what software on that node may do.
//!
//! Specification: software talks to its own controller and to nothing else. Everything it asks for takes effect at the present instant of the bus; time passes
//! only when the owner of the bus lets it.

use core::fmt;

use embedded_can::nb::Can;

use crate::controller::{Controller, ControllerError, ControllerState};
use crate::frame::Frame;
use crate::node::{Node, RECOVERY_SEQUENCES, Recovery};

/// Access to the controller of one node; implements [`embedded_can::nb::Can`].
#[derive(Debug)]
pub struct Port<'a> {
    pub(crate) node: &'a mut Node,
    pub(crate) now_ns: u64,
    /// From then on the bus is idle, as far as is known now.
    pub(crate) idle_from_ns: u64,
}

impl Port<'_> {
    /// The controller, to read its state and counters.
    pub fn controller(&self) -> &Controller {
        &self.node.controller
    }

    /// Frees all waiting mailboxes; see [`Controller::abort_all`].
    pub fn abort_all(&mut self) -> usize {
        self.node.controller.abort_all()
    }

    /// Starts the recovery from bus-off: the controller comes back error-active after 128 times 11 recessive bits.
    ///
    /// A second request does not start it anew. Frames that wait in mailboxes go out afterwards unless they are aborted first.
    ///
    /// # Errors
    /// [`NotBusOff`] in every other state.
    pub fn request_recovery(&mut self) -> Result<(), NotBusOff> {
        let state = self.node.controller.state();
        if state != ControllerState::On(crate::confinement::ErrorState::BusOff) {
            return Err(NotBusOff { state });
        }
        let recessive_since_ns = self.now_ns.max(self.idle_from_ns);
        self.node.recovery.get_or_insert(Recovery {
            sequences_left: RECOVERY_SEQUENCES,
            recessive_since_ns,
        });
        Ok(())
    }

    /// Switches the controller off: mailboxes, receive FIFO and error counters are lost, a frame on the wire is cut off.
    pub fn power_off(&mut self) {
        self.node.controller.switch(false);
        self.node.recovery = None;
    }

    /// Switches the controller on, or resets it when it is on: it is empty, error-active and listens from the next frame on.
    pub fn power_on(&mut self) {
        self.node.controller.switch(true);
        self.node.recovery = None;
        self.node.listening_since_ns = self.now_ns;
    }
}

impl Can for Port<'_> {
    type Frame = Frame;
    type Error = ControllerError;

    /// Stores `frame` for transmission; see [`Controller`].
    ///
    /// # Errors
    /// `WouldBlock` when nothing was stored for want of room, `Other` when the controller is off or bus-off.
    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, ControllerError> {
        self.node.controller.transmit(frame)
    }

    /// Takes the oldest received frame.
    ///
    /// # Errors
    /// `WouldBlock` when there is none, `Other` when there is none and the controller is off or bus-off.
    fn receive(&mut self) -> nb::Result<Frame, ControllerError> {
        self.node.controller.receive()
    }
}

/// Recovery was requested from a controller that is not bus-off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotBusOff {
    /// Its state.
    pub state: ControllerState,
}

impl fmt::Display for NotBusOff {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "recovery needs a controller that is bus-off, this one is {}; check its state first",
            self.state
        )
    }
}

impl core::error::Error for NotBusOff {}
