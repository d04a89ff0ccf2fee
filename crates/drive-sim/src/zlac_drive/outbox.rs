//! What a drive sends, and when.
//!
//! Specification: SDO replies are ready after a drawn delay, counted from the end of the request, in the order of the requests; everything else is
//! ready at once.

use std::collections::VecDeque;

use embedded_can::{Frame as _, StandardId};

use crate::dyn_drive::ResponseDelay;
use crate::frame::Frame;
use crate::split_mix::SplitMix64;

/// Identifier and data.
pub(super) type Message = (u16, Vec<u8>);

#[derive(Debug, Clone)]
pub(super) struct Outbox {
    urgent: VecDeque<(u64, Frame)>,
    replies: VecDeque<(u64, Frame)>,
    delay: ResponseDelay,
    random: SplitMix64,
}

impl Outbox {
    pub(super) fn new(delay: ResponseDelay, seed: u64) -> Self {
        Self {
            urgent: VecDeque::new(),
            replies: VecDeque::new(),
            delay,
            random: SplitMix64::new(seed),
        }
    }

    pub(super) fn at_once(&mut self, now_ns: u64, message: Message) {
        self.urgent
            .extend(frame(message).map(|frame| (now_ns, frame)));
    }

    pub(super) fn reply(&mut self, now_ns: u64, extra_ns: u64, message: Message) {
        let window_ns = self.delay.max_ns() - self.delay.min_ns();
        let delay_ns = self.delay.min_ns() + self.random.up_to(window_ns);
        let behind_ns = self.replies.back().map_or(0, |(ready_ns, _)| *ready_ns);
        let ready_ns = (now_ns + delay_ns + extra_ns).max(behind_ns);
        self.replies
            .extend(frame(message).map(|frame| (ready_ns, frame)));
    }

    pub(super) fn next_due_ns(&self) -> Option<u64> {
        let first = |queue: &VecDeque<(u64, Frame)>| queue.front().map(|(ready_ns, _)| *ready_ns);
        first(&self.urgent)
            .into_iter()
            .chain(first(&self.replies))
            .min()
    }

    pub(super) fn pop_due(&mut self, now_ns: u64) -> Option<Frame> {
        let queue = if self.urgent.is_empty() {
            &mut self.replies
        } else {
            &mut self.urgent
        };
        let (ready_ns, frame) = *queue.front()?;
        (ready_ns <= now_ns).then(|| {
            queue.pop_front();
            frame
        })
    }

    pub(super) fn clear(&mut self) {
        self.urgent.clear();
        self.replies.clear();
    }
}

fn frame((id, data): Message) -> Option<Frame> {
    Frame::new(StandardId::new(id)?, &data)
}
