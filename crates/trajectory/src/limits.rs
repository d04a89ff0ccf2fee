//! What a profile must keep, and what it starts from.

use core::fmt;

use crate::quantity::Position;

/// Largest velocity, acceleration and jerk, each the same in both directions.
///
/// Counts per cycle, per cycle² and per cycle³. A [`Limits`] exists only within its ranges. Without a limit of the jerk the profiles
/// are trapezoids of velocity: cheaper, a little faster, and rougher for the machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    velocity: f32,
    acceleration: f32,
    jerk: f32,
}

/// A quantity of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// In counts per cycle.
    Velocity,
    /// In counts per cycle².
    Acceleration,
    /// In counts per cycle³.
    Jerk,
}

/// A limit or a state outside its range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeError {
    /// What it is.
    pub quantity: Quantity,
    /// The smallest value.
    pub min: f32,
    /// The largest value.
    pub max: f32,
    /// The value that was given.
    pub actual: f32,
}

impl Limits {
    /// Smallest and largest velocity, in counts per cycle: one count in 17 minutes at 1 kHz, and 64 times the largest step of a DYN drive.
    pub const VELOCITY: (f32, f32) = (1.0 / 1_048_576.0, 1_048_576.0);
    /// Smallest and largest acceleration, in counts per cycle².
    pub const ACCELERATION: (f32, f32) = (1.0 / 16_777_216.0, 1_048_576.0);
    /// Smallest and largest jerk, in counts per cycle³.
    pub const JERK: (f32, f32) = (1.0 / 1_073_741_824.0, 16_777_216.0);

    /// Limits in counts per cycle, per cycle² and per cycle³.
    ///
    /// # Errors
    /// [`RangeError`] when one is outside [`Self::VELOCITY`], [`Self::ACCELERATION`] or [`Self::JERK`], or is no number.
    pub const fn new(velocity: f32, acceleration: f32, jerk: f32) -> Result<Self, RangeError> {
        if let Err(error) = check(Quantity::Velocity, velocity, Self::VELOCITY) {
            return Err(error);
        }
        if let Err(error) = check(Quantity::Acceleration, acceleration, Self::ACCELERATION) {
            return Err(error);
        }
        if let Err(error) = check(Quantity::Jerk, jerk, Self::JERK) {
            return Err(error);
        }
        Ok(Self {
            velocity,
            acceleration,
            jerk,
        })
    }

    /// Limits without one of the jerk, in counts per cycle and per cycle².
    ///
    /// # Errors
    /// As [`Self::new`].
    pub const fn without_jerk(velocity: f32, acceleration: f32) -> Result<Self, RangeError> {
        match Self::new(velocity, acceleration, Self::JERK.1) {
            Ok(limits) => Ok(Self {
                jerk: f32::INFINITY,
                ..limits
            }),
            error => error,
        }
    }

    /// In counts per cycle.
    #[must_use]
    pub const fn velocity(&self) -> f32 {
        self.velocity
    }

    /// In counts per cycle².
    #[must_use]
    pub const fn acceleration(&self) -> f32 {
        self.acceleration
    }

    /// In counts per cycle³; infinite when there is no limit.
    #[must_use]
    pub const fn jerk(&self) -> f32 {
        self.jerk
    }

    /// The same with so much less velocity.
    pub(crate) const fn less_velocity(&self, by: f32) -> Result<Self, RangeError> {
        let velocity = self.velocity - by;
        match check(Quantity::Velocity, velocity, Self::VELOCITY) {
            Ok(()) => Ok(Self { velocity, ..*self }),
            Err(error) => Err(error),
        }
    }

    pub(crate) const fn has_jerk(&self) -> bool {
        self.jerk <= Self::JERK.1
    }
}

/// Where an axis is and how it moves.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    /// Position.
    pub position: Position,
    /// Counts per cycle.
    pub velocity: f32,
    /// Counts per cycle².
    pub acceleration: f32,
}

impl State {
    /// Largest size of velocity and acceleration that a profile may start with; limits may be exceeded, this may not.
    pub const LARGEST: f32 = 1_048_576.0;

    /// Standing still at a count.
    #[must_use]
    pub const fn at_rest(counts: i32) -> Self {
        Self {
            position: Position::from_counts(counts),
            velocity: 0.0,
            acceleration: 0.0,
        }
    }

    pub(crate) const fn check(&self) -> Result<(), RangeError> {
        let range = (-Self::LARGEST, Self::LARGEST);
        match check(Quantity::Velocity, self.velocity, range) {
            Ok(()) => check(Quantity::Acceleration, self.acceleration, range),
            error => error,
        }
    }
}

pub(crate) const fn check(
    quantity: Quantity,
    actual: f32,
    (min, max): (f32, f32),
) -> Result<(), RangeError> {
    if actual >= min && actual <= max {
        return Ok(());
    }
    Err(RangeError {
        quantity,
        min,
        max,
        actual,
    })
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Velocity => "velocity in counts per cycle",
            Self::Acceleration => "acceleration in counts per cycle²",
            Self::Jerk => "jerk in counts per cycle³",
        })
    }
}

impl fmt::Display for RangeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            quantity,
            min,
            max,
            actual,
        } = self;
        write!(f, "{quantity} must be {min} to {max}, it is {actual}")
    }
}

impl core::error::Error for RangeError {}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn limits_have_ranges_with_their_ends_inside() {
        let ((v_min, v_max), (a_min, a_max), (j_min, j_max)) =
            (Limits::VELOCITY, Limits::ACCELERATION, Limits::JERK);
        assert!(Limits::new(v_min, a_min, j_min).is_ok());
        assert!(Limits::new(v_max, a_max, j_max).is_ok());
        assert!(Limits::new(v_max * 1.01, a_max, j_max).is_err());
        assert!(Limits::new(v_max, a_min * 0.99, j_max).is_err());
        assert!(Limits::new(v_max, a_max, j_min * 0.99).is_err());
        for none in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(Limits::new(none, 1.0, 1.0).is_err());
            assert!(Limits::new(1.0, none, 1.0).is_err());
            assert!(Limits::new(1.0, 1.0, none).is_err());
        }
    }

    #[test]
    fn the_limits_are_the_given_ones() {
        let limits = Limits::new(3.0, 2.0, 1.0).unwrap();
        assert_eq!(
            (limits.velocity(), limits.acceleration(), limits.jerk()),
            (3.0, 2.0, 1.0)
        );
    }

    #[test]
    fn an_error_says_what_is_expected() {
        let error = Limits::new(1.0, 0.0, 1.0).unwrap_err();
        assert_eq!(
            error.to_string(),
            "acceleration in counts per cycle² must be 0.000000059604645 to 1048576, it is 0"
        );
    }

    #[test]
    fn a_state_that_is_no_number_is_refused() {
        let state = |velocity, acceleration| State {
            velocity,
            acceleration,
            ..State::default()
        };
        assert!(state(State::LARGEST, -State::LARGEST).check().is_ok());
        assert!(state(f32::NAN, 0.0).check().is_err());
        assert!(state(0.0, f32::INFINITY).check().is_err());
        assert!(state(2.0 * State::LARGEST, 0.0).check().is_err());
    }
}
