//! When the frames of the master are through, at the latest, counted from the start of their cycle.
//!
//! General response time analysis lets every poll of every axis, and its reply, meet the set-points at once, and a reply with the
//! least jitter meet them twice. The master does not work like that, and what it does instead is known, so more can be
//! admitted without giving up soundness.
//!
//! # What is assumed
//!
//! 1. At the start of each cycle, at most `release_jitter_us` late, the master offers one set-point for each drive in ascending
//!    order and at most r requests ([`CycleSetup::requests_per_cycle`](crate::CycleSetup)), and it refills the
//!    controller while the last frame in it is still on the wire, so that the bus never idles while the cycle has frames left.
//! 2. A drive answers a request once, within the response window, and sends nothing else but alarm frames.
//! 3. Nobody else sends. No frame exceeds the length that the plan takes for it; errors keep their distance.
//!
//! # The bound
//!
//! All in bit times. T is the cycle, q and y the longest request and reply. Let F be when the last request of a cycle is
//! through, counted from the start of its cycle. Its reply is offered to the bus no later than `Y = F + longest response` and no
//! earlier than `a = shortest request + shortest response` after the start of that cycle; no set-points are assumed before
//! the request here, because axes that do not stream send none.
//!
//! Take a frame of the cycle that starts at 0, and the busy period of the bus that contains its end: it begins at some
//! instant -u when nothing waits. Until the frame is through, the bus then carries without a gap: the frames of the master
//! before it in order, replies that are offered after -u and before that end, alarms and errors. Which of them wins
//! arbitration does not matter, they are all counted. A reply to a request of j cycles ago takes part only if it can be
//! offered in that interval, so if `a - end < j T <= u + Y`. Behind the set-points of a first-in-first-out controller j >= 1,
//! because the requests of the same cycle are behind them too. Wherever requests may come first, they and their replies (j = 0)
//! count as well.
//!
//! ```text
//! end(u) = jitter - u + frames of this cycle up to this one
//!        + r y |{ j : a - end < j T <= u + Y }| + alarms + errors
//! ```
//!
//! `end(u)` falls with u except where one more j comes in, so the largest is at u = 0 or where the first such j comes in. For
//! u >= T - jitter one more cycle of frames comes in as well, but as long as a cycle with everything in it is not longer than T
//! that is less than u grows. That is why the load is checked first. F depends on Y and Y on F; both only grow from
//! their least values, and the first values that agree are safe, because the first frame ever to exceed them would need an
//! earlier one that did.
//!
//! With a first-in-first-out controller a request may end in the next cycle: the set-points there are behind it, and the busy
//! period that they share is what the bound follows. Sorted by identifier it must be through before, or it would meet them.

use crate::analysis::{ERROR_FRAME_BITS, Message, Response, Rules, max, response};
use crate::setup::TxOrder;

/// Cycles after which an end counts as unbounded.
const HORIZON_CYCLES: u64 = 64;

/// Where the requests of a cycle may be among its set-points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RequestPlace {
    /// Behind all of them.
    Behind,
    /// Anywhere, so for the bound before all of them. A controller that sorts by identifier puts them there by itself.
    Anywhere,
}

/// The frames of a cycle, in bit times.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cycle {
    /// The cycle, rounded down.
    pub(crate) bits: u64,
    /// The cycle, rounded up.
    pub(crate) bits_rounded_up: u64,
    /// All set-points together.
    pub(crate) set_points_bits: u64,
    /// The longest set-point.
    pub(crate) set_point_bits: u64,
    /// Requests of a cycle.
    pub(crate) requests: u64,
    /// The longest request.
    pub(crate) request_bits: u64,
    /// The shortest request without its interframe space.
    pub(crate) shortest_request_bits: u64,
    /// The longest reply.
    pub(crate) reply_bits: u64,
    /// Shortest time from a request to its reply.
    pub(crate) response_min_bits: u64,
    /// Longest time from a request to its reply.
    pub(crate) response_max_bits: u64,
    /// Alarms in two cycles.
    pub(crate) alarms: u64,
    /// The longest alarm.
    pub(crate) alarm_bits: u64,
    /// Longest delay from the start of the cycle to its frames.
    pub(crate) jitter_bits: u64,
    /// From the acceptance of a request until the master stops waiting.
    pub(crate) reply_timeout_bits: u64,
    /// Where the requests are.
    pub(crate) place: RequestPlace,
    /// Order of transmission of the frames of the master.
    pub(crate) order: TxOrder,
    /// Shortest time between two errors.
    pub(crate) error_interval_bits: Option<u32>,
}

impl Cycle {
    /// What a cycle may have to carry if everything comes together, with only so many bits of set-points.
    pub(crate) const fn load_bits(&self, set_points_bits: u64) -> u64 {
        self.jitter_bits
            .saturating_add(set_points_bits)
            .saturating_add(self.requests * (self.request_bits + self.reply_bits))
            .saturating_add(self.alarms * self.alarm_bits)
            .saturating_add(self.errors_bits(self.bits))
    }

    /// What errors cost in an interval: each an error frame and the longest frame once more.
    const fn errors_bits(&self, interval_bits: u64) -> u64 {
        self.errors().demand(interval_bits)
    }

    const fn longest_bits(&self) -> u64 {
        max(
            max(self.set_point_bits, self.alarm_bits),
            max(self.request_bits, self.reply_bits),
        )
    }

    /// When the last request of a cycle is through.
    pub(crate) const fn requests_end_bits(&self) -> Option<u64> {
        let frames_bits = self.set_points_bits + self.requests * self.request_bits;
        // The reply to the last request comes behind it.
        let own_replies = self.requests.saturating_sub(1);
        let mut end_bits = frames_bits;
        loop {
            match self.end_bits(frames_bits, own_replies, end_bits) {
                Some(next_bits) if next_bits > end_bits => end_bits = next_bits,
                Some(_) => return Some(end_bits),
                None => return None,
            }
        }
    }

    /// The last request, judged by the end of its cycle, or of the next one where it may end in that.
    pub(crate) const fn request_response(&self, requests_end_bits: Option<u64>) -> Response {
        let deadline_bits = match self.order {
            TxOrder::Fifo => 2 * self.bits,
            TxOrder::Identifier => self.bits,
        };
        Response::new(requests_end_bits, narrow(deadline_bits))
    }

    /// The last of the first set-points, `up_to_bits` together, judged by the end of its cycle.
    pub(crate) const fn set_point_response(
        &self,
        up_to_bits: u64,
        requests_end_bits: Option<u64>,
    ) -> Response {
        let end_bits = match (requests_end_bits, self.place) {
            (None, _) => None,
            (Some(end_bits), RequestPlace::Behind) => self.end_bits(up_to_bits, 0, end_bits),
            (Some(end_bits), RequestPlace::Anywhere) => {
                let requests_bits = self.requests * self.request_bits;
                self.end_bits(up_to_bits + requests_bits, self.requests, end_bits)
            }
        };
        Response::new(end_bits, narrow(self.bits))
    }

    /// The end of the last of `frames_bits`, before which `own_replies` to requests of the same cycle may come.
    const fn end_bits(
        &self,
        frames_bits: u64,
        own_replies: u64,
        requests_end_bits: u64,
    ) -> Option<u64> {
        let latest_bits = self.reply_latest_bits(requests_end_bits);
        let Some(cycles) = latest_bits.checked_div(self.bits) else {
            return None;
        };
        let head_start_bits = (cycles + 1) * self.bits - latest_bits;
        let mut end_bits = frames_bits;
        loop {
            let own_bits = if self.reply_earliest_bits() < end_bits {
                own_replies * self.reply_bits
            } else {
                0
            };
            let others_bits = (self.jitter_bits + frames_bits + own_bits)
                .saturating_add(self.errors_bits(end_bits.saturating_add(self.bits)))
                .saturating_add(self.alarms * self.alarm_bits);
            let at_once_bits = self.replies_bits(cycles, end_bits);
            let later_bits = self.replies_bits(cycles + 1, end_bits);
            let next_bits = max(
                others_bits.saturating_add(at_once_bits),
                others_bits
                    .saturating_add(later_bits)
                    .saturating_sub(head_start_bits),
            );
            if next_bits <= end_bits {
                return Some(end_bits);
            }
            if next_bits > HORIZON_CYCLES * self.bits {
                return None;
            }
            end_bits = next_bits;
        }
    }

    /// Replies to requests of at most `oldest` cycles ago, and not so recent that they come after `end_bits`.
    const fn replies_bits(&self, oldest: u64, end_bits: u64) -> u64 {
        let beyond_end_bits = self.reply_earliest_bits().saturating_sub(end_bits);
        let Some(too_recent) = beyond_end_bits.checked_div(self.bits_rounded_up) else {
            return 0;
        };
        oldest.saturating_sub(too_recent) * self.requests * self.reply_bits
    }

    /// Earliest offer of a reply after the start of the cycle of its request.
    const fn reply_earliest_bits(&self) -> u64 {
        self.shortest_request_bits + self.response_min_bits
    }

    /// Latest offer of a reply, when the requests are through at `requests_end_bits`.
    const fn reply_latest_bits(&self, requests_end_bits: u64) -> u64 {
        requests_end_bits + self.response_max_bits
    }

    /// The last reply to the requests of a cycle, from the start of that cycle. The master waits from the acceptance of the
    /// request on, which is not before the start of its cycle.
    pub(crate) const fn reply_response(&self, requests_end_bits: Option<u64>) -> Response {
        let deadline_bits = narrow(self.reply_timeout_bits);
        let Some(requests_end_bits) = requests_end_bits else {
            return Response::new(None, deadline_bits);
        };
        let replies = self.replies(requests_end_bits);
        let others = [self.of_master(), self.alarm_burst(), self.errors()];
        let end_bits = match response(&replies, &others, &self.rules()).bits {
            Some(bits) => Some(self.reply_earliest_bits() + bits as u64),
            None => None,
        };
        Response::new(end_bits, deadline_bits)
    }

    /// The last alarm of a burst, from when the drive offers it, judged by the span in which the burst must be over.
    pub(crate) const fn alarm_response(&self, requests_end_bits: Option<u64>) -> Response {
        let alarms = self.alarm_burst();
        let Some(requests_end_bits) = requests_end_bits else {
            return Response::new(None, alarms.deadline_bits);
        };
        let replies = self.replies(requests_end_bits);
        let others = [self.of_master(), replies, self.errors()];
        response(&alarms, &others, &self.rules())
    }

    /// Everything is equally urgent to everything: then nothing is left out that a node holds back behind another frame,
    /// whatever the order of transmission.
    const fn stream(&self, count: u64, bits: u64, period_bits: u64, jitter_bits: u64) -> Message {
        Message {
            last_id: u16::MAX,
            count: narrow(count),
            jitter_bits: narrow(jitter_bits),
            ..Message::periodic(0, narrow(bits), narrow(period_bits))
        }
    }

    /// All frames of the master as one.
    const fn of_master(&self) -> Message {
        let bits = self.set_points_bits + self.requests * self.request_bits;
        self.stream(1, bits, self.bits, self.jitter_bits)
    }

    const fn replies(&self, requests_end_bits: u64) -> Message {
        let jitter_bits = self.reply_jitter_bits(requests_end_bits);
        self.stream(self.requests, self.reply_bits, self.bits, jitter_bits)
    }

    /// From the earliest to the latest offer of a reply.
    pub(crate) const fn reply_jitter_bits(&self, requests_end_bits: u64) -> u64 {
        let latest_bits = self.reply_latest_bits(requests_end_bits);
        latest_bits.saturating_sub(self.reply_earliest_bits())
    }

    const fn alarm_burst(&self) -> Message {
        self.stream(self.alarms, self.alarm_bits, 2 * self.bits, 0)
    }

    /// Errors, each as the frame that it costs. The jitter lets the last of them hit the frame under analysis itself.
    const fn errors(&self) -> Message {
        let longest_bits = self.longest_bits();
        match self.error_interval_bits {
            Some(between) => {
                let bits = ERROR_FRAME_BITS as u64 + longest_bits;
                self.stream(1, bits, between as u64, longest_bits)
            }
            None => self.stream(0, 0, 1, 0),
        }
    }

    const fn rules(&self) -> Rules {
        Rules {
            error_interval_bits: None,
            horizon_bits: narrow(HORIZON_CYCLES * self.bits),
        }
    }
}

/// The number, or the largest that fits: every quantity here is one that a plan only gets away with when it is small.
pub(crate) const fn narrow(number: u64) -> u32 {
    if number > u32::MAX as u64 {
        u32::MAX
    } else {
        number as u32
    }
}
