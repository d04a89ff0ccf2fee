//! The play of an axis.

use trajectory::{Limits, PlanError, Position, Tracker};

/// Takes up the play of an axis where it turns: an option behind a machine.
///
/// The counts are moved by half of the play in the direction in which the axis went last, from the middle of the play, where the axis is
/// taken to be at first. The move has limits of its own, which come on top of those of the path: together they must not be more than the
/// motor's. [`Self::release`] goes back to the middle, so that what comes after it may start there.
#[derive(Debug, Clone, Copy)]
pub struct Backlash {
    half: Position,
    /// The farthest place in the direction.
    farthest: i64,
    direction: i64,
    target: Position,
    offset: Tracker,
}

impl Backlash {
    /// An axis has turned when it is back by so much, in position units: 1/64 counts, far more than what a path is rounded by.
    const TURN: i64 = Position::UNITS / 64;

    /// An axis that stands at a position, with so much play in counts, which is taken up within these limits.
    ///
    /// # Errors
    /// [`PlanError`] for a play that cannot be taken up.
    pub fn new(at: Position, play: Position, limits: Limits) -> Result<Self, PlanError> {
        let half = Position::from_units(play.units().saturating_abs() / 2);
        let mut offset = Tracker::at_rest(0, limits);
        // A longer way than any of those to come.
        offset.next(play)?;
        Ok(Self {
            half,
            farthest: at.units(),
            direction: 0,
            target: Position::ZERO,
            offset: Tracker::at_rest(0, limits),
        })
    }

    /// The set-point of the next cycle.
    ///
    /// # Errors
    /// [`PlanError`] when the play cannot be taken up from where it is; nothing has moved then.
    pub fn apply(&mut self, position: Position) -> Result<Position, PlanError> {
        let units = position.units();
        let way = units.wrapping_sub(self.farthest);
        let turns = match self.direction {
            0 => way.wrapping_abs() > Self::TURN,
            direction => way.wrapping_mul(direction) < -Self::TURN,
        };
        if turns {
            self.direction = way.signum();
            self.target = Position::from_units(self.half.units() * self.direction);
        }
        if turns || way.wrapping_mul(self.direction) > 0 {
            self.farthest = units;
        }
        self.offset
            .next(self.target)
            .map(|offset| position.moved_by(offset))
    }

    /// Back to the middle of the play, while the axis stands.
    pub const fn release(&mut self) {
        self.direction = 0;
        self.target = Position::ZERO;
    }

    /// Whether nothing is left to be taken up or released.
    #[must_use]
    pub fn is_there(&self) -> bool {
        let state = self.offset.state();
        self.offset.is_there() && state.position == self.target
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn play() -> Backlash {
        let limits = Limits::new(2.0, 0.5, 0.25).unwrap();
        Backlash::new(Position::ZERO, Position::from_counts(10), limits).unwrap()
    }

    /// Plays positions in sixteenths of a count; returns the last offset in counts.
    fn played(axis: &mut Backlash, positions: impl IntoIterator<Item = i64>) -> f64 {
        let mut offset = 0;
        for sixteenths in positions {
            let position = Position::from_units(sixteenths * Position::UNITS / 16);
            offset = axis
                .apply(position)
                .unwrap()
                .distance_from(position)
                .units();
        }
        offset as f64 / Position::UNITS as f64
    }

    #[test]
    fn play_is_taken_up_where_the_axis_turns() {
        let mut axis = play();
        assert_eq!(played(&mut axis, [0; 50]), 0.0);
        assert!(axis.is_there());
        assert_eq!(played(&mut axis, 1..=100), 5.0);
        // It stands: nothing changes.
        assert_eq!(played(&mut axis, [100; 50]), 5.0);
        assert_eq!(played(&mut axis, (0..100).rev()), -5.0);
        assert!(axis.is_there());
        axis.release();
        assert!(!axis.is_there());
        assert_eq!(played(&mut axis, [0; 50]), 0.0);
        assert!(axis.is_there());
        // The other way first.
        assert_eq!(played(&mut axis, (-100..0).rev()), -5.0);
    }

    #[test]
    fn rounding_is_no_turn_and_a_slow_turn_is_one() {
        let mut axis = play();
        played(&mut axis, 1..=100);
        let end = 100 * Position::UNITS / 16;
        for cycle in 0..1_000 {
            let position = Position::from_units(end - cycle % 3);
            let offset = axis.apply(position).unwrap().distance_from(position);
            assert_eq!(offset, Position::from_counts(5));
        }
        // A sixteenth of the least turn in each cycle.
        let mut offset = Position::ZERO;
        for cycle in 0..200 {
            let position = Position::from_units(end - cycle * Position::UNITS / 1_024);
            offset = axis.apply(position).unwrap().distance_from(position);
        }
        assert_eq!(offset, Position::from_counts(-5));
    }

    #[test]
    fn the_taking_up_keeps_its_limits() {
        let mut axis = play();
        let mut offsets = std::vec![0.0; 3];
        let there_and_back = (0..=200).chain((0..200).rev());
        for sixteenths in there_and_back.cycle().take(2_000) {
            offsets.push(played(&mut axis, [sixteenths]));
        }
        for row in offsets.windows(4) {
            let [a, b, c, d] = row else {
                unreachable!("windows of four")
            };
            assert!((d - c).abs() <= 2.0 + 1e-3);
            assert!((d - 2.0 * c + b).abs() <= 0.5 + 1e-3);
            assert!((d - 3.0 * c + 3.0 * b - a).abs() <= 0.25 + 1e-3, "{row:?}");
        }
        let highest = offsets.iter().copied().fold(0.0, f64::max);
        assert_eq!(highest, 5.0);
    }
}
