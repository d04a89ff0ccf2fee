//! The wire of the serial port and the device at its other end: bytes with times, at a bit rate of its own.

use std::collections::VecDeque;

use super::{FRAME, FRAMING_ERROR, NOISE, SAMPLED};

/// What the other side puts on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Symbol {
    /// A byte.
    Byte(u8),
    /// A byte with a disturbance: samples of a bit differ, but the value can be read.
    Noisy(u8),
    /// The line is low for longer than a byte.
    Break,
}

/// A byte that came from the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Received {
    /// The byte as the other side reads it at its own bit rate.
    pub byte: u8,
    /// The end of its stop bit.
    pub at_ns: u64,
    /// There was no stop bit where the other side expects it.
    pub framing_error: bool,
}

/// A symbol on its way to the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Arrival {
    symbol: Symbol,
    /// First edge of its start bit.
    pub(super) starts_ns: u64,
    /// The receiver has it.
    sampled_ns: u64,
    /// End of its stop bit.
    pub(super) ends_ns: u64,
    /// Length of a bit.
    bit_ns: u64,
}

impl Arrival {
    /// The byte and the error flags that a receiver with bits of this length gets.
    pub(super) fn seen_with(&self, bit_ns: u64) -> (u8, u32) {
        match self.symbol {
            Symbol::Break => (0, FRAMING_ERROR),
            Symbol::Byte(byte) | Symbol::Noisy(byte) if !is_close(self.bit_ns, bit_ns) => {
                (garbled(byte, self.bit_ns, bit_ns), FRAMING_ERROR)
            }
            Symbol::Noisy(byte) => (byte, NOISE),
            Symbol::Byte(byte) => (byte, 0),
        }
    }
}

/// Largest difference of the bit rates at which every bit is still read, in percent: half a bit in the 9.5 of a frame, less the
/// resolution of the sampling.
const TOLERANCE_PERCENT: u64 = 4;
const BREAK_BITS: u64 = 13;

fn is_close(sent_ns: u64, read_ns: u64) -> bool {
    100 * sent_ns.abs_diff(read_ns) <= TOLERANCE_PERCENT * sent_ns
}

/// What a receiver of another bit rate makes of a byte: it samples the wrong bits. Where it would meet all the right ones by chance,
/// its last bit is wrong, so that a test never passes by chance.
fn garbled(byte: u8, sent_ns: u64, read_ns: u64) -> u8 {
    let frame = u32::from(byte) << 1 | 1 << 9;
    let level = |half_bits: u64| {
        let bit = half_bits * read_ns / (2 * sent_ns);
        if bit > 9 { 1 } else { frame >> bit & 1 }
    };
    let read = (0..8).fold(0, |read, bit| read | (level(2 * bit + 3) as u8) << bit);
    if read == byte { byte ^ 0x80 } else { read }
}

/// The wire and its other end. It outlives every reset of the chip.
#[derive(Debug, Clone)]
pub struct SerialLine {
    rate: u32,
    connected: bool,
    to_board: VecDeque<Arrival>,
    /// When the other side's transmitter is free.
    free_ns: u64,
    received: Vec<Received>,
    lost: u64,
}

impl Default for SerialLine {
    fn default() -> Self {
        Self {
            rate: 115_200,
            connected: true,
            to_board: VecDeque::new(),
            free_ns: 0,
            received: Vec::new(),
            lost: 0,
        }
    }
}

impl SerialLine {
    /// Sets the bit rate of the other side, for what it sends from now on and for what it reads.
    ///
    /// # Panics
    /// When it is 0.
    pub fn set_rate(&mut self, bits_per_s: u32) {
        assert!(bits_per_s > 0, "a bit rate is above 0");
        self.rate = bits_per_s;
    }

    /// Breaks the wire or mends it. While it is broken, nothing arrives on either side; both lines are idle.
    pub fn connect(&mut self, connected: bool) {
        self.connected = connected;
    }

    fn half_bits_ns(&self, half_bits: u64) -> u64 {
        half_bits * 500_000_000 / u64::from(self.rate)
    }

    /// The other side sends, beginning at `at_ns` or when it has sent everything before.
    pub fn send(&mut self, at_ns: u64, symbols: impl IntoIterator<Item = Symbol>) {
        for symbol in symbols {
            let starts_ns = self.free_ns.max(at_ns);
            let length = match symbol {
                Symbol::Break => 2 * BREAK_BITS,
                Symbol::Byte(_) | Symbol::Noisy(_) => FRAME,
            };
            self.free_ns = starts_ns + self.half_bits_ns(length);
            self.to_board.push_back(Arrival {
                symbol,
                starts_ns,
                sampled_ns: starts_ns + self.half_bits_ns(SAMPLED),
                ends_ns: self.free_ns,
                bit_ns: self.half_bits_ns(2),
            });
        }
    }

    /// The other side sends bytes, beginning at `at_ns` or when it has sent everything before.
    pub fn send_bytes(&mut self, at_ns: u64, bytes: &[u8]) {
        self.send(at_ns, bytes.iter().copied().map(Symbol::Byte));
    }

    /// When the other side has sent everything.
    #[must_use]
    pub fn sent_ns(&self) -> u64 {
        self.free_ns
    }

    /// Takes what came from the board.
    pub fn take_received(&mut self) -> Vec<Received> {
        core::mem::take(&mut self.received)
    }

    /// Symbols that were sent and that the receiver of the board never saw: it was off, or there was no connection.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.lost
    }

    pub(super) fn next_arrival_ns(&self) -> Option<u64> {
        self.to_board.front().map(|arrival| arrival.sampled_ns)
    }

    pub(super) fn next_start_ns(&self) -> Option<u64> {
        let seen = self.to_board.front().filter(|_| self.connected);
        seen.map(|arrival| arrival.starts_ns)
    }

    /// The symbol that has arrived; `None` when the wire is broken.
    pub(super) fn take_arrival(&mut self) -> Option<Arrival> {
        let arrival = self.to_board.pop_front();
        if !self.connected {
            self.lost += 1;
        }
        arrival.filter(|_| self.connected)
    }

    pub(super) fn note_lost(&mut self) {
        self.lost += 1;
    }

    pub(super) fn lose_until(&mut self, now_ns: u64) {
        while self.next_arrival_ns().is_some_and(|at_ns| at_ns <= now_ns) {
            self.to_board.pop_front();
            self.lost += 1;
        }
    }

    /// A byte of the board with bits of `bit_ns` has ended.
    pub(super) fn take_in(&mut self, byte: u8, at_ns: u64, bit_ns: u64) {
        if !self.connected {
            return;
        }
        let own_ns = self.half_bits_ns(2);
        let framing_error = !is_close(bit_ns, own_ns);
        let byte = if framing_error {
            garbled(byte, bit_ns, own_ns)
        } else {
            byte
        };
        self.received.push(Received {
            byte,
            at_ns,
            framing_error,
        });
    }
}
