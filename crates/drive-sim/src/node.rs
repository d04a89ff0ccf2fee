//! A node as the bus sees it: its controller and its place in time.
//!
//! Specification: a node that joins in mid-frame neither receives nor acknowledges that frame; an error-passive node waits eight bits more between its own
//! frames (suspend transmission); a bus-off node comes back only on command, after 128 times 11 recessive bits (Bosch CAN 2.0 B,
//! sections 3.1.5 and 7).

use crate::controller::Controller;

/// Recessive bits in a row that count once towards bus-off recovery.
pub(crate) const RECOVERY_SEQUENCE_BITS: u64 = 11;

/// Sequences that end bus-off.
pub(crate) const RECOVERY_SEQUENCES: u64 = 128;

/// A node of one bus, in the order of registration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(pub(crate) usize);

impl NodeId {
    /// Index in the order of registration, from 0.
    pub fn index(self) -> usize {
        self.0
    }
}

/// A bus-off node on its way back.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Recovery {
    pub(crate) sequences_left: u64,
    /// Begin of the recessive bits that have not been counted yet.
    pub(crate) recessive_since_ns: u64,
}

#[derive(Debug, Clone)]
pub(crate) struct Node {
    pub(crate) controller: Controller,
    pub(crate) connected: bool,
    /// Frames that began earlier are not received.
    pub(crate) listening_since_ns: u64,
    /// No frame of its own before this.
    pub(crate) may_send_from_ns: u64,
    pub(crate) recovery: Option<Recovery>,
}

impl Node {
    pub(crate) fn new(controller: Controller, now_ns: u64) -> Self {
        Self {
            controller,
            connected: true,
            listening_since_ns: now_ns,
            may_send_from_ns: now_ns,
            recovery: None,
        }
    }

    pub(crate) fn is_on_bus(&self) -> bool {
        self.connected && self.controller.is_on_bus()
    }

    /// Arbitration field of the frame that waits for an idle bus.
    pub(crate) fn waiting_priority(&self) -> Option<u32> {
        let priority = self.controller.next_priority()?;
        self.is_on_bus().then_some(priority)
    }

    /// Whether it receives a frame that began at `start_ns`: it is there from the beginning and does not send it itself.
    pub(crate) fn hears(&self, start_ns: u64) -> bool {
        self.listening_since_ns <= start_ns
            && self.is_on_bus()
            && !self.controller.is_transmitting()
    }

    pub(crate) fn connect(&mut self, connected: bool, now_ns: u64) {
        if connected == self.connected {
            return;
        }
        self.connected = connected;
        self.listening_since_ns = now_ns;
        self.controller.release_wire();
    }

    pub(crate) fn recover(&mut self, at_ns: u64) {
        self.recovery = None;
        self.listening_since_ns = at_ns;
        self.controller.recover();
    }
}
