//! The bus over bxCAN, the controller of the STM32F4, in its registers (RM0090, section 32.9).
//!
//! An adapter of its own: the vendor's driver waits in its constructor for recessive bits that never come on a bus that is held dominant,
//! switches the time-triggered mode on, which must stay off (ES0182), and shows one error where there were many.
//!
//! # Interrupts
//!
//! Those of frames have the priority of the cycle, so neither interrupts the other, and the enable register has one writer at a time.
//! They last until the cause is gone: a frame that waits to be read, or a free mailbox while one waits to be sent. The one of errors may
//! come at any time: it touches nothing but the marks of errors.

mod controller;

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

use can_motion::{BusErrorKind, Outcome, Progress, Sink};
use dyn_can::DataFrame;
use embassy_stm32::pac::can::Can;
use embassy_stm32::pac::can::vals::Lec;

use super::error_of_code;
use crate::recovery::{Cell, FaultState, Recovery};
use crate::transmit_places::TransmitPlaces;
pub(crate) use controller::Controller;
use controller::{RECEIVE_FIFOS, error_enables};

/// How often [`Bus::take_back`] looks whether the controller has given a frame up.
const ABORT_LOOKS: usize = 8;

/// Errors on the bus since they were taken, and the code of the latest.
static ERRORS: AtomicU32 = AtomicU32::new(0);
static LATEST_ERROR: AtomicU8 = AtomicU8::new(Lec::NO_ERROR.to_bits());

/// The bus with its controller.
pub(crate) struct Bus {
    controller: Controller,
    recovery: Recovery,
    places: TransmitPlaces,
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

    /// To be called before the bus is looked after.
    pub(crate) const fn begin_service(&mut self) {}

    /// The bus was looked after; enables the interrupts that ask for the next time.
    pub(crate) fn end_service(&mut self, progress: Progress) {
        let mut enables = error_enables();
        (0..RECEIVE_FIFOS).for_each(|fifo| enables.set_fmpie(fifo, true));
        enables.set_tmeie(progress == Progress::Blocked);
        self.controller.registers.ier().write_value(enables);
    }

    /// Whether there may be something to receive.
    #[inline(always)]
    pub(crate) fn has_news(&self) -> bool {
        self.controller.has_received()
            || LATEST_ERROR.load(Ordering::Relaxed) != Lec::NO_ERROR.to_bits()
    }

    /// The oldest received frame, replies first. Errors come once each and interleaved.
    pub(crate) fn receive(&mut self) -> Option<Result<DataFrame, BusErrorKind>> {
        for fifo in 0..RECEIVE_FIFOS {
            let marks = self.controller.registers.rfr(fifo);
            let status = marks.read();
            if status.fovr() {
                marks.write(|fifo| fifo.set_fovr(true));
                return Some(Err(BusErrorKind::Overrun));
            }
            if status.fmp() > 0 {
                return Some(Ok(self.controller.read(fifo)));
            }
        }
        let code = LATEST_ERROR.swap(Lec::NO_ERROR.to_bits(), Ordering::Relaxed);
        error_of_code(code).map(Err)
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

    /// One step onto the bus, at the start and after a failure, to be called every cycle until it returns true: at once when there is
    /// nothing to do. Frames still in the mailboxes are thrown away: nobody knows which of them went out.
    pub(crate) fn recover(&mut self) -> bool {
        self.recovery.step(&mut self.controller)
    }
}

impl Sink<DataFrame> for Bus {
    #[inline(always)]
    fn has_room(&self) -> bool {
        self.controller.free_mailbox().is_some()
    }

    /// Queues a frame in a free mailbox, to go out after those already there; none is ever displaced.
    #[inline(always)]
    fn offer(&mut self, frame: &DataFrame) -> Outcome<DataFrame> {
        if !self.recovery.is_over() || self.controller.is_bus_off() {
            return Outcome::Failed(BusErrorKind::Other);
        }
        let Some(mailbox) = self.controller.free_mailbox() else {
            return Outcome::Full;
        };
        self.controller.write(mailbox, frame);
        self.places.note_queued(mailbox);
        Outcome::Accepted
    }

    /// Takes back the frame that was queued last. The one that goes next stays: it may be on the wire already, and what became of it
    /// could not be told. So at most one frame goes out after the last that comes back.
    fn take_back(&mut self) -> Option<DataFrame> {
        let occupied = self.controller.occupied();
        let mailbox = self.places.last_behind_another(occupied)?;
        let frame = self.controller.queued(mailbox);
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
