//! What a polynomial of fifth degree needs: the largest velocity, acceleration and jerk on its way, and where it turns.
//!
//! Each derivative is largest at an end or where the next one is zero. The zeros of a polynomial are separated by those of its
//! derivative, so they are found one degree after the other, by halving: exact to the last places of a float, and nothing in between is
//! missed.

use heapless::Vec;
use trajectory::Position;
use trajectory::curve::Share;

/// More halves make no difference to a number of 24 bits.
const HALVES: u8 = 24;
/// Rates can be small: halves of 2 down to 2^-31.
const HALVES_OF_ROOT: u8 = 32;
/// Steps of a duration, for the places where an axis turns.
const STEPS: u64 = 1 << 31;
/// What the rounding of a [`Piece`](trajectory::curve::Piece) can make of a place where an axis turns: 25 units, and a little more.
pub(crate) const ROUNDING_OF_PLACE: Position = Position::from_units(32);

/// The share of the duration at which an axis turns.
pub(crate) fn share_of(turn: f32) -> Share {
    Share::of((turn * STEPS as f32) as u64, STEPS)
}

/// Zeros of a polynomial of fourth degree between 0 and 1.
type Places = Vec<f32, 4>;

/// The largest velocity, acceleration and jerk, in counts and cycles.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Needs {
    pub(crate) velocity: f32,
    pub(crate) acceleration: f32,
    pub(crate) jerk: f32,
}

impl Needs {
    /// The highest rate of time, 2 at most, at which these needs are no more than the most that is allowed.
    pub(crate) fn highest_rate(&self, most: &Self) -> f32 {
        let by_velocity = most.velocity / self.velocity;
        let by_acceleration = root(most.acceleration / self.acceleration, |rate| rate * rate);
        let by_jerk = root(most.jerk / self.jerk, |rate| rate * rate * rate);
        // What needs nothing has no limit: the quotient is infinite or no number, which `min` passes over.
        by_velocity.min(by_acceleration).min(by_jerk).min(2.0)
    }
}

/// The largest number from 0 to 2 whose power is no more than this; 2 where there is no limit. By halving, because a cube root of a library
/// brings floats of 64 bits, which the processor has not (3.4 KB). It is rounded down, to 2^-31 or the last place of a float.
fn root(most: f32, power: impl Fn(f32) -> f32) -> f32 {
    if most.is_nan() || most >= power(2.0) {
        return 2.0;
    }
    let (mut from, mut to) = (0.0, 2.0);
    for _ in 0..HALVES_OF_ROOT {
        let middle = (from + to) / 2.0;
        if power(middle) <= most {
            from = middle;
        } else {
            to = middle;
        }
    }
    from
}

/// The way of an axis, as a function of the share of a duration that has passed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Polynomial {
    /// Of the powers 1 to 5 of the share, in counts.
    coefficients: [f32; 5],
    cycles: f32,
}

impl Polynomial {
    pub(crate) const fn new(coefficients: [f32; 5], cycles: f32) -> Self {
        Self {
            coefficients,
            cycles,
        }
    }

    /// The shares at which the direction changes.
    pub(crate) fn turns(&self) -> Places {
        zeros(|u| self.velocity(u), &self.still_velocities())
    }

    /// The largest of each on the way.
    pub(crate) fn needs(&self) -> Needs {
        let (h, turns) = (self.cycles, self.still_velocities());
        Needs {
            velocity: largest(|u| self.velocity(u), &turns) / h,
            acceleration: largest(|u| self.acceleration(u), &self.still_accelerations()) / (h * h),
            jerk: largest(|u| self.jerk(u), &self.still_jerks()) / (h * h * h),
        }
    }

    /// Velocity times duration.
    fn velocity(&self, u: f32) -> f32 {
        let [c1, c2, c3, c4, c5] = self.coefficients;
        c1 + (2.0 * c2 + (3.0 * c3 + (4.0 * c4 + 5.0 * c5 * u) * u) * u) * u
    }

    /// Acceleration times the square of the duration.
    fn acceleration(&self, u: f32) -> f32 {
        let [_, c2, c3, c4, c5] = self.coefficients;
        2.0 * c2 + (6.0 * c3 + (12.0 * c4 + 20.0 * c5 * u) * u) * u
    }

    fn jerk(&self, u: f32) -> f32 {
        let [_, _, c3, c4, c5] = self.coefficients;
        6.0 * c3 + (24.0 * c4 + 60.0 * c5 * u) * u
    }

    fn still_jerks(&self) -> Places {
        let [_, _, _, c4, c5] = self.coefficients;
        zeros(|u| 24.0 * c4 + 120.0 * c5 * u, &Places::new())
    }

    fn still_accelerations(&self) -> Places {
        zeros(|u| self.jerk(u), &self.still_jerks())
    }

    fn still_velocities(&self) -> Places {
        zeros(|u| self.acceleration(u), &self.still_accelerations())
    }
}

/// The zeros between 0 and 1 of a function that rises or falls between these places, where it changes its sign.
fn zeros(of: impl Fn(f32) -> f32, between: &Places) -> Places {
    let mut found = Places::new();
    let mut from = 0.0;
    for &to in between.iter().chain(&[1.0]) {
        if (of(from) < 0.0) != (of(to) < 0.0) {
            // There are at most as many as places between, and one.
            let _ = found.push(zero(&of, from, to));
        }
        from = to;
    }
    found
}

fn zero(of: &impl Fn(f32) -> f32, mut from: f32, mut to: f32) -> f32 {
    let is_negative = of(from) < 0.0;
    for _ in 0..HALVES {
        let middle = (from + to) / 2.0;
        if (of(middle) < 0.0) == is_negative {
            from = middle;
        } else {
            to = middle;
        }
    }
    from
}

/// The largest size at both ends and at the places between them; what is no number is larger than everything.
fn largest(of: impl Fn(f32) -> f32, inner: &Places) -> f32 {
    let places = [0.0, 1.0];
    let values = places.iter().chain(inner).map(|&u| of(u).abs());
    values.fold(0.0, |most, value| if value <= most { most } else { value })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The way at a share, in counts.
    fn way(polynomial: &Polynomial, u: f32) -> f32 {
        let [c1, c2, c3, c4, c5] = polynomial.coefficients;
        (c1 + (c2 + (c3 + (c4 + c5 * u) * u) * u) * u) * u
    }

    #[test]
    fn a_minimum_jerk_move_needs_what_the_formulas_say() {
        let (way, h) = (1_000.0_f32, 50.0_f32);
        let needs = Polynomial::new([0.0, 0.0, 10.0 * way, -15.0 * way, 6.0 * way], h).needs();
        let near = |actual: f32, expected: f32| (actual / expected - 1.0).abs() < 1e-5;
        assert!(near(needs.velocity, 1.875 * way / h), "{needs:?}");
        let peak = 10.0 / 3.0_f32.sqrt();
        assert!(near(needs.acceleration, peak * way / (h * h)), "{needs:?}");
        assert!(near(needs.jerk, 60.0 * way / (h * h * h)), "{needs:?}");
    }

    #[test]
    fn a_move_there_and_back_turns_where_it_is_farthest() {
        // 4 u (1 - u): farthest in the middle.
        let polynomial = Polynomial::new([4.0, -4.0, 0.0, 0.0, 0.0], 1.0);
        let turns = polynomial.turns();
        assert_eq!(turns.len(), 1);
        assert!((turns[0] - 0.5).abs() < 1e-6 && way(&polynomial, turns[0]) == 1.0);
    }

    /// Also where the limits allow less than the rate 1.
    #[test]
    fn the_rate_is_the_root_of_what_is_allowed() {
        for (most, expected) in [
            (8.0_f32, 2.0),
            (f32::NAN, 2.0),
            (1.331, 1.1),
            (0.125, 0.5),
            (1e-9, 1e-3),
            (0.0, 0.0),
        ] {
            let rate = root(most, |rate| rate * rate * rate);
            assert!(
                rate <= expected && expected - rate <= expected * 1e-5,
                "{most}: {rate}"
            );
            assert!(most.is_nan() || rate * rate * rate <= most);
        }
    }

    proptest! {
        /// No place among a thousand needs more, and one needs nearly as much.
        #[test]
        fn nothing_on_the_way_needs_more(coefficients in [(); 5].map(|()| -100.0_f32..100.0)) {
            let polynomial = Polynomial::new(coefficients, 1.0);
            let needs = polynomial.needs();
            let [c1, c2, c3, c4, c5] = coefficients.map(f64::from);
            let places = || (0..=1_000).map(|place| f64::from(place) / 1_000.0);
            let most = |of: &dyn Fn(f64) -> f64| places().map(|u| of(u).abs()).fold(0.0, f64::max);
            let velocity = most(&|u| {
                c1 + 2.0 * c2 * u + 3.0 * c3 * u.powi(2) + 4.0 * c4 * u.powi(3) + 5.0 * c5 * u.powi(4)
            });
            let acceleration = most(&|u| 2.0 * c2 + 6.0 * c3 * u + 12.0 * c4 * u * u + 20.0 * c5 * u.powi(3));
            let jerk = most(&|u| 6.0 * c3 + 24.0 * c4 * u + 60.0 * c5 * u * u);
            for (bound, sampled) in [
                (needs.velocity, velocity), (needs.acceleration, acceleration), (needs.jerk, jerk),
            ] {
                let bound = f64::from(bound);
                prop_assert!(bound >= sampled - 0.01 && bound <= sampled * 1.001 + 0.1, "{bound} {sampled}");
            }
            let farthest = polynomial.turns().iter().map(|&u| way(&polynomial, u).abs()).fold(
                way(&polynomial, 1.0).abs(), f32::max,
            );
            let sampled = most(&|u| c1 * u + c2 * u * u + c3 * u.powi(3) + c4 * u.powi(4) + c5 * u.powi(5));
            prop_assert!((f64::from(farthest) - sampled).abs() < 0.01, "{farthest} {sampled}");
        }
    }
}
