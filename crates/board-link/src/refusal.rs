//! Why a set-point is not taken.

use trajectory::{Position, Time};

/// A set-point that is not taken: nothing of it moves anything.
///
/// Axes count from 0. Times are cycles of the sender's clock, positions and their derivatives counts and cycles.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// Another number of positions than there are axes.
    #[error("expected {expected} positions, got {actual}")]
    Axes {
        /// Axes of the buffer.
        expected: usize,
        /// Positions of the set-point.
        actual: usize,
    },
    /// The first one is not where an axis stands.
    #[error(
        "axis {axis}: the first set-point must be where the axis stands: expected {expected}, got {actual}"
    )]
    Start {
        /// The axis.
        axis: usize,
        /// Where it stands.
        expected: Position,
        /// Where the set-point is.
        actual: Position,
    },
    /// The motion has passed this time already.
    #[error("the time is in the past: expected later than {expected}, got {actual}")]
    Past {
        /// The time of the motion.
        expected: Time,
        /// The time of the set-point.
        actual: Time,
    },
    /// Not later than the set-point before.
    #[error("the time is out of order: expected later than {expected}, got {actual}")]
    Order {
        /// The time of the latest set-point.
        expected: Time,
        /// The time of this one.
        actual: Time,
    },
    /// Closer to the set-point before than half a cycle.
    #[error(
        "the time is too close to the set-point before: expected at least {expected}, got {actual}"
    )]
    Close {
        /// The first time that is taken.
        expected: Time,
        /// The time of the set-point.
        actual: Time,
    },
    /// Farther from the set-point before than the longest gap.
    #[error("the time is too far ahead: expected at most {expected}, got {actual}")]
    Ahead {
        /// The last time that is taken.
        expected: Time,
        /// The time of the set-point.
        actual: Time,
    },
    /// An axis may not go there; between set-points it is the curve that does.
    #[error("axis {axis}: beyond its travel: expected {lowest} to {highest}, got {actual}")]
    Travel {
        /// The axis.
        axis: usize,
        /// The lowest position.
        lowest: Position,
        /// The highest position.
        highest: Position,
        /// How far it would go.
        actual: Position,
    },
    /// An axis would be too fast.
    #[error("axis {axis}: too fast: expected at most {expected} counts per cycle, got {actual}")]
    Velocity {
        /// The axis.
        axis: usize,
        /// The limit.
        expected: f32,
        /// What the set-points need.
        actual: f32,
    },
    /// An axis would accelerate too much.
    #[error(
        "axis {axis}: too much acceleration: expected at most {expected} counts per cycle², got {actual}"
    )]
    Acceleration {
        /// The axis.
        axis: usize,
        /// The limit.
        expected: f32,
        /// What the set-points need.
        actual: f32,
    },
    /// The acceleration of an axis would change too fast.
    #[error(
        "axis {axis}: too much jerk: expected at most {expected} counts per cycle³, got {actual}"
    )]
    Jerk {
        /// The axis.
        axis: usize,
        /// The limit.
        expected: f32,
        /// What the set-points need.
        actual: f32,
    },
    /// There is no room: the sender has no credit.
    #[error("the buffer is full: expected at most {expected} set-points ahead")]
    Full {
        /// Set-points that fit.
        expected: usize,
    },
    /// The set-points ran out before this one came, and the motion ends.
    #[error("too late: the set-points ran out at {expected}, got one for {actual}")]
    Late {
        /// The time of the last set-point.
        expected: Time,
        /// The time of this one.
        actual: Time,
    },
    /// The end was announced or ordered before.
    #[error("the motion ends: no set-point is taken any more")]
    Ended,
}

impl Refusal {
    /// How many kinds there are.
    pub const KINDS: usize = 13;

    /// The number of its kind, from 1 to [`Self::KINDS`]; it never changes.
    #[must_use]
    pub const fn number(&self) -> usize {
        match self {
            Self::Axes { .. } => 1,
            Self::Start { .. } => 2,
            Self::Past { .. } => 3,
            Self::Order { .. } => 4,
            Self::Close { .. } => 5,
            Self::Ahead { .. } => 6,
            Self::Travel { .. } => 7,
            Self::Velocity { .. } => 8,
            Self::Acceleration { .. } => 9,
            Self::Jerk { .. } => 10,
            Self::Full { .. } => 11,
            Self::Late { .. } => 12,
            Self::Ended => 13,
        }
    }
}
