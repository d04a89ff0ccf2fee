//! The known path: its pieces, the front in them, and how pieces are added.

use crate::front::{Front, LATE_CYCLES, SEARCH_CYCLES};
use crate::inbox::PLACES;
use crate::length;
use crate::order::Order as _;
use crate::plan::{Guard, Plan};
use crate::queue::{Piece, Ring};
use crate::shape::Point;

/// Cycles that limits are in force before and behind what the average needs: set-points are compared over three cycles.
const EDGE_CYCLES: f32 = 3.0;
/// Cycles that take a piece one after another: as many as can wait, and two more while they are prepared. They have no time to look back.
const TAKING_CYCLES: usize = PLACES + 2;
/// Cycles that limits are in force before what the average needs, where the front enters many pieces at once.
const EARLY_CYCLES: f32 = EDGE_CYCLES + (LATE_CYCLES + TAKING_CYCLES) as f32;

/// Cycles of the front that it may be behind a border when it learns of it.
const BEHIND: f32 = (1 + SEARCH_CYCLES + TAKING_CYCLES) as f32 + 0.5;

/// From here on places are counted anew at the next rest: days before they come to the end of 64 bits.
const FAR: i64 = 1 << 61;

/// What is known of the path.
#[derive(Debug, Clone)]
pub(crate) struct Known<const S: usize, const Q: usize> {
    pub(crate) ring: Ring<S, Q>,
    pub(crate) front: Front,
    pub(crate) plan: Plan,
    /// Of the average.
    cycles: f32,
}

/// What the limits of a piece depend on that follows.
#[derive(Debug, Clone, Copy)]
struct Before {
    end: i64,
    enter: i64,
    leave: i64,
    alone: i64,
    velocity: f32,
    acceleration: f32,
    shared: f32,
}

impl<const S: usize, const Q: usize> Known<S, Q> {
    /// Nothing, with an average over so many cycles.
    pub(crate) fn nothing(cycles: usize) -> Self {
        Self {
            ring: Ring::new(),
            front: Front::START,
            plan: Plan::DONE,
            cycles: cycles as f32,
        }
    }

    pub(crate) fn forget(&mut self) {
        self.ring.clear();
        self.plan = Plan::DONE;
    }

    /// Whether there is room for a piece and the blend before it.
    pub(crate) const fn has_room(&self) -> bool {
        self.ring.free() >= 2
    }

    /// Whether the front is at the end of the last piece.
    pub(crate) fn is_at_end(&self) -> bool {
        self.last()
            .is_none_or(|(place, last)| self.front.piece >= place && self.front.place >= last.end())
    }

    /// A cycle of the front. Returns the instructions it has taken beyond the usual, about.
    pub(crate) fn advance(&mut self, rate: f32, has_time: bool) -> u32 {
        let guard = self.plan.room(&self.front);
        let spent = self.front.look_back(&self.ring, has_time);
        spent + self.front.advance(&self.ring, rate, guard, has_time)
    }

    /// Plans a piece.
    pub(crate) fn plan_some(&mut self) {
        self.plan.step(&mut self.ring, &self.front);
    }

    /// A piece that the tool has passed and that is not in force any more.
    pub(crate) fn forget_before(&mut self, tool: usize) {
        let first = self.ring.first();
        if first < tool
            && let Some(piece) = self.ring.get(first)
            && piece.leave <= self.front.place
        {
            self.ring.retire(first + 1);
        }
    }

    /// Front and tool stand: the piece that begins now, if there is one.
    pub(crate) fn rest(&mut self, tool: usize) -> Option<usize> {
        let first = self.ring.first();
        self.ring.retire(tool);
        if first != self.ring.first() {
            self.front.forget_the_past(self.ring.first());
        }
        let next = self.front.piece + 1;
        let (piece, following) = (self.ring.get(self.front.piece)?, self.ring.get(next)?);
        (following.from_rest && self.front.place >= piece.end()).then_some(next)
    }

    /// The front at the start of a piece, from rest. Returns its first point, and how far the path should be known before it goes on.
    pub(crate) fn begin(&mut self, place: usize) -> Option<(Point<S>, i64)> {
        self.ring.retire(place);
        let start = self.ring.get(place)?.start;
        if start > FAR {
            self.count_from(start);
        }
        let piece = self.ring.get(place)?;
        self.front.begin(place, piece);
        let (from, velocity) = (piece.shape.from, piece.velocity);
        let cycles = self.cycles + velocity / piece.acceleration;
        let until = self.front.place + length::from_units(velocity * cycles);
        Some((from, until))
    }

    /// Places are counted from another one, where front and tool stand.
    #[cold]
    fn count_from(&mut self, start: i64) {
        for index in self.ring.first()..self.ring.end() {
            if let Some(piece) = self.ring.get_mut(index) {
                for place in [
                    &mut piece.start,
                    &mut piece.enter,
                    &mut piece.leave,
                    &mut piece.alone,
                ] {
                    *place -= start;
                }
            }
        }
        self.plan.count_from(start);
    }

    /// Whether enough of the path is known for the front to leave the place where it stands: up to a place, or a quarter of the queue.
    pub(crate) fn reaches(&self, place: i64) -> bool {
        self.ring.free() + Q / 4 < Q || self.last().is_none_or(|(_, last)| last.end() >= place)
    }

    /// The last piece, and its place in the ring.
    pub(crate) fn last(&self) -> Option<(usize, &Piece<S>)> {
        let place = self.ring.end().checked_sub(1)?;
        Some((place, self.ring.get(place)?))
    }

    /// Adds a piece that starts from rest where the path ends now. Tells whether it is the only one.
    pub(crate) fn start_with(&mut self, piece: &mut Piece<S>) -> bool {
        let last = self.last().map(|(_, last)| last.end());
        let start = last.unwrap_or(self.front.place);
        piece.start = start;
        piece.enter = start;
        piece.alone = start;
        piece.shared = piece.acceleration;
        piece.least = f32::MAX;
        piece.entry = 0.0;
        piece.from_rest = true;
        piece.leave = self.left(start + piece.length, piece.velocity);
        self.ring.push(piece);
        last.is_none()
    }

    /// Where the limits of a piece are in force that follows the last one, from which so much is cut off, without a rest.
    pub(crate) fn follow_last(&self, piece: &mut Piece<S>, cut: i64) -> bool {
        let Some((_, last)) = self.last() else {
            return false;
        };
        let before = self.before(last, last.length - cut);
        self.following(&before, piece);
        true
    }

    /// The same of a piece that follows one which is not among the known ones yet.
    pub(crate) fn follow(&self, before: &Piece<S>, piece: &mut Piece<S>) {
        self.following(&self.before(before, before.length), piece);
    }

    /// Makes the front stop before a piece that is about to be added and planned, if it still can.
    pub(crate) fn guard(&mut self, piece: &Piece<S>) -> bool {
        let Some((place, last)) = self.last() else {
            return false;
        };
        let mut acceleration = last.acceleration.lower(last.shared).lower(piece.shared);
        if let Some(piece) = self.ring.get(self.front.piece) {
            acceleration = acceleration.lower(piece.shared);
        }
        if self.front.piece < place
            && let Some(next) = self.ring.get(self.front.piece + 1)
        {
            acceleration = acceleration.lower(next.least);
        }
        let room = piece.enter - self.front.place;
        if room < 0 || length::units(room) < self.front.stopping_distance(acceleration) {
            return false;
        }
        self.plan = Plan::guarded(Guard {
            place: piece.enter,
            acceleration,
        });
        true
    }

    /// Adds a piece that follows the last one, from which so much is cut off.
    pub(crate) fn add(&mut self, piece: &Piece<S>, cut: i64) {
        if let Some((place, last)) = self.last() {
            self.connect(place, last.length - cut, piece);
        }
    }

    /// Adds the piece behind a blend that was added.
    pub(crate) fn add_more(&mut self, piece: &Piece<S>) {
        self.ring.push(piece);
        self.plan_anew();
    }

    /// Plans what was added.
    pub(crate) fn plan_anew(&mut self) {
        self.plan.begin(self.ring.end() - 1);
    }

    /// What follows a piece that is shortened to a length.
    fn before(&self, piece: &Piece<S>, length: i64) -> Before {
        let end = piece.start + length;
        Before {
            end,
            enter: piece.enter,
            leave: self.left(end, piece.velocity),
            alone: piece.alone,
            velocity: piece.velocity,
            acceleration: piece.acceleration,
            shared: piece.shared,
        }
    }

    /// Where the limits of a piece are in force that follows another one without a rest.
    fn following(&self, before: &Before, piece: &mut Piece<S>) {
        // A cycle must not pass more than a few pieces.
        piece.velocity = piece.velocity.lower(4.0 * length::units(piece.length));
        piece.start = before.end;
        let cycles = 0.5 * self.cycles + EARLY_CYCLES;
        let way = piece.velocity.lower(before.velocity) * cycles;
        piece.enter = before.enter.max(before.end - length::from_units(way));
        piece.leave = self.left(piece.end(), piece.velocity);
        // What is in force until the one before it leaves.
        let alone = before.leave + length::from_units(BEHIND * before.velocity);
        piece.alone = before.alone.max(alone);
        let shared = if before.alone > piece.enter {
            before.shared.lower(before.acceleration)
        } else {
            before.acceleration
        };
        piece.shared = shared.lower(piece.acceleration);
        piece.entry = 0.0;
        piece.least = f32::MAX;
        piece.from_rest = false;
    }

    /// Where the front is at the latest when the tool leaves a piece.
    fn left(&self, end: i64, velocity: f32) -> i64 {
        end + length::from_units(velocity * (0.5 * self.cycles + EDGE_CYCLES))
    }

    /// Puts a piece behind the last one, which gets a length; in its place if that is nothing.
    fn connect(&mut self, place: usize, length: i64, next: &Piece<S>) {
        let is_replaced = length == 0 && self.front.piece < place;
        let Some(slot) = self.ring.get_mut(place) else {
            return;
        };
        if is_replaced {
            *slot = *next;
            return;
        }
        slot.length = length;
        let (end, velocity) = (slot.end(), slot.velocity);
        let leave = self.left(end, velocity);
        if let Some(slot) = self.ring.get_mut(place) {
            slot.leave = leave;
        }
        self.ring.push(next);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A blend and the piece behind it are added one after the other: neither may be left out.
    #[test]
    fn a_queue_with_one_place_has_no_room() {
        let mut known: Known<2, 4> = Known::nothing(1);
        let mut room = std::vec::Vec::new();
        for _ in 0..5 {
            room.push(known.has_room());
            known.ring.push(&Piece::EMPTY);
        }
        assert_eq!(room, [true, true, true, false, false]);
        assert_eq!((known.ring.end(), known.ring.free()), (4, 0));
    }
}
