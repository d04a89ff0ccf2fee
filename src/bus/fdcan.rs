//! The bus over FDCAN in classic mode, the controller of the STM32G4, in its registers and its message memory (RM0440, section 44).
//!
//! An adapter of its own: the vendor's driver reads the protocol status at every look for a frame, each of which forgets the last error,
//! so that most errors were never counted; and it cannot be brought back from bus-off with an empty transmit FIFO.
//!
//! # Interrupts
//!
//! Line 0 has the priority of the cycle, so neither interrupts the other, and the enable register has one writer at a time: the
//! handler switches everything off and wakes the cycle, which switches on what it waits for.

use core::future::poll_fn;
use core::task::Poll;

use can_motion::Progress;
use embassy_stm32::gpio::Flex;
use embassy_stm32::pac::can::vals::{Act, Anfe, Anfs, Tfqm};
use embassy_stm32::pac::can::{Fdcan, regs};
use embassy_stm32::pac::fdcanram::Fdcanram;
use embassy_sync::waitqueue::AtomicWaker;

use super::{BusError, DRIVE_ERROR, FUNCTION_CODE_MASK};
use crate::frame::Frame;
use crate::misbehaviour::{self, Fault};
use crate::recovery::{Cell, FaultState, Recovery};
use crate::transmit_places::{PLACES, TransmitPlaces};

const RECEIVE_FIFOS: usize = 2;
/// Frames in each receive FIFO.
const RECEIVE_DEPTH: usize = 3;
/// Words of the message memory in an element of a FIFO (RM0440, section 44.3.7).
const ELEMENT_WORDS: usize = 18;
/// Words of a frame there: two of header, two of data.
const FRAME_WORDS: usize = 4;
const FILTERS: u8 = 2;

/// Wakes the cycle when a frame has come in or a place is free.
static TRAFFIC: AtomicWaker = AtomicWaker::new();

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
    pub(crate) registers: Fdcan,
    /// Its message memory.
    pub(crate) memory: Fdcanram,
    /// Resets it; its clock is on.
    pub(crate) reset: fn(),
    /// Its bit timing.
    pub(crate) timing: BitTiming,
    /// Its pins, connected to it. Held because a pin that is dropped is disconnected.
    pub(crate) _pins: [Flex<'static>; 2],
    /// The protocol status as it was read last, once a cycle: reading it clears the last error code.
    pub(crate) status: regs::Psr,
}

impl Controller {
    fn occupied(&self) -> [bool; PLACES] {
        let pending = self.registers.txbrp().read();
        core::array::from_fn(|place| pending.trp(place))
    }

    fn has_received(&self) -> bool {
        (0..RECEIVE_FIFOS).any(|fifo| self.registers.rxfs(fifo).read().ffl() > 0)
    }

    /// The oldest frame of a FIFO.
    fn read(&self, fifo: usize) -> Frame {
        let element = self.registers.rxfs(fifo).read().fgi();
        let first = usize::from(element).min(RECEIVE_DEPTH - 1) * ELEMENT_WORDS;
        let [header, control, low, high] = core::array::from_fn(|word: usize| {
            let at = first + word.min(FRAME_WORDS - 1);
            match fifo {
                0 => self.memory.rxfifo0(at).read(),
                _ => self.memory.rxfifo1(at).read(),
            }
        });
        self.registers
            .rxfa(fifo)
            .write(|acknowledge| acknowledge.set_fai(element));
        Frame::from_registers(
            (header >> 18 & 0x7FF) as u16,
            (control >> 16 & 0xF) as u8,
            [low, high],
        )
    }

    fn write(&self, place: usize, frame: &Frame) {
        let first = place.min(PLACES - 1) * ELEMENT_WORDS;
        let [low, high] = frame.words();
        // A classic frame with a standard identifier, without an event when it has gone out.
        let words = [
            u32::from(frame.standard_id()) << 18,
            u32::from(frame.length()) << 16,
            low,
            high,
        ];
        for (word, value) in words.into_iter().enumerate() {
            self.memory.txbuf(first + word).write_value(value);
        }
        self.registers.txbar().write(|add| add.set_ar(place, true));
    }

    /// Alarm frames to a FIFO of their own, so that a burst of replies cannot push one out; all other standard data frames to the
    /// other. The first filter that matches decides.
    fn set_filters(&self) {
        const MASK: u32 = 0b10 << 30;
        const RANGE: u32 = 0;
        const TO_FIFO_0: u32 = 0b001 << 27;
        const TO_FIFO_1: u32 = 0b010 << 27;
        let alarms = u32::from(DRIVE_ERROR) << 16 | u32::from(FUNCTION_CODE_MASK);
        let all_identifiers = 0x7FF;
        let filters = [
            MASK | TO_FIFO_1 | alarms,
            RANGE | TO_FIFO_0 | all_identifiers,
        ];
        for (place, filter) in filters.into_iter().enumerate() {
            self.memory.flssa(place).write_value(filter);
        }
        self.registers.rxgfc().write(|global| {
            global.set_lss(FILTERS);
            global.set_anfs(Anfs::REJECT);
            global.set_anfe(Anfe::REJECT);
            global.set_rrfs(true);
            global.set_rrfe(true);
        });
    }
}

impl Cell for Controller {
    fn reset(&mut self) {
        (self.reset)();
    }

    fn request_initialisation(&mut self) {
        self.registers
            .cccr()
            .modify(|control| control.set_init(true));
    }

    fn is_initialising(&self) -> bool {
        self.registers.cccr().read().init()
    }

    fn set_up_and_join(&mut self) {
        let Self { registers, .. } = *self;
        if misbehaviour::has(Fault::KeepOldFrames) && !self.is_empty() {
            registers.cccr().modify(|control| control.set_init(false));
            return;
        }
        // Also forgets every request to transmit and what both receive FIFOs hold (RM0440, section 44.4.6, CCE).
        registers.cccr().modify(|control| {
            control.set_cce(true);
            control.set_fdoe(false);
            control.set_brse(false);
            control.set_dar(false);
        });
        registers.nbtp().write(|timing| {
            timing.set_nbrp(self.timing.prescaler - 1);
            timing.set_ntseg1(self.timing.segment_1 - 1);
            timing.set_ntseg2(self.timing.segment_2 - 1);
            timing.set_nsjw(self.timing.jump_width - 1);
        });
        // First in, first out: by identifier, a poll of a low drive would overtake the set-points of the higher ones.
        registers
            .txbc()
            .write(|transmitter| transmitter.set_tfqm(Tfqm::FIFO));
        self.set_filters();
        // The end of every transmission counts (RM0440, section 44.4.31), on line 0 as everything else.
        registers.txbtie().write_value(regs::Txbtie(0b111));
        registers.ie().write_value(regs::Ie(0));
        registers.ile().write(|lines| lines.set_eint0(true));
        registers.cccr().modify(|control| {
            control.set_cce(false);
            control.set_init(false);
        });
    }

    fn has_joined(&self) -> bool {
        !self.is_initialising() && !self.status.bo() && self.status.act() != Act::SYNC
    }

    /// Bus-off also requests the initialisation.
    fn is_bus_off(&self) -> bool {
        self.status.bo() || self.is_initialising()
    }

    fn discard_pending(&mut self) {
        self.registers.txbcr().write(|cancel| {
            (0..PLACES).for_each(|place| cancel.set_cr(place, true));
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
