//! The bus over FDCAN in classic mode, the controller of the STM32G4, in its registers and its message memory (RM0440, section 44).
//!
//! An adapter of its own: the vendor's driver reads the protocol status at every look for a frame, each of which forgets the last error,
//! so that most errors were never counted; and it cannot be brought back from bus-off with an empty transmit FIFO.
//!
//! # Interrupts
//!
//! Line 0 has the priority of the cycle, so neither interrupts the other, and the enable register has one writer at a time: the
//! handler switches everything off and wakes the cycle, which switches on what it waits for.

mod controller;

use core::future::poll_fn;
use core::task::Poll;

use can_motion::Progress;
use embassy_stm32::pac::can::{Fdcan, regs};
use embassy_sync::waitqueue::AtomicWaker;

use super::BusError;
use crate::frame::Frame;
use crate::recovery::{Cell, FaultState, Recovery};
use crate::transmit_places::{PLACES, TransmitPlaces};
pub(crate) use controller::Controller;
use controller::RECEIVE_FIFOS;

/// Wakes the cycle when a frame has come in or a place is free.
static TRAFFIC: AtomicWaker = AtomicWaker::new();

/// The bus with its controller.
pub(crate) struct Bus {
    controller: Controller,
    recovery: Recovery,
    places: TransmitPlaces<()>,
    latest_error: Option<BusError>,
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

    /// Waits until servicing the bus again has a purpose: until a received frame can be read or, when a frame waits for
    /// room, until a place is free. Cancelling it loses nothing.
    pub(crate) async fn serviceable(&mut self, progress: Progress) {
        let is_blocked = progress == Progress::Blocked;
        let controller = &self.controller;
        let registers = controller.registers;
        poll_fn(|context| {
            TRAFFIC.register(context.waker());
            // A mark that comes after this stays until the next look.
            let mut marks = regs::Ir(0);
            (0..RECEIVE_FIFOS).for_each(|fifo| marks.set_rfn(fifo, true));
            marks.set_tc(true);
            registers.ir().write_value(marks);
            let has_room = || !registers.txfqs().read().tfqf();
            if controller.has_received() || is_blocked && has_room() {
                return Poll::Ready(());
            }
            registers.ie().write(|enables| {
                (0..RECEIVE_FIFOS).for_each(|fifo| enables.set_rfne(fifo, true));
                enables.set_tce(is_blocked);
            });
            Poll::Pending
        })
        .await;
    }

    /// Looks after the frames that wait, once a cycle, and tells the state of the controller.
    pub(crate) fn check(&mut self) -> FaultState {
        let status = self.controller.registers.psr().read();
        self.controller.status = status;
        // Each counts up to 255 and is cleared by reading it.
        let counters = self.controller.registers.ecr().read();
        let latest = BusError::from_code(status.lec().to_bits());
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

    /// Takes nothing back: this controller cannot cancel single frames of its FIFO (RM0440, section 44.3.6). The three frames that it
    /// holds still go out.
    pub(crate) const fn take_back(&mut self) -> Option<Frame> {
        None
    }

    /// One step onto the bus, at the start and after a failure, to be called every cycle after [`Self::check`] until it returns `Ok`; `Ok`
    /// at once when there is nothing to do. Frames that still wait are thrown away: nobody knows which of them went out.
    pub(crate) fn recover(&mut self) -> nb::Result<(), core::convert::Infallible> {
        self.recovery.step(&mut self.controller)
    }
}

impl embedded_can::nb::Can for Bus {
    type Frame = Frame;
    type Error = BusError;

    /// Queues a frame in a free place, to go out after those already there; none is ever displaced.
    ///
    /// `WouldBlock`: all places are taken, nothing was queued. `BusOff`: the controller is down, nothing was queued either.
    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, BusError> {
        if !self.recovery.is_over() || self.controller.is_bus_off() {
            return Err(nb::Error::Other(BusError::BusOff));
        }
        let queue = self.controller.registers.txfqs().read();
        let place = usize::from(queue.tfqpi());
        if queue.tfqf() || place >= PLACES {
            return Err(nb::Error::WouldBlock);
        }
        self.controller.write(place, frame);
        self.places.note_queued(place, ());
        Ok(None)
    }

    /// The oldest received frame, replies first. Errors come once each and interleaved; read on until `WouldBlock`.
    fn receive(&mut self) -> nb::Result<Frame, BusError> {
        let marks = self.controller.registers.ir();
        for fifo in 0..RECEIVE_FIFOS {
            if marks.read().rfl(fifo) {
                // Writing 0 to the other marks of this register leaves them.
                marks.write(|marks| marks.set_rfl(fifo, true));
                return Err(nb::Error::Other(BusError::Overrun(fifo)));
            }
            if self.controller.registers.rxfs(fifo).read().ffl() > 0 {
                return Ok(self.controller.read(fifo));
            }
        }
        match self.latest_error.take() {
            Some(error) => Err(nb::Error::Other(error)),
            None => Err(nb::Error::WouldBlock),
        }
    }
}

/// A frame has come in, or a place is free: for the interrupt of line 0, at the priority of the cycle.
pub(crate) fn on_traffic(registers: Fdcan) {
    registers.ie().write_value(regs::Ie(0));
    TRAFFIC.wake();
}
