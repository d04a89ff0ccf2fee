//! A stream of set-points as a motion of a board.

use std::time::{Duration, Instant};

use board_link::segment::{Begin, StreamPhase};

use super::LEAST_KEPT_MS;
use super::taker::{PathEnd, Taker};
use crate::board::motion::{BoardMotion, GivenUp, StreamState, units};
use crate::board::session::BoardClient;
use crate::recording::AxisNaming;
use crate::set_points::{Order, Speed};
use crate::stream::{Conversation, SetPointTaker as _, StreamReport};

/// A sender is told its credit at most this often.
const TELL_TIME: Duration = Duration::from_millis(5);
/// A speed that is lower than what was asked for by so many percent is another one.
const SLOWER_PERCENT: f32 = 3.0;

/// Set-points of a sender, for a board.
pub(super) struct StreamMotion {
    conversation: Conversation,
    taker: Taker,
    told_at: Instant,
    has_told_end: bool,
    /// The speed that was asked for was reached, and so it is something that it is lower now.
    is_at_speed: bool,
    asked_percent: u16,
}

impl StreamMotion {
    pub(super) fn new(conversation: Conversation, taker: Taker) -> Self {
        Self {
            conversation,
            taker,
            told_at: Instant::now(),
            has_told_end: false,
            is_at_speed: false,
            asked_percent: 100,
        }
    }

    /// What came in.
    pub(super) fn report(&self) -> StreamReport {
        self.conversation.report(&self.taker.counters())
    }

    /// Where the streamed axes are at the last set-point, in counts from the start.
    pub(super) fn targets(&self) -> Vec<i32> {
        self.taker.targets()
    }

    /// Segments that were made.
    pub(super) const fn segments(&self) -> u32 {
        self.taker.made
    }

    fn take_lines(&mut self) {
        self.conversation.take_lines(&mut self.taker);
        if self.taker.end == PathEnd::InMotion && !self.has_told_end {
            self.has_told_end = true;
            if self.taker.given_up.is_none() {
                self.conversation.note(
                    "the last set-point is too fast to come to rest there within the limits: the axes come to rest along the path before it"
                        .to_owned(),
                );
            }
        }
        if let Some((gap_s, takes_s)) = self.taker.slow_end.take() {
            self.conversation.note(format!(
                "the way to the last set-point takes {takes_s:.3} s instead of {gap_s:.3} s: within its time the axes could not come to rest within the limits"
            ));
        }
        if self.told_at.elapsed() >= TELL_TIME && self.conversation.tell_credit(&self.taker) {
            self.told_at = Instant::now();
        }
    }

    /// Says it when the board goes slower than it was asked to.
    fn watch_speed(&mut self, state: &StreamState) {
        let speed = &state.speed;
        let is_other = self.asked_percent != speed.asked_percent;
        self.asked_percent = speed.asked_percent;
        let goes = state.phase == StreamPhase::Moving && !speed.is_paused && !is_other;
        let wanted = f32::from(speed.asked_percent.min(100)) - SLOWER_PERCENT;
        if !goes {
            self.is_at_speed = false;
        } else if speed.actual_percent >= wanted {
            self.is_at_speed = true;
        } else if self.is_at_speed && self.taker.is_open() {
            self.is_at_speed = false;
            let buffered = self.taker.buffered_ms();
            self.conversation.note(if buffered < f64::from(LEAST_KEPT_MS) {
                format!("the set-points are late: {buffered:.0} ms are left, and the axes slow down along the path")
            } else {
                format!("{buffered:.0} ms are buffered, and the memory of the board holds less than slowing down takes: the axes slow down along the path")
            });
        }
    }
}

impl BoardMotion for StreamMotion {
    fn cycle_us(&self) -> u32 {
        self.taker.cycle_us()
    }

    fn cycles(&self) -> Option<u64> {
        None
    }

    /// How much faster set-points may be played that nobody knows yet is not known either.
    fn most_percent(&self) -> u16 {
        100
    }

    fn wait(&mut self, stand: &[i32], speed: Speed) {
        self.taker.get_ready(stand, speed);
        self.take_lines();
    }

    fn begin(&mut self, stream: u32, stand: &[i32]) -> Option<Begin> {
        self.taker.has_lead().then(|| Begin {
            stream,
            start: None,
            when_dry: self.taker.buffering().when_dry,
            percent: 100,
            from: units(stand),
        })
    }

    fn feed(&mut self, client: &mut BoardClient) {
        self.take_lines();
        while client.wants_segment() {
            let Some(segment) = self.taker.segments.pop_front() else {
                if self.taker.end == PathEnd::AtRest {
                    client.finish();
                }
                return;
            };
            // It was asked whether there is room.
            let _ = client.offer(segment);
        }
    }

    fn watch(&mut self, state: &StreamState) {
        if self.taker.watch(state) {
            let buffered = self.taker.buffered_ms();
            self.conversation.note(format!(
                "the set-points ran out: the axes have come to rest along the path, {buffered:.0} ms before the last one"
            ));
        }
        self.watch_speed(state);
    }

    fn next_order(&mut self) -> Option<Order> {
        self.taker.orders.pop_front()
    }

    fn next_notice(&mut self) -> Option<String> {
        self.conversation.next_notice()
    }

    fn take_naming(&mut self) -> Option<Vec<AxisNaming>> {
        self.conversation.take_naming()
    }

    fn has_run_out(&self) -> bool {
        self.taker.is_gone
    }

    fn has_given_up(&self) -> Option<GivenUp> {
        self.taker.given_up.clone()
    }
}
