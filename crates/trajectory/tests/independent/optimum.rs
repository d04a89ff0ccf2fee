//! The duration of the time-optimal move after rsruckig, and bounds where it does not answer.

use rsruckig::prelude::*;

use trajectory::{Position, State};

use super::cases::Case;

/// The duration in cycles; `None` where the other solver fails.
pub(crate) fn optimum(case: &Case) -> Option<f64> {
    let mut input = InputParameter::<1>::new(None);
    let counts =
        case.target.distance_from(case.start.position).units() as f64 / Position::UNITS as f64;
    input.current_position[0] = 0.0;
    input.current_velocity[0] = f64::from(case.start.velocity);
    input.current_acceleration[0] = f64::from(case.start.acceleration);
    input.target_position[0] = counts;
    input.max_velocity[0] = f64::from(case.limits.velocity());
    input.max_acceleration[0] = f64::from(case.limits.acceleration());
    input.max_jerk[0] = f64::from(case.limits.jerk());
    let mut solver = Ruckig::<1, ThrowErrorHandler>::new(None, 1.0);
    let mut trajectory = Trajectory::<1>::new(None);
    match solver.calculate(&input, &mut trajectory) {
        Ok(RuckigResult::Working | RuckigResult::Finished) => Some(trajectory.get_duration()),
        _ => None,
    }
}

/// No move is faster: each limit alone needs this long.
pub(crate) fn lower_bound(case: &Case) -> f64 {
    let (v, a) = (
        f64::from(case.start.velocity),
        f64::from(case.start.acceleration),
    );
    let [v_max, a_max, j_max] = [
        case.limits.velocity(),
        case.limits.acceleration(),
        case.limits.jerk(),
    ]
    .map(f64::from);
    let way = (case.target.distance_from(case.start.position).units() as f64
        / Position::UNITS as f64)
        .abs();
    let fastest = v_max.max(v.abs() + a * a / 2.0 / j_max);
    let hardest = a_max.max(a.abs());
    (way / fastest).max(v.abs() / hardest).max(a.abs() / j_max)
}

/// Whether a refusal is right: the start is beyond the range of a state, or the fastest stop alone, or the way at the highest velocity, is beyond what a profile may be. Durations
/// that are near the limit either way count as right.
pub(crate) fn is_beyond_range(case: &Case) -> bool {
    let [v_max, a_max, j] = [
        case.limits.velocity(),
        case.limits.acceleration(),
        case.limits.jerk(),
    ]
    .map(f64::from);
    let (v, a) = (
        f64::from(case.start.velocity).abs(),
        f64::from(case.start.acceleration).abs(),
    );
    let way = (case.target.distance_from(case.start.position).units() as f64
        / Position::UNITS as f64)
        .abs();
    // While the acceleration is released, velocity grows to this at most; from there the brake takes so long and so far.
    let highest = v + a * a / (2.0 * j);
    let brake = highest / a_max + 2.0 * a.max(a_max) / j;
    let far = highest * (a / j + brake);
    let long = a / j + brake + (way + far) / v_max;
    v.max(a) > f64::from(State::LARGEST) || far > 2_f64.powi(33) || long > 2_f64.powi(29)
}
