//! The front of the motion: the place and the velocity of a profile with a limit of the acceleration.

use crate::length;
use crate::order::Order as _;
use crate::queue::{Piece, Ring, Room};

/// Times that the velocity of a cycle is corrected: the way to a slower piece may be one over several others.
const CORRECTIONS: usize = 3;

/// Pieces that are entered in a cycle that has time, more of a long queue, so that all are in [`LATE_CYCLES`]; in another one it is none.
const ENTERED: usize = 4;
pub(crate) const LATE_CYCLES: usize = 8;

/// Pieces whose limits are looked at in a cycle, more in a long queue, so that all are in this number of cycles.
const SEARCHED: usize = 4;
pub(crate) const SEARCH_CYCLES: usize = 8;

/// Instructions on a Cortex-M4, about: of a cycle in which limits are collected, of a correction, and of a piece that is entered.
const OF_A_SEARCH: u32 = 170;
const OF_A_CORRECTION: u32 = 90;
const OF_A_PIECE: u32 = 60;

/// A way to the end that is gone in one cycle, in 2^-20 units.
const DUST: i64 = 32;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Front {
    /// In the ring: the latest piece that the front has entered.
    pub(crate) piece: usize,
    /// From the start of the path.
    pub(crate) place: i64,
    /// With [`length::LENGTH_BITS`].
    pub(crate) velocity: u32,
    in_force: InForce,
    /// While the limits are collected anew: the next piece to look at, and what was found so far.
    search: Option<(usize, InForce)>,
}

/// The lowest of the limits in force.
#[derive(Debug, Clone, Copy)]
struct InForce {
    velocity: f32,
    feed: f32,
    acceleration: f32,
    /// Where the first of them ends.
    until: i64,
}

impl InForce {
    const NONE: Self = Self {
        velocity: f32::MAX,
        feed: f32::MAX,
        acceleration: f32::MAX,
        until: i64::MAX,
    };

    fn and<const S: usize>(&mut self, piece: &Piece<S>) {
        self.velocity = self.velocity.lower(piece.velocity);
        self.feed = self.feed.lower(piece.feed);
        self.acceleration = self.acceleration.lower(piece.acceleration);
        self.until = self.until.min(piece.leave);
    }
}

impl Front {
    pub(crate) const START: Self = Self {
        piece: 0,
        place: 0,
        velocity: 0,
        in_force: InForce::NONE,
        search: None,
    };

    /// Starts anew at rest at the start of a piece.
    pub(crate) fn begin<const S: usize>(&mut self, place: usize, piece: &Piece<S>) {
        self.piece = place;
        self.place = piece.start;
        self.velocity = 0;
        self.in_force = InForce::NONE;
        self.in_force.and(piece);
        self.search = None;
    }

    pub(crate) const fn is_at_rest(&self) -> bool {
        self.velocity == 0
    }

    /// What it needs to come to rest with an acceleration, in units, cautiously.
    pub(crate) fn stopping_distance(&self, acceleration: f32) -> f32 {
        let v = length::velocity_units(self.velocity);
        v * v / (2.0 * acceleration) * 1.05 + 2.0 * v
    }

    /// A cycle. `rate` is the override, 0 for a pause; `guard` a place before which it must be able to stop.
    /// Returns the instructions it has taken beyond the usual, about.
    pub(crate) fn advance<const S: usize, const Q: usize>(
        &mut self,
        ring: &Ring<S, Q>,
        rate: f32,
        guard: Option<Room>,
        has_time: bool,
    ) -> u32 {
        let Some(piece) = ring.get(self.piece) else {
            return 0;
        };
        let change = length::velocity(self.in_force.acceleration.lower(length::FASTEST));
        let raised = length::velocity_units(self.velocity.saturating_add(change));
        let mut most = (self.in_force.feed * rate)
            .lower(self.in_force.velocity)
            .lower(raised);
        if let Some(guard) = guard
            && most * most + 2.0 * guard.acceleration * most > guard.square
        {
            most = guard.velocity(0.0);
        }
        let next = ring.get(self.piece + 1);
        let entered = if has_time {
            ENTERED.max(Q / LATE_CYCLES)
        } else {
            0
        };
        let (kept, effort) = self.kept(ring, (piece, next), most, entered);
        let velocity = length::velocity(kept)
            .min(self.velocity.saturating_add(change))
            .max(self.velocity.saturating_sub(change));
        let end = match next {
            Some(next) if !next.from_rest => i64::MAX,
            _ => piece.end(),
        };
        let left = end - self.place;
        // The last steps become smaller than what a float of 24 bits resolves.
        self.velocity = if left <= i64::from(velocity) || (left <= DUST && rate > 0.0) {
            u32::try_from(left).unwrap_or(velocity)
        } else {
            velocity
        };
        self.place += i64::from(self.velocity);
        effort + OF_A_PIECE * self.enter(ring, next, entered)
    }

    /// The highest velocity of this cycle, at most `most`, with which everything ahead can still be kept behind it.
    fn kept<'a, const S: usize, const Q: usize>(
        &self,
        ring: &'a Ring<S, Q>,
        (mut piece, mut next): (&'a Piece<S>, Option<&'a Piece<S>>),
        most: f32,
        entered_most: usize,
    ) -> (f32, u32) {
        let mut velocity = most;
        let mut place = self.place + i64::from(length::velocity(velocity));
        let (mut index, mut spent) = (self.piece, 0);
        // The farthest piece that may be entered.
        while let Some(entered) = next
            && !entered.from_rest
            && entered.enter <= place
            && index < self.piece + entered_most
        {
            index += 1;
            spent += OF_A_PIECE;
            velocity = velocity.lower(entered.velocity);
            (piece, next) = (entered, ring.get(index + 1));
        }
        let mut before = None;
        for _ in 0..CORRECTIONS {
            place = self.place + i64::from(length::velocity(velocity));
            // A slower one may not get so far.
            while index > self.piece
                && piece.enter > place
                && let Some(previous) = ring.get(index - 1)
            {
                index -= 1;
                (piece, next) = (previous, Some(piece));
            }
            // A correction holds where the room falls in the same way.
            let way = Some((index, place >= piece.alone));
            if way == before {
                break;
            }
            before = way;
            let room = piece.room(place, piece.goal(next));
            if velocity * velocity <= room.square {
                break;
            }
            velocity = room.velocity(velocity).lower(velocity);
            spent += OF_A_CORRECTION;
        }
        (velocity, spent)
    }

    /// With front and tool at the same place at rest, pieces that were passed are not in force: they are not in the ring any more.
    pub(crate) fn forget_the_past(&mut self, first: usize) {
        if self.search.is_none() {
            self.search = Some((first, InForce::NONE));
        }
    }

    /// The pieces that the front has come to; returns their number.
    fn enter<const S: usize, const Q: usize>(
        &mut self,
        ring: &Ring<S, Q>,
        next: Option<&Piece<S>>,
        most: usize,
    ) -> u32 {
        let (mut next, mut entered) = (next, 0);
        while let Some(piece) = next
            && !piece.from_rest
            && piece.enter <= self.place
            && entered < most as u32
        {
            self.piece += 1;
            self.in_force.and(piece);
            next = ring.get(self.piece + 1);
            entered += 1;
        }
        entered
    }

    /// Collects the limits anew once one of them has ended, some pieces in a cycle that has time; those of before are in force until
    /// that is done. Returns the instructions it has taken, about.
    pub(crate) fn look_back<const S: usize, const Q: usize>(
        &mut self,
        ring: &Ring<S, Q>,
        has_time: bool,
    ) -> u32 {
        if !has_time || (self.search.is_none() && self.place < self.in_force.until) {
            return 0;
        }
        let (from, mut found) = self.search.unwrap_or((ring.first(), InForce::NONE));
        let from = from.max(ring.first());
        let to = (from + SEARCHED.max(Q / SEARCH_CYCLES)).min(self.piece + 1);
        for index in from..to {
            if let Some(piece) = ring.get(index)
                && (piece.leave > self.place || index == self.piece)
            {
                found.and(piece);
            }
        }
        if to <= self.piece {
            self.search = Some((to, found));
        } else {
            self.in_force = found;
            self.search = None;
        }
        OF_A_SEARCH
    }
}
