//! The front end for `embedded_can::nb::Can`: the only place that touches a CAN driver.

use embedded_can::Error as _;
use embedded_can::nb::Can;

use crate::error::BusErrorKind;
use crate::sink::{BusFrame, BusUser, Outcome, Progress, Sink};
use crate::time::Instant;

/// Hands what came in to the user of the bus, and what it wants sent to the controller.
///
/// All four outcomes of [`Can::transmit`] reach the ledger: accepted, accepted and another frame displaced, no room, error. Never
/// waits.
pub fn service<U: BusUser, C: Can>(user: &mut U, can: &mut C, now: Instant) -> Progress {
    service_taking_back(user, can, now, |_| None)
}

/// As [`service`], for a driver that can take a frame back which waits unsent in its controller: see [`Sink::take_back`].
pub fn service_taking_back<U: BusUser, C: Can>(
    user: &mut U,
    can: &mut C,
    now: Instant,
    take_back: fn(&mut C) -> Option<C::Frame>,
) -> Progress {
    receive(user, can, now);
    let mut sink = CanSink {
        can,
        take_back,
        foreign: None::<<U::Frame as BusFrame>::Error>,
    };
    let progress = user.send(now, &mut sink);
    if let Some(error) = sink.foreign {
        user.on_foreign_frame(now, error);
    }
    progress
}

fn receive<U: BusUser, C: Can>(user: &mut U, can: &mut C, now: Instant) {
    loop {
        match can.receive() {
            Ok(frame) => match U::Frame::from_can(&frame) {
                Ok(frame) => user.on_frame(now, &frame),
                Err(error) => user.on_foreign_frame(now, error),
            },
            Err(nb::Error::WouldBlock) => return,
            Err(nb::Error::Other(error)) => {
                // The next call continues; a driver that reports the same error for ever must not hold the cycle.
                user.on_receive_error(now, BusErrorKind::from(error.kind()));
                return;
            }
        }
    }
}

/// A driver as a sink.
struct CanSink<'a, C: Can, E> {
    can: &'a mut C,
    take_back: fn(&mut C) -> Option<C::Frame>,
    /// Why a frame that the driver gave back is of another protocol.
    foreign: Option<E>,
}

impl<C: Can, E> CanSink<'_, C, E> {
    /// A frame that the driver gave back; one of another protocol is remembered.
    fn ours<Fr: BusFrame<Error = E>>(&mut self, frame: &C::Frame) -> Option<Fr> {
        Fr::from_can(frame)
            .map_err(|error| self.foreign = Some(error))
            .ok()
    }
}

impl<C: Can, Fr: BusFrame> Sink<Fr> for CanSink<'_, C, Fr::Error> {
    fn offer(&mut self, frame: &Fr) -> Outcome<Fr> {
        let Some(frame) = frame.to_can::<C::Frame>() else {
            return Outcome::Failed(BusErrorKind::Other);
        };
        match self.can.transmit(&frame) {
            Ok(None) => Outcome::Accepted,
            Ok(Some(displaced)) => match self.ours(&displaced) {
                Some(displaced) => Outcome::Displaced(displaced),
                None => Outcome::Accepted,
            },
            Err(nb::Error::WouldBlock) => Outcome::Full,
            Err(nb::Error::Other(error)) => Outcome::Failed(BusErrorKind::from(error.kind())),
        }
    }

    fn take_back(&mut self) -> Option<Fr> {
        let frame = (self.take_back)(self.can)?;
        self.ours(&frame)
    }
}
