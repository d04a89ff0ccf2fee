//! Starts, targets and limits by the name of what is difficult about them.

use trajectory::{Limits, Position, Profile, State, Time};

use super::fastest_stop;
use super::random::Random;

/// What a case is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Class {
    AtTheTarget,
    OneCountAway,
    Dust,
    TargetBehind,
    BeyondLimits,
    TinyLimits,
    HugeLimits,
    LongestTravel,
    LimitsChanged,
    TargetMoved,
    NearTheStop,
    AtTheFastestStop,
    AnyState,
}

impl Class {
    pub(crate) const ALL: [Self; 13] = [
        Self::AtTheTarget,
        Self::OneCountAway,
        Self::Dust,
        Self::TargetBehind,
        Self::BeyondLimits,
        Self::TinyLimits,
        Self::HugeLimits,
        Self::LongestTravel,
        Self::LimitsChanged,
        Self::TargetMoved,
        Self::NearTheStop,
        Self::AtTheFastestStop,
        Self::AnyState,
    ];
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Case {
    pub(crate) class: Class,
    pub(crate) start: State,
    pub(crate) target: Position,
    pub(crate) limits: Limits,
}

impl Case {
    /// The case of a seed; the same for ever.
    pub(crate) fn of_seed(seed: u64) -> Self {
        let mut random = Random(seed);
        let class = Class::ALL[random.below(Class::ALL.len() as u64) as usize];
        Self::of_class(class, &mut random)
    }

    pub(crate) fn of_class(class: Class, random: &mut Random) -> Self {
        let limits = match class {
            Class::TinyLimits => tiny(random),
            Class::HugeLimits => huge(random),
            _ => usual(random),
        };
        let moving = moving(random, &limits, 1.0);
        let case = |start: State, target: i32| Self {
            class,
            start,
            target: Position::from_counts(target),
            limits,
        };
        let sign = random.sign() as i32;
        match class {
            Class::AtTheTarget => {
                let target = start_count(random);
                case(
                    State {
                        position: Position::from_counts(target),
                        ..moving
                    },
                    target,
                )
            }
            Class::OneCountAway => {
                let start = if random.below(2) == 0 {
                    moving
                } else {
                    State::at_rest(start_count(random))
                };
                case(start, start.position.counts() + sign)
            }
            Class::Dust => {
                let dust =
                    |random: &mut Random| (random.sign() * random.magnitude(1e-30, 1e-3)) as f32;
                let start = State {
                    position: moving.position,
                    velocity: dust(random),
                    acceleration: if random.below(2) == 0 {
                        dust(random)
                    } else {
                        0.0
                    },
                };
                case(start, start.position.counts() + random.below(3) as i32 - 1)
            }
            Class::TargetBehind => {
                let way = random
                    .magnitude(1.0, 1e6)
                    .copysign(f64::from(-moving.velocity));
                case(moving, moving.position.counts() + way as i32)
            }
            Class::BeyondLimits => {
                let start = self::moving(random, &limits, 8.0);
                case(start, near(random, start.position.counts()))
            }
            Class::LongestTravel => {
                let start = State {
                    position: Position::from_counts(-sign * ((1 << 27) - 1)),
                    ..moving
                };
                case(start, sign * ((1 << 27) - 1))
            }
            Class::LimitsChanged => {
                let target = near(random, moving.position.counts());
                case(on_the_way(random, &case(moving, target)), target)
            }
            Class::TargetMoved => {
                let target = near(random, moving.position.counts());
                let start = on_the_way(
                    random,
                    &Self {
                        limits,
                        ..case(moving, target)
                    },
                );
                // Small and large changes of the target alike.
                let by = random.sign() * random.magnitude(1.0, 1e5);
                Self {
                    limits,
                    ..case(start, target + by as i32)
                }
            }
            Class::NearTheStop => {
                let stop = Profile::stop(&moving, &limits)
                    .map_or(Position::ZERO, |stop| stop.end_position());
                let off = random.sign() * random.magnitude(1e-6, 1e3) * Position::UNITS as f64;
                let whole =
                    (stop.units() + off as i64 + Position::UNITS / 2).div_euclid(Position::UNITS);
                // A start with a fraction, so that the distance is any number.
                let shift = (whole * Position::UNITS) - stop.units() - off as i64;
                let start = State {
                    position: Position::from_units(moving.position.units() + shift),
                    ..moving
                };
                Self {
                    class,
                    start,
                    target: Position::from_units(whole * Position::UNITS),
                    limits,
                }
            }
            Class::AtTheFastestStop => {
                let (start, target) = fastest_stop::start_and_target(random, &limits);
                Self {
                    class,
                    start,
                    target,
                    limits,
                }
            }
            Class::TinyLimits | Class::HugeLimits | Class::AnyState => {
                case(moving, near(random, moving.position.counts()))
            }
        }
    }
}

fn start_count(random: &mut Random) -> i32 {
    random.below(1 << 28) as i32 - (1 << 27)
}

/// A target from one count to a million counts away, or anywhere.
fn near(random: &mut Random, from: i32) -> i32 {
    match random.below(8) {
        0 => start_count(random),
        _ => from + (random.sign() * random.magnitude(1.0, 1e6)) as i32,
    }
}

fn limits(velocity: f64, acceleration: f64, jerk: f64) -> Limits {
    let within = |value: f64, (min, max): (f32, f32)| (value as f32).clamp(min, max);
    Limits::new(
        within(velocity, Limits::VELOCITY),
        within(acceleration, Limits::ACCELERATION),
        within(jerk, Limits::JERK),
    )
    .expect("within the ranges")
}

/// Those of machines: 0.1 to 16384 counts per cycle in 3 to 3000 cycles, jerk in a third of it or far less or more.
fn usual(random: &mut Random) -> Limits {
    let velocity = random.magnitude(0.1, 16_384.0);
    let acceleration = velocity / random.magnitude(3.0, 3_000.0);
    let jerk = acceleration / random.magnitude(0.3, 1_000.0);
    limits(velocity, acceleration, jerk)
}

/// Up to ten times as large or small.
fn changed(random: &mut Random, before: &Limits) -> Limits {
    let mut times = |limit: f32| f64::from(limit) * random.magnitude(0.1, 10.0);
    limits(
        times(before.velocity()),
        times(before.acceleration()),
        times(before.jerk()),
    )
}

/// Hours for a million counts, minutes to get there.
fn tiny(random: &mut Random) -> Limits {
    let velocity = random.magnitude(1e-3, 1.0);
    let acceleration = velocity / random.magnitude(1.0, 1e5);
    let jerk = acceleration / random.magnitude(1.0, 1e5);
    limits(velocity, acceleration, jerk)
}

/// Everything within a cycle.
fn huge(random: &mut Random) -> Limits {
    limits(
        random.magnitude(1e2, 1e6),
        random.magnitude(1e2, 1e6),
        random.magnitude(1e2, 1e7),
    )
}

/// A moving start: velocity and acceleration up to `most` times the limits, now and then exactly at one or zero.
fn moving(random: &mut Random, limits: &Limits, most: f64) -> State {
    let mut of = |limit: f32| match random.below(8) {
        0 => 0.0,
        1 => (random.sign() as f32) * limit,
        _ => (random.between(-most, most) * f64::from(limit)) as f32,
    };
    let velocity = of(limits.velocity());
    let acceleration = of(limits.acceleration());
    State {
        position: Position::from_counts(start_count(random)),
        velocity: velocity.clamp(-State::LARGEST, State::LARGEST),
        acceleration: acceleration.clamp(-State::LARGEST, State::LARGEST),
    }
}

/// Somewhere in the middle of another move.
fn on_the_way(random: &mut Random, case: &Case) -> State {
    match Profile::to_rest(&case.start, case.target, &changed(random, &case.limits)) {
        Ok(profile) => {
            let at = profile.duration().ticks() as f64 * random.share();
            profile.state(Time::from_ticks(at as u64))
        }
        Err(_) => case.start,
    }
}
