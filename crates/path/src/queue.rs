//! The pieces of a path that are known, and the velocities at which they may be entered.
//!
//! Places are lengths from the start of the path. The *front* of the motion is a profile with a limit of the acceleration; the tool follows
//! it as the average of the latest `n` places of the front. So while the tool is in a piece, the front has been and will be in others:
//! the limits of a piece are in force for the front from `enter`, which is as far before its start as the front goes in the `n` cycles
//! before the tool arrives, to `leave`, which the front has reached when the tool is out of it.

use crate::length;
use crate::roots::square_root;
use crate::shape::Shape;

/// Planned with this much less than the acceleration: what a step of a whole cycle may need more.
const PLANNED: f32 = 1.0 - 1.0 / 64.0;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Piece<const S: usize> {
    pub(crate) shape: Shape<S>,
    /// Of the shape, what a blend has replaced.
    pub(crate) begin: i64,
    pub(crate) length: i64,
    /// Place of its start.
    pub(crate) start: i64,
    /// From here its limits are in force for the front; never decreasing from piece to piece.
    pub(crate) enter: i64,
    /// Here they end.
    pub(crate) leave: i64,
    /// Highest velocity, and the one that was asked for, in units per cycle.
    pub(crate) velocity: f32,
    pub(crate) feed: f32,
    /// Acceleration, and what the pieces before it leave of it until `alone`.
    pub(crate) acceleration: f32,
    pub(crate) shared: f32,
    pub(crate) alone: i64,
    /// Square of the highest velocity at `enter` from which everything that is known can be kept.
    pub(crate) entry: f32,
    /// Lowest of `shared` from here to the end of what is known; [`f32::MAX`] until it is planned.
    pub(crate) least: f32,
    /// The tool comes to rest before it.
    pub(crate) from_rest: bool,
}

/// The square of the highest velocity at a place from which everything ahead can be kept, and the acceleration by which it has to fall
/// there. Beyond the end of a path it is negative.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Room {
    pub(crate) square: f32,
    pub(crate) acceleration: f32,
}

impl Room {
    /// To rest within a length.
    pub(crate) fn before_rest(length: i64, acceleration: f32) -> Self {
        let acceleration = PLANNED * acceleration;
        Self {
            square: 2.0 * acceleration * length::units(length),
            acceleration,
        }
    }

    /// The highest velocity of a cycle that ends with this room when it is `ahead` units further.
    pub(crate) fn velocity(&self, ahead: f32) -> f32 {
        let a = self.acceleration;
        let room = self.square + 2.0 * a * ahead;
        if room <= 0.0 {
            return 0.0;
        }
        room / (square_root(a * a + room) + a)
    }
}

/// What a piece asks of the one before it: at this place at most this square of a velocity.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Entry {
    place: i64,
    square: f32,
}

impl<const S: usize> Piece<S> {
    pub(crate) const EMPTY: Self = Self {
        shape: Shape::EMPTY,
        begin: 0,
        length: 0,
        start: 0,
        enter: 0,
        leave: 0,
        velocity: 0.0,
        feed: 0.0,
        acceleration: 1.0,
        shared: 1.0,
        alone: 0,
        entry: 0.0,
        least: f32::MAX,
        from_rest: true,
    };

    pub(crate) const fn end(&self) -> i64 {
        self.start + self.length
    }

    /// What this piece asks of the one before it.
    pub(crate) const fn asks(&self) -> Entry {
        if self.from_rest {
            return Entry {
                place: self.start,
                square: 0.0,
            };
        }
        Entry {
            place: self.enter,
            square: self.entry,
        }
    }

    /// What the piece before the next one must keep: what that asks for, or rest at its own end.
    pub(crate) fn goal(&self, next: Option<&Self>) -> Entry {
        match next {
            Some(next) => next.asks(),
            None => Entry {
                place: self.end(),
                square: 0.0,
            },
        }
    }

    /// What a front at a place in this piece must keep, before its goal.
    pub(crate) fn room(&self, place: i64, goal: Entry) -> Room {
        let (goal, square) = (goal.place, goal.square);
        let alone = PLANNED * self.acceleration;
        if place >= self.alone {
            return Room {
                square: square + 2.0 * alone * length::units(goal - place),
                acceleration: alone,
            };
        }
        let (turn, shared) = (self.alone.min(goal), PLANNED * self.shared);
        let later = alone * length::units(goal - turn);
        Room {
            square: square + 2.0 * (later + shared * length::units(turn - place)),
            acceleration: shared,
        }
    }

    /// [`Self::entry`], so that the next one can be entered.
    pub(crate) fn entry_before(&self, goal: Entry) -> f32 {
        let square = self.room(self.enter, goal).square;
        let most = self.velocity * self.velocity;
        if square < most { square } else { most }
    }
}

/// A ring of pieces; places in it count up for ever.
#[derive(Debug, Clone)]
pub(crate) struct Ring<const S: usize, const Q: usize> {
    pieces: [Piece<S>; Q],
    first: usize,
    end: usize,
}

impl<const S: usize, const Q: usize> Ring<S, Q> {
    pub(crate) const fn new() -> Self {
        Self {
            pieces: [Piece::EMPTY; Q],
            first: 0,
            end: 0,
        }
    }

    pub(crate) fn get(&self, place: usize) -> Option<&Piece<S>> {
        if place < self.first || place >= self.end {
            return None;
        }
        self.pieces.get(place.checked_rem(Q)?)
    }

    pub(crate) fn get_mut(&mut self, place: usize) -> Option<&mut Piece<S>> {
        if place < self.first || place >= self.end {
            return None;
        }
        self.pieces.get_mut(place.checked_rem(Q)?)
    }

    pub(crate) fn push(&mut self, piece: &Piece<S>) {
        if self.free() == 0 {
            return;
        }
        if let Some(place) = self.end.checked_rem(Q)
            && let Some(slot) = self.pieces.get_mut(place)
        {
            *slot = *piece;
            self.end += 1;
        }
    }

    /// Forgets what is before a place.
    pub(crate) fn retire(&mut self, before: usize) {
        self.first = self.first.max(before.min(self.end));
    }

    pub(crate) fn clear(&mut self) {
        self.first = self.end;
    }

    pub(crate) const fn free(&self) -> usize {
        Q - (self.end - self.first)
    }

    pub(crate) const fn first(&self) -> usize {
        self.first
    }

    pub(crate) const fn end(&self) -> usize {
        self.end
    }
}
