//! A receive FIFO (RM0090, section 32.7.3).

use std::collections::VecDeque;

use drive_sim::Frame;

use super::register_frame::to_registers;

const DEPTH: usize = 3;
const FULL: u32 = 1 << 3;
const OVERRUN: u32 = 1 << 4;
const RELEASE: u32 = 1 << 5;

/// Three frames at most.
#[derive(Debug, Clone, Default)]
pub(super) struct ReceiveFifo {
    frames: VecDeque<Frame>,
    /// The FULL and OVERRUN flags; they stay until software clears them.
    flags: u32,
    lost: u64,
}

impl ReceiveFifo {
    /// A frame comes in. When there is no room, one is lost: the new one if `locked`, else the latest.
    pub(super) fn push(&mut self, frame: Frame, locked: bool) {
        if self.frames.len() < DEPTH {
            self.frames.push_back(frame);
        } else {
            self.lost += 1;
            self.flags |= OVERRUN;
            if !locked {
                self.frames[DEPTH - 1] = frame;
            }
        }
        if self.frames.len() == DEPTH {
            self.flags |= FULL;
        }
    }

    /// Frames lost so far.
    #[must_use]
    pub(super) fn lost(&self) -> u64 {
        self.lost
    }

    /// The level of its interrupt line under the three enables: pending, full, overrun.
    #[must_use]
    pub(super) fn interrupts(&self, enables: u32) -> bool {
        enables & 1 != 0 && !self.frames.is_empty()
            || enables & 2 != 0 && self.flags & FULL != 0
            || enables & 4 != 0 && self.flags & OVERRUN != 0
    }

    /// The RFR register.
    #[must_use]
    pub(super) fn status(&self) -> u32 {
        self.frames.len() as u32 | self.flags
    }

    /// Writes the RFR register.
    pub(super) fn write_status(&mut self, value: u32) {
        self.flags &= !(value & (FULL | OVERRUN));
        if value & RELEASE != 0 && self.frames.pop_front().is_some() {
            self.flags &= !FULL;
        }
    }

    /// A register of the oldest frame.
    #[must_use]
    pub(super) fn front(&self, register: usize) -> u32 {
        self.frames
            .front()
            .map_or(0, |frame| to_registers(frame)[register])
    }
}

#[cfg(test)]
mod tests {
    use embedded_can::{Frame as _, StandardId};

    use super::*;

    fn filled(locked: bool) -> ReceiveFifo {
        let mut fifo = ReceiveFifo::default();
        for id in 1..=5 {
            fifo.push(
                Frame::new(StandardId::new(id).unwrap(), &[]).unwrap(),
                locked,
            );
        }
        fifo
    }

    fn drain(mut fifo: ReceiveFifo) -> Vec<u32> {
        let mut ids = Vec::new();
        while fifo.status() & 3 != 0 {
            ids.push(fifo.front(0) >> 21);
            fifo.write_status(RELEASE);
        }
        ids
    }

    #[test]
    fn an_overrun_loses_the_latest_or_the_new_frame_and_is_marked() {
        let fifo = filled(false);
        assert_eq!((fifo.status(), fifo.lost()), (3 | FULL | OVERRUN, 2));
        assert_eq!(drain(fifo), [1, 2, 5]);
        assert_eq!(drain(filled(true)), [1, 2, 3]);
    }

    #[test]
    fn the_overrun_mark_stays_until_it_is_cleared() {
        let mut fifo = filled(false);
        fifo.write_status(RELEASE);
        assert!(fifo.interrupts(4));
        fifo.write_status(OVERRUN);
        assert!(!fifo.interrupts(4));
    }
}
