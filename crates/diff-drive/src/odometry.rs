//! Where the vehicle is, by what its wheels have turned.

use core::f64::consts::{PI, TAU};

use crate::error::JumpError;
use crate::geometry::Geometry;

/// Turns of a wheel from one update to the next that are still believed.
const MOST_TURNS: f64 = 8.0;
/// Below this the quotient of sine and angle is 1 within the precision of a double.
const SMALL_RAD: f64 = 1e-8;

/// Position and heading on the ground.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pose {
    /// Forwards, seen from the start, in metres.
    pub x_m: f64,
    /// To the left, seen from the start, in metres.
    pub y_m: f64,
    /// Counter-clockwise, seen from above, in rad; it is not wrapped.
    pub heading_rad: f64,
}

impl Pose {
    /// The heading within -pi ..= pi.
    #[must_use]
    pub fn wrapped_heading_rad(&self) -> f64 {
        let turned = libm::fmod(self.heading_rad + PI, TAU);
        let turned = if turned < 0.0 { turned + TAU } else { turned };
        turned - PI
    }

    /// How far it is from the start, in metres.
    #[must_use]
    pub fn distance_m(&self) -> f64 {
        libm::hypot(self.x_m, self.y_m)
    }
}

/// The way of the vehicle, from the counts of its wheels.
#[derive(Debug, Clone, Copy)]
pub struct Odometry {
    geometry: Geometry,
    counts: Option<(i32, i32)>,
    travel: (i64, i64),
    pose: Pose,
}

impl Odometry {
    /// A vehicle at its start, whose wheels have not been read yet.
    #[must_use]
    pub const fn new(geometry: Geometry) -> Self {
        Self {
            geometry,
            counts: None,
            travel: (0, 0),
            pose: Pose {
                x_m: 0.0,
                y_m: 0.0,
                heading_rad: 0.0,
            },
        }
    }

    /// Where the vehicle is.
    #[must_use]
    pub const fn pose(&self) -> Pose {
        self.pose
    }

    /// Counts of the left and the right wheel since the first update, wraps included.
    #[must_use]
    pub const fn travel_counts(&self) -> (i64, i64) {
        self.travel
    }

    /// Takes the position counts of both wheels, forwards positive, read at about the same time. The first update is the start.
    ///
    /// # Errors
    /// [`JumpError`] for more than 8 turns of a wheel since the last update; nothing has changed then.
    pub fn update(&mut self, left: i32, right: i32) -> Result<Pose, JumpError> {
        let Some((left_before, right_before)) = self.counts else {
            self.counts = Some((left, right));
            return Ok(self.pose);
        };
        let (left_way, right_way) = (
            left.wrapping_sub(left_before),
            right.wrapping_sub(right_before),
        );
        let most = (MOST_TURNS * self.geometry.counts_per_turn()) as u32;
        if left_way.unsigned_abs() > most || right_way.unsigned_abs() > most {
            return Err(JumpError {
                left: left_way,
                right: right_way,
                most,
            });
        }
        self.counts = Some((left, right));
        let (left_travel, right_travel) = self.travel;
        self.travel = (
            left_travel.saturating_add(i64::from(left_way)),
            right_travel.saturating_add(i64::from(right_way)),
        );
        self.follow(f64::from(left_way), f64::from(right_way));
        Ok(self.pose)
    }

    /// Goes on from other counts, where it is: after a drive was restarted or cleared. What was turned meanwhile is not known.
    pub const fn rebase(&mut self, left: i32, right: i32) {
        self.counts = Some((left, right));
    }

    /// Puts the vehicle somewhere, as after a fix by other means.
    pub const fn set_pose(&mut self, pose: Pose) {
        self.pose = pose;
    }

    /// The vehicle follows an arc whose length and angle come from its wheels; the chord lies half-way between both headings.
    fn follow(&mut self, left: f64, right: f64) {
        let m_per_count = self.geometry.m_per_count();
        let way_m = (left + right) / 2.0 * m_per_count;
        let turned_rad = (right - left) * m_per_count / self.geometry.track_m();
        let half = turned_rad / 2.0;
        let chord_m = if half.abs() < SMALL_RAD {
            way_m
        } else {
            way_m * libm::sin(half) / half
        };
        let heading = self.pose.heading_rad + half;
        self.pose.x_m += chord_m * libm::cos(heading);
        self.pose.y_m += chord_m * libm::sin(heading);
        self.pose.heading_rad += turned_rad;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn geometry() -> Geometry {
        Geometry::new(0.4, 0.1, 4_000).unwrap()
    }

    #[test]
    fn a_quarter_circle_is_exact_in_one_step() {
        // Around a point 0.5 m to the left: the wheels go 0.3 and 0.7 of a quarter turn.
        let mut odometry = Odometry::new(geometry());
        odometry.update(0, 0).unwrap();
        let quarter = |radius_m: f64| (radius_m * PI / 2.0 / geometry().m_per_count()).round();
        let pose = odometry
            .update(quarter(0.3) as i32, quarter(0.7) as i32)
            .unwrap();
        assert!((pose.x_m - 0.5).abs() < 2e-4, "{pose:?}");
        assert!((pose.y_m - 0.5).abs() < 2e-4, "{pose:?}");
        assert!((pose.heading_rad - PI / 2.0).abs() < 1e-3, "{pose:?}");
        assert_eq!(odometry.travel_counts(), (3_000, 7_000));
    }

    #[test]
    fn counts_wrap_both_ways_and_jumps_are_refused() {
        let mut odometry = Odometry::new(geometry());
        odometry.update(i32::MAX - 10, i32::MIN + 10).unwrap();
        let pose = odometry.update(i32::MIN + 9, i32::MAX - 9).unwrap();
        assert_eq!(odometry.travel_counts(), (20, -20));
        assert_eq!((pose.x_m, pose.y_m), (0.0, 0.0));
        assert!(pose.heading_rad < 0.0);
        // A drive starts again and counts from 0.
        let error = odometry.update(0, 0).unwrap_err();
        assert_eq!(error.most, 32_000);
        assert_eq!(odometry.pose(), pose);
        odometry.rebase(0, 0);
        odometry.update(5, 5).unwrap();
        assert_eq!(odometry.travel_counts(), (25, -15));
    }

    #[test]
    fn headings_wrap_for_those_who_want_it() {
        let heading = |heading_rad| {
            Pose {
                heading_rad,
                ..Pose::default()
            }
            .wrapped_heading_rad()
        };
        assert!((heading(TAU + 0.5) - 0.5).abs() < 1e-12);
        assert!((heading(-TAU - 0.5) + 0.5).abs() < 1e-12);
        assert!((heading(PI + 0.5) - (0.5 - PI)).abs() < 1e-12);
    }

    proptest! {
        /// The pose does not depend on where the counts begin, nor on how often they are read, along arcs.
        #[test]
        fn a_way_is_the_same_from_any_start_and_in_any_pieces(
            start: (i32, i32),
            arcs in proptest::collection::vec((-2_000..2_000_i32, -2_000..2_000_i32), 1..20),
            pieces in 1..10_i32,
        ) {
            let mut once = Odometry::new(geometry());
            let mut often = Odometry::new(geometry());
            let (mut left, mut right) = start;
            once.update(left, right).unwrap();
            often.update(0, 0).unwrap();
            let (mut often_left, mut often_right) = (0_i32, 0_i32);
            for (left_way, right_way) in arcs {
                // Whole pieces, so that every piece lies on the arc.
                let (left_way, right_way) = (left_way / pieces * pieces, right_way / pieces * pieces);
                left = left.wrapping_add(left_way);
                right = right.wrapping_add(right_way);
                once.update(left, right).unwrap();
                for _ in 0..pieces {
                    often_left += left_way / pieces;
                    often_right += right_way / pieces;
                    often.update(often_left, often_right).unwrap();
                }
            }
            let (a, b) = (once.pose(), often.pose());
            prop_assert!((a.x_m - b.x_m).abs() < 1e-9 && (a.y_m - b.y_m).abs() < 1e-9);
            prop_assert_eq!(once.travel_counts(), often.travel_counts());
        }
    }

    #[test]
    fn straight_on_is_straight_on() {
        let mut odometry = Odometry::new(geometry());
        let ways: Vec<Pose> = (0..5)
            .map(|turns| odometry.update(turns * 4_000, turns * 4_000).unwrap())
            .collect();
        assert!((ways[4].x_m - 4.0 * TAU * 0.1).abs() < 1e-12);
        assert_eq!((ways[4].y_m, ways[4].heading_rad), (0.0, 0.0));
        assert!((ways[4].distance_m() - ways[4].x_m).abs() < 1e-12);
    }
}
