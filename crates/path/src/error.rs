//! What is no path.

use core::fmt;

/// Why a piece is not part of the path.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum PathError {
    /// The queue is full; once the tool has gone on there is room.
    Full,
    /// The path is being stopped; the rest of it is given up.
    Stopping,
    /// A feed or a tolerance that is no positive number.
    NotPositive {
        /// What was given.
        actual: f32,
    },
    /// A coordinate beyond [`Path::FARTHEST`](crate::Path::FARTHEST), in units.
    Far {
        /// The coordinate, counted from 0.
        coordinate: usize,
        /// What was given, in units.
        actual: i64,
    },
    /// An arc in a plane that is none of this space, or of one coordinate twice.
    Plane {
        /// What was given.
        actual: (usize, usize),
    },
    /// An arc with a radius that is not positive, or one beyond [`Path::FARTHEST`](crate::Path::FARTHEST).
    Radius {
        /// What was given, in units.
        actual: f32,
    },
    /// An arc of more than 2^28 turns.
    Sweep {
        /// What was given, in 2^-32 turns.
        actual: i64,
    },
    /// An arc or a helix longer than 2^29 units.
    Long {
        /// Its length, in units.
        actual: f32,
    },
    /// A feed below 2^-16 units per cycle.
    Slow {
        /// What was given, in units per cycle.
        actual: f32,
    },
    /// An arc that misses its end by more than 1/64 of its radius.
    End {
        /// By how much, in units.
        actual: f32,
        /// The most, in units.
        most: f32,
    },
    /// Limits of the axes that do not let the tool move.
    Limits,
}

impl fmt::Display for PathError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Full => f.write_str("the queue of the path is full"),
            Self::Stopping => f.write_str("the path is being stopped"),
            Self::NotPositive { actual } => {
                write!(
                    f,
                    "a feed and a tolerance must be positive numbers, got {actual}"
                )
            }
            Self::Far { coordinate, actual } => write!(
                f,
                "coordinates must be -2^28 to 2^28 units, coordinate {coordinate} is {actual}"
            ),
            Self::Plane { actual } => write!(
                f,
                "the plane of an arc must be two coordinates of the path, got {actual:?}"
            ),
            Self::Radius { actual } => {
                write!(f, "a radius must be 2^-6 to 2^28 units, got {actual}")
            }
            Self::Sweep { actual } => {
                let turns = actual >> 32;
                write!(f, "an arc must have at most 2^28 turns, got {turns}")
            }
            Self::Long { actual } => {
                write!(f, "an arc must be at most 2^29 units long, got {actual}")
            }
            Self::Slow { actual } => {
                write!(
                    f,
                    "a feed must be at least 2^-16 units per cycle, got {actual}"
                )
            }
            Self::End { actual, most } => write!(
                f,
                "an arc must end where its circle does, within {most} units, it misses by {actual}"
            ),
            Self::Limits => f.write_str("with these limits an axis would not move"),
        }
    }
}

impl core::error::Error for PathError {}
