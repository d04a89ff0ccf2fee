//! What the set-points must keep: the settings of the board and the options, whichever is less.

use board_link::AxisLimits;
use trajectory::{Limits, Position, RangeError};

/// The limits of a streamed axis, wherever it stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StreamLimits {
    motion: Limits,
    of_board: AxisLimits,
    /// Its positions count from where the axis stands.
    of_options: AxisLimits,
}

impl StreamLimits {
    /// Both, whichever is less.
    ///
    /// # Errors
    /// When they are outside of what a trajectory can have.
    pub(super) fn new(of_board: AxisLimits, of_options: AxisLimits) -> Result<Self, RangeError> {
        let (board, options) = (&of_board.motion, &of_options.motion);
        let velocity = board.velocity().min(options.velocity());
        let acceleration = board.acceleration().min(options.acceleration());
        let jerk = board.jerk().min(options.jerk());
        let motion = if jerk.is_finite() {
            Limits::new(velocity, acceleration, jerk)
        } else {
            Limits::without_jerk(velocity, acceleration)
        };
        Ok(Self {
            motion: motion?,
            of_board,
            of_options,
        })
    }

    /// Of an axis that stands here.
    pub(super) fn around(&self, stand: Position) -> AxisLimits {
        let (board, options) = (&self.of_board, &self.of_options);
        AxisLimits {
            motion: self.motion,
            lowest: board.lowest.max(stand.moved_by(options.lowest)),
            highest: board.highest.min(stand.moved_by(options.highest)),
        }
    }
}

/// Of an axis of the board that stands still. Where it stands it may stand, as far as set-points are concerned; the board says more.
pub(super) fn of_standing(of_board: &AxisLimits, stand: Position) -> AxisLimits {
    AxisLimits {
        lowest: of_board.lowest.min(stand),
        highest: of_board.highest.max(stand),
        ..*of_board
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits(motion: Limits, lowest: i32, highest: i32) -> AxisLimits {
        AxisLimits {
            motion,
            lowest: Position::from_counts(lowest),
            highest: Position::from_counts(highest),
        }
    }

    #[test]
    fn the_narrower_one_counts_and_the_travel_of_the_options_goes_with_the_axis() {
        let board = limits(Limits::without_jerk(10.0, 2.0).unwrap(), -1_000, 5_000);
        let options = limits(Limits::new(20.0, 1.0, 0.5).unwrap(), -300, 300);
        let both = StreamLimits::new(board, options).unwrap();
        let at = |counts| both.around(Position::from_counts(counts));
        let expected = Limits::new(10.0, 1.0, 0.5).unwrap();
        assert_eq!(at(0), limits(expected, -300, 300));
        assert_eq!(at(-900), limits(expected, -1_000, -600));
        assert_eq!(at(4_900), limits(expected, 4_600, 5_000));
        let free = limits(Limits::without_jerk(20.0, 1.0).unwrap(), -300, 300);
        let both = StreamLimits::new(board, free).unwrap();
        let motion = both.around(Position::ZERO).motion;
        assert_eq!(motion, Limits::without_jerk(10.0, 1.0).unwrap());
    }
}
