//! The bus over FDCAN in classic mode, the controller of the STM32G4, in its registers and its message memory (RM0440, section 44).
//!
//! An adapter of its own: the vendor's driver reads the protocol status at every look for a frame, each of which forgets the last error,
//! so that most errors were never counted; and it cannot be brought back from bus-off with an empty transmit FIFO.
//!
//! # Interrupts
//!
//! Line 0 has the priority of the cycle, so neither interrupts the other, and the enable register has one writer at a time.

mod controller;

use can_motion::{BusErrorKind, Outcome, Progress, Sink};
use dyn_can::DataFrame;
use embassy_stm32::pac::can::regs;

use super::error_of_code;
use crate::recovery::{Cell, FaultState, Recovery};
use crate::transmit_places::{PLACES, TransmitPlaces};
pub(crate) use controller::Controller;
use controller::RECEIVE_FIFOS;

/// RF0N and RF1N: a frame has come in; the bits of the enable register are the same (RM0440, sections 44.4.16 and 44.4.17).
const RECEIVED: u32 = 1 << 0 | 1 << 3;
/// RF0L and RF1L: a FIFO was full when a frame came.
const LOST: u32 = 1 << 2 | 1 << 5;
/// TC: a frame has gone out.
const TRANSMITTED: u32 = 1 << 7;

/// The bus with its controller.
pub(crate) struct Bus {
    controller: Controller,
    recovery: Recovery,
    places: TransmitPlaces,
    latest_error: Option<BusErrorKind>,
    errors: u32,
}

impl Bus {
    /// A controller that nobody has touched yet: [`Self::recover`] brings it onto the bus.
    pub(crate) const fn new(controller: Controller) -> Self {
        Self {
            controller,
            recovery: Recovery::new(),
            places: TransmitPlaces::new(),
            latest_error: None,
            errors: 0,
        }
    }

    /// To be called before the bus is looked after: a mark that comes after this stays until the next time.
    pub(crate) fn begin_service(&mut self) {
        let marks = regs::Ir(RECEIVED | TRANSMITTED);
        self.controller.registers.ir().write_value(marks);
    }

    /// The bus was looked after; enables the interrupts that ask for the next time. What has come since [`Self::begin_service`] has left
    /// its mark, which interrupts at once.
    pub(crate) fn end_service(&mut self, progress: Progress) {
        let mut enables = regs::Ie(RECEIVED);
        enables.set_tce(progress == Progress::Blocked);
        self.controller.registers.ie().write_value(enables);
    }

    /// Whether there may be something to receive.
    #[inline(always)]
    pub(crate) fn has_news(&self) -> bool {
        self.controller.has_received() || self.latest_error.is_some()
    }

    /// The oldest received frame, replies first. Errors come once each, before the frames.
    pub(crate) fn receive(&mut self) -> Option<Result<DataFrame, BusErrorKind>> {
        let marks = self.controller.registers.ir();
        let lost = marks.read().0 & LOST;
        if lost != 0 {
            // One of them; writing 0 to the other marks of this register leaves them.
            marks.write_value(regs::Ir(lost & lost.wrapping_neg()));
            return Some(Err(BusErrorKind::Overrun));
        }
        for fifo in 0..RECEIVE_FIFOS {
            if let Some(frame) = self.controller.read(fifo) {
                return Some(Ok(frame));
            }
        }
        self.latest_error.take().map(Err)
    }

    /// Looks after the frames that wait, once a cycle, and tells the state of the controller.
    pub(crate) fn check(&mut self) -> FaultState {
        let status = self.controller.registers.psr().read();
        self.controller.status = status;
        // Each counts up to 255 and is cleared by reading it.
        let counters = self.controller.registers.ecr().read();
        let latest = error_of_code(status.lec().to_bits());
        let counted = u32::from(counters.cel());
        self.errors += counted.max(u32::from(latest.is_some()));
        self.latest_error = latest.or(self.latest_error);
        if self.places.pass_cycle(self.controller.occupied()) {
            self.recovery.give_up(&mut self.controller);
        }
        self.recovery.fault_state(status.bo(), status.ep())
    }

    /// How many errors there were on the bus since the last call.
    pub(crate) fn take_error_count(&mut self) -> u32 {
        core::mem::take(&mut self.errors)
    }

    /// One step onto the bus, at the start and after a failure, to be called every cycle after [`Self::check`] until it returns true: at
    /// once when there is nothing to do. Frames that still wait are thrown away: nobody knows which of them went out.
    pub(crate) fn recover(&mut self) -> bool {
        self.recovery.step(&mut self.controller)
    }
}

/// Takes nothing back: this controller cannot cancel single frames of its FIFO (RM0440, section 44.3.6). The three frames that it holds
/// still go out.
impl Sink<DataFrame> for Bus {
    #[inline(always)]
    fn has_room(&self) -> bool {
        !self.controller.registers.txfqs().read().tfqf()
    }

    /// Queues a frame in a free place, to go out after those already there; none is ever displaced.
    #[inline(always)]
    fn offer(&mut self, frame: &DataFrame) -> Outcome<DataFrame> {
        if !self.recovery.is_over() || self.controller.is_bus_off() {
            return Outcome::Failed(BusErrorKind::Other);
        }
        let queue = self.controller.registers.txfqs().read();
        let place = usize::from(queue.tfqpi());
        if queue.tfqf() || place >= PLACES {
            return Outcome::Full;
        }
        self.controller.write(place, frame);
        self.places.note_queued(place);
        Outcome::Accepted
    }
}
