//! The only place that touches a CAN driver.

use embedded_can::Error as _;
use embedded_can::nb::Can;

use crate::bus_user::{BusFrame, BusUser};
use crate::event::BusErrorKind;
use crate::time::Instant;

/// What is left to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[must_use]
pub enum Progress {
    /// Every frame of this cycle is with the controller; come back with the next frame or the next cycle.
    Idle,
    /// A frame waits for room; come back as soon as the controller has sent one.
    Blocked,
}

/// Hands what came in to the user of the bus, usually the [`Master`](crate::Master), and what it wants sent to the
/// controller.
///
/// All four outcomes of [`Can::transmit`] are entered in the books: accepted, accepted and another frame displaced, no
/// room, error. Never waits.
pub fn service<U: BusUser, C: Can>(user: &mut U, can: &mut C, now: Instant) -> Progress {
    receive(user, can, now);
    transmit(user, can, now)
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

fn transmit<U: BusUser, C: Can>(user: &mut U, can: &mut C, now: Instant) -> Progress {
    while let Some(outgoing) = user.next_frame() {
        let Some(frame) = outgoing.as_ref().to_can::<C::Frame>() else {
            user.on_transmit_error(now, &outgoing, BusErrorKind::Other);
            return Progress::Idle;
        };
        match can.transmit(&frame) {
            Ok(None) => user.on_accepted(now, &outgoing),
            Ok(Some(displaced)) => {
                user.on_accepted(now, &outgoing);
                match U::Frame::from_can(&displaced) {
                    Ok(displaced) => user.on_displaced(now, &displaced),
                    Err(error) => user.on_foreign_frame(now, error),
                }
            }
            Err(nb::Error::WouldBlock) => return Progress::Blocked,
            Err(nb::Error::Other(error)) => {
                user.on_transmit_error(now, &outgoing, BusErrorKind::from(error.kind()));
                return Progress::Idle;
            }
        }
    }
    Progress::Idle
}
