//! How fast each piece may be entered, planned backward from the end.

use crate::front::Front;
use crate::order::Order as _;
use crate::queue::{Ring, Room};

/// A planning under way, and what holds until it is done.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plan {
    /// The piece to be planned next.
    next: Option<usize>,
    guard: Option<Guard>,
}

/// Until pieces are planned that were added behind it, the front must be able to stop before a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Guard {
    pub(crate) place: i64,
    pub(crate) acceleration: f32,
}

impl Guard {
    fn room(&self, front: i64) -> Room {
        Room::before_rest(self.place - front, self.acceleration)
    }
}

impl Plan {
    pub(crate) const DONE: Self = Self {
        next: None,
        guard: None,
    };

    /// Nothing to be planned yet, but something that must hold.
    pub(crate) const fn guarded(guard: Guard) -> Self {
        Self {
            next: None,
            guard: Some(guard),
        }
    }

    /// From the last piece backward.
    pub(crate) const fn begin(&mut self, last: usize) {
        self.next = Some(last);
    }

    /// Places are counted from another one.
    pub(crate) const fn count_from(&mut self, start: i64) {
        if let Some(guard) = &mut self.guard {
            guard.place -= start;
        }
    }

    pub(crate) const fn is_done(&self) -> bool {
        self.next.is_none()
    }

    pub(crate) fn room(&self, front: &Front) -> Option<Room> {
        self.guard.map(|guard| guard.room(front.place))
    }

    /// Plans a piece. Where nothing changes, nothing does further ahead.
    pub(crate) fn step<const S: usize, const Q: usize>(
        &mut self,
        ring: &mut Ring<S, Q>,
        front: &Front,
    ) {
        let Some(place) = self.next.filter(|place| *place > front.piece) else {
            *self = Self::DONE;
            return;
        };
        let next = ring.get(place + 1);
        let behind = next.map_or(f32::MAX, |next| next.least);
        let Some(piece) = ring.get(place) else {
            *self = Self::DONE;
            return;
        };
        let entry = piece.entry_before(piece.goal(next));
        let least = behind.lower(piece.shared);
        let keeps_entry = piece.from_rest || entry.to_bits() == piece.entry.to_bits();
        let is_same = keeps_entry && least.to_bits() == piece.least.to_bits();
        if let Some(piece) = ring.get_mut(place) {
            piece.least = least;
            if !piece.from_rest {
                piece.entry = entry;
            }
        }
        if is_same {
            *self = Self::DONE;
        } else {
            self.next = place.checked_sub(1);
        }
    }
}
