//! The tool: where the average of the front's latest places is.

use trajectory::fixed::part_of;

use crate::filter::Average;
use crate::front::Front;
use crate::queue::Ring;
use crate::shape::Point;

/// Instructions on a Cortex-M4, about: more of an arc than of a line, and of a border between pieces.
const OF_AN_ARC: u32 = 150;
const OF_A_PIECE: u32 = 40;

#[derive(Debug, Clone)]
pub(crate) struct Tool<const S: usize> {
    pub(crate) average: Average,
    /// One over the cycles of the average, 64 bits behind the point.
    share: u64,
    /// Its piece, and its way in it times the cycles of the average.
    piece: usize,
    way: i64,
    pub(crate) place: Point<S>,
    /// Instructions that the latest cycle has taken beyond those of a line, about.
    cost: u32,
}

impl<const S: usize> Tool<S> {
    /// At rest, with an average over so many cycles.
    pub(crate) fn new(cycles: usize, place: Point<S>) -> Self {
        Self {
            average: Average::new(cycles),
            share: u64::MAX.checked_div(cycles as u64).unwrap_or(u64::MAX),
            piece: 0,
            way: 0,
            place,
            cost: 0,
        }
    }

    pub(crate) const fn piece(&self) -> usize {
        self.piece
    }

    /// At the start of a piece.
    pub(crate) const fn begin(&mut self, piece: usize, place: Point<S>) {
        self.wait_for(piece);
        self.place = place;
    }

    /// Where it is, for a piece to come.
    pub(crate) const fn wait_for(&mut self, piece: usize) {
        self.piece = piece;
        self.way = 0;
    }

    pub(crate) const fn cost(&self) -> u32 {
        self.cost
    }

    /// A cycle of the front. Tells whether the tool moves.
    pub(crate) fn follow<const Q: usize>(&mut self, front: &Front, ring: &Ring<S, Q>) -> bool {
        let way = self.average.add(front.velocity);
        self.cost = 0;
        if way == 0 {
            return false;
        }
        let cycles = self.average.cycles() as i64;
        self.way += way.cast_signed();
        while let Some(piece) = ring.get(self.piece) {
            let whole = piece.length * cycles;
            if self.way <= whole || self.piece >= front.piece {
                let at = part_of(self.way, self.share).min(piece.length);
                piece.shape.put_point(piece.begin + at, &mut self.place);
                if piece.shape.is_round() {
                    self.cost += OF_AN_ARC;
                }
                break;
            }
            self.way -= whole;
            self.piece += 1;
            self.cost += OF_A_PIECE;
        }
        true
    }
}
