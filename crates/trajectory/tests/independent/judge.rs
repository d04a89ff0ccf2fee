//! A judge of profiles that knows nothing of how they are made: it integrates the stretches in double precision and looks at the
//! extrema of each.

use trajectory::{Limits, Position, Profile, State, Stretch, Time};

use super::cases::Case;

/// Rounding that a limit may be exceeded by: two units in the last place of a float.
const ROUNDING: f64 = 1.0 + 2.0 * f32::EPSILON as f64;
/// Largest jump of position at the border of two stretches, in counts, and at the end.
const JUMP_COUNTS: f64 = 1.0 / 16_384.0;
/// The same as a share of the longest way from the start, for ways of more than 2^29 counts: a correction of the velocity is a float.
const JUMP_SHARE: f64 = 1.0 / (1_u64 << 43) as f64;
/// Largest jump of velocity and acceleration there, relative to their largest value in the profile.
const JUMP: f64 = 1.0 / 131_072.0;
/// A start below this share of the limits leaves room for rounding.
const ROOM: f64 = 1.0 - 1.0 / 131_072.0;
/// What rounding may add to a limit, as a share of the largest value, where the start leaves no room.
const NO_ROOM: f64 = 1.0 / 524_288.0;
/// Velocity and acceleration below this share of their limits count as so much.
const LEAST: f64 = 1.0 / 4_096.0;
const TICK: f64 = 1.0 / 4_294_967_296.0;

fn counts(position: Position) -> f64 {
    position.units() as f64 / Position::UNITS as f64
}

fn cycles(time: Time) -> f64 {
    time.ticks() as f64 * TICK
}

/// Position, velocity and acceleration in double precision.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Exact {
    pub(crate) p: f64,
    pub(crate) v: f64,
    pub(crate) a: f64,
}

impl Exact {
    pub(crate) fn of(state: &State, origin: Position) -> Self {
        Self {
            p: counts(state.position.distance_from(origin)),
            v: f64::from(state.velocity),
            a: f64::from(state.acceleration),
        }
    }

    /// The state at the start of a stretch.
    pub(crate) fn start_of(stretch: &Stretch, origin: Position) -> Self {
        let state = Self::of(&stretch.state, origin);
        Self {
            v: state.v + f64::from(stretch.velocity_correction),
            ..state
        }
    }

    pub(crate) fn later(self, j: f64, t: f64) -> Self {
        Self {
            p: self.p + t * (self.v + t * (self.a / 2.0 + t * j / 6.0)),
            v: self.v + t * (self.a + t * j / 2.0),
            a: self.a + t * j,
        }
    }
}

/// Largest sizes in a profile.
#[derive(Debug, Clone, Copy)]
struct Largest {
    p: f64,
    v: f64,
    a: f64,
}

/// Checks a move to rest.
pub(crate) fn judge(case: &Case, profile: &Profile) -> Result<(), String> {
    let stretches: Vec<Stretch> = profile.stretches().collect();
    joined(&case.start, &case.limits, profile, &stretches)?;
    within(&case.start, &case.limits, profile, &stretches)?;
    if profile.end_position() != case.target {
        return Err(format!("ends at {:?}", profile.end_position()));
    }
    for late in [
        profile.duration(),
        profile.duration().after(Time::from_cycles(1)),
        Time::MAX,
    ] {
        let state = profile.state(late);
        if state.position != case.target || state.velocity != 0.0 || state.acceleration != 0.0 {
            return Err(format!("does not rest at the target: {state:?}"));
        }
    }
    Ok(())
}

/// Each stretch starts where the one before it ends, the first one at the start, and the last one ends where the profile says.
pub(crate) fn joined(
    start: &State,
    limits: &Limits,
    profile: &Profile,
    stretches: &[Stretch],
) -> Result<(), String> {
    let origin = start.position;
    let mut largest = Largest {
        p: 0.0,
        v: LEAST * f64::from(limits.velocity()),
        a: LEAST * f64::from(limits.acceleration()),
    };
    for stretch in stretches {
        let state = Exact::start_of(stretch, origin);
        largest.p = largest.p.max(state.p.abs());
        largest.v = largest.v.max(state.v.abs());
        largest.a = largest.a.max(state.a.abs());
    }
    let mut now = Exact::of(start, origin);
    let mut time = Time::ZERO;
    let mut corner = (now.a.abs() * TICK, 0.0);
    let nearly = |from: Exact, to: Exact, corner: (f64, f64), place: usize| {
        let (v, a) = (JUMP * largest.v + corner.0, JUMP * largest.a + corner.1);
        let is_joined = (from.p - to.p).abs() <= JUMP_COUNTS + JUMP_SHARE * largest.p
            && (from.v - to.v).abs() <= v
            && (from.a - to.a).abs() <= a;
        is_joined.then_some(()).ok_or_else(|| {
            format!("jump before stretch {place}: {from:?} to {to:?}, allowed {v:e} and {a:e}")
        })
    };
    for (place, stretch) in stretches.iter().enumerate() {
        let state = Exact::start_of(stretch, origin);
        if stretch.start != time {
            return Err(format!(
                "stretch {place} starts at {} instead of {time}",
                stretch.start
            ));
        }
        nearly(now, state, corner, place)?;
        let j = f64::from(stretch.jerk);
        now = state.later(j, cycles(stretch.duration));
        time = time.after(stretch.duration);
        // What half a tick changes, twice.
        corner = (state.a.abs().max(now.a.abs()) * TICK, j.abs() * TICK);
    }
    if profile.duration() != time {
        return Err(format!("lasts {} instead of {time}", profile.duration()));
    }
    let end = Exact::of(&profile.state(time), origin);
    nearly(now, end, corner, stretches.len())
}

/// The extrema of each stretch keep the limits; a start beyond them comes back without going further out than it must.
fn within(
    start: &State,
    limits: &Limits,
    profile: &Profile,
    stretches: &[Stretch],
) -> Result<(), String> {
    let [v_max, a_max, j_max] = [limits.velocity(), limits.acceleration(), limits.jerk()]
        .map(|limit| f64::from(limit) * ROUNDING);
    let begin = Exact::of(start, start.position);
    // The velocity that a start goes to whatever the jerk. The planned jerk is a little smaller.
    let gained = begin.a * begin.a
        / 2.0
        / f64::from(limits.jerk()).min(
            4_095.0 * f64::from(limits.acceleration()).min(4_095.0 * f64::from(limits.velocity())),
        );
    let forced = |sign: f64| {
        sign * begin.v
            + if sign * begin.a > 0.0 {
                gained * 1.000_2
            } else {
                0.0
            }
    };
    // A start that is at a limit, or beyond it, leaves no room for rounding: the limit is then kept to a share of the largest value.
    let has_room = begin.a.abs() <= ROOM * a_max && forced(1.0).max(forced(-1.0)) <= ROOM * v_max;
    let largest = |first: f64, limit: f64, of: fn(&State) -> f32| {
        let most = stretches.iter().fold(first.abs(), |most, stretch| {
            most.max(f64::from(of(&stretch.state)).abs())
        });
        if has_room {
            0.0
        } else {
            NO_ROOM * most.max(limit)
        }
    };
    let dust = largest(begin.v, v_max, |state| state.velocity);
    let (v_max, a_max) = (
        v_max + dust,
        a_max + largest(begin.a, a_max, |state| state.acceleration),
    );
    let (v_high, v_low) = (
        v_max.max(forced(1.0) + dust),
        -v_max.max(forced(-1.0) + dust),
    );
    let (a_high, a_low) = (
        a_max.max(begin.a * ROUNDING),
        -a_max.max(-begin.a * ROUNDING),
    );
    let (lowest, highest) = profile.extent();
    let (lowest, highest) = (
        counts(lowest.distance_from(start.position)) - JUMP_COUNTS,
        counts(highest.distance_from(start.position)) + JUMP_COUNTS,
    );
    let mut was_inside = false;
    for (place, stretch) in stretches.iter().enumerate() {
        let j = f64::from(stretch.jerk);
        let from = Exact::start_of(stretch, start.position);
        if j.abs() > j_max {
            return Err(format!("jerk {j} in stretch {place}"));
        }
        for point in extrema(from, j, cycles(stretch.duration)) {
            if point.a > a_high || point.a < a_low {
                return Err(format!("acceleration {} in stretch {place}", point.a));
            }
            if point.v > v_high || point.v < v_low {
                return Err(format!(
                    "velocity {} in stretch {place}, allowed {v_low} to {v_high}",
                    point.v
                ));
            }
            let slack = 1e-9 * (highest - lowest);
            if point.p < lowest - slack || point.p > highest + slack {
                return Err(format!(
                    "position {} in stretch {place} outside {lowest} to {highest}",
                    point.p
                ));
            }
            let is_inside = point.v.abs() <= v_max && point.a.abs() <= a_max;
            // A start inside the limits that cannot stay inside is no mistake of the profile.
            if was_inside && !is_inside && forced(point.v.signum()) <= ROOM * v_max {
                return Err(format!("leaves the limits in stretch {place}: {point:?}"));
            }
            was_inside |= is_inside;
        }
    }
    Ok(())
}

/// Start, end, and where acceleration or velocity are zero between them.
pub(crate) fn extrema(from: Exact, j: f64, duration: f64) -> impl Iterator<Item = Exact> {
    let root = (from.a * from.a - 2.0 * from.v * j).sqrt();
    let turns = if j == 0.0 {
        [f64::NAN, -from.v / from.a, f64::NAN]
    } else {
        [-from.a / j, (-from.a - root) / j, (-from.a + root) / j]
    };
    let inner = turns.into_iter().filter(move |&t| t > 0.0 && t < duration);
    core::iter::once(0.0)
        .chain(inner)
        .chain(core::iter::once(duration))
        .map(move |t| from.later(j, t))
}

/// Samples a profile at every cycle, at most `most` of them evenly, and compares with the integrated stretches and the limits.
pub(crate) fn judge_samples(case: &Case, profile: &Profile, most: u32) -> Result<(), String> {
    let stretches: Vec<Stretch> = profile.stretches().collect();
    let origin = case.start.position;
    let last = profile.duration().whole_cycles();
    let stride = last / most + 1;
    let fastest = stretches.iter().fold(0.0_f64, |fastest, stretch| {
        extrema(
            Exact::start_of(stretch, origin),
            f64::from(stretch.jerk),
            cycles(stretch.duration),
        )
        .fold(fastest, |fastest, point| fastest.max(point.v.abs()))
    });
    let mut place = 0;
    let mut cycle = 0;
    while cycle < last {
        let at = Time::from_cycles(cycle);
        while place + 1 < stretches.len() && stretches[place + 1].start <= at {
            place += 1;
        }
        let stretch = &stretches[place];
        let expected = Exact::start_of(stretch, origin)
            .later(f64::from(stretch.jerk), cycles(at.since(stretch.start)));
        let actual = profile.state(at);
        let state = Exact::of(&actual, origin);
        let tolerance = JUMP_COUNTS + 1e-12 * expected.p.abs();
        if (state.p - expected.p).abs() > tolerance {
            return Err(format!(
                "at cycle {cycle} {state:?} instead of {expected:?}"
            ));
        }
        let step = f64::from(
            profile
                .position(at.after(Time::from_cycles(1)))
                .counts()
                .wrapping_sub(actual.position.counts()),
        );
        if step.abs() > fastest * ROUNDING + 1.0 {
            return Err(format!(
                "a step of {step} at cycle {cycle}, fastest {fastest}"
            ));
        }
        cycle = cycle.saturating_add(stride);
    }
    Ok(())
}
