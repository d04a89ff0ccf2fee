//! Orders to a motion that runs: from keys, from a socket, from a stream.

mod keys;
mod options;
mod socket;
mod words;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};

use crate::set_points::{Order, SetPointSource};
pub(crate) use keys::{Keys, wish};
pub(crate) use options::{ControlOptions, Listening};
pub(crate) use socket::{ControlSocket, broken};
pub(crate) use words::{WordError, order};

/// Percent that a key changes the speed by.
const STEP_PERCENT: u16 = 10;
/// Largest percentage.
const MOST_PERCENT: u16 = trajectory::TimeScale::MOST_PERCENT;

/// What somebody asks of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wish {
    Order(Order),
    /// Pause what goes, and let go on what is paused.
    TogglePause,
    Faster,
    Slower,
}

impl Wish {
    /// As an order to a motion that is like this.
    pub(crate) fn as_order(self, source: &dyn SetPointSource) -> Order {
        let speed = source.speed();
        match self {
            Self::Order(order) => order,
            Self::TogglePause if speed.is_paused => Order::Resume,
            Self::TogglePause => Order::Pause,
            Self::Faster => Order::Override((speed.asked_percent + STEP_PERCENT).min(MOST_PERCENT)),
            Self::Slower => Order::Override(speed.asked_percent.saturating_sub(STEP_PERCENT)),
        }
    }
}

/// How a motion goes, for threads that are asked.
#[derive(Debug, Default)]
pub(crate) struct Status {
    asked_percent: AtomicU32,
    actual_percent: AtomicU32,
    is_paused: AtomicBool,
    passed_cycles: AtomicU32,
}

impl Status {
    fn note(&self, source: &dyn SetPointSource) {
        let speed = source.speed();
        self.asked_percent
            .store(speed.asked_percent.into(), Ordering::Relaxed);
        self.actual_percent
            .store(speed.actual_percent.round() as u32, Ordering::Relaxed);
        self.is_paused.store(speed.is_paused, Ordering::Relaxed);
        let passed = u32::try_from(source.progress().0).unwrap_or(u32::MAX);
        self.passed_cycles.store(passed, Ordering::Relaxed);
    }
}

impl Status {
    /// Percent of the speed of the motion, and whether it is paused.
    pub(crate) fn speed(&self) -> (u32, bool) {
        (
            self.actual_percent.load(Ordering::Relaxed),
            self.is_paused.load(Ordering::Relaxed),
        )
    }
}

impl core::fmt::Display for Status {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(
            f,
            "cycle={} speed={} asked={} paused={}",
            self.passed_cycles.load(Ordering::Relaxed),
            self.actual_percent.load(Ordering::Relaxed),
            self.asked_percent.load(Ordering::Relaxed),
            self.is_paused.load(Ordering::Relaxed)
        )
    }
}

/// Where every wish arrives.
#[derive(Debug)]
pub(crate) struct Wishes {
    receiver: Receiver<Wish>,
    sender: Sender<Wish>,
    status: Arc<Status>,
}

impl Wishes {
    pub(crate) fn new() -> Self {
        let (sender, receiver) = channel();
        Self {
            receiver,
            sender,
            status: Arc::default(),
        }
    }

    /// For those who wish.
    pub(crate) fn sender(&self) -> Sender<Wish> {
        self.sender.clone()
    }

    /// For those who ask.
    pub(crate) fn status(&self) -> Arc<Status> {
        Arc::clone(&self.status)
    }

    /// Hands every wish on to a motion, before its next cycle.
    pub(crate) fn hand_on(&self, source: &mut dyn SetPointSource) {
        while let Ok(wish) = self.receiver.try_recv() {
            source.order(wish.as_order(source));
        }
        self.status.note(source);
    }
}
