//! What the vehicle shall do.

use crate::error::{ValueError, checked};

/// Speed of the middle between the wheels, and turning speed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Twist {
    v_m_s: f64,
    omega_rad_s: f64,
}

impl Twist {
    /// Largest speed either way, in m/s.
    pub const MOST_M_S: f64 = 100.0;
    /// Largest turning speed either way, in rad/s.
    pub const MOST_RAD_S: f64 = 1_000.0;
    /// Standing.
    pub const ZERO: Self = Self {
        v_m_s: 0.0,
        omega_rad_s: 0.0,
    };

    /// A twist; forwards and counter-clockwise seen from above are positive.
    ///
    /// # Errors
    /// [`ValueError`] for a number out of range, or none.
    pub const fn new(v_m_s: f64, omega_rad_s: f64) -> Result<Self, ValueError> {
        let v = (-Self::MOST_M_S, Self::MOST_M_S);
        let omega = (-Self::MOST_RAD_S, Self::MOST_RAD_S);
        match (
            checked("v in m/s", v, v_m_s),
            checked("omega in rad/s", omega, omega_rad_s),
        ) {
            (Ok(v_m_s), Ok(omega_rad_s)) => Ok(Self { v_m_s, omega_rad_s }),
            (Err(error), _) | (_, Err(error)) => Err(error),
        }
    }

    /// Speed in m/s, forwards positive.
    #[must_use]
    pub const fn v_m_s(self) -> f64 {
        self.v_m_s
    }

    /// Turning speed in rad/s, counter-clockwise seen from above positive.
    #[must_use]
    pub const fn omega_rad_s(self) -> f64 {
        self.omega_rad_s
    }
}
