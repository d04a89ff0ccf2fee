//! A receive FIFO in blocking mode, as after a reset: when it is full the new frame is lost (RM0440, section 44.3.5).

/// Frames that it holds.
const DEPTH: usize = 3;

/// Where its frames are; they themselves are in the message memory.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ReceiveFifo {
    level: usize,
    get: usize,
    has_lost: bool,
    lost: u64,
}

impl ReceiveFifo {
    /// The element for a new frame; `None` when there is no room and the frame is lost.
    pub(super) fn push(&mut self) -> Option<usize> {
        if self.level == DEPTH {
            (self.lost, self.has_lost) = (self.lost + 1, true);
            return None;
        }
        self.level += 1;
        Some((self.get + self.level - 1) % DEPTH)
    }

    /// The oldest frame was read.
    pub(super) fn acknowledge(&mut self) {
        if self.level > 0 {
            self.level -= 1;
            self.get = (self.get + 1) % DEPTH;
        }
    }

    /// The mark of a lost frame is cleared.
    pub(super) fn clear_mark(&mut self) {
        self.has_lost = false;
    }

    /// Empty, as after a reset; what was lost so far still counts.
    pub(super) fn reset(&mut self) {
        *self = Self {
            lost: self.lost,
            ..Self::default()
        };
    }

    /// Frames lost so far.
    pub(super) fn lost(&self) -> u64 {
        self.lost
    }

    /// The RXFS register.
    pub(super) fn status(&self) -> u32 {
        let put = (self.get + self.level) % DEPTH;
        self.level as u32
            | (self.get as u32) << 8
            | (put as u32) << 16
            | u32::from(self.level == DEPTH) << 24
            | u32::from(self.has_lost) << 25
    }
}
