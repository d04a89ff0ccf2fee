//! The controller in its registers: settings, mailboxes and FIFOs, and what its recovery asks of it.

use dyn_can::DataFrame;
use embassy_stm32::gpio::Flex;
use embassy_stm32::pac::can::{Can, regs};

use crate::bus::{BitTiming, DRIVE_ERROR, FUNCTION_CODE_MASK};
use crate::frame;
use crate::recovery::Cell;
use crate::transmit_places::{ALL_PLACES, Occupied, PLACES};

pub(super) const RECEIVE_FIFOS: usize = 2;

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
    /// Which mailboxes have a frame that waits.
    pub(super) fn occupied(&self) -> Occupied {
        Occupied(self.empty() ^ ALL_PLACES)
    }

    /// Which mailboxes have none: one bit each.
    #[inline(always)]
    fn empty(&self) -> u32 {
        /// TME0.
        const FIRST: u32 = 26;
        self.registers.tsr().read().0 >> FIRST & ALL_PLACES
    }

    /// A mailbox without a frame.
    #[inline(always)]
    pub(super) fn free_mailbox(&self) -> Option<usize> {
        let empty = self.empty();
        (empty != 0).then_some(empty.trailing_zeros() as usize)
    }

    /// Whether a frame can be read, or was lost.
    #[inline(always)]
    pub(super) fn has_received(&self) -> bool {
        /// FMP and FOVR.
        const MARKS: u32 = 0b1_0011;
        (self.registers.rfr(0).read().0 | self.registers.rfr(1).read().0) & MARKS != 0
    }

    /// The oldest frame of a FIFO.
    pub(super) fn read(&self, fifo: usize) -> DataFrame {
        let mailbox = self.registers.rx(fifo);
        let read = frame::from_registers(
            mailbox.rir().read().stid(),
            mailbox.rdtr().read().dlc(),
            [mailbox.rdlr().read().0, mailbox.rdhr().read().0],
        );
        // Writing 0 to the marks of this register leaves them.
        self.registers.rfr(fifo).write(|fifo| fifo.set_rfom(true));
        read
    }

    /// The frame that was put into a mailbox last.
    #[inline(never)]
    pub(super) fn queued(&self, mailbox: usize) -> DataFrame {
        let mailbox = self.registers.tx(mailbox);
        frame::from_registers(
            mailbox.tir().read().stid(),
            mailbox.tdtr().read().dlc(),
            [mailbox.tdlr().read().0, mailbox.tdhr().read().0],
        )
    }

    /// Requests a frame to be sent, by a free mailbox.
    #[inline(always)]
    pub(super) fn write(&self, mailbox: usize, frame: &DataFrame) {
        let mailbox = self.registers.tx(mailbox);
        let [low, high] = frame::words(frame);
        mailbox.tdtr().write(|control| control.set_dlc(frame.len()));
        mailbox.tdlr().write_value(regs::Tdlr(low));
        mailbox.tdhr().write_value(regs::Tdhr(high));
        mailbox.tir().write(|identifier| {
            identifier.set_stid(frame.id());
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

    #[inline(always)]
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
        self.occupied() == Occupied::NONE
    }
}

/// The interrupts that are never switched off.
pub(super) const fn error_enables() -> regs::Ier {
    /// LECIE and ERRIE.
    const LAST_ERROR_CODE: u32 = 1 << 11;
    const ERRORS: u32 = 1 << 15;
    regs::Ier(LAST_ERROR_CODE | ERRORS)
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
