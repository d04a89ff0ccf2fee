//! One node's CAN controller, behind `embedded_can::nb::Can`.
//!
//! Law (bxCAN, RM0090; `embedded_can::nb::Can`): handing over a frame has four outcomes. It is stored; it is stored and a waiting frame of lower
//! priority comes back; there is no room; or the controller is bus-off or off, which is an error. Frames that wait when a controller
//! becomes bus-off stay in their mailboxes and go out after the recovery unless they are aborted.

mod config;
mod state;

use std::collections::VecDeque;

use crate::confinement::{ErrorCounters, ErrorState};
use crate::frame::Frame;
use crate::mailbox::{MAILBOXES, Placement, TxMailboxes, TxOrder};
use crate::receive::RxFrames;

pub use config::{ControllerConfig, TxQueue};
pub use state::{ControllerError, ControllerState, Counters};

/// A CAN controller. Nodes of a [`Bus`](crate::Bus) own one each.
#[derive(Debug, Clone)]
pub struct Controller {
    config: ControllerConfig,
    on: bool,
    errors: ErrorCounters,
    mailboxes: TxMailboxes,
    /// Frames behind the mailboxes, with [`TxQueue::Unbounded`] only.
    backlog: VecDeque<Frame>,
    received: RxFrames,
    counters: Counters,
}

impl Controller {
    /// A controller that is on, error-active and empty.
    pub fn new(config: ControllerConfig) -> Self {
        let order = match config.tx {
            TxQueue::Mailboxes(order) => order,
            TxQueue::Unbounded => TxOrder::Fifo,
        };
        Self {
            config,
            on: true,
            errors: ErrorCounters::default(),
            mailboxes: TxMailboxes::new(order),
            backlog: VecDeque::new(),
            received: RxFrames::new(config.rx),
            counters: Counters::default(),
        }
    }

    /// How it is set up.
    pub fn config(&self) -> ControllerConfig {
        self.config
    }

    /// On or off, and the error state.
    pub fn state(&self) -> ControllerState {
        if self.on {
            ControllerState::On(self.errors.state())
        } else {
            ControllerState::Off
        }
    }

    /// Transmit error counter.
    pub fn tec(&self) -> u16 {
        self.errors.tec()
    }

    /// Receive error counter.
    pub fn rec(&self) -> u16 {
        self.errors.rec()
    }

    /// Frames, errors and losses counted so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// Frames that wait to be sent, the one on the wire included.
    pub fn tx_pending(&self) -> usize {
        self.mailboxes.pending() + self.backlog.len()
    }

    /// Whether one of its frames is on the wire right now.
    pub fn is_transmitting(&self) -> bool {
        self.mailboxes.is_transmitting()
    }

    /// Frames received and not yet read.
    pub fn rx_pending(&self) -> usize {
        self.received.len()
    }

    /// Frees all waiting mailboxes and returns how many frames that were.
    ///
    /// A frame on the wire is finished; it is given up only if this attempt fails. [`Self::is_transmitting`] says whether there is one.
    pub fn abort_all(&mut self) -> usize {
        let freed = self.mailboxes.abort_all() + self.backlog.len();
        self.backlog.clear();
        self.counters.tx_aborted += freed as u64;
        freed
    }

    pub(crate) fn switch(&mut self, on: bool) {
        self.on = on;
        self.errors = ErrorCounters::default();
        self.mailboxes.clear();
        self.backlog.clear();
        self.received.clear();
    }

    pub(crate) fn recover(&mut self) {
        self.errors = ErrorCounters::default();
    }

    fn check_on_bus(&self) -> Result<(), ControllerError> {
        match self.state() {
            ControllerState::Off => Err(ControllerError::Off),
            ControllerState::On(ErrorState::BusOff) => {
                Err(ControllerError::BusOff { tec: self.tec() })
            }
            ControllerState::On(_) => Ok(()),
        }
    }

    pub(crate) fn is_on_bus(&self) -> bool {
        self.check_on_bus().is_ok()
    }

    pub(crate) fn is_passive(&self) -> bool {
        self.errors.state() == ErrorState::Passive
    }

    fn place(&mut self, frame: Frame) -> Placement {
        if self.config.tx != TxQueue::Unbounded {
            return self.mailboxes.store(frame);
        }
        if self.mailboxes.pending() < MAILBOXES {
            return self.mailboxes.store(frame);
        }
        self.backlog.push_back(frame);
        Placement::Stored
    }

    fn refill(&mut self) {
        while self.mailboxes.pending() < MAILBOXES {
            let Some(frame) = self.backlog.pop_front() else {
                return;
            };
            self.mailboxes.store(frame);
        }
    }

    /// Arbitration field of the frame it sends next.
    pub(crate) fn next_priority(&self) -> Option<u32> {
        self.mailboxes.head_priority()
    }

    pub(crate) fn begin(&mut self) -> Option<(Frame, u32)> {
        self.mailboxes.begin()
    }

    pub(crate) fn frame_on_wire(&self) -> Option<Frame> {
        self.mailboxes.on_wire()
    }

    pub(crate) fn transmitted(&mut self) {
        self.errors.transmitted();
        self.counters.tx_frames += 1;
        self.mailboxes.complete();
        self.refill();
    }

    pub(crate) fn transmit_error(&mut self) {
        self.errors.transmit_error();
        self.end_failed_attempt();
    }

    pub(crate) fn not_acknowledged(&mut self) {
        self.errors.not_acknowledged();
        self.end_failed_attempt();
    }

    fn end_failed_attempt(&mut self) {
        self.counters.tx_errors += 1;
        self.release_wire();
    }

    /// The attempt ended without a verdict of the bus, as when the node is cut off.
    pub(crate) fn release_wire(&mut self) {
        if self.mailboxes.fail() {
            self.counters.tx_aborted += 1;
            self.refill();
        }
    }

    pub(crate) fn accepts(&self, frame: &Frame) -> bool {
        self.config.filter.accepts(frame)
    }

    /// Every correct frame counts, also one that the filter or the fault model keeps out of the FIFO.
    pub(crate) fn heard(&mut self) {
        self.errors.received();
    }

    pub(crate) fn receive_error(&mut self) {
        self.errors.receive_error();
        self.counters.rx_errors += 1;
    }

    pub(crate) fn drop_received(&mut self) {
        self.counters.rx_dropped += 1;
    }

    pub(crate) fn store_received(&mut self, frame: Frame) {
        let kept = self.received.push(frame);
        self.counters.rx_frames += u64::from(kept);
        self.counters.rx_overruns += u64::from(!kept);
    }

    pub(crate) fn pop_received(&mut self) -> Option<Frame> {
        self.received.pop()
    }
}

impl embedded_can::nb::Can for Controller {
    type Frame = Frame;
    type Error = ControllerError;

    /// Stores `frame` for transmission.
    ///
    /// # Errors
    /// `WouldBlock` when nothing was stored for want of room, `Other` when the controller is off or bus-off.
    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, ControllerError> {
        if let Err(error) = self.check_on_bus() {
            self.counters.tx_refused += 1;
            return Err(nb::Error::Other(error));
        }
        match self.place(*frame) {
            Placement::Stored => Ok(None),
            Placement::Displaced(evicted) => {
                self.counters.tx_displaced += 1;
                Ok(Some(evicted))
            }
            Placement::Full => {
                self.counters.tx_refused += 1;
                Err(nb::Error::WouldBlock)
            }
        }
    }

    /// Takes the oldest received frame. What was received before bus-off can still be read.
    ///
    /// # Errors
    /// `WouldBlock` when there is none, `Other` when there is none and the controller is off or bus-off.
    fn receive(&mut self) -> nb::Result<Frame, ControllerError> {
        match self.received.pop() {
            Some(frame) => Ok(frame),
            None => Err(self
                .check_on_bus()
                .map_or_else(nb::Error::Other, |()| nb::Error::WouldBlock)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::tests::standard;
    use embedded_can::nb::Can;

    fn bxcan(order: TxOrder) -> Controller {
        Controller::new(ControllerConfig::bxcan(order))
    }

    #[test]
    fn four_outcomes_by_identifier() {
        let mut controller = bxcan(TxOrder::ByIdentifier);
        for id in [0x30, 0x20, 0x40] {
            assert_eq!(controller.transmit(&standard(id, &[])), Ok(None));
        }
        assert_eq!(
            controller.transmit(&standard(0x41, &[])),
            Err(nb::Error::WouldBlock)
        );
        assert_eq!(
            controller.transmit(&standard(0x10, &[])),
            Ok(Some(standard(0x40, &[])))
        );
        (0..32).for_each(|_| controller.transmit_error());
        assert_eq!(
            controller.transmit(&standard(0x10, &[])),
            Err(nb::Error::Other(ControllerError::BusOff { tec: 256 }))
        );
        assert_eq!(
            (
                controller.counters().tx_refused,
                controller.counters().tx_displaced
            ),
            (2, 1)
        );
    }

    #[test]
    fn fifo_would_block_when_full() {
        let mut controller = bxcan(TxOrder::Fifo);
        for id in [0x30, 0x20, 0x40] {
            assert_eq!(controller.transmit(&standard(id, &[])), Ok(None));
        }
        assert_eq!(
            controller.transmit(&standard(0, &[])),
            Err(nb::Error::WouldBlock)
        );
    }

    #[test]
    fn off_refuses_and_forgets() {
        let mut controller = bxcan(TxOrder::Fifo);
        controller.transmit(&standard(1, &[])).unwrap();
        controller.switch(false);
        assert_eq!(controller.tx_pending(), 0);
        assert_eq!(
            controller.transmit(&standard(1, &[])),
            Err(nb::Error::Other(ControllerError::Off))
        );
        assert_eq!(
            controller.receive(),
            Err(nb::Error::Other(ControllerError::Off))
        );
    }

    #[test]
    fn unbounded_device_keeps_order() {
        let mut controller = Controller::new(ControllerConfig::device());
        for id in (0..10).rev() {
            assert_eq!(controller.transmit(&standard(id, &[])), Ok(None));
        }
        for id in (0..10).rev() {
            assert_eq!(controller.begin(), Some((standard(id, &[]), 1)));
            controller.transmitted();
        }
        assert_eq!(controller.tx_pending(), 0);
    }

    #[test]
    fn abort_counts_also_the_frame_that_fails_afterwards() {
        let mut controller = bxcan(TxOrder::Fifo);
        controller.transmit(&standard(1, &[])).unwrap();
        controller.transmit(&standard(2, &[])).unwrap();
        controller.begin();
        assert_eq!(controller.abort_all(), 1);
        assert!(controller.is_transmitting());
        controller.transmit_error();
        assert_eq!(
            (controller.tx_pending(), controller.counters().tx_aborted),
            (0, 2)
        );
    }
}
