//! The CAN controller at register level (RM0090, section 32), as a node of drive-sim's bus.
//!
//! The registers, mailboxes, filters and FIFOs are here; the rest is the [`Connection`]'s.

mod filter;
mod mailboxes;
mod receive_fifo;
mod register_frame;

use drive_sim::{ControllerState, ErrorState, Frame, NodeId};

use crate::can::{Line, Wire};
use crate::clock::Clock;
use crate::connection::{Connection, LEC_STUFF, Seen};
use filter::Filters;
use mailboxes::{MAILBOXES, Mailboxes};
use receive_fifo::ReceiveFifo;

/// Its interrupts: transmit, FIFO 0, FIFO 1, status change.
const INTERRUPTS: [u16; 4] = [19, 20, 21, 22];
const MCR_RESET: u32 = 0x0001_0002;
const MCR_INIT: u32 = 1;
const MCR_SLEEP: u32 = 1 << 1;
const MCR_FIRST_COME: u32 = 1 << 2;
const MCR_FIFO_LOCKED: u32 = 1 << 3;
const MCR_NO_RETRANSMISSION: u32 = 1 << 4;
/// Time-triggered communication: must stay clear (ES0182).
const MCR_TIME_TRIGGERED: u32 = 1 << 7;
const MCR_AUTOMATIC_RECOVERY: u32 = 1 << 6;
const MCR_SOFTWARE_RESET: u32 = 1 << 15;
const BTR_RESET: u32 = 0x0123_0000;
const BTR_LOOPBACK_OR_SILENT: u32 = 0b11 << 30;
const MSR_ERROR: u32 = 1 << 2;
/// The RX pin reads recessive, now and at the last sample point.
const MSR_RECESSIVE: u32 = 0xC00;
const IER_TRANSMIT: u32 = 1;
const IER_ERROR: u32 = 1 << 15;
/// Recessive bits after which the controller takes part in the bus, or is awake.
const JOIN_BITS: u64 = 11;
/// From the request to give a frame up that is not on the wire until it has happened: two clocks of the controller. The manual only says
/// that it is done at once, and not in the same instruction.
const ABORT_NS: u64 = 50;

/// What the controller does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    Sleep,
    /// On the way from sleep to initialisation: it leaves sleep only after 11 recessive bits (RM0090, section 32.9.2, SLAK).
    Waking {
        until_ns: Option<u64>,
    },
    Initialisation,
    /// Waiting for recessive bits; `None` while the bit rate is wrong, when they never come.
    Joining {
        until_ns: Option<u64>,
    },
    OnBus,
}

/// The controller.
#[derive(Debug, Clone)]
pub struct BxCan {
    connection: Connection,
    mode: Mode,
    mcr: u32,
    interrupt_flags: u32,
    interrupt_enable: u32,
    bit_timing: u32,
    last_error: u32,
    mailboxes: Mailboxes,
    filters: Filters,
    fifos: [ReceiveFifo; 2],
    /// When the request to give up the frame of a mailbox takes effect.
    aborts_ns: [Option<u64>; MAILBOXES],
    /// Something holds the RX pin dominant: a transceiver without supply, a short circuit.
    held_dominant: bool,
    keeps_frames: bool,
    unfiltered: u64,
}

impl BxCan {
    /// Adds the controller to a bus. It sleeps, as after a reset.
    #[must_use]
    pub fn new(wire: &mut Wire) -> Self {
        Self::asleep(Connection::new(wire))
    }

    fn asleep(connection: Connection) -> Self {
        Self {
            connection,
            mode: Mode::Sleep,
            mcr: MCR_RESET,
            interrupt_flags: 0,
            interrupt_enable: 0,
            bit_timing: BTR_RESET,
            last_error: 0,
            mailboxes: Mailboxes::default(),
            filters: Filters::default(),
            fifos: Default::default(),
            aborts_ns: [None; MAILBOXES],
            held_dominant: false,
            keeps_frames: false,
            unfiltered: 0,
        }
    }

    /// Its node.
    #[must_use]
    pub fn node(&self) -> NodeId {
        self.connection.node()
    }

    /// The frames that wait in its mailboxes.
    #[must_use]
    pub fn waiting(&self) -> Vec<Frame> {
        let pending = (0..MAILBOXES).filter(|&mailbox| self.mailboxes.is_pending(mailbox));
        pending
            .map(|mailbox| self.mailboxes.frame(mailbox))
            .collect()
    }

    /// Received frames that no filter passed.
    #[must_use]
    pub fn unfiltered(&self) -> u64 {
        self.unfiltered
    }

    /// Frames lost because a receive FIFO was full.
    #[must_use]
    pub fn overruns(&self) -> u64 {
        self.fifos.iter().map(ReceiveFifo::lost).sum()
    }

    /// Breaks the controller on purpose: it never gives a frame up.
    pub fn keep_frames(&mut self, kept: bool) {
        self.keeps_frames = kept;
    }

    /// A reset: off the bus, everything forgotten.
    pub fn reset(&mut self, wire: &mut Wire) {
        self.connection.reset(wire);
        *self = Self {
            held_dominant: self.held_dominant,
            keeps_frames: self.keeps_frames,
            ..Self::asleep(self.connection.clone())
        };
    }

    /// Holds the RX pin dominant, or lets it go.
    ///
    /// # Panics
    /// When the controller is on the bus: only the start is modelled.
    pub fn hold_dominant(&mut self, wire: &Wire, clock: &Clock, held: bool) {
        assert_ne!(
            self.mode,
            Mode::OnBus,
            "a bus that fails is not modelled so"
        );
        self.held_dominant = held;
        match self.mode {
            Mode::Waking { .. } => self.wake(wire, clock),
            Mode::Joining { .. } => self.leave_initialisation(wire, clock),
            _ => {}
        }
    }

    /// Lets the bus run up to `now_ns`.
    pub fn advance(&mut self, wire: &mut Wire, now_ns: u64) {
        while let Some(due_ns) = self.next_own_event_ns().filter(|&due_ns| due_ns <= now_ns) {
            self.run_to(wire, due_ns.max(wire.now_ns()));
            match self.mode {
                Mode::Joining { until_ns } if until_ns == Some(due_ns) => self.join(wire),
                Mode::Waking { until_ns } if until_ns == Some(due_ns) => {
                    self.mode = Mode::Initialisation;
                }
                _ => self.abort_due(wire, due_ns),
            }
        }
        self.run_to(wire, now_ns);
    }

    /// The next instant at which the controller does something by itself. In initialisation no frame is given up.
    fn next_own_event_ns(&self) -> Option<u64> {
        let mode_ns = match self.mode {
            Mode::Joining { until_ns } | Mode::Waking { until_ns } => until_ns,
            _ => None,
        };
        let aborts_ns = self.aborts_ns.iter().flatten().copied();
        let aborts_ns = aborts_ns.filter(|_| self.mode != Mode::Initialisation);
        mode_ns.into_iter().chain(aborts_ns).min()
    }

    fn abort_due(&mut self, wire: &mut Wire, due_ns: u64) {
        for mailbox in 0..MAILBOXES {
            if self.aborts_ns[mailbox]
                .take_if(|at_ns| *at_ns <= due_ns)
                .is_some()
            {
                self.give_up(wire, mailbox);
            }
        }
        self.settle(wire);
    }

    fn run_to(&mut self, wire: &mut Wire, limit_ns: u64) {
        loop {
            let more = wire.step_to(limit_ns);
            self.settle(wire);
            if !more {
                return;
            }
        }
    }

    fn join(&mut self, wire: &mut Wire) {
        self.mode = Mode::OnBus;
        // Leaving initialisation is what starts the way back from bus-off.
        self.connection.join(wire);
    }

    /// The next instant at which something changes by itself.
    #[must_use]
    pub fn next_event_ns(&self, wire: &Wire) -> Option<u64> {
        let own_ns = self.next_own_event_ns();
        own_ns.into_iter().chain(wire.next_event_ns()).min()
    }

    fn settle(&mut self, wire: &mut Wire) {
        while let Some(frame) = self.connection.receive(wire) {
            self.receive(frame);
        }
        match self.connection.look(wire) {
            Seen::Nothing => {}
            Seen::Sent(mailbox) => {
                self.last_error = 0;
                if let Some(mailbox) = mailbox {
                    self.mailboxes.sent(mailbox);
                }
            }
            Seen::Failed {
                code,
                place,
                given_up,
            } => {
                self.error(code);
                match place {
                    Some(mailbox) if given_up => self.mailboxes.aborted(mailbox),
                    Some(mailbox) => self.mailboxes.failed(mailbox),
                    None => {}
                }
            }
            Seen::Received { with_error: true } => self.error(LEC_STUFF),
            Seen::Received { with_error: false } => self.last_error = 0,
        }
        if self.mcr & MCR_AUTOMATIC_RECOVERY != 0 {
            self.connection.recover_by_itself(wire);
        }
        let next = self.mailboxes.next(self.mcr & MCR_FIRST_COME != 0);
        let next = next.map(|mailbox| (mailbox, self.mailboxes.frame(mailbox)));
        self.connection.hand_over(wire, next);
    }

    fn receive(&mut self, frame: Frame) {
        match self.filters.fifo_for(&frame) {
            Some(fifo) => self.fifos[fifo].push(frame, self.mcr & MCR_FIFO_LOCKED != 0),
            None => self.unfiltered += 1,
        }
    }

    fn error(&mut self, code: u32) {
        self.last_error = code;
        // The enables of warning, passive, bus-off and last error code; the flags themselves are looked up when read.
        if self.interrupt_enable >> 8 & 0xF != 0 {
            self.interrupt_flags |= MSR_ERROR;
        }
    }

    fn give_up(&mut self, wire: &mut Wire, mailbox: usize) {
        if self.mailboxes.is_pending(mailbox) && self.connection.withdraw(wire, mailbox) {
            self.mailboxes.aborted(mailbox);
        }
    }

    /// Numbers and levels of its interrupt lines.
    #[must_use]
    pub fn lines(&self) -> [Line; 4] {
        let enable = self.interrupt_enable;
        let [transmit, fifo_0, fifo_1, status] = INTERRUPTS;
        [
            (
                transmit,
                enable & IER_TRANSMIT != 0 && self.mailboxes.has_completed(),
            ),
            (fifo_0, self.fifos[0].interrupts(enable >> 1)),
            (fifo_1, self.fifos[1].interrupts(enable >> 4)),
            (
                status,
                enable & IER_ERROR != 0 && self.interrupt_flags & MSR_ERROR != 0,
            ),
        ]
    }

    /// Reads a register by its offset.
    #[must_use]
    pub fn read(&self, wire: &Wire, offset: u32) -> u32 {
        match offset {
            0x00 => self.mcr,
            0x04 if self.held_dominant => self.mode_bits() | self.interrupt_flags,
            0x04 => self.mode_bits() | self.interrupt_flags | MSR_RECESSIVE,
            0x08 => self.mailboxes.status() | self.abort_bits(),
            0x0C => self.fifos[0].status(),
            0x10 => self.fifos[1].status(),
            0x14 => self.interrupt_enable,
            0x18 => self.error_status(wire),
            0x1C => self.bit_timing,
            0x180..0x1B0 => self.mailboxes.read(offset - 0x180),
            0x1B0..0x1C0 => self.fifos[0].front((offset as usize & 0xF) / 4),
            0x1C0..0x1D0 => self.fifos[1].front((offset as usize & 0xF) / 4),
            _ => self.filters.read(offset),
        }
    }

    fn abort_bits(&self) -> u32 {
        let pending = (0..MAILBOXES).filter(|&mailbox| self.aborts_ns[mailbox].is_some());
        pending.fold(0, |bits, mailbox| bits | 0x80 << (8 * mailbox))
    }

    fn mode_bits(&self) -> u32 {
        match self.mode {
            Mode::Sleep | Mode::Waking { .. } => 2,
            Mode::Initialisation | Mode::Joining { .. } => 1,
            Mode::OnBus => 0,
        }
    }

    fn error_status(&self, wire: &Wire) -> u32 {
        let (tec, rec) = self.connection.counters(wire);
        let state = self.connection.state(wire);
        let bit = |set: bool, at: u32| u32::from(set) << at;
        bit(tec >= 96 || rec >= 96, 0)
            | bit(state != ControllerState::On(ErrorState::Active), 1)
            | bit(state == ControllerState::On(ErrorState::BusOff), 2)
            | self.last_error << 4
            | tec.min(0xFF) << 16
            | rec.min(0xFF) << 24
    }

    /// Writes a register.
    ///
    /// # Panics
    /// When the firmware uses what is not modelled: loopback, silent mode, no retransmission, the time-triggered mode.
    pub fn write(&mut self, wire: &mut Wire, offset: u32, value: u32, clock: &Clock) {
        match offset {
            0x00 if value & MCR_SOFTWARE_RESET != 0 => return self.reset(wire),
            0x00 => self.write_master_control(wire, value, clock),
            0x04 => self.interrupt_flags &= !value,
            0x08 => {
                let aborts = self.mailboxes.write_status(value);
                for mailbox in aborts.filter(|_| !self.keeps_frames) {
                    self.aborts_ns[mailbox].get_or_insert(wire.now_ns() + ABORT_NS);
                }
            }
            0x0C => self.fifos[0].write_status(value),
            0x10 => self.fifos[1].write_status(value),
            0x14 => self.interrupt_enable = value,
            0x18 => self.last_error = value >> 4 & 7,
            0x1C if self.mode == Mode::Initialisation => {
                assert_eq!(
                    value & BTR_LOOPBACK_OR_SILENT,
                    0,
                    "test modes are not modelled"
                );
                self.bit_timing = value;
            }
            0x180..0x1B0 => self.mailboxes.write(offset - 0x180, value),
            0x200..0x320 => self.filters.write(offset, value),
            _ => {}
        }
        self.settle(wire);
    }

    fn write_master_control(&mut self, wire: &mut Wire, value: u32, clock: &Clock) {
        assert_eq!(
            value & MCR_NO_RETRANSMISSION,
            0,
            "single attempts are not modelled"
        );
        assert_eq!(
            value & MCR_TIME_TRIGGERED,
            0,
            "the time-triggered mode must stay off"
        );
        self.mcr = value;
        // Sleep wins over initialisation.
        match (value & MCR_SLEEP != 0, value & MCR_INIT != 0) {
            (true, _) => self.leave_bus(wire, Mode::Sleep),
            (false, true) if matches!(self.mode, Mode::Sleep | Mode::Waking { .. }) => {
                self.wake(wire, clock);
            }
            (false, true) => self.leave_bus(wire, Mode::Initialisation),
            (false, false) if !matches!(self.mode, Mode::Joining { .. } | Mode::OnBus) => {
                self.leave_initialisation(wire, clock);
            }
            (false, false) => {}
        }
    }

    fn leave_bus(&mut self, wire: &mut Wire, mode: Mode) {
        self.mode = mode;
        self.connection.leave(wire);
    }

    /// At whatever bit rate is set: the bus is taken for idle.
    fn wake(&mut self, wire: &Wire, clock: &Clock) {
        let bits_ns = JOIN_BITS * self.ticks_ns().div_ceil(clock.pclk1_hz());
        let until_ns = (!self.held_dominant).then(|| wire.now_ns() + bits_ns);
        self.mode = Mode::Waking { until_ns };
    }

    fn leave_initialisation(&mut self, wire: &Wire, clock: &Clock) {
        let bit_ns = wire.bus().bit_rate().bit_ns();
        let joins = !self.held_dominant && self.bit_ns(clock) == Some(bit_ns);
        let until_ns = joins.then(|| wire.now_ns() + JOIN_BITS * bit_ns);
        self.mode = Mode::Joining { until_ns };
    }

    /// Length of a bit; `None` when it is no whole number of nanoseconds, which no bit rate of the drives is.
    #[must_use]
    pub fn bit_ns(&self, clock: &Clock) -> Option<u64> {
        let ticks_ns = self.ticks_ns();
        ticks_ns
            .is_multiple_of(clock.pclk1_hz())
            .then(|| ticks_ns / clock.pclk1_hz())
    }

    /// Clocks of the controller in a bit, times the nanoseconds in a second.
    fn ticks_ns(&self) -> u64 {
        let field = |at: u32, bits: u32| u64::from(self.bit_timing >> at & ((1 << bits) - 1));
        let quanta = 1 + (field(16, 4) + 1) + (field(20, 3) + 1);
        quanta * (field(0, 10) + 1) * 1_000_000_000
    }
}

#[cfg(test)]
mod tests;
