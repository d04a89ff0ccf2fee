//! The bus over bxCAN, the controller of the STM32F4, in its registers (RM0090, section 32.9).
//!
//! An adapter of its own: the vendor's driver waits in its constructor for recessive bits that never come on a bus that is held dominant,
//! switches the time-triggered mode on, which must stay off (ES0182), and shows one error where there were many.
//!
//! # Interrupts
//!
//! Those of frames have the priority of the cycle, so neither interrupts the other, and the enable register has one writer at a time:
//! the handler switches them off and wakes the cycle, which switches them on when it waits again. The one of errors may come at any
//! time: it touches nothing but the marks of errors.

mod controller;

use core::future::poll_fn;
use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};
use core::task::Poll;

use can_motion::Progress;
use embassy_stm32::pac::can::Can;
use embassy_stm32::pac::can::vals::Lec;
use embassy_sync::waitqueue::AtomicWaker;

use super::BusError;
use crate::frame::Frame;
use crate::recovery::{Cell, FaultState, Recovery};
use crate::transmit_places::{PLACES, TransmitPlaces};
pub(crate) use controller::Controller;
use controller::{RECEIVE_FIFOS, error_enables};

/// How often [`Bus::take_back`] looks whether the controller has given a frame up.
const ABORT_LOOKS: usize = 8;

/// Wakes the cycle when a frame has come in or a mailbox is free.
static TRAFFIC: AtomicWaker = AtomicWaker::new();
/// Errors on the bus since they were taken, and the code of the latest.
static ERRORS: AtomicU32 = AtomicU32::new(0);
static LATEST_ERROR: AtomicU8 = AtomicU8::new(Lec::NO_ERROR.to_bits());

/// The bus with its controller.
pub(crate) struct Bus {
    controller: Controller,
    recovery: Recovery,
    places: TransmitPlaces<Frame>,
}

impl Bus {
    /// A controller that nobody has touched yet: [`Self::recover`] brings it onto the bus.
    pub(crate) const fn new(controller: Controller) -> Self {
        Self {
            controller,
            recovery: Recovery::new(),
            places: TransmitPlaces::new(),
        }
    }

    /// Waits until servicing the bus again has a purpose: until a received frame can be read or, when a frame waits for
    /// room, until a mailbox is free. Cancelling it loses nothing.
    pub(crate) async fn serviceable(&mut self, progress: Progress) {
        let is_blocked = progress == Progress::Blocked;
        let controller = &self.controller;
        poll_fn(|context| {
            TRAFFIC.register(context.waker());
            let has_room = || controller.occupied() != [true; PLACES];
            if controller.has_received() || is_blocked && has_room() {
                return Poll::Ready(());
            }
            let mut enables = error_enables();
            (0..RECEIVE_FIFOS).for_each(|fifo| enables.set_fmpie(fifo, true));
            enables.set_tmeie(is_blocked);
            controller.registers.ier().write_value(enables);
            Poll::Pending
        })
        .await;
    }

    /// Looks after the frames in the mailboxes, once a cycle, and tells the state of the controller.
    pub(crate) fn check(&mut self) -> FaultState {
        if self.places.pass_cycle(self.controller.occupied()) {
            self.recovery.give_up(&mut self.controller);
        }
        let errors = self.controller.registers.esr().read();
        self.recovery.fault_state(errors.boff(), errors.epvf())
    }

    /// How many errors there were on the bus since the last call.
    pub(crate) fn take_error_count(&mut self) -> u32 {
        ERRORS.swap(0, Ordering::Relaxed)
    }

    /// Takes back the frame that was queued last. The one that goes next stays: it may be on the wire already, and what became of it
    /// could not be told. So at most one frame goes out after the last that comes back.
    pub(crate) fn take_back(&mut self) -> Option<Frame> {
        let occupied = self.controller.occupied();
        let (mailbox, frame) = self.places.last_behind_another(occupied)?;
        let status = self.controller.registers.tsr();
        // Writing 0 to the other bits of this register changes nothing.
        status.write(|tsr| tsr.set_abrq(mailbox, true));
        // A frame that waits is given up within a few clocks; one that has come onto the wire in this very moment is not.
        (0..ABORT_LOOKS)
            .map(|_| status.read())
            .find(|status| status.tme(mailbox))
            .filter(|status| !status.txok(mailbox))?;
        Some(frame)
    }

    /// One step onto the bus, at the start and after a failure, to be called every cycle until it returns `Ok`; `Ok` at once when there
    /// is nothing to do. Frames still in the mailboxes are thrown away: nobody knows which of them went out.
    pub(crate) fn recover(&mut self) -> nb::Result<(), core::convert::Infallible> {
        self.recovery.step(&mut self.controller)
    }
}

impl embedded_can::nb::Can for Bus {
    type Frame = Frame;
    type Error = BusError;

    /// Queues a frame in a free mailbox, to go out after those already there; none is ever displaced.
    ///
    /// `WouldBlock`: all mailboxes are taken, nothing was queued. `BusOff`: the controller is down, nothing was queued either.
    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, BusError> {
        if !self.recovery.is_over() || self.controller.is_bus_off() {
            return Err(nb::Error::Other(BusError::BusOff));
        }
        let occupied = self.controller.occupied();
        let free = (0..).zip(occupied).find(|(_, occupied)| !occupied);
        let Some((mailbox, _)) = free else {
            return Err(nb::Error::WouldBlock);
        };
        self.controller.write(mailbox, frame);
        self.places.note_queued(mailbox, *frame);
        Ok(None)
    }

    /// The oldest received frame, replies first. Errors come once each and interleaved; read on until `WouldBlock`.
    fn receive(&mut self) -> nb::Result<Frame, BusError> {
        for fifo in 0..RECEIVE_FIFOS {
            let marks = self.controller.registers.rfr(fifo);
            let status = marks.read();
            if status.fovr() {
                marks.write(|fifo| fifo.set_fovr(true));
                return Err(nb::Error::Other(BusError::Overrun(fifo)));
            }
            if status.fmp() > 0 {
                return Ok(self.controller.read(fifo));
            }
        }
        let code = LATEST_ERROR.swap(Lec::NO_ERROR.to_bits(), Ordering::Relaxed);
        match BusError::from_code(code) {
            Some(error) => Err(nb::Error::Other(error)),
            None => Err(nb::Error::WouldBlock),
        }
    }
}

/// A frame has come in, or a mailbox is free: for the interrupts of the transmitter and of both FIFOs, at the priority of the cycle.
pub(crate) fn on_traffic(registers: Can) {
    registers.ier().write_value(error_enables());
    TRAFFIC.wake();
}

/// There was an error: for the interrupt of status changes.
pub(crate) fn on_error(registers: Can) {
    let code = registers.esr().read().lec();
    // So that the same error sets it again; the other bits of this register are read-only.
    registers
        .esr()
        .write(|errors| errors.set_lec(Lec::NO_ERROR));
    // Writing 0 to the other marks of this register leaves them.
    registers.msr().write(|status| status.set_erri(true));
    if code != Lec::NO_ERROR {
        ERRORS.fetch_add(1, Ordering::Relaxed);
        LATEST_ERROR.store(code.to_bits(), Ordering::Relaxed);
    }
}
