//! Cubics through the table of a motion that is no curve of its own: a program, or points closer than cycles.

use board_link::segment::{AxisSegment, Segment, Shape};
use trajectory::Position;
use trajectory::curve::Share;

/// The longest way from one node to the next, in cycles.
const LONGEST: usize = 1_024;
const CYCLE: u64 = 1 << 32;

/// How far a set-point may be from the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tolerance {
    /// Each is the same.
    None,
    /// By a count.
    OneCount,
}

/// As few segments as are found by going as far as possible with each. Positions, one row a cycle, are exact; a segment of one cycle always fits.
pub(super) fn fit(rows: &[Vec<Position>], tolerance: Tolerance) -> Vec<Segment> {
    let path = Path { rows, tolerance };
    let (mut segments, mut from) = (Vec::new(), 0);
    while from + 1 < rows.len() {
        let to = path.farthest(from);
        segments.push(path.segment(from, to));
        from = to;
    }
    segments
}

struct Path<'a> {
    rows: &'a [Vec<Position>],
    tolerance: Tolerance,
}

impl Path<'_> {
    /// The farthest cycle that is found by doubling and halving.
    fn farthest(&self, from: usize) -> usize {
        let most = (self.rows.len() - 1 - from).min(LONGEST);
        let fits = |steps: usize| self.fits(from, from + steps);
        let mut near = 1;
        while near < most && fits((2 * near).min(most)) {
            near = (2 * near).min(most);
        }
        let mut far = (2 * near).min(most + 1);
        while far - near > 1 {
            let middle = usize::midpoint(near, far);
            if fits(middle) {
                near = middle;
            } else {
                far = middle;
            }
        }
        from + near
    }

    fn fits(&self, from: usize, to: usize) -> bool {
        let axes = 0..self.rows[from].len();
        axes.into_iter().all(|axis| {
            let piece = self.way(axis, from, to).piece(self.rows[from][axis]);
            (from + 1..to).all(|cycle| {
                let share = Share::of((cycle - from) as u64, (to - from) as u64);
                let (is, wanted) = (piece.at(share), self.rows[cycle][axis]);
                let apart = is.wide_counts().abs_diff(wanted.wide_counts());
                match self.tolerance {
                    Tolerance::None => apart == 0,
                    Tolerance::OneCount => apart <= 1,
                }
            })
        })
    }

    fn segment(&self, from: usize, to: usize) -> Segment {
        let axes = 0..self.rows[from].len();
        Segment {
            duration: (to - from) as u64 * CYCLE,
            axes: axes.map(|axis| self.way(axis, from, to)).collect(),
        }
    }

    fn way(&self, axis: usize, from: usize, to: usize) -> AxisSegment {
        let cycles = (to - from) as f64;
        let velocity = |cycle| (self.velocity(axis, cycle) * cycles).round() as i64;
        AxisSegment {
            end: self.rows[to][axis].units(),
            shape: Shape::Cubic {
                leaving: velocity(from),
                arriving: velocity(to),
            },
        }
    }

    /// In position units a cycle; nothing moves at the ends.
    fn velocity(&self, axis: usize, cycle: usize) -> f64 {
        if cycle == 0 || cycle + 1 >= self.rows.len() {
            return 0.0;
        }
        let (before, after) = (self.rows[cycle - 1][axis], self.rows[cycle + 1][axis]);
        after.distance_from(before).units() as f64 / 2.0
    }
}
