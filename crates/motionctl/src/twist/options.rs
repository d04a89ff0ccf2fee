//! The options that describe a vehicle with two wheels.

use clap::ValueEnum;
use diff_drive::{DiffDrive, Geometry, Limits, Odometry, ValueError};

/// A vehicle with a left and a right wheel.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct TwistOptions {
    /// Drive a vehicle by twists: a file of lines time,v,omega in s, m/s and rad/s, or - for standard input. The first node is the left
    /// wheel, the second the right one.
    #[arg(long, value_name = "FILE", requires_all = ["track", "wheel_radius"], conflicts_with = "trajectory")]
    pub(crate) twist: Option<String>,
    /// Twists: metres from the middle of one wheel to that of the other.
    #[arg(long, value_name = "M", requires = "twist")]
    track: Option<f64>,
    /// Twists: radius of the wheels under load, in metres.
    #[arg(long, value_name = "M", requires = "twist")]
    wheel_radius: Option<f64>,
    /// Twists: wheels whose drives count down while the vehicle goes forwards. One of two wheels that are mounted alike does, unless its
    /// sense of rotation (2001h) is set.
    #[arg(long, value_enum, value_delimiter = ',', requires = "twist")]
    reversed: Vec<Side>,
    /// Twists: how long one is good for, in milliseconds; then the wheels ramp to 0.
    #[arg(long, value_name = "MS", default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=60_000))]
    dead_man_ms: u32,
    /// Twists: largest speed of a wheel in r/min; a faster twist is driven slower on its curve.
    #[arg(long, value_name = "RPM", default_value_t = 60.0)]
    max_rpm: f64,
    /// Twists: fastest change of the speed of a wheel in r/min per second.
    #[arg(long, value_name = "RPM_PER_S", default_value_t = 200.0)]
    max_rpm_per_s: f64,
    /// Twists: change of the speed with which the vehicle stops when no twist comes any more, in r/min per second.
    #[arg(long, value_name = "RPM_PER_S", default_value_t = 400.0)]
    stop_rpm_per_s: f64,
}

/// A wheel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Side {
    Left,
    Right,
}

/// A vehicle as the options describe it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Vehicle {
    pub(crate) geometry: Geometry,
    limits: Limits,
    pub(crate) max_rpm: f64,
    /// The fastest change that can be asked of a wheel.
    pub(crate) most_rpm_per_s: f64,
    signs: (i32, i32),
}

impl TwistOptions {
    /// The vehicle, whose drives have so many counts a turn.
    ///
    /// # Errors
    /// What is out of range, with the range.
    pub(crate) fn vehicle(&self, counts_per_turn: f64) -> Result<Vehicle, ValueError> {
        let geometry = Geometry::new(
            self.track.unwrap_or(f64::NAN),
            self.wheel_radius.unwrap_or(f64::NAN),
            counts_per_turn.round() as u32,
        )?;
        let timeout_us = u64::from(self.dead_man_ms) * 1_000;
        let sign = |side| if self.reversed.contains(&side) { -1 } else { 1 };
        Ok(Vehicle {
            geometry,
            limits: Limits::new(
                self.max_rpm,
                self.max_rpm_per_s,
                self.stop_rpm_per_s,
                timeout_us,
            )?,
            max_rpm: self.max_rpm,
            most_rpm_per_s: self.max_rpm_per_s.max(self.stop_rpm_per_s),
            signs: (sign(Side::Left), sign(Side::Right)),
        })
    }
}

impl Vehicle {
    /// A vehicle that stands, whose drives count 1/n r/min.
    pub(crate) fn drive(&self, speed_resolution: u16) -> DiffDrive {
        DiffDrive::new(self.geometry, self.limits, speed_resolution)
    }

    /// Its way from here on.
    pub(crate) fn odometry(&self) -> Odometry {
        Odometry::new(self.geometry)
    }

    /// From forwards to what a drive counts, or back: left and right.
    pub(crate) fn mounted(&self, (left, right): (i32, i32)) -> (i32, i32) {
        let (left_sign, right_sign) = self.signs;
        (left.wrapping_mul(left_sign), right.wrapping_mul(right_sign))
    }
}
