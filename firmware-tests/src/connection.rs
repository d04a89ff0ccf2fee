//! A controller's connection to drive-sim's bus: arbitration, frame lengths, acknowledge, error counters and bus-off are drive-sim's. At
//! most one frame at a time is with drive-sim's controller: the one that goes next.

use drive_sim::{
    ControllerConfig, ControllerState, Counters, ErrorState, Frame, NodeId, Outcome, Port,
};
use embedded_can::nb::Can as _;

use crate::can::Wire;

/// Error codes of the last error, the same in both controllers.
pub(crate) const LEC_STUFF: u32 = 1;
/// Nobody acknowledged.
pub(crate) const LEC_ACKNOWLEDGE: u32 = 3;
/// The level read back was not the level sent.
pub(crate) const LEC_BIT: u32 = 5;

/// What has happened on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Seen {
    /// Nothing that counts.
    Nothing,
    /// The frame of a place went out and was acknowledged.
    Sent(Option<usize>),
    /// An attempt failed with this code.
    Failed {
        /// Error code.
        code: u32,
        /// Its place.
        place: Option<usize>,
        /// It was to be given up when the attempt was over.
        given_up: bool,
    },
    /// A frame of another was received, with an error or without.
    Received {
        /// It was destroyed.
        with_error: bool,
    },
}

/// The connection.
#[derive(Debug, Clone)]
pub(crate) struct Connection {
    node: NodeId,
    /// The place whose frame is with drive-sim's controller.
    handed: Option<usize>,
    /// That frame shall not be sent again after a failed attempt.
    giving_up: bool,
    seen: Counters,
}

impl Connection {
    /// Adds a node to a bus, disconnected.
    pub(crate) fn new(wire: &mut Wire) -> Self {
        let node = wire.add_master(ControllerConfig::device());
        wire.bus_mut().set_connected(node, false);
        Self {
            node,
            handed: None,
            giving_up: false,
            seen: Counters::default(),
        }
    }

    /// Its node.
    pub(crate) fn node(&self) -> NodeId {
        self.node
    }

    fn port<'a>(&self, wire: &'a mut Wire) -> Port<'a> {
        wire.port(self.node)
    }

    /// A reset of the controller.
    pub(crate) fn reset(&mut self, wire: &mut Wire) {
        wire.bus_mut().set_connected(self.node, false);
        let mut port = self.port(wire);
        port.power_off();
        port.power_on();
        self.seen = port.controller().counters();
        (self.handed, self.giving_up) = (None, false);
    }

    /// Takes part in the traffic. After a bus-off, which ends 128 times 11 recessive bits later.
    pub(crate) fn join(&self, wire: &mut Wire) {
        wire.bus_mut().set_connected(self.node, true);
        // In any other state there is nothing to recover.
        let _ = self.port(wire).request_recovery();
    }

    /// A recovery without a word of the firmware.
    pub(crate) fn recover_by_itself(&self, wire: &mut Wire) {
        let _ = self.port(wire).request_recovery();
    }

    /// Takes no part any more.
    pub(crate) fn leave(&self, wire: &mut Wire) {
        wire.bus_mut().set_connected(self.node, false);
    }

    /// Transmit and receive error counters.
    pub(crate) fn counters(&self, wire: &Wire) -> (u32, u32) {
        let controller = wire.bus().controller(self.node);
        (u32::from(controller.tec()), u32::from(controller.rec()))
    }

    /// Fault confinement.
    pub(crate) fn state(&self, wire: &Wire) -> ControllerState {
        wire.bus().controller(self.node).state()
    }

    /// Whether it is bus-off.
    pub(crate) fn is_bus_off(&self, wire: &Wire) -> bool {
        self.state(wire) == ControllerState::On(ErrorState::BusOff)
    }

    /// The oldest frame that came in.
    pub(crate) fn receive(&self, wire: &mut Wire) -> Option<Frame> {
        self.port(wire).receive().ok()
    }

    /// What has happened since the last call, at most one thing: to be asked after each step of the bus.
    pub(crate) fn look(&mut self, wire: &Wire) -> Seen {
        let counters = wire.bus().controller(self.node).counters();
        let seen = core::mem::replace(&mut self.seen, counters);
        if counters.tx_frames > seen.tx_frames {
            Seen::Sent(self.handed.take())
        } else if counters.tx_errors > seen.tx_errors {
            let given_up = core::mem::take(&mut self.giving_up);
            let place = self.handed;
            if given_up {
                self.handed = None;
            }
            Seen::Failed {
                code: last_code(wire),
                place,
                given_up,
            }
        } else if counters.rx_errors > seen.rx_errors {
            Seen::Received { with_error: true }
        } else if counters.rx_frames > seen.rx_frames {
            Seen::Received { with_error: false }
        } else {
            Seen::Nothing
        }
    }

    /// Gives drive-sim's controller the frame that goes next, in place of another that has not begun.
    pub(crate) fn hand_over(&mut self, wire: &mut Wire, next: Option<(usize, Frame)>) {
        let place = next.as_ref().map(|(place, _)| *place);
        if place == self.handed || wire.bus().controller(self.node).is_transmitting() {
            return;
        }
        let mut port = self.port(wire);
        port.abort_all();
        // A controller that is bus-off takes none; it is tried again when time moves on.
        self.handed = next
            .filter(|(_, frame)| port.transmit(frame).is_ok())
            .map(|(place, _)| place);
    }

    /// Withdraws the frame of a place; false when it is on the wire and will be given up only if this attempt fails.
    pub(crate) fn withdraw(&mut self, wire: &mut Wire, place: usize) -> bool {
        if self.handed != Some(place) {
            return true;
        }
        let mut port = self.port(wire);
        port.abort_all();
        if port.controller().is_transmitting() {
            self.giving_up = true;
            return false;
        }
        self.handed = None;
        true
    }
}

/// Error code of the latest attempt on the wire.
fn last_code(wire: &Wire) -> u32 {
    match wire.bus().log().iter().last().map(|record| record.outcome) {
        Some(Outcome::AckError) => LEC_ACKNOWLEDGE,
        _ => LEC_BIT,
    }
}
