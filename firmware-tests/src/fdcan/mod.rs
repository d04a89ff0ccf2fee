//! The CAN controller of the STM32G4 at register level, in classic mode (RM0440, section 44), as a node of drive-sim's bus.

mod memory;
mod receive;
mod transmit;

use drive_sim::{ControllerState, ErrorState, Frame, NodeId};

use crate::can::{Line, Wire};
use crate::clock::Clock;
use crate::connection::{Connection, LEC_STUFF, Seen};
use memory::{Memory, Target};
use receive::ReceiveFifo;
use transmit::TransmitFifo;

/// Interrupt line 0.
const INTERRUPT: u16 = 21;
const RECEIVE_FIFOS: usize = 2;

const CCCR_INIT: u32 = 1;
const CCCR_CHANGE_ENABLE: u32 = 1 << 1;
/// Restricted, monitoring, no retransmission, test, FD and bit rate switching: none is modelled.
const CCCR_NOT_MODELLED: u32 = 1 << 2 | 1 << 5 | 1 << 6 | 1 << 7 | 1 << 8 | 1 << 9;
const TXBC_QUEUE: u32 = 1 << 24;
/// Reading PSR sets the last error code to this.
const LEC_UNCHANGED: u32 = 7;
/// IR: a new frame, and one lost, of FIFO 0; those of FIFO 1 are three bits higher. The end of a transmission, the end of
/// a cancellation, bus-off.
const IR_NEW: u32 = 1;
const IR_LOST: u32 = 1 << 2;
const IR_SENT: u32 = 1 << 7;
const IR_CANCELLED: u32 = 1 << 8;
const IR_BUS_OFF: u32 = 1 << 19;
/// Recessive bits after which the controller takes part in the bus.
const JOIN_BITS: u64 = 11;

const CORE_RELEASE: u32 = 0x3214_1218;
const ENDIAN_TEST: u32 = 0x8765_4321;
const NBTP_RESET: u32 = 0x0600_0A03;

/// What the controller does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    Initialisation,
    /// `None` while the bit rate is wrong or the bus dominant.
    Joining {
        until_ns: Option<u64>,
    },
    OnBus,
}

/// The controller.
#[derive(Debug, Clone)]
pub struct FdCan {
    connection: Connection,
    mode: Mode,
    control: u32,
    bit_timing: u32,
    global_filter: u32,
    transmit_config: u32,
    flags: u32,
    enables: u32,
    lines: u32,
    transmit_enables: u32,
    last_error: u32,
    /// Errors that were counted since the counter was read.
    logged_errors: u32,
    memory: Memory,
    receive: [ReceiveFifo; RECEIVE_FIFOS],
    transmit: TransmitFifo,
    /// The way back from a bus-off is under way.
    is_recovering: bool,
    held_dominant: bool,
    keeps_frames: bool,
    unfiltered: u64,
}

impl FdCan {
    /// Adds the controller to a bus. It is in initialisation, as after a reset.
    #[must_use]
    pub fn new(wire: &mut Wire) -> Self {
        Self::after_reset(Connection::new(wire))
    }

    fn after_reset(connection: Connection) -> Self {
        Self {
            connection,
            mode: Mode::Initialisation,
            control: CCCR_INIT,
            bit_timing: NBTP_RESET,
            global_filter: 0,
            transmit_config: 0,
            flags: 0,
            enables: 0,
            lines: 0,
            transmit_enables: 0,
            last_error: LEC_UNCHANGED,
            logged_errors: 0,
            memory: Memory::default(),
            receive: Default::default(),
            transmit: TransmitFifo::default(),
            is_recovering: false,
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

    /// The frames that wait to be sent.
    #[must_use]
    pub fn waiting(&self) -> Vec<Frame> {
        let places = self.transmit.waiting();
        places.map(|place| self.memory.to_send(place)).collect()
    }

    /// Received frames that no filter passed.
    #[must_use]
    pub fn unfiltered(&self) -> u64 {
        self.unfiltered
    }

    /// Frames lost because a receive FIFO was full.
    #[must_use]
    pub fn overruns(&self) -> u64 {
        self.receive.iter().map(ReceiveFifo::lost).sum()
    }

    /// Breaks the controller on purpose: it never gives a frame up.
    pub fn keep_frames(&mut self, kept: bool) {
        self.keeps_frames = kept;
    }

    /// The message memory.
    pub fn memory(&mut self) -> &mut [u32] {
        self.memory.words()
    }

    /// A reset: off the bus, everything forgotten but the message memory, which keeps what it has.
    pub fn reset(&mut self, wire: &mut Wire) {
        self.connection.reset(wire);
        self.receive.iter_mut().for_each(ReceiveFifo::reset);
        *self = Self {
            memory: self.memory.clone(),
            receive: self.receive,
            held_dominant: self.held_dominant,
            keeps_frames: self.keeps_frames,
            unfiltered: self.unfiltered,
            ..Self::after_reset(self.connection.clone())
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
        if matches!(self.mode, Mode::Joining { .. }) {
            self.leave_initialisation(wire, clock);
        }
    }

    /// Lets the bus run up to `now_ns`.
    pub fn advance(&mut self, wire: &mut Wire, now_ns: u64) {
        while let Some(due_ns) = self.next_own_event_ns().filter(|&due_ns| due_ns <= now_ns) {
            self.run_to(wire, due_ns.max(wire.now_ns()));
            if self.mode
                == (Mode::Joining {
                    until_ns: Some(due_ns),
                })
            {
                self.mode = Mode::OnBus;
                self.is_recovering = self.connection.is_bus_off(wire);
                self.connection.join(wire);
            } else {
                self.cancel_due(wire, due_ns);
            }
        }
        self.run_to(wire, now_ns);
    }

    fn next_own_event_ns(&self) -> Option<u64> {
        let mode_ns = match self.mode {
            Mode::Joining { until_ns } => until_ns,
            _ => None,
        };
        let cancel_ns = self.transmit.next_cancel_ns();
        mode_ns.into_iter().chain(cancel_ns).min()
    }

    fn cancel_due(&mut self, wire: &mut Wire, due_ns: u64) {
        for place in self.transmit.take_due(due_ns) {
            if self.connection.withdraw(wire, place) {
                self.finish_cancelled(place);
            }
        }
        self.settle(wire);
    }

    fn finish_cancelled(&mut self, place: usize) {
        self.transmit.finish_cancelled(place);
        self.flags |= IR_CANCELLED;
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

    /// The next instant at which something changes by itself.
    #[must_use]
    pub fn next_event_ns(&self, wire: &Wire) -> Option<u64> {
        let own_ns = self.next_own_event_ns();
        own_ns.into_iter().chain(wire.next_event_ns()).min()
    }

    fn settle(&mut self, wire: &mut Wire) {
        while let Some(frame) = self.connection.receive(wire) {
            self.take_in(&frame);
        }
        match self.connection.look(wire) {
            Seen::Nothing => {}
            Seen::Sent(place) => {
                self.last_error = 0;
                if let Some(place) = place {
                    self.finish_sent(place);
                }
            }
            Seen::Failed {
                code,
                place,
                given_up,
            } => {
                self.log_error(code);
                if let Some(place) = place.filter(|_| given_up) {
                    self.finish_cancelled(place);
                }
            }
            Seen::Received { with_error: true } => self.log_error(LEC_STUFF),
            Seen::Received { with_error: false } => self.last_error = 0,
        }
        self.note_bus_off(wire);
        let next = self.transmit.waiting().next();
        let next = next.filter(|_| self.mode == Mode::OnBus);
        let next = next.map(|place| (place, self.memory.to_send(place)));
        self.connection.hand_over(wire, next);
    }

    /// Bus-off requests the initialisation by itself.
    fn note_bus_off(&mut self, wire: &mut Wire) {
        if !self.connection.is_bus_off(wire) {
            self.is_recovering = false;
        } else if !self.is_recovering && self.mode == Mode::OnBus {
            self.control |= CCCR_INIT;
            self.flags |= IR_BUS_OFF;
            self.mode = Mode::Initialisation;
            self.connection.leave(wire);
        }
    }

    fn finish_sent(&mut self, place: usize) {
        self.transmit.finish_sent(place);
        if self.transmit_enables >> place & 1 != 0 {
            self.flags |= IR_SENT;
        }
    }

    fn log_error(&mut self, code: u32) {
        self.last_error = code;
        self.logged_errors = (self.logged_errors + 1).min(0xFF);
    }

    fn take_in(&mut self, frame: &Frame) {
        let fifo = match self.memory.target(frame, self.global_filter) {
            Target::Fifo(fifo) => fifo,
            Target::Rejected => {
                self.unfiltered += 1;
                return;
            }
        };
        let Some(element) = self.receive[fifo].push() else {
            self.flags |= IR_LOST << (3 * fifo);
            return;
        };
        self.memory.store(fifo, element, frame);
        self.flags |= IR_NEW << (3 * fifo);
    }

    /// Numbers and levels of its interrupt lines.
    #[must_use]
    pub fn lines(&self) -> [Line; 1] {
        let level = self.lines & 1 != 0 && self.flags & self.enables != 0;
        [(INTERRUPT, level)]
    }

    /// Reads a register by its offset; PSR and ECR forget by it.
    pub fn read(&mut self, wire: &Wire, offset: u32) -> u32 {
        match offset {
            0x00 => CORE_RELEASE,
            0x04 => ENDIAN_TEST,
            0x18 => self.control,
            0x1C => self.bit_timing,
            0x40 => self.error_counters(wire),
            0x44 => self.protocol_status(wire),
            0x50 => self.flags,
            0x54 => self.enables,
            0x5C => self.lines,
            0x80 => self.global_filter,
            0x90 => self.receive[0].status(),
            0x98 => self.receive[1].status(),
            0xC0 => self.transmit_config,
            0xC4 => self.transmit.status(),
            0xC8 => self.transmit.pending(),
            0xD4 => self.transmit.finished()[0],
            0xD8 => self.transmit.finished()[1],
            0xDC => self.transmit_enables,
            _ => 0,
        }
    }

    fn error_counters(&mut self, wire: &Wire) -> u32 {
        let (tec, rec) = self.connection.counters(wire);
        let passive = u32::from(rec > 127);
        let logged = core::mem::take(&mut self.logged_errors);
        tec.min(0xFF) | rec.min(0x7F) << 8 | passive << 15 | logged << 16
    }

    fn protocol_status(&mut self, wire: &Wire) -> u32 {
        let code = core::mem::replace(&mut self.last_error, LEC_UNCHANGED);
        let (tec, rec) = self.connection.counters(wire);
        let state = self.connection.state(wire);
        // Synchronising, idle; whether it sends or receives does not matter here.
        let activity = u32::from(self.mode == Mode::OnBus);
        let bit = |set: bool, at: u32| u32::from(set) << at;
        code | activity << 3
            | bit(state == ControllerState::On(ErrorState::Passive), 5)
            | bit(tec >= 96 || rec >= 96, 6)
            | bit(state == ControllerState::On(ErrorState::BusOff), 7)
    }

    /// Writes a register.
    ///
    /// # Panics
    /// When the firmware uses what is not modelled: test modes, FD frames, single attempts, the transmit queue.
    pub fn write(&mut self, wire: &mut Wire, offset: u32, value: u32, clock: &Clock) {
        match offset {
            0x18 => self.write_control(wire, value, clock),
            0x1C if self.may_change() => self.bit_timing = value,
            0x50 => self.write_flags(value),
            0x54 => self.enables = value,
            0x5C => self.lines = value & 3,
            0x80 if self.may_change() => self.global_filter = value,
            0x94 => self.receive[0].acknowledge(),
            0x9C => self.receive[1].acknowledge(),
            0xC0 if self.may_change() => {
                assert_eq!(value & TXBC_QUEUE, 0, "the transmit queue is not modelled");
                self.transmit_config = value;
            }
            // In initialisation no request is taken.
            0xCC if self.control & CCCR_INIT == 0 => self.transmit.request(value),
            0xD0 if !self.keeps_frames => {
                self.transmit.request_cancellation(value, wire.now_ns());
            }
            0xDC => self.transmit_enables = value,
            _ => {}
        }
        self.settle(wire);
    }

    fn may_change(&self) -> bool {
        let both = CCCR_INIT | CCCR_CHANGE_ENABLE;
        self.control & both == both
    }

    fn write_control(&mut self, wire: &mut Wire, value: u32, clock: &Clock) {
        assert_eq!(value & CCCR_NOT_MODELLED, 0, "not modelled: {value:#x}");
        let was = self.control;
        // The change enable can only be set within initialisation and ends with it.
        let may_enable = was & CCCR_INIT != 0 && value & CCCR_INIT != 0;
        self.control = if may_enable {
            value
        } else {
            value & !CCCR_CHANGE_ENABLE
        };
        if self.control & CCCR_CHANGE_ENABLE != 0 {
            self.forget_frames();
        }
        match (was & CCCR_INIT != 0, value & CCCR_INIT != 0) {
            (false, true) => {
                self.mode = Mode::Initialisation;
                self.connection.leave(wire);
            }
            (true, false) => self.leave_initialisation(wire, clock),
            _ => {}
        }
    }

    /// What the change enable resets: receive FIFOs, requests to transmit, their ends.
    fn forget_frames(&mut self) {
        self.receive.iter_mut().for_each(ReceiveFifo::reset);
        self.transmit = TransmitFifo::default();
    }

    fn leave_initialisation(&mut self, wire: &Wire, clock: &Clock) {
        let bit_ns = wire.bus().bit_rate().bit_ns();
        let joins = !self.held_dominant && self.bit_ns(clock) == Some(bit_ns);
        let until_ns = joins.then(|| wire.now_ns() + JOIN_BITS * bit_ns);
        self.mode = Mode::Joining { until_ns };
    }

    /// Length of a bit, from the clock of peripheral bus 1; `None` when it is no whole number of nanoseconds.
    #[must_use]
    pub fn bit_ns(&self, clock: &Clock) -> Option<u64> {
        let field = |at: u32, bits: u32| u64::from(self.bit_timing >> at & ((1 << bits) - 1));
        let quanta = 1 + (field(8, 8) + 1) + (field(0, 7) + 1);
        let ticks_ns = quanta * (field(16, 9) + 1) * 1_000_000_000;
        ticks_ns
            .is_multiple_of(clock.pclk1_hz())
            .then(|| ticks_ns / clock.pclk1_hz())
    }

    fn write_flags(&mut self, value: u32) {
        self.flags &= !value;
        for (fifo, state) in self.receive.iter_mut().enumerate() {
            if value & IR_LOST << (3 * fifo) != 0 {
                state.clear_mark();
            }
        }
    }
}

#[cfg(test)]
mod tests;
