//! The controller as the master sees it, with a record of every outcome.

use drive_sim::Frame;
use embedded_can::nb::Can;

/// One outcome at the border between master and controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Note {
    /// The controller took the frame.
    Accepted(Frame),
    /// The controller gave the frame back to make room for the one noted just before.
    Displaced(Frame),
    /// The controller failed while it took a frame.
    SendFailed,
    /// The master read the frame.
    Received(Frame),
}

/// An adapter that changes nothing and notes everything.
#[derive(Debug)]
pub(super) struct Tap<'a, C> {
    inner: C,
    notes: &'a mut Vec<Note>,
}

impl<'a, C> Tap<'a, C> {
    /// Notes what passes between the user of this adapter and `inner`.
    pub(super) fn new(inner: C, notes: &'a mut Vec<Note>) -> Self {
        Self { inner, notes }
    }
}

impl<C: Can<Frame = Frame>> Can for Tap<'_, C> {
    type Frame = Frame;
    type Error = C::Error;

    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, C::Error> {
        let outcome = self.inner.transmit(frame);
        match &outcome {
            Ok(displaced) => {
                self.notes.push(Note::Accepted(*frame));
                self.notes.extend(displaced.map(Note::Displaced));
            }
            Err(nb::Error::Other(_)) => self.notes.push(Note::SendFailed),
            Err(nb::Error::WouldBlock) => {}
        }
        outcome
    }

    fn receive(&mut self) -> nb::Result<Frame, C::Error> {
        let outcome = self.inner.receive();
        self.notes
            .extend(outcome.as_ref().ok().copied().map(Note::Received));
        outcome
    }
}
