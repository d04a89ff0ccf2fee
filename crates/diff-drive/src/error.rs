//! What is refused.

/// A value out of its range, or one that is no number. Nothing has changed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{name} must be {least}..={most}, got {actual}")]
pub struct ValueError {
    /// The value with its unit.
    pub name: &'static str,
    /// Smallest value.
    pub least: f64,
    /// Largest value.
    pub most: f64,
    /// The value.
    pub actual: f64,
}

/// Counts that no wheel can have made since the last update: a drive was restarted or cleared, or the counts are of another wheel. The pose
/// is unchanged, and [`Odometry::rebase`](crate::Odometry::rebase) goes on from the new counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "a wheel moved by {left} and {right} counts since the last update, at most {most} are possible: was a drive restarted? rebase the odometry"
)]
pub struct JumpError {
    /// Change of the left wheel.
    pub left: i32,
    /// Change of the right wheel.
    pub right: i32,
    /// Largest change that is believed.
    pub most: u32,
}

/// A number within a range; NaN is in none.
pub(crate) const fn checked(
    name: &'static str,
    (least, most): (f64, f64),
    actual: f64,
) -> Result<f64, ValueError> {
    if actual >= least && actual <= most {
        Ok(actual)
    } else {
        Err(ValueError {
            name,
            least,
            most,
            actual,
        })
    }
}
