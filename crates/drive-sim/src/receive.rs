//! Acceptance filter and receive FIFO.
//!
//! Law (bxCAN, RM0090, "Reception handling" and "Identifier filtering"): a receive FIFO holds three frames. A further one is an overrun: with
//! the FIFO locked (RFLM = 1) it is lost, otherwise it overwrites the newest. A frame that matches no filter is acknowledged but not stored.

use std::collections::VecDeque;

use embedded_can::StandardId;

use crate::frame::Frame;

/// Frames that a bxCAN receive FIFO holds.
pub const RX_FIFO_FRAMES: usize = 3;

/// What an overrun does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Overrun {
    /// The new frame overwrites the newest in the FIFO (RFLM = 0, the state after reset).
    #[default]
    Overwrite,
    /// The FIFO is locked and the new frame is lost (RFLM = 1).
    Lock,
}

/// Receive side of a controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RxQueue {
    /// Three frames, as in hardware.
    Fifo(Overrun),
    /// Unbounded, for simulated devices whose software is not under test.
    Unbounded,
}

/// One filter in mask mode, over the arbitration field of [`Frame::arbitration_field`]: a frame is stored if all masked bits agree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AcceptanceFilter {
    value: u32,
    mask: u32,
}

impl AcceptanceFilter {
    /// Stores every frame.
    pub const ALL: Self = Self { value: 0, mask: 0 };

    /// Stores no frame: a bxCAN out of reset, with no filter bank active. It still acknowledges.
    pub const NONE: Self = Self {
        value: u32::MAX,
        mask: 0,
    };

    /// Stores standard frames, data and remote, whose identifier agrees with `id` in the bits set in `mask`.
    pub fn standard(id: StandardId, mask: StandardId) -> Self {
        const IDE: u32 = 1 << 19;
        let mask = u32::from(mask.as_raw()) << 21;
        Self {
            value: u32::from(id.as_raw()) << 21 & mask,
            mask: mask | IDE,
        }
    }

    /// Whether `frame` is stored.
    pub fn accepts(&self, frame: &Frame) -> bool {
        frame.arbitration_field() & self.mask == self.value
    }
}

/// Frames received and not yet read.
#[derive(Debug, Clone)]
pub(crate) struct RxFrames {
    queue: RxQueue,
    frames: VecDeque<Frame>,
}

impl RxFrames {
    pub(crate) fn new(queue: RxQueue) -> Self {
        Self {
            queue,
            frames: VecDeque::with_capacity(RX_FIFO_FRAMES),
        }
    }

    /// Stores `frame`; returns false if that lost a frame.
    pub(crate) fn push(&mut self, frame: Frame) -> bool {
        match self.queue {
            RxQueue::Fifo(overrun) if self.frames.len() == RX_FIFO_FRAMES => {
                if overrun == Overrun::Overwrite {
                    self.frames[RX_FIFO_FRAMES - 1] = frame;
                }
                false
            }
            _ => {
                self.frames.push_back(frame);
                true
            }
        }
    }

    pub(crate) fn pop(&mut self) -> Option<Frame> {
        self.frames.pop_front()
    }

    pub(crate) fn len(&self) -> usize {
        self.frames.len()
    }

    pub(crate) fn clear(&mut self) {
        self.frames.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::tests::{extended, remote, standard};

    fn after_five(queue: RxQueue) -> (Vec<bool>, Vec<String>) {
        let mut frames = RxFrames::new(queue);
        let kept = (1..=5).map(|id| frames.push(standard(id, &[]))).collect();
        let read = std::iter::from_fn(|| frames.pop())
            .map(|frame| frame.to_string())
            .collect();
        (kept, read)
    }

    #[test]
    fn overrun_locks_or_overwrites_the_newest() {
        let kept = vec![true, true, true, false, false];
        assert_eq!(
            after_five(RxQueue::Fifo(Overrun::Lock)),
            (
                kept.clone(),
                vec!["001#".into(), "002#".into(), "003#".into()]
            )
        );
        assert_eq!(
            after_five(RxQueue::Fifo(Overrun::Overwrite)),
            (kept, vec!["001#".into(), "002#".into(), "005#".into()])
        );
    }

    #[test]
    fn unbounded_keeps_all() {
        let (kept, read) = after_five(RxQueue::Unbounded);
        assert_eq!((kept, read.len()), (vec![true; 5], 5));
    }

    #[test]
    fn filter_compares_masked_bits_of_standard_frames() {
        // All function codes of drive 3.
        let id = |raw| StandardId::new(raw).unwrap();
        let drive_3 = AcceptanceFilter::standard(id(3 << 5), id(0x7E0));
        assert!(drive_3.accepts(&standard(0x060, &[])));
        assert!(drive_3.accepts(&remote(0x07F, 2)));
        assert!(!drive_3.accepts(&standard(0x080, &[])));
        assert!(!drive_3.accepts(&extended(0x060 << 18, &[])));
        assert!(AcceptanceFilter::ALL.accepts(&extended(0x1FFF_FFFF, &[])));
        assert!(!AcceptanceFilter::NONE.accepts(&standard(0, &[])));
        assert!(!AcceptanceFilter::NONE.accepts(&extended(0x1FFF_FFFF, &[])));
    }
}
