//! Worst-case response times of CAN frames that are sent by priority.
//!
//! # Source
//!
//! R. I. Davis, A. Burns, R. J. Bril, J. J. Lukkien, "Controller Area Network (CAN) schedulability analysis: Refuted,
//! revisited and revised", Real-Time Systems 35, 2007: every instance in the busy period, blocking, release jitter, errors.
//!
//! # Formula
//!
//! Whole bit times. For the `q`-th instance of frame m, counted from 0, in the longest period in which the bus is busy with
//! m and with what is more urgent:
//!
//! ```text
//! w = E(w + C) + B + q C + sum over more urgent k of ceil((w + J_k + 1) / T_k) C_k
//! R = max over q of J + w - q T + C
//! ```
//!
//! B is the longest less urgent frame, E the error term. Equal identifiers count as more urgent to one another. A
//! [`Message`] may stand for a stream whose frames have different identifiers: its own later frames may then overtake, it
//! is judged as the least urgent and disturbs others as the most urgent of them.
//!
//! # What it takes for granted
//!
//! Every node offers its most urgent frame; frames with one identifier come out in the order in which they went in.
//! Whoever converts to bit times rounds lengths and jitters up and periods and deadlines down.

/// Bits of the longest error frame with its interframe space (Davis et al. 2007, section 3.5).
pub const ERROR_FRAME_BITS: u32 = 31;

/// A stream of frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Message {
    /// The most urgent identifier of the stream.
    pub first_id: u16,
    /// The least urgent identifier of the stream; equal to `first_id` for one with a single identifier.
    pub last_id: u16,
    /// Longest frame in bits, interframe space included, at least 1.
    pub bits: u32,
    /// Frames that arrive together once a period.
    pub count: u32,
    /// Shortest time between arrivals, at least 1.
    pub period_bits: u32,
    /// Longest time from arrival to release, when the frame takes part in arbitration.
    pub jitter_bits: u32,
    /// Latest end, counted from arrival.
    pub deadline_bits: u32,
}

impl Message {
    /// A periodic frame with one identifier whose deadline is its period, without jitter.
    #[must_use]
    pub const fn periodic(id: u16, bits: u32, period_bits: u32) -> Self {
        Self {
            first_id: id,
            last_id: id,
            bits,
            count: 1,
            period_bits,
            jitter_bits: 0,
            deadline_bits: period_bits,
        }
    }

    /// Most frames released in a half-open interval.
    const fn released(&self, interval_bits: u64) -> u64 {
        let period = self.period_bits as u64;
        let from_first_arrival = interval_bits + self.jitter_bits as u64;
        match from_first_arrival.checked_div(period) {
            None => u64::MAX,
            Some(full) => {
                let begun = (full.saturating_mul(period) < from_first_arrival) as u64;
                (full + begun).saturating_mul(self.count as u64)
            }
        }
    }

    /// Most bits released in a half-open interval.
    pub(crate) const fn demand(&self, interval_bits: u64) -> u64 {
        self.released(interval_bits)
            .saturating_mul(self.bits as u64)
    }

    /// Arrival of the `number`-th frame, counted from 0, after the first arrival.
    const fn arrival(&self, number: u64) -> u64 {
        match number.checked_div(self.count as u64) {
            Some(periods) => periods * self.period_bits as u64,
            None => 0,
        }
    }
}

/// What holds for the whole bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rules {
    /// Shortest time between two errors on the bus; each costs [`ERROR_FRAME_BITS`] and the longest frame once more.
    /// `None` for a bus without errors.
    pub error_interval_bits: Option<u32>,
    /// Busy periods up to this long are looked through; beyond, a response counts as unbounded. Bounds the time of the
    /// analysis.
    pub horizon_bits: u32,
}

impl Rules {
    /// What errors cost in an interval on a bus whose longest frame has `longest_bits`.
    const fn error_bits(&self, interval_bits: u64, longest_bits: u64) -> u64 {
        match self.error_interval_bits {
            None => 0,
            Some(between) => {
                let each = Message::periodic(0, ERROR_FRAME_BITS, between);
                each.released(interval_bits)
                    .saturating_mul(ERROR_FRAME_BITS as u64 + longest_bits)
            }
        }
    }
}

/// Worst-case response of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Response {
    /// Longest time from arrival to the end of the interframe space, `None` when there is no bound within the horizon.
    pub bits: Option<u32>,
    /// The deadline of the message.
    pub deadline_bits: u32,
}

impl Response {
    /// Without a bound there is no meeting any deadline.
    pub(crate) const fn new(bits: Option<u64>, deadline_bits: u32) -> Self {
        let bits = match bits {
            Some(bits) if bits < u32::MAX as u64 => Some(bits as u32),
            _ => None,
        };
        Self {
            bits,
            deadline_bits,
        }
    }

    /// Whether the deadline is always met.
    #[must_use]
    pub const fn is_met(&self) -> bool {
        match self.bits {
            Some(bits) => bits <= self.deadline_bits,
            None => false,
        }
    }
}

/// Worst-case response of a message among others; it is not one of `others`.
#[must_use]
pub const fn response(message: &Message, others: &[Message], rules: &Rules) -> Response {
    let level = Level::of(message, others, rules);
    Response::new(level.worst_response(), message.deadline_bits)
}

/// What delays the message under analysis.
#[derive(Clone, Copy)]
struct Level<'a> {
    message: &'a Message,
    others: &'a [Message],
    rules: &'a Rules,
    /// Longest less urgent frame.
    blocking_bits: u64,
    /// Longest frame that may have to be repeated.
    longest_bits: u64,
}

impl<'a> Level<'a> {
    const fn of(message: &'a Message, others: &'a [Message], rules: &'a Rules) -> Self {
        let (mut blocking_bits, mut longest_bits) = (0, message.bits as u64);
        let mut rest = others;
        while let Some((other, behind)) = rest.split_first() {
            if other.count > 0 {
                longest_bits = max(longest_bits, other.bits as u64);
                if other.last_id > message.last_id {
                    blocking_bits = max(blocking_bits, other.bits as u64);
                }
            }
            rest = behind;
        }
        Self {
            message,
            others,
            rules,
            blocking_bits,
            longest_bits,
        }
    }

    const fn worst_response(&self) -> Option<u64> {
        let message = self.message;
        let Some(busy_bits) = self.busy_bits() else {
            return None;
        };
        let (bits, jitter_bits) = (message.bits as u64, message.jitter_bits as u64);
        let (mut number, mut worst_bits, mut start_bits) = (0, 0, 0);
        while number < message.released(busy_bits) {
            // Starts do not come earlier from one instance to the next.
            let Some(found) = self.start_bits(start_bits, number * bits) else {
                return None;
            };
            start_bits = found;
            let response_bits = jitter_bits + start_bits + bits;
            worst_bits = max(
                worst_bits,
                response_bits.saturating_sub(message.arrival(number)),
            );
            number += 1;
        }
        Some(worst_bits)
    }

    /// Length of the longest busy period.
    const fn busy_bits(&self) -> Option<u64> {
        let mut busy_bits = self.message.bits as u64;
        loop {
            let next_bits = self
                .rules
                .error_bits(busy_bits, self.longest_bits)
                .saturating_add(self.blocking_bits)
                .saturating_add(self.interference_bits(busy_bits))
                .saturating_add(self.message.demand(busy_bits));
            if next_bits <= busy_bits {
                return Some(busy_bits);
            }
            if next_bits > self.rules.horizon_bits as u64 {
                return None;
            }
            busy_bits = next_bits;
        }
    }

    /// The least start of a frame at or after `from_bits`, behind `ahead_bits` of its own kind.
    const fn start_bits(&self, from_bits: u64, ahead_bits: u64) -> Option<u64> {
        let bits = self.message.bits as u64;
        let may_be_overtaken = self.message.first_id < self.message.last_id;
        let mut start_bits = from_bits;
        loop {
            let own_bits = if may_be_overtaken {
                self.message.demand(start_bits + 1).saturating_sub(bits)
            } else {
                0
            };
            let next_bits = self
                .rules
                .error_bits(start_bits + bits, self.longest_bits)
                .saturating_add(self.blocking_bits)
                .saturating_add(max(ahead_bits, own_bits))
                .saturating_add(self.interference_bits(start_bits + 1));
            if next_bits <= start_bits {
                return Some(start_bits);
            }
            if next_bits > self.rules.horizon_bits as u64 {
                return None;
            }
            start_bits = next_bits;
        }
    }

    /// Bits of the more urgent messages in a half-open interval.
    const fn interference_bits(&self, interval_bits: u64) -> u64 {
        let mut total_bits = 0_u64;
        let mut rest = self.others;
        while let Some((other, behind)) = rest.split_first() {
            if other.first_id <= self.message.last_id {
                total_bits = total_bits.saturating_add(other.demand(interval_bits));
            }
            rest = behind;
        }
        total_bits
    }
}

pub(crate) const fn max(left: u64, right: u64) -> u64 {
    if left > right { left } else { right }
}

#[cfg(test)]
mod tests;
