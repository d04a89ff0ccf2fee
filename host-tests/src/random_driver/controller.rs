//! A controller with a few mailboxes, in every way that the outcome of an offer can be.

use can_motion::{BusErrorKind, Outcome};
use dyn_can::DataFrame;
use fastrand::Rng;

/// A frame that waits in a mailbox.
#[derive(Debug, Clone, Copy)]
pub(super) struct Waiting {
    pub(super) frame: DataFrame,
    /// When the controller took it.
    pub(super) taken_us: u64,
}

/// A controller.
#[derive(Debug)]
pub(super) struct Controller {
    waiting: Vec<Waiting>,
    room: usize,
    by_identifier: bool,
    displaces: bool,
    takes_back: bool,
    /// One of so many offers fails.
    fails_once_in: u32,
    /// Nobody acknowledges: nothing leaves.
    pub(super) is_blocked: bool,
}

impl Controller {
    /// A controller of any kind.
    pub(super) fn draw(random: &mut Rng) -> Self {
        let by_identifier = random.bool();
        Self {
            waiting: Vec::new(),
            room: random.usize(1..=3),
            by_identifier,
            displaces: by_identifier && random.bool(),
            takes_back: random.bool(),
            fails_once_in: if random.bool() { 5_000 } else { u32::MAX },
            is_blocked: false,
        }
    }

    /// The master offers a frame.
    pub(super) fn offer(
        &mut self,
        now_us: u64,
        frame: &DataFrame,
        random: &mut Rng,
    ) -> Outcome<DataFrame> {
        let new = Waiting {
            frame: *frame,
            taken_us: now_us,
        };
        if random.u32(..self.fails_once_in) == 0 {
            if random.bool() && self.waiting.len() < self.room {
                self.waiting.push(new);
            }
            return Outcome::Failed(BusErrorKind::Other);
        }
        if self.waiting.len() < self.room {
            self.waiting.push(new);
            return Outcome::Accepted;
        }
        let least_urgent = self
            .waiting
            .iter()
            .enumerate()
            .max_by_key(|(_, held)| held.frame.id());
        match least_urgent {
            Some((place, held)) if self.displaces && held.frame.id() > frame.id() => {
                let displaced = held.frame;
                self.waiting.remove(place);
                self.waiting.push(new);
                Outcome::Displaced(displaced)
            }
            _ => Outcome::Full,
        }
    }

    /// The newest frame that waits, given back unsent.
    pub(super) fn take_back(&mut self) -> Option<DataFrame> {
        if !self.takes_back {
            return None;
        }
        self.waiting.pop().map(|held| held.frame)
    }

    /// The next frame on the wire.
    pub(super) fn transmit(&mut self) -> Option<Waiting> {
        if self.is_blocked || self.waiting.is_empty() {
            return None;
        }
        let urgent = self
            .waiting
            .iter()
            .enumerate()
            .min_by_key(|(_, held)| held.frame.id());
        let place = if self.by_identifier {
            urgent.map_or(0, |(place, _)| place)
        } else {
            0
        };
        Some(self.waiting.remove(place))
    }

    /// Whether a frame like that waits.
    pub(super) fn holds(&self, like: impl Fn(&DataFrame) -> bool) -> bool {
        self.waiting.iter().any(|held| like(&held.frame))
    }

    /// Bus-off: what waits is gone.
    pub(super) fn forget(&mut self) {
        self.waiting.clear();
    }
}
