//! The stream on the board, for those who give orders to it.

use std::collections::VecDeque;

use board_link::message::{Request, Snapshot};

use crate::set_points::{Order, SetPointSource, Speed, Step, held};

/// What is known of the stream, and what is to be ordered.
#[derive(Debug)]
pub(super) struct Remote {
    cycles: Option<u64>,
    passed: u64,
    asked_percent: u16,
    actual_percent: u16,
    is_paused: bool,
    /// Was told to stop.
    pub(super) is_stopping: bool,
    orders: VecDeque<Request>,
    /// The highest speed at which the motion keeps its own limits.
    most_percent: u16,
    /// The override that was told last not to be played.
    is_held_to: u16,
    notices: VecDeque<String>,
}

impl Remote {
    /// A stream of so many cycles, where that is known, that was not begun yet.
    pub(super) fn new(cycles: Option<u64>, most_percent: u16) -> Self {
        Self {
            cycles,
            passed: 0,
            asked_percent: 100,
            actual_percent: 100,
            is_paused: false,
            is_stopping: false,
            orders: VecDeque::new(),
            most_percent,
            is_held_to: 0,
            notices: VecDeque::new(),
        }
    }

    pub(super) fn note(&mut self, snapshot: &Snapshot) {
        self.passed = snapshot.player.time_cycles.into();
        self.actual_percent = snapshot.player.percent;
    }

    /// The stream begins, at the speed that was ordered before.
    pub(super) fn percent_at_begin(&mut self) -> u16 {
        self.orders.clear();
        self.asked_percent
    }

    /// The next order; it comes back when it could not be given.
    pub(super) fn next_order(&mut self) -> Option<Request> {
        self.orders.pop_front()
    }

    /// It could not be given yet.
    pub(super) fn put_back(&mut self, order: Request) {
        self.orders.push_front(order);
    }

    fn within_limits(&mut self, percent: u16) -> u16 {
        if percent > self.most_percent && self.is_held_to != percent {
            self.is_held_to = percent;
            self.notices.push_back(held(percent, self.most_percent));
        }
        percent.min(self.most_percent)
    }
}

impl SetPointSource for Remote {
    fn axes(&self) -> usize {
        0
    }

    /// The board has the set-points.
    fn next(&mut self, _row: &mut [i32]) -> Step {
        Step::Goes
    }

    fn order(&mut self, order: Order) {
        let request = match order {
            Order::Pause => {
                self.is_paused = true;
                Request::Pause
            }
            Order::Resume => {
                self.is_paused = false;
                Request::Resume
            }
            Order::Override(percent) => {
                let percent = self.within_limits(percent);
                self.asked_percent = percent;
                // One that still waits is not wanted any more.
                let is_other = |order: &Request| !matches!(order, Request::Override { .. });
                self.orders.retain(is_other);
                Request::Override { percent }
            }
            Order::Stop => {
                self.is_stopping = true;
                // Behind nothing.
                self.orders.clear();
                Request::Stop
            }
        };
        self.orders.push_back(request);
    }

    fn speed(&self) -> Speed {
        Speed {
            asked_percent: self.asked_percent,
            actual_percent: self.actual_percent.into(),
            is_paused: self.is_paused,
        }
    }

    fn progress(&self) -> (u64, Option<u64>) {
        let passed = self.cycles.map_or(self.passed, |all| self.passed.min(all));
        (passed, self.cycles)
    }

    fn next_notice(&mut self) -> Option<String> {
        self.notices.pop_front()
    }
}
