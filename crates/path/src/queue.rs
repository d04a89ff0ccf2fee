//! The pieces of a path that are known, and the velocities at which they may be entered.
//!
//! Places are lengths from the start of the path. The *front* of the motion is a profile with a limit of the acceleration; the tool follows
//! it as the average of the latest `n` places of the front. So while the tool is in a piece, the front has been and will be in others:
//! the limits of a piece are in force for the front from `enter`, which is as far before its start as the front goes in the `n` cycles
//! before the tool arrives, to `leave`, which the front has reached when the tool is out of it.

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
    /// The tool comes to rest before it.
    pub(crate) from_rest: bool,
}

/// A velocity that must not be exceeded at a place ahead, and the acceleration to reduce it with.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ahead {
    pub(crate) distance: f32,
    /// Its square.
    pub(crate) square: f32,
    pub(crate) acceleration: f32,
}

impl Ahead {
    /// Rest within a length.
    pub(crate) fn rest(length: i64, acceleration: f32) -> Self {
        Self {
            distance: crate::length::units(length.max(0)),
            square: 0.0,
            acceleration: PLANNED * acceleration,
        }
    }

    /// The highest velocity now, for a front that moves for a whole cycle before it can change it.
    pub(crate) fn velocity(&self) -> f32 {
        let a = self.acceleration;
        let room = self.square + 2.0 * a * self.distance;
        let braking = room / (square_root(a * a + room) + a);
        if braking * braking >= self.square {
            braking
        } else {
            square_root(self.square)
        }
    }
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
        from_rest: true,
    };

    pub(crate) const fn end(&self) -> i64 {
        self.start + self.length
    }

    /// What a front in this piece must keep, before the next one or before the end.
    pub(crate) fn ahead(&self, place: i64, next: Option<&Self>) -> Ahead {
        let (goal, square) = match next {
            Some(next) if !next.from_rest => (next.enter, next.entry),
            _ => (self.end(), 0.0),
        };
        let distance = |to: i64, from: i64| crate::length::units((to - from).max(0));
        if place >= self.alone {
            return Ahead {
                distance: distance(goal, place),
                square,
                acceleration: PLANNED * self.acceleration,
            };
        }
        let turn = self.alone.min(goal);
        let later = 2.0 * PLANNED * self.acceleration * distance(goal, turn);
        Ahead {
            distance: distance(turn, place),
            square: square + later,
            acceleration: PLANNED * self.shared,
        }
    }

    /// [`Self::entry`], so that the next one can be entered.
    pub(crate) fn entry_before(&self, next: Option<&Self>) -> f32 {
        let ahead = self.ahead(self.enter, next);
        let square = ahead.square + 2.0 * ahead.acceleration * ahead.distance;
        square.min(self.velocity * self.velocity)
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

    pub(crate) fn push(&mut self, piece: Piece<S>) {
        if self.free() == 0 {
            return;
        }
        if let Some(place) = self.end.checked_rem(Q)
            && let Some(slot) = self.pieces.get_mut(place)
        {
            *slot = piece;
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
