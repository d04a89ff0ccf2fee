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

use core::future::poll_fn;
use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};
use core::task::Poll;

use can_motion::Progress;
use embassy_stm32::gpio::Flex;
use embassy_stm32::pac::can::vals::Lec;
use embassy_stm32::pac::can::{Can, regs};
use embassy_sync::waitqueue::AtomicWaker;

use super::{BusError, DRIVE_ERROR, FUNCTION_CODE_MASK};
use crate::frame::Frame;
use crate::recovery::{Cell, FaultState, Recovery};
use crate::transmit_places::{PLACES, TransmitPlaces};

const RECEIVE_FIFOS: usize = 2;
/// How often [`Bus::take_back`] looks whether the controller has given a frame up.
const ABORT_LOOKS: usize = 8;

/// Wakes the cycle when a frame has come in or a mailbox is free.
static TRAFFIC: AtomicWaker = AtomicWaker::new();
/// Errors on the bus since they were taken, and the code of the latest.
static ERRORS: AtomicU32 = AtomicU32::new(0);
static LATEST_ERROR: AtomicU8 = AtomicU8::new(Lec::NO_ERROR.to_bits());

/// Length of a bit in time quanta; synchronisation is one more.
pub(crate) struct BitTiming {
    /// Clocks of the controller in a quantum.
    pub(crate) prescaler: u16,
    /// Propagation and phase segment 1.
    pub(crate) segment_1: u8,
    /// Phase segment 2.
    pub(crate) segment_2: u8,
    /// Longest resynchronisation.
    pub(crate) jump_width: u8,
}

/// The controller, as the board has it.
pub(crate) struct Controller {
    /// Its registers.
    pub(crate) registers: Can,
    /// Resets it; its clock is on.
    pub(crate) reset: fn(),
    /// Its bit timing.
    pub(crate) timing: BitTiming,
    /// Its pins, connected to it. Held because a pin that is dropped is disconnected.
    pub(crate) _pins: [Flex<'static>; 2],
}

impl Controller {
    fn occupied(&self) -> [bool; PLACES] {
        let status = self.registers.tsr().read();
        core::array::from_fn(|mailbox| !status.tme(mailbox))
    }

    fn has_received(&self) -> bool {
        (0..RECEIVE_FIFOS).any(|fifo| self.registers.rfr(fifo).read().fmp() > 0)
    }

    /// The oldest frame of a FIFO.
    fn read(&self, fifo: usize) -> Frame {
        let mailbox = self.registers.rx(fifo);
        let frame = Frame::from_registers(
            mailbox.rir().read().stid(),
            mailbox.rdtr().read().dlc(),
            [mailbox.rdlr().read().0, mailbox.rdhr().read().0],
        );
        // Writing 0 to the marks of this register leaves them.
        self.registers.rfr(fifo).write(|fifo| fifo.set_rfom(true));
        frame
    }

    fn write(&self, mailbox: usize, frame: &Frame) {
        let mailbox = self.registers.tx(mailbox);
        let [low, high] = frame.words();
        mailbox
            .tdtr()
            .write(|control| control.set_dlc(frame.length()));
        mailbox.tdlr().write_value(regs::Tdlr(low));
        mailbox.tdhr().write_value(regs::Tdhr(high));
        mailbox.tir().write(|identifier| {
            identifier.set_stid(frame.standard_id());
            identifier.set_txrq(true);
        });
    }

    /// Nothing passes out of reset; extended and remote frames are not part of the protocol.
    fn set_filters(&self) {
        let Self { registers, .. } = self;
        registers.fmr().modify(|filters| filters.set_finit(true));
        // Mask mode, the first bank of 32 bits. An alarm passes both: a 32-bit filter goes before a 16-bit one (RM0090, section 32.7.4).
        registers.fm1r().write(|_| {});
        registers.fs1r().write(|scale| scale.set_fsc(0, true));
        // Alarms have a FIFO of their own, so that a burst of replies cannot push one out.
        registers.ffa1r().write(|fifos| fifos.set_ffa(0, true));
        for (bank, words) in [alarms(), others()].into_iter().enumerate() {
            registers.fb(bank).fr1().write_value(regs::Fr1(words[0]));
            registers.fb(bank).fr2().write_value(regs::Fr2(words[1]));
        }
        registers.fa1r().write(|active| {
            active.set_fact(0, true);
            active.set_fact(1, true);
        });
        registers.fmr().modify(|filters| filters.set_finit(false));
    }
}

impl Cell for Controller {
    fn reset(&mut self) {
        (self.reset)();
    }

    fn request_initialisation(&mut self) {
        self.registers.mcr().modify(|control| {
            control.set_sleep(false);
            control.set_inrq(true);
            // First in, first out: by identifier, a poll of a low drive would overtake the set-points of the higher ones.
            control.set_txfp(true);
            // A recovery by itself would send old set-points.
            control.set_abom(false);
            // Must stay off: ES0182, "bxCAN time-triggered communication mode not supported".
            control.set_ttcm(false);
        });
    }

    fn is_initialising(&self) -> bool {
        let status = self.registers.msr().read();
        status.inak() && !status.slak()
    }

    fn set_up_and_join(&mut self) {
        self.registers.btr().write(|timing| {
            timing.set_brp(self.timing.prescaler - 1);
            timing.set_ts(0, self.timing.segment_1 - 1);
            timing.set_ts(1, self.timing.segment_2 - 1);
            timing.set_sjw(self.timing.jump_width - 1);
        });
        self.set_filters();
        self.registers.ier().write_value(error_enables());
        self.registers
            .mcr()
            .modify(|control| control.set_inrq(false));
    }

    fn has_joined(&self) -> bool {
        let status = self.registers.msr().read();
        !status.inak() && !status.slak() && !self.is_bus_off()
    }

    fn is_bus_off(&self) -> bool {
        self.registers.esr().read().boff()
    }

    fn discard_pending(&mut self) {
        // Writing 0 to the other bits of this register changes nothing.
        self.registers.tsr().write(|tsr| {
            (0..PLACES).for_each(|mailbox| tsr.set_abrq(mailbox, true));
        });
    }

    fn is_empty(&self) -> bool {
        self.occupied() == [false; PLACES]
    }
}

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

/// The interrupts that are never switched off.
const fn error_enables() -> regs::Ier {
    /// LECIE and ERRIE.
    const LAST_ERROR_CODE: u32 = 1 << 11;
    const ERRORS: u32 = 1 << 15;
    regs::Ier(LAST_ERROR_CODE | ERRORS)
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

/// Alarm frames, in a 32-bit filter: identifier, then mask. The identifier has the 11 upper bits; the marks of extended and remote frames
/// must be clear.
const fn alarms() -> [u32; 2] {
    const EXTENDED_AND_REMOTE: u32 = 0b110;
    [
        (DRIVE_ERROR as u32) << 21,
        (FUNCTION_CODE_MASK as u32) << 21 | EXTENDED_AND_REMOTE,
    ]
}

/// All standard data frames, in two equal 16-bit filters: masks above identifiers. They look only at the marks of extended and remote
/// frames.
const fn others() -> [u32; 2] {
    const EXTENDED_AND_REMOTE: u32 = 0b11 << 3;
    [EXTENDED_AND_REMOTE << 16; 2]
}
