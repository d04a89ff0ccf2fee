//! The columns of a sender among the axes of the board: a sender counts positions from where the axes stand.

use board_link::{AxisLimits, Refusal};
use trajectory::Position;

use super::limits::{StreamLimits, of_standing};

/// Which axes of the board the columns move, and where all of them stand.
pub(super) struct Columns {
    /// The place of each streamed axis among those of the board, and its limits.
    axes: Vec<(usize, StreamLimits)>,
    of_board: Vec<AxisLimits>,
    stand: Vec<Position>,
}

impl Columns {
    /// For axes of a board with these limits, whose standing is not known yet.
    pub(super) fn new(axes: Vec<(usize, StreamLimits)>, of_board: Vec<AxisLimits>) -> Self {
        Self {
            axes,
            of_board,
            stand: Vec::new(),
        }
    }

    /// The axes of the board stand here; returns the limits of all of them.
    pub(super) fn stand_at(&mut self, counts: &[i32]) -> Vec<AxisLimits> {
        self.stand = counts.iter().copied().map(Position::from_counts).collect();
        let standing = self.of_board.iter().zip(&self.stand);
        let mut limits: Vec<AxisLimits> = standing
            .map(|(of_board, &stand)| of_standing(of_board, stand))
            .collect();
        for (place, streamed) in &self.axes {
            if let (Some(limits), Some(&stand)) = (limits.get_mut(*place), self.stand.get(*place)) {
                *limits = streamed.around(stand);
            }
        }
        limits
    }

    pub(super) fn stand(&self) -> &[Position] {
        &self.stand
    }

    /// All axes of the board, where those of the sender are here.
    pub(super) fn among_all(&self, positions: &[Position]) -> Vec<Position> {
        let mut all = self.stand.clone();
        for ((place, _), &position) in self.axes.iter().zip(positions) {
            if let Some(at) = all.get_mut(*place) {
                *at = at.moved_by(position);
            }
        }
        all
    }

    /// Where the streamed axes are, in counts from the start, when all axes of the board are here; 0 without that.
    pub(super) fn targets(&self, all: Option<&[Position]>) -> Vec<i32> {
        let counts = |(place, _): &(usize, StreamLimits)| {
            let at = all.and_then(|all| all.get(*place));
            let (Some(at), Some(stand)) = (at, self.stand.get(*place)) else {
                return 0;
            };
            at.counts().wrapping_sub(stand.counts())
        };
        self.axes.iter().map(counts).collect()
    }

    /// A refusal in the axes of the sender, from where they stood.
    pub(super) fn of_sender(&self, mut refusal: Refusal) -> Refusal {
        match &mut refusal {
            Refusal::Start {
                axis,
                expected,
                actual,
            } => self.relative(axis, [expected, actual]),
            Refusal::Travel {
                axis,
                lowest,
                highest,
                actual,
            } => self.relative(axis, [lowest, highest, actual]),
            Refusal::Velocity { axis, .. }
            | Refusal::Acceleration { axis, .. }
            | Refusal::Jerk { axis, .. } => self.relative(axis, []),
            _ => {}
        }
        refusal
    }

    /// The column of an axis of the board, and positions from where it stood.
    fn relative<const N: usize>(&self, axis: &mut usize, positions: [&mut Position; N]) {
        let stand = self.stand.get(*axis).copied().unwrap_or_default();
        for position in positions {
            *position = position.distance_from(stand);
        }
        let column = self.axes.iter().position(|(place, _)| place == axis);
        *axis = column.unwrap_or(*axis);
    }
}

#[cfg(test)]
mod tests {
    use trajectory::Limits;

    use super::*;

    #[test]
    fn columns_are_those_of_the_sender_and_places_those_of_the_board() {
        let limits = AxisLimits {
            motion: Limits::without_jerk(10.0, 1.0).unwrap(),
            lowest: Position::from_counts(-9_000),
            highest: Position::from_counts(9_000),
        };
        let streamed = StreamLimits::new(limits, limits).unwrap();
        let mut columns = Columns::new(vec![(2, streamed), (0, streamed)], vec![limits; 3]);
        let all = columns.stand_at(&[100, -9_500, 8_000]);
        let at = Position::from_counts;
        // The one that is not streamed stands outside of its travel, and stays there.
        assert_eq!((all[1].lowest, all[2].highest), (at(-9_500), at(9_000)));
        let among = columns.among_all(&[at(7), at(-5)]);
        assert_eq!(among, [at(95), at(-9_500), at(8_007)]);
        assert_eq!(columns.targets(Some(&among)), [7, -5]);
        assert_eq!(columns.targets(None), [0, 0]);
        let travel = |axis, lowest, highest, actual| Refusal::Travel {
            axis,
            lowest: at(lowest),
            highest: at(highest),
            actual: at(actual),
        };
        assert_eq!(
            columns.of_sender(travel(2, -9_000, 9_000, 9_001)),
            travel(0, -17_000, 1_000, 1_001)
        );
        let fast = |axis| Refusal::Velocity {
            axis,
            expected: 1.0,
            actual: 2.0,
        };
        assert_eq!(columns.of_sender(fast(0)), fast(1));
    }
}
