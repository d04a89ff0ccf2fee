//! The controller in its registers and its message memory: settings, places and FIFOs, and what its recovery asks of it.

use dyn_can::DataFrame;
use embassy_stm32::gpio::Flex;
use embassy_stm32::pac::can::vals::{Act, Anfe, Anfs, Tfqm};
use embassy_stm32::pac::can::{Fdcan, regs};
use embassy_stm32::pac::fdcanram::Fdcanram;

use crate::bus::{BitTiming, DRIVE_ERROR, FUNCTION_CODE_MASK};
use crate::frame;
use crate::misbehaviour::{self, Fault};
use crate::recovery::Cell;
use crate::transmit_places::{ALL_PLACES, Occupied, PLACES};

pub(super) const RECEIVE_FIFOS: usize = 2;
/// Frames in each receive FIFO.
const RECEIVE_DEPTH: usize = 3;
/// Words of the message memory in an element of a FIFO (RM0440, section 44.3.7).
const ELEMENT_WORDS: usize = 18;
const FILTERS: u8 = 2;

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
    /// Which places have a frame that waits.
    pub(super) fn occupied(&self) -> Occupied {
        Occupied(self.registers.txbrp().read().0 & ALL_PLACES)
    }

    /// Whether a frame can be read.
    pub(super) fn has_received(&self) -> bool {
        self.registers.rxfs(0).read().ffl() | self.registers.rxfs(1).read().ffl() > 0
    }

    #[inline(always)]
    fn word(&self, fifo: usize, place: usize) -> u32 {
        match fifo {
            0 => self.memory.rxfifo0(place).read(),
            _ => self.memory.rxfifo1(place).read(),
        }
    }

    /// Takes the oldest frame of a FIFO.
    #[inline]
    pub(super) fn read(&self, fifo: usize) -> Option<DataFrame> {
        let status = self.registers.rxfs(fifo).read();
        if status.ffl() == 0 {
            return None;
        }
        let element = status.fgi();
        let first = usize::from(element).min(RECEIVE_DEPTH - 1) * ELEMENT_WORDS;
        let (header, control) = (self.word(fifo, first), self.word(fifo, first + 1));
        let data = [self.word(fifo, first + 2), self.word(fifo, first + 3)];
        self.registers
            .rxfa(fifo)
            .write(|acknowledge| acknowledge.set_fai(element));
        Some(frame::from_registers(
            (header >> 18 & 0x7FF) as u16,
            (control >> 16 & 0xF) as u8,
            data,
        ))
    }

    /// Requests a frame to be sent, by the place that the controller names.
    #[inline(always)]
    pub(super) fn write(&self, place: usize, frame: &DataFrame) {
        let first = place.min(PLACES - 1) * ELEMENT_WORDS;
        let [low, high] = frame::words(frame);
        // A classic frame with a standard identifier, without an event when it has gone out. Not a loop over the words: that costs three
        // times as much, for each set-point.
        let identifier = u32::from(frame.id()) << 18;
        let control = u32::from(frame.len()) << 16;
        self.memory.txbuf(first).write_value(identifier);
        self.memory.txbuf(first + 1).write_value(control);
        self.memory.txbuf(first + 2).write_value(low);
        self.memory.txbuf(first + 3).write_value(high);
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
        self.occupied() == Occupied::NONE
    }
}
