//! What a stream of one kind of controller and a channel of the other have in common.

/// Which way the items go.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Direction {
    /// From the peripheral to memory.
    #[default]
    ToMemory,
    /// From memory to the peripheral.
    FromMemory,
}

/// One item to move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transfer {
    /// Index of the stream.
    pub stream: usize,
    /// Which way it goes.
    pub direction: Direction,
    /// Address of the peripheral's register, and bytes of an access there.
    pub peripheral: u32,
    /// As above.
    pub peripheral_size: usize,
    /// Address in memory, and bytes of an access there.
    pub memory: u32,
    /// As above.
    pub memory_size: usize,
}

/// Events of a stream.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Events {
    pub(super) half: bool,
    pub(super) complete: bool,
    pub(super) error: bool,
}

impl Events {
    pub(super) fn any(self) -> bool {
        self.half || self.complete || self.error
    }
}

/// A stream or channel.
#[derive(Debug, Clone, Default)]
pub(super) struct Stream {
    /// The control register as written, without the enable.
    pub(super) control: u32,
    pub(super) enabled: bool,
    pub(super) direction: Direction,
    pub(super) circular: bool,
    pub(super) peripheral_increments: bool,
    pub(super) memory_increments: bool,
    /// Bytes of an item at the peripheral and in memory.
    pub(super) sizes: [usize; 2],
    pub(super) priority: u32,
    pub(super) channel: u32,
    pub(super) peripheral: u32,
    pub(super) memory: u32,
    pub(super) remaining: u32,
    /// Items when it was enabled.
    total: u32,
    pub(super) events: Events,
    pub(super) enables: Events,
    /// The second memory address and the control of the FIFO, of the streams.
    pub(super) others: [u32; 2],
}

impl Stream {
    pub(super) fn new() -> Self {
        Self {
            // The FIFO threshold is a half (RM0090, section 10.5.10).
            others: [0, 1],
            ..Self::default()
        }
    }

    pub(super) fn enable(&mut self) {
        self.enabled = true;
        self.total = self.remaining;
    }

    pub(super) fn line(&self) -> bool {
        let (events, enables) = (self.events, self.enables);
        events.half && enables.half
            || events.complete && enables.complete
            || events.error && enables.error
    }

    /// Whether a request would be served.
    pub(super) fn is_ready(&self) -> bool {
        self.enabled && self.remaining > 0
    }

    pub(super) fn transfer(&self, stream: usize) -> Transfer {
        let done = self.total - self.remaining;
        let [peripheral_size, memory_size] = self.sizes;
        let at = |base: u32, increments: bool, size: usize| {
            let offset = if increments { done * size as u32 } else { 0 };
            // Addresses of items are aligned to their size.
            base.wrapping_add(offset) & !(size as u32 - 1)
        };
        Transfer {
            stream,
            direction: self.direction,
            peripheral: at(self.peripheral, self.peripheral_increments, peripheral_size),
            peripheral_size,
            memory: at(self.memory, self.memory_increments, memory_size),
            memory_size,
        }
    }

    pub(super) fn finish(&mut self, keeps_enabled: bool) {
        self.remaining -= 1;
        if self.remaining == self.total / 2 {
            self.events.half = true;
        }
        if self.remaining > 0 {
            return;
        }
        self.events.complete = true;
        if self.circular {
            self.remaining = self.total;
        } else {
            self.enabled = keeps_enabled;
        }
    }

    pub(super) fn fail(&mut self) {
        self.events.error = true;
        self.enabled = false;
    }
}
