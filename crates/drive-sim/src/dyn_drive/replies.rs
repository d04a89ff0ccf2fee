//! What a drive sends, and when.
//!
//! Specification: every reply is prepared for a drawn delay, counted from the end of its request; replies keep the order of their requests and none
//! overtakes another; an alarm frame waits for nothing. A data error is prepared like a reply.

use std::collections::VecDeque;

use dyn_can::DataFrame;

use super::faults::{ReplyFault, Resize};
use super::settings::ResponseDelay;
use crate::frame::Frame;
use crate::split_mix::SplitMix64;

/// Most data bytes of a classic CAN frame.
const MAX_DATA: usize = crate::frame::MAX_DATA_BYTES;

/// Frames in preparation, ordered by the instant at which they are ready.
#[derive(Debug, Clone)]
pub(super) struct Outbox {
    frames: VecDeque<(u64, Frame)>,
    delay: ResponseDelay,
    random: SplitMix64,
}

impl Outbox {
    pub(super) fn new(delay: ResponseDelay, seed: u64) -> Self {
        Self {
            frames: VecDeque::new(),
            delay,
            random: SplitMix64::new(seed),
        }
    }

    /// Prepares the answer to a request that ended at `now_ns`.
    pub(super) fn answer(&mut self, now_ns: u64, frame: DataFrame) {
        let delay_ns = self.draw_delay_ns();
        self.push(now_ns.saturating_add(delay_ns), frame);
    }

    /// Prepares a reply with its fault; returns whether it will be sent at all.
    pub(super) fn reply(&mut self, now_ns: u64, frame: DataFrame, fault: ReplyFault) -> bool {
        let delay_ns = self.draw_delay_ns().saturating_add(fault.delay_ns);
        let frame = resize(frame, fault.resize);
        for _ in 0..fault.copies {
            self.push(now_ns.saturating_add(delay_ns), frame);
        }
        fault.copies > 0
    }

    /// Sends a frame before all others.
    pub(super) fn at_once(&mut self, now_ns: u64, frame: DataFrame) {
        self.frames
            .extend(frame.to_can().map(|frame| (now_ns, frame)));
        if self.frames.len() > 1 {
            self.frames.rotate_right(1);
        }
    }

    /// The delay of a dropped reply is drawn too, so that a fault does not change the delays behind it.
    pub(super) fn draw_delay_ns(&mut self) -> u64 {
        let window_ns = self.delay.max_ns() - self.delay.min_ns();
        self.delay.min_ns() + self.random.up_to(window_ns)
    }

    fn push(&mut self, ready_ns: u64, frame: DataFrame) {
        let behind_ns = self.frames.back().map_or(0, |(ready_ns, _)| *ready_ns);
        let ready_ns = ready_ns.max(behind_ns);
        // Every data frame of the codec is a frame of the bus.
        self.frames
            .extend(frame.to_can().map(|frame| (ready_ns, frame)));
    }

    pub(super) fn next_due_ns(&self) -> Option<u64> {
        self.frames.front().map(|(ready_ns, _)| *ready_ns)
    }

    /// Takes the next frame that is ready.
    pub(super) fn pop_due(&mut self, now_ns: u64) -> Option<Frame> {
        if self.next_due_ns()? > now_ns {
            return None;
        }
        self.frames.pop_front().map(|(_, frame)| frame)
    }

    /// Forgets everything in preparation.
    pub(super) fn clear(&mut self) {
        self.frames.clear();
    }
}

fn resize(frame: DataFrame, resize: Option<Resize>) -> DataFrame {
    let length = usize::from(frame.len());
    let length = match resize {
        None => return frame,
        Some(Resize::Shorter) => length.saturating_sub(1),
        Some(Resize::Longer) => (length + 1).min(MAX_DATA),
    };
    let mut data = [0; MAX_DATA];
    data[..frame.data().len()].copy_from_slice(frame.data());
    // An identifier of the codec with at most 8 bytes is always a frame.
    DataFrame::new(frame.id(), &data[..length]).unwrap_or(frame)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOUND: ReplyFault = ReplyFault {
        copies: 1,
        delay_ns: 0,
        resize: None,
    };

    fn frame(byte: u8) -> DataFrame {
        DataFrame::new(0x029, &[byte]).unwrap()
    }

    fn drain(outbox: &mut Outbox) -> Vec<(u64, String)> {
        let mut sent = Vec::new();
        while let Some(due_ns) = outbox.next_due_ns() {
            assert_eq!(outbox.pop_due(due_ns.wrapping_sub(1)), None);
            sent.extend(
                outbox
                    .pop_due(due_ns)
                    .map(|frame| (due_ns, frame.to_string())),
            );
        }
        sent
    }

    fn outbox() -> Outbox {
        Outbox::new(ResponseDelay::fixed(100), 0)
    }

    #[test]
    fn slow_reply_holds_back_the_next_one() {
        let mut outbox = outbox();
        let slow = ReplyFault {
            delay_ns: 1_000,
            ..SOUND
        };
        outbox.reply(50, frame(1), slow);
        outbox.reply(60, frame(2), SOUND);
        outbox.answer(2_000, frame(3));
        assert_eq!(
            drain(&mut outbox),
            [
                (1_150, "029#01".into()),
                (1_150, "029#02".into()),
                (2_100, "029#03".into())
            ]
        );
    }

    #[test]
    fn alarm_overtakes_everything() {
        let mut outbox = outbox();
        outbox.reply(50, frame(1), SOUND);
        outbox.reply(50, frame(2), SOUND);
        outbox.at_once(70, frame(0xEE));
        assert_eq!(
            drain(&mut outbox),
            [
                (70, "029#EE".into()),
                (150, "029#01".into()),
                (150, "029#02".into())
            ]
        );
    }

    #[test]
    fn faults_drop_double_and_change_the_length() {
        let mut outbox = outbox();
        assert!(!outbox.reply(0, frame(1), ReplyFault { copies: 0, ..SOUND }));
        assert!(outbox.reply(0, frame(2), ReplyFault { copies: 2, ..SOUND }));
        for kind in [Resize::Shorter, Resize::Longer] {
            let fault = ReplyFault {
                resize: Some(kind),
                ..SOUND
            };
            outbox.reply(0, frame(3), fault);
        }
        let sent: Vec<String> = drain(&mut outbox)
            .into_iter()
            .map(|(_, text)| text)
            .collect();
        assert_eq!(sent, ["029#02", "029#02", "029#", "029#0300"]);
    }

    #[test]
    fn delays_stay_in_the_window_and_repeat_with_the_seed() {
        let delays = |seed| {
            let window = ResponseDelay::between(1_000, 1_500).unwrap();
            let mut outbox = Outbox::new(window, seed);
            (0..100)
                .map(|_| outbox.draw_delay_ns())
                .collect::<Vec<u64>>()
        };
        assert!(delays(1).iter().all(|ns| (1_000..=1_500).contains(ns)));
        assert_eq!(delays(1), delays(1));
        assert_ne!(delays(1), delays(2));
    }
}
