//! One cycle on the wire: every frame at its longest, and where the replies may come.

use can_motion::plan::{BusPlan, frames};
use can_motion::{AxisConfig, MasterConfig, PollKind};

/// What a block stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BlockKind {
    SetPoint,
    Request,
    /// From the earliest begin to the latest end of the replies.
    Replies,
}

/// A stretch of the cycle, in microseconds.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Block {
    pub(super) kind: BlockKind,
    pub(super) label: String,
    pub(super) from_us: f64,
    pub(super) until_us: f64,
}

/// One cycle.
#[derive(Debug, Clone)]
pub(super) struct Picture {
    pub(super) cycle_us: f64,
    pub(super) blocks: Vec<Block>,
    /// The replies share no time with the set-points.
    pub(super) replies_in_slack: bool,
}

impl Picture {
    pub(super) fn new(plan: &BusPlan<'_>) -> Self {
        let (config, axes) = (plan.config(), plan.axes());
        let bit_us = 1_000.0 / f64::from(config.bus.bit_rate.kbit_per_s());
        let mut picture = Self {
            cycle_us: f64::from(config.cycle_us),
            blocks: Vec::new(),
            replies_in_slack: true,
        };
        let requests = plan.cycle().requests_per_cycle();
        let polls = longest_poll(axes);
        let place = plan.requests_behind().map_or(axes.len(), usize::from);
        let mut at_us = 0.0;
        for index in 0..=axes.len() {
            if index == place && requests > 0 {
                at_us = picture.ask(config, requests, polls, at_us, bit_us);
            }
            if let Some(axis) = axes.get(index) {
                let us = f64::from(frames::set_point_bits(axis)) * bit_us;
                let drive = axis.drive.to_string();
                at_us = picture.add(BlockKind::SetPoint, drive, at_us, us);
            }
        }
        picture.replies_in_slack = !picture.replies_meet_set_points();
        picture
    }

    fn add(&mut self, kind: BlockKind, label: String, from_us: f64, us: f64) -> f64 {
        self.blocks.push(Block {
            kind,
            label,
            from_us,
            until_us: from_us + us,
        });
        from_us + us
    }

    /// The requests of a cycle, and the time in which their replies are on the wire, in this cycle as in every one.
    fn ask(
        &mut self,
        config: &MasterConfig,
        requests: u64,
        (request_bits, reply_bits): (u16, u16),
        from_us: f64,
        bit_us: f64,
    ) -> f64 {
        let window = config.bus.response;
        let request_us = f64::from(request_bits) * bit_us;
        let mut at_us = from_us;
        for _ in 0..requests {
            at_us = self.add(BlockKind::Request, "poll".to_owned(), at_us, request_us);
        }
        let replies_us = requests as f64 * f64::from(reply_bits) * bit_us;
        let first_us = from_us + request_us + f64::from(window.min_us);
        let last_us = at_us + f64::from(window.max_us) + replies_us;
        self.add_replies(first_us, last_us);
        at_us
    }

    /// Folds a stretch that may lie in later cycles into one.
    fn add_replies(&mut self, first_us: f64, last_us: f64) {
        let cycle_us = self.cycle_us;
        if last_us - first_us >= cycle_us {
            self.add(BlockKind::Replies, "replies".to_owned(), 0.0, cycle_us);
            return;
        }
        let from_us = first_us % cycle_us;
        let until_us = from_us + last_us - first_us;
        let here_us = until_us.min(cycle_us) - from_us;
        self.add(BlockKind::Replies, "replies".to_owned(), from_us, here_us);
        if until_us > cycle_us {
            self.add(
                BlockKind::Replies,
                "replies".to_owned(),
                0.0,
                until_us - cycle_us,
            );
        }
    }

    fn replies_meet_set_points(&self) -> bool {
        let of = |kind| self.blocks.iter().filter(move |block| block.kind == kind);
        of(BlockKind::Replies).any(|replies| {
            of(BlockKind::SetPoint).any(|set_point| {
                replies.from_us < set_point.until_us && set_point.from_us < replies.until_us
            })
        })
    }
}

/// Bits of the longest request and the longest reply.
fn longest_poll(axes: &[AxisConfig]) -> (u16, u16) {
    let mut longest = (0, 0);
    for axis in axes {
        for kind in PollKind::ALL {
            if axis.polls.of(kind).is_some() {
                longest.0 = longest.0.max(frames::poll_bits(axis, kind));
                longest.1 = longest.1.max(frames::reply_bits(axis.drive, kind));
            }
        }
    }
    longest
}
