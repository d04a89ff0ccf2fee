//! What the wheels may do, and how long a twist is good for.

use crate::error::{ValueError, checked};

/// Limits of the wheels and of the time without a new twist.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    pub(crate) most_rpm: f64,
    pub(crate) rpm_per_s: f64,
    pub(crate) stop_rpm_per_s: f64,
    pub(crate) timeout_us: u64,
}

impl Limits {
    /// Largest speed of a wheel (0.1 to 10,000 r/min), its fastest change while it follows twists, the change with which a vehicle stops
    /// that hears nothing any more (both 0.1 to 1,000,000 r/min per second), and how long a twist is good for (1 ms to 60 s, in us).
    ///
    /// # Errors
    /// [`ValueError`] for a number out of range, or none.
    pub const fn new(
        most_rpm: f64,
        rpm_per_s: f64,
        stop_rpm_per_s: f64,
        timeout_us: u64,
    ) -> Result<Self, ValueError> {
        let change = (0.1, 1e6);
        match (
            checked("largest speed in r/min", (0.1, 1e4), most_rpm),
            checked("acceleration in r/min per second", change, rpm_per_s),
            checked("stop in r/min per second", change, stop_rpm_per_s),
            checked("time-out in us", (1e3, 6e7), timeout_us as f64),
        ) {
            (Ok(most_rpm), Ok(rpm_per_s), Ok(stop_rpm_per_s), Ok(_)) => Ok(Self {
                most_rpm,
                rpm_per_s,
                stop_rpm_per_s,
                timeout_us,
            }),
            (Err(error), _, _, _)
            | (_, Err(error), _, _)
            | (_, _, Err(error), _)
            | (_, _, _, Err(error)) => Err(error),
        }
    }
}
