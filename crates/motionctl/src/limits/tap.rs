//! A controller that notes in which cycle each frame was handed over.

use std::collections::VecDeque;

use drive_sim::{ControllerError, Frame, Port};
use embedded_can::nb::Can;

/// The cycles of the frames that the controller holds, oldest first: its mailboxes send them in this order.
#[derive(Debug, Default)]
pub(crate) struct HandedOver(VecDeque<u64>);

impl HandedOver {
    /// The cycle in which the frame was handed over that has just gone out.
    pub(crate) fn sent(&mut self) -> Option<u64> {
        self.0.pop_front()
    }
}

/// The port of the master in one cycle.
pub(crate) struct Tap<'a> {
    pub(crate) port: Port<'a>,
    pub(crate) handed_over: &'a mut HandedOver,
    pub(crate) cycle: u64,
}

impl Can for Tap<'_> {
    type Frame = Frame;
    type Error = ControllerError;

    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, ControllerError> {
        let displaced = self.port.transmit(frame)?;
        self.handed_over.0.push_back(self.cycle);
        Ok(displaced)
    }

    fn receive(&mut self) -> nb::Result<Frame, ControllerError> {
        self.port.receive()
    }
}
