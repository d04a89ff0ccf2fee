//! The fastest stop in double precision, and starts for which it is difficult.

use trajectory::{Limits, Position, State};

use super::random::Random;

/// Way of the fastest stop in counts: a phase of constant jerk, one of the largest acceleration, one of the opposite jerk.
pub(crate) fn way(velocity: f64, acceleration: f64, limits: &Limits) -> f64 {
    let [a_max, j] = [limits.acceleration(), limits.jerk()].map(f64::from);
    // Forward is where the velocity grows if the acceleration is let go to zero at once.
    let left = velocity + acceleration * acceleration.abs() / (2.0 * j);
    let sign = if left > 0.0 { -1.0 } else { 1.0 };
    let (v, a) = (sign * velocity, sign * acceleration);
    let gain = a * a / (2.0 * j) - v;
    let peak = (j * gain).max(0.0).sqrt().min(a_max).max(a);
    let hold = (gain / a_max - a_max / j).max(0.0);
    let phases = [((peak - a) / j, j), (hold, 0.0), (peak / j, -j)];
    let end = phases.into_iter().fold((0.0, v, a), |(p, v, a), (t, j)| {
        let way = t * (v + t * (a / 2.0 + t * j / 6.0));
        (p + way, v + t * (a + t * j / 2.0), a + t * j)
    });
    sign * end.0
}

/// A start inside the limits, and a target next to where its fastest stop ends: where a move that turns back, or one that starts anew at
/// the end, takes a few percent longer than one that does not. Half of the starts come to rest with the largest jerk alone, or nearly:
/// there it is most.
pub(crate) fn start_and_target(random: &mut Random, limits: &Limits) -> (State, Position) {
    let [v_max, a_max, j] =
        [limits.velocity(), limits.acceleration(), limits.jerk()].map(f64::from);
    // What can be released without leaving the limit of the velocity.
    let a_max = a_max.min((1.9 * v_max * j).sqrt());
    let acceleration = match random.below(6) {
        0 => 0.0,
        1 => random.sign() * a_max,
        _ => random.between(-a_max, a_max),
    };
    let released = -acceleration * acceleration.abs() / (2.0 * j);
    let velocity = match random.below(6) {
        0 => released * random.between(0.5, 1.05),
        1 | 2 => released,
        3 => released * (1.0 - random.sign() * random.magnitude(1e-8, 0.05)),
        4 => turning_velocity(acceleration, limits) * (1.0 - random.magnitude(1e-9, 1e-2)),
        _ => random.between(-v_max, v_max),
    };
    let start = State {
        velocity: velocity.clamp(-v_max, v_max) as f32,
        acceleration: acceleration as f32,
        ..State::at_rest(random.below(1 << 20) as i32)
    };
    let (v, a) = (f64::from(start.velocity), f64::from(start.acceleration));
    let stop = way(v, a, limits);
    let length = stop.abs().max(a.abs().powi(3) / (6.0 * j * j));
    let off = match random.below(8) {
        0 => 0.0,
        _ => random.sign() * random.magnitude(1e-9, 1e-3) * length,
    };
    let units = (stop + off) * Position::UNITS as f64;
    (
        start,
        start.position.moved_by(Position::from_units(units as i64)),
    )
}

/// The velocity from which the fastest stop ends where it starts.
fn turning_velocity(acceleration: f64, limits: &Limits) -> f64 {
    let released = -acceleration * acceleration.abs() / (2.0 * f64::from(limits.jerk()));
    let is_behind = |share: f64| way(share * released, acceleration, limits) * released < 0.0;
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if is_behind(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low * released
}
