//! What moves with the time: bytes that go out, bytes that come, the idle line.

use super::{COMPLETE, FRAME, IDLE, OVERRUN, SerialLine, Surroundings, Usart};

/// What is on the way out.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shift {
    /// `None` for the idle frame that the transmitter begins with.
    pub(super) byte: Option<u8>,
    pub(super) ends_ns: u64,
}

impl Usart {
    /// When something changes by itself: a byte is sent or has come, the line is idle.
    #[must_use]
    pub fn next_event_ns(&self, line: &SerialLine) -> Option<u64> {
        let sent = self.shift.map(|shift| shift.ends_ns);
        [sent, self.idle_ns, line.next_arrival_ns()]
            .into_iter()
            .flatten()
            .min()
    }

    /// Brings the port up to `now_ns`. `around` is `None` while the port has no clock: then nothing moves and what comes is lost.
    pub fn advance(&mut self, now_ns: u64, around: Option<&Surroundings>, line: &mut SerialLine) {
        while let Some(due_ns) = self.next_event_ns(line).filter(|due_ns| *due_ns <= now_ns) {
            let Some(around) = around else {
                (self.shift, self.idle_ns) = (None, None);
                line.lose_until(now_ns);
                return;
            };
            if self.shift.is_some_and(|shift| shift.ends_ns == due_ns) {
                self.finish_shift(due_ns, around, line);
            } else if line.next_arrival_ns() == Some(due_ns) {
                self.take_arrival(around, line);
            } else {
                self.note_idle(line);
            }
        }
    }

    fn finish_shift(&mut self, at_ns: u64, around: &Surroundings, line: &mut SerialLine) {
        let shift = self.shift.take();
        if let (Some(byte), Some(bit)) = (
            shift.and_then(|shift| shift.byte),
            self.bit_time(around).filter(|_| around.wired[1]),
        ) {
            line.take_in(byte, at_ns, bit.ns(2));
        }
        if !self.start_shift(at_ns, around) && shift.is_some_and(|shift| shift.byte.is_some()) {
            self.status |= COMPLETE;
        }
    }

    /// Begins with the next byte; false when there is none.
    pub(super) fn start_shift(&mut self, at_ns: u64, around: &Surroundings) -> bool {
        let Some(bit) = self.bit_time(around).filter(|_| self.transmits()) else {
            return false;
        };
        let Some(byte) = self.to_send.pop_front() else {
            return false;
        };
        self.shift = Some(Shift {
            byte: Some(byte),
            ends_ns: at_ns + bit.ns(FRAME),
        });
        true
    }

    fn take_arrival(&mut self, around: &Surroundings, line: &mut SerialLine) {
        let Some(arrival) = line.take_arrival() else {
            return;
        };
        let listens = self.listens_ns.filter(|_| around.wired[0]);
        let Some(bit) = self.bit_time(around).filter(|_| {
            self.receives() && listens.is_some_and(|since_ns| since_ns <= arrival.starts_ns)
        }) else {
            line.note_lost();
            return;
        };
        let (byte, flags) = arrival.seen_with(bit.ns(2));
        self.idle_ns = Some(arrival.ends_ns + bit.ns(FRAME));
        if self.received.len() < self.depth() {
            self.received.push_back(byte);
            self.status |= flags;
        } else {
            self.status |= OVERRUN;
            self.overruns += 1;
        }
    }

    /// The line was idle for a frame, unless another byte began meanwhile.
    fn note_idle(&mut self, line: &SerialLine) {
        let idle_ns = self.idle_ns.take();
        let began = line.next_start_ns();
        if idle_ns.is_some_and(|idle_ns| began.is_none_or(|began_ns| began_ns >= idle_ns)) {
            self.status |= IDLE;
        }
    }
}
