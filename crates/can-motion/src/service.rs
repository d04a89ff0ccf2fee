//! The only place that touches a CAN driver.

use dyn_can::DataFrame;
use embedded_can::Error as _;
use embedded_can::nb::Can;

use crate::event::BusErrorKind;
use crate::master::Master;
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

/// Hands what came in to the master, and what the master wants sent to the controller.
///
/// All four outcomes of [`Can::transmit`] are entered in the books: accepted, accepted and another frame displaced, no
/// room, error. Never waits.
pub fn service<const N: usize, C: Can>(
    master: &mut Master<N>,
    can: &mut C,
    now: Instant,
) -> Progress {
    receive(master, can, now);
    transmit(master, can, now)
}

fn receive<const N: usize, C: Can>(master: &mut Master<N>, can: &mut C, now: Instant) {
    loop {
        match can.receive() {
            Ok(frame) => match DataFrame::from_can(&frame) {
                Ok(frame) => master.on_frame(now, &frame),
                Err(error) => master.on_foreign_frame(now, error),
            },
            Err(nb::Error::WouldBlock) => return,
            Err(nb::Error::Other(error)) => {
                // The next call continues; a driver that reports the same error for ever must not hold the cycle.
                master.on_receive_error(now, BusErrorKind::from(error.kind()));
                return;
            }
        }
    }
}

fn transmit<const N: usize, C: Can>(master: &mut Master<N>, can: &mut C, now: Instant) -> Progress {
    while let Some(outgoing) = master.next_frame() {
        let Some(frame) = outgoing.frame().to_can::<C::Frame>() else {
            master.on_transmit_error(now, &outgoing, BusErrorKind::Other);
            return Progress::Idle;
        };
        match can.transmit(&frame) {
            Ok(None) => master.on_accepted(now, &outgoing),
            Ok(Some(displaced)) => {
                master.on_accepted(now, &outgoing);
                match DataFrame::from_can(&displaced) {
                    Ok(displaced) => master.on_displaced(now, &displaced),
                    Err(error) => master.on_foreign_frame(now, error),
                }
            }
            Err(nb::Error::WouldBlock) => return Progress::Blocked,
            Err(nb::Error::Other(error)) => {
                master.on_transmit_error(now, &outgoing, BusErrorKind::from(error.kind()));
                return Progress::Idle;
            }
        }
    }
    Progress::Idle
}
