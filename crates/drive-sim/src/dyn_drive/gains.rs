//! A servo loop whose answer depends on the gains.
//!
//! How a drive turns gains into motion is not published. This loop has the parts that the manual names (DYN2 manual A1.8, section 5.1) and
//! moves as it describes them: a higher main gain answers faster, a higher speed gain damps, the integration gain removes an error that
//! stays, and the torque filter is a low pass with its corner at 26 rad/s times its constant. The figures are chosen so that the gains
//! of a simulated drive as it leaves its factory (20, 20, 10, 127) give a fast answer with little overshoot. It is for trying the
//! commands that tune, not for finding the gains of a machine.
//!
//! Specification: `acceleration = w^2 * error - c * velocity + i * (integral of the error)`, through the filter, within the limits of the motor, with
//! `w` = 2.5 rad/s and `c` = 4 /s for each unit of main and speed gain, and `i` = `w^2` times 0.05 /s for each unit of the integration gain. The
//! load is a pure inertia that a constant torque pulls back: an acceleration of 0.2 % of the highest one of the motor.

use dyn_can::{ParamGroup1, units};

use super::servo::{Limits, TICK_S};

/// Natural frequency for each unit of the main gain, in rad/s.
const MAIN_RAD_S: f64 = 2.5;
/// Damping for each unit of the speed gain, in 1/s.
const SPEED_PER_S: f64 = 4.0;
/// Integration for each unit of its gain, in 1/s.
const INTEGRATION_PER_S: f64 = 0.05;
/// The pull of the load, as a share of the highest acceleration of the motor.
const LOAD_SHARE: f64 = 0.002;
/// The integral ends at this share of the highest acceleration.
const INTEGRAL_SHARE: f64 = 0.25;

/// How the motor answers to its reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ServoLoop {
    /// Smoothly and exactly, whatever the gains.
    #[default]
    Smooth,
    /// As a loop with the gains and the torque filter of parameter group 1, and a load that pulls a little.
    WithGains,
}

impl ServoLoop {
    pub(super) fn gains(self, group: &ParamGroup1) -> Option<Gains> {
        if self == Self::Smooth {
            return None;
        }
        let w = MAIN_RAD_S * f64::from(group.main_gain.get());
        Some(Gains {
            stiffness: w * w,
            damping: SPEED_PER_S * f64::from(group.speed_gain.get()),
            integration: w * w * INTEGRATION_PER_S * f64::from(group.integration_gain.get()),
            filter_rad_s: units::torque_filter_rad_s(group.torque_filter),
        })
    }
}

/// The figures of a loop with gains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gains {
    /// 1/s2.
    stiffness: f64,
    /// 1/s.
    damping: f64,
    /// 1/s3.
    integration: f64,
    filter_rad_s: f64,
}

/// What the loop remembers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Feedback {
    /// Acceleration of the integral part, in counts/s2.
    integral: f64,
    /// Acceleration behind the torque filter, in counts/s2.
    filtered: f64,
}

impl Feedback {
    /// The acceleration of the next tick, with the pull of the load.
    pub(super) fn acceleration(
        &mut self,
        reference: f64,
        (position, velocity): (f64, f64),
        gains: &Gains,
        limits: &Limits,
    ) -> f64 {
        let error = reference - position;
        let most = limits.motor_acceleration;
        let end = INTEGRAL_SHARE * most;
        self.integral = (self.integral + gains.integration * error * TICK_S).clamp(-end, end);
        let wanted = gains.stiffness * error - gains.damping * velocity + self.integral;
        let share = 1.0 - (-gains.filter_rad_s * TICK_S).exp();
        self.filtered += (wanted.clamp(-most, most) - self.filtered) * share;
        self.filtered - LOAD_SHARE * most
    }
}
