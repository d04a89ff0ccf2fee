//! Stops, changes of velocity, trapezoids, tracking, and override of a profile.

mod independent;

use independent::cases::{Case, Class};
use independent::judge::{Exact, extrema, joined};
use independent::optimum::is_beyond_range;
use independent::random::Random;
use proptest::prelude::*;
use trajectory::{
    Limits, PlanError, Position, Profile, Quantity, State, Stretch, Time, TimeScale, Tracker,
};

fn counts(position: Position) -> f64 {
    position.units() as f64 / Position::UNITS as f64
}

fn cycles(time: Time) -> f64 {
    time.ticks() as f64 / 4_294_967_296.0
}

/// Every extremum of a profile.
fn all_extrema(profile: &Profile) -> Vec<(Exact, f64)> {
    let origin = profile.start_position();
    let of = |stretch: Stretch| {
        let from = Exact::start_of(&stretch, origin);
        let jerk = f64::from(stretch.jerk);
        extrema(from, jerk, cycles(stretch.duration)).map(move |point| (point, jerk))
    };
    profile.stretches().flat_map(of).collect()
}

fn trapezoid(limits: &Limits) -> Limits {
    Limits::without_jerk(limits.velocity(), limits.acceleration()).unwrap()
}

/// A failure prints its seed, which is all that is needed to repeat it.
fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        max_global_rejects: 10 * cases,
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config(10_000))]

    #[test]
    fn a_stop_is_the_fastest_way_to_rest(seed in any::<u64>().no_shrink()) {
        let case = Case::of_seed(seed);
        prop_assume!(!is_beyond_range(&case));
        let stop = Profile::stop(&case.start, &case.limits).unwrap();
        let stretches: Vec<Stretch> = stop.stretches().collect();
        prop_assert_eq!(joined(&case.start, &case.limits, &stop, &stretches), Ok(()));
        let end = stop.state(stop.duration());
        prop_assert_eq!((end.velocity, end.acceleration), (0.0, 0.0));
        prop_assert_eq!(end.position, stop.end_position());
        prop_assert_eq!(stop.position(Time::MAX), end.position);
        let a_max = f64::from(case.limits.acceleration().max(case.start.acceleration.abs())) * 1.000_001;
        let j_max = f64::from(case.limits.jerk());
        for (point, jerk) in all_extrema(&stop) {
            prop_assert!(point.a.abs() <= a_max && jerk.abs() <= j_max, "{:?}", point);
        }
        // No way to rest is faster than the one to where this one ends.
        let target = Position::from_units(stop.end_position().units());
        let other = Profile::to_rest(&case.start, target, &case.limits).unwrap();
        let allowed = cycles(other.duration()) * 1.01 + 1.0 / 256.0;
        prop_assert!(cycles(stop.duration()) <= allowed, "{} {}", stop.duration(), other.duration());
    }

    #[test]
    fn a_change_of_velocity_ends_at_it_for_ever(seed in any::<u64>().no_shrink(), share in -1.0..=1.0_f32) {
        let case = Case::of_seed(seed);
        prop_assume!(!is_beyond_range(&case));
        let velocity = share * case.limits.velocity();
        for limits in [case.limits, trapezoid(&case.limits)] {
            let jog = Profile::to_velocity(&case.start, velocity, &limits).unwrap();
            let end = jog.state(jog.duration());
            prop_assert_eq!((end.velocity, end.acceleration), (velocity, 0.0));
            let later = jog.duration().after(Time::from_cycles(100_000));
            let way = counts(jog.position(later).distance_from(end.position));
            prop_assert!((way - f64::from(velocity) * cycles(later.since(jog.duration()))).abs() < 1e-5);
            // Between start and goal, but for what the acceleration at the start makes unavoidable.
            let a = f64::from(case.start.acceleration);
            let gained = if limits.jerk() < f32::INFINITY { a * a / 1.999 / f64::from(limits.jerk()) } else { 0.0 };
            let (v0, v1) = (f64::from(case.start.velocity), f64::from(velocity));
            let steepest = 4_095.0 * f64::from(limits.velocity().min(limits.acceleration()));
            let gained = gained.max(a * a / 1.999 / steepest);
            let dust = 1e-5 * f64::from(limits.velocity()).max(v0.abs());
            for (point, _) in all_extrema(&jog) {
                prop_assert!(point.v <= v0.max(v1) + gained + dust && point.v >= v0.min(v1) - gained - dust, "{:?}", point);
            }
        }
    }

    #[test]
    fn a_trapezoid_keeps_its_limits_and_is_the_fastest(seed in any::<u64>().no_shrink()) {
        let case = Case::of_seed(seed);
        prop_assume!(!is_beyond_range(&case));
        let limits = trapezoid(&case.limits);
        let start = State { acceleration: 0.0, ..case.start };
        let profile = Profile::to_rest(&start, case.target, &limits).unwrap();
        prop_assert_eq!(profile.end_position(), case.target);
        prop_assert_eq!(profile.position(profile.duration()), case.target);
        let (v, a) = (f64::from(limits.velocity()), f64::from(limits.acceleration()));
        let v0 = f64::from(start.velocity);
        let v_most = v.max(v0.abs()) * 1.000_004;
        for (point, jerk) in all_extrema(&profile) {
            prop_assert!(jerk == 0.0 && point.v.abs() <= v_most && point.a.abs() <= a, "{:?}", point);
        }
        // By hand: the fastest trapezoid.
        let way = counts(case.target.distance_from(start.position));
        let stop = v0 * v0.abs() / 2.0 / a;
        let sign = if way < stop { -1.0 } else { 1.0 };
        let (way, v0) = (sign * way, sign * v0);
        let highest = (a * way + v0 * v0 / 2.0).max(0.0).sqrt();
        let best = if v0 > v {
            (v0 - v) / a + (way - v0 * v0 / 2.0 / a) / v + v / a
        } else if highest > v {
            (v - v0) / a + (way - (v * v - v0 * v0 / 2.0) / a) / v + v / a
        } else {
            (2.0 * highest - v0) / a
        };
        let actual = cycles(profile.duration());
        prop_assert!((actual - best).abs() <= 0.002 * best + 1e-3, "{} instead of {}", actual, best);
    }
}

proptest! {
    #![proptest_config(config(200))]

    #[test]
    fn an_override_changes_the_time_and_not_the_way(seed in any::<u64>().no_shrink()) {
        let mut random = Random(seed);
        let case = Case::of_class(Class::AnyState, &mut random);
        prop_assume!(!is_beyond_range(&case));
        let profile = Profile::to_rest(&case.start, case.target, &case.limits).unwrap();
        let fastest = all_extrema(&profile)
            .into_iter()
            .fold(0.0_f64, |v, (point, _)| v.max(point.v.abs()));
        let mut scale = TimeScale::running(20).unwrap();
        let mut before = profile.position(Time::ZERO);
        for _ in 0..2_000 {
            match random.below(50) {
                0 => scale.set_override(random.below(201) as u16).unwrap(),
                1 => scale.pause(),
                2..5 => scale.resume(),
                _ => {}
            }
            let (rate, position) = (scale.rate(), profile.position(scale.advance()));
            let share = f64::from(rate.max(scale.rate()));
            let step = counts(position.distance_from(before)).abs();
            prop_assert!(step <= share * fastest * 1.000_01 + 1e-4, "{} {}", step, share * fastest);
            before = position;
            if profile.is_done(scale.time()) {
                break;
            }
        }
    }

    /// A new target in every cycle: the limits are kept from cycle to cycle, and the axis arrives once the target stands.
    #[test]
    fn a_target_that_jumps_in_every_cycle_is_followed_within_the_limits(seed in any::<u64>().no_shrink()) {
        let mut random = Random(seed);
        let limits = std::iter::repeat_with(|| Case::of_class(Class::AnyState, &mut random).limits)
            .find(|limits| limits.velocity() / limits.acceleration() < 300.0)
            .unwrap();
        let mut tracker = Tracker::at_rest(0, limits);
        let mut target = 0;
        let mut before = tracker.state();
        let [v, a, j] = [limits.velocity(), limits.acceleration(), limits.jerk()].map(|limit| f64::from(limit) * 1.000_005);
        for cycle in 0..2_000 {
            if cycle < 500 {
                target += (random.sign() * random.magnitude(0.1, 100.0)) as i32;
            }
            let position = tracker.next(Position::from_counts(target)).unwrap();
            let now = tracker.state();
            prop_assert_eq!(now.position, position);
            let step = counts(now.position.distance_from(before.position));
            prop_assert!(step.abs() <= v + 1e-4);
            prop_assert!(f64::from(now.velocity).abs() <= v);
            prop_assert!(f64::from(now.velocity - before.velocity).abs() <= a + 1e-6 * v);
            prop_assert!(f64::from(now.acceleration - before.acceleration).abs() <= j + 1e-6 * a);
            // Where it is follows from where it was and how it moved.
            let mean = f64::from(now.velocity + before.velocity) / 2.0;
            prop_assert!((step - mean).abs() <= a / 4.0 + 1e-4, "{} {}", step, mean);
            before = now;
        }
        for _ in 0..20_000 {
            tracker.next(Position::from_counts(target)).unwrap();
        }
        // Slower limits need longer than this test waits.
        if limits.acceleration() / limits.jerk() < 1_000.0 && limits.velocity() > 1.0 {
            prop_assert!(tracker.is_there());
            prop_assert_eq!(tracker.state(), State::at_rest(target));
        }
    }

    /// A target whose velocity is another one in every cycle, up to twice the limit: the axis keeps its limits from cycle to cycle.
    #[test]
    fn a_target_that_swings_is_followed_within_the_limits(seed in any::<u64>().no_shrink()) {
        let mut random = Random(seed);
        let limits = Case::of_class(Class::AnyState, &mut random).limits;
        let mut tracker = Tracker::at_rest(0, limits);
        let mut target = Position::ZERO;
        let mut before = tracker.state();
        let [v, a, j] = [limits.velocity(), limits.acceleration(), limits.jerk()].map(f64::from);
        for cycle in 0..2_000 {
            let velocity = (random.between(-2.0, 2.0) * v) as f32;
            match random.below(40) {
                0 => prop_assert!(tracker.next(target).is_ok()),
                _ => prop_assert!(tracker.follow(target, velocity).is_ok()),
            }
            target = target.moved_by(Position::at_velocity(velocity, Time::from_cycles(1)));
            let now = tracker.state();
            // In the frame of the target rounding is that of the sum of both velocities.
            prop_assert!(f64::from(now.velocity).abs() <= v * 1.000_01, "{} at {}", now.velocity, cycle);
            prop_assert!(f64::from(now.velocity - before.velocity).abs() <= a + 2e-5 * v);
            prop_assert!(f64::from(now.acceleration - before.acceleration).abs() <= j + 1e-5 * a);
            before = now;
        }
    }

    /// Planned anew for the same target in every cycle, from what a state can hold, the move takes no longer and stays there.
    #[test]
    fn a_move_that_is_planned_anew_in_every_cycle_stays_in_time(seed in any::<u64>().no_shrink()) {
        let mut random = Random(seed);
        let case = Case::of_class(Class::AnyState, &mut random);
        prop_assume!(!is_beyond_range(&case));
        let first = Profile::to_rest(&case.start, case.target, &case.limits).unwrap();
        prop_assume!(first.duration() < Time::from_cycles(3_000));
        let cycle = Time::from_cycles(1);
        let most = (1.01 * f64::from(first.duration().whole_cycles())) as u32 + 3;
        let mut state = case.start;
        for cycles in 0..most + 50 {
            let off = counts(state.position.distance_from(case.target));
            prop_assert!(cycles < most || off.abs() <= 1.0 / 16_384.0, "{} off at cycle {} of {}", off, cycles, most);
            state = Profile::to_rest(&state, case.target, &case.limits).unwrap().state(cycle);
        }
    }

    /// A target at constant velocity is caught up with and then followed without lag.
    #[test]
    fn a_target_that_moves_is_followed_without_lag(seed in any::<u64>().no_shrink(), share in -0.9..0.9_f32) {
        let mut random = Random(seed);
        let limits = Limits::new(
            random.magnitude(1.0, 1e4) as f32,
            random.magnitude(0.5, 100.0) as f32,
            random.magnitude(0.05, 10.0) as f32,
        )
        .unwrap();
        let velocity = share * limits.velocity();
        let mut tracker = Tracker::at_rest(0, limits);
        let mut target = Position::from_counts((random.sign() * random.magnitude(1.0, 1e4)) as i32);
        let v_max = f64::from(limits.velocity()) * 1.000_005;
        for _ in 0..100_000 {
            tracker.follow(target, velocity).unwrap();
            target = target.moved_by(Position::at_velocity(velocity, Time::from_cycles(1)));
            prop_assert!(f64::from(tracker.state().velocity).abs() <= v_max);
            if tracker.is_there() {
                break;
            }
        }
        prop_assert!(tracker.is_there());
        for _ in 0..100 {
            tracker.follow(target, velocity).unwrap();
            target = target.moved_by(Position::at_velocity(velocity, Time::from_cycles(1)));
            let lag = counts(target.distance_from(tracker.state().position));
            prop_assert!(lag.abs() < 1e-3, "{}", lag);
        }
    }
}

const LIMITS: Limits = match Limits::new(100.0, 2.0, 0.1) {
    Ok(limits) => limits,
    Err(_) => panic!("within the ranges"),
};

#[test]
fn a_refused_target_leaves_the_tracker_as_it_was() {
    let mut tracker = Tracker::at_rest(5, LIMITS);
    for _ in 0..10 {
        tracker.next(Position::from_counts(1_000)).unwrap();
    }
    let before = tracker;
    assert!(matches!(
        tracker.next(Position::from_units(i64::MAX)),
        Err(PlanError::TooFar | PlanError::TooLong)
    ));
    assert!(matches!(
        tracker.follow(Position::ZERO, f32::NAN),
        Err(PlanError::Range(_))
    ));
    assert_eq!(tracker, before);
    let slow = Limits::new(1e-6, 1e-6, 1e-6).unwrap();
    assert!(tracker.set_limits(slow).is_err());
    assert_eq!(tracker, before);
    let fast = Limits::new(1_000.0, 20.0, 5.0).unwrap();
    tracker.set_limits(fast).unwrap();
    let before = tracker.state();
    tracker.next(Position::from_counts(1_000)).unwrap();
    assert!(tracker.state().acceleration > before.acceleration + 1.0);
}

#[test]
fn a_velocity_beyond_its_limit_is_refused() {
    for velocity in [100.1, -100.1, f32::NAN, f32::INFINITY] {
        let Err(PlanError::Range(error)) =
            Profile::to_velocity(&State::at_rest(0), velocity, &LIMITS)
        else {
            panic!("{velocity} is not refused");
        };
        assert_eq!((error.quantity, error.max), (Quantity::Velocity, 100.0));
    }
}

#[test]
fn a_start_that_is_no_number_is_refused() {
    for (velocity, acceleration) in [
        (f32::NAN, 0.0),
        (0.0, f32::INFINITY),
        (2e6, 0.0),
        (0.0, -2e6),
    ] {
        let start = State {
            velocity,
            acceleration,
            ..State::at_rest(0)
        };
        assert!(matches!(
            Profile::to_rest(&start, Position::ZERO, &LIMITS),
            Err(PlanError::Range(_))
        ));
        assert!(Profile::stop(&start, &LIMITS).is_err());
    }
}

#[test]
fn what_is_too_far_or_too_long_is_refused() {
    let start = State::at_rest(0);
    let far = Position::from_units(i64::MAX / 2);
    let fast = Limits::new(1e6, 1e4, 1e3).unwrap();
    assert_eq!(Profile::to_rest(&start, far, &fast), Err(PlanError::TooFar));
    let slow = Limits::new(0.01, 0.01, 0.01).unwrap();
    let target = Position::from_counts(1 << 27);
    assert_eq!(
        Profile::to_rest(&start, target, &slow),
        Err(PlanError::TooLong)
    );
    let slow = Limits::without_jerk(0.01, 0.01).unwrap();
    assert_eq!(
        Profile::to_rest(&start, target, &slow),
        Err(PlanError::TooLong)
    );
}

/// 10^9 counts and more, by one velocity and by 10,000 moves, without losing one.
#[test]
fn nothing_drifts() {
    let jog = Profile::to_velocity(&State::at_rest(0), 0.1, &LIMITS).unwrap();
    let start = jog.end_position();
    let at = jog.duration().after(Time::from_cycles(4_000_000_000));
    let way = counts(jog.position(at).distance_from(start));
    assert!((way - f64::from(0.1_f32) * 4e9).abs() < 1e-4, "{way}");

    let mut random = Random(1);
    let (mut state, mut sum) = (State::at_rest(0), 0_i64);
    for _ in 0..10_000 {
        let by = random.between(50_000.0, 200_000.0) as i32;
        sum += i64::from(by);
        let target = state.position.moved_by(Position::from_counts(by));
        let profile = Profile::to_rest(&state, target, &LIMITS).unwrap();
        state = profile.state(profile.duration());
        assert_eq!((state.velocity, state.acceleration), (0.0, 0.0));
    }
    assert!(sum > 1_000_000_000);
    assert_eq!(state.position.wide_counts(), sum);
    assert_eq!(state.position.counts(), sum as i32);
}

/// A longer or shorter cruise makes the end exact; nothing is left to spread.
#[test]
fn a_cruise_takes_what_rounding_leaves_over() {
    for target in [100_000, 123_456_789, -134_217_727] {
        let target = Position::from_counts(target);
        let profile = Profile::to_rest(&State::at_rest(0), target, &LIMITS).unwrap();
        assert_eq!(profile.end_position(), target);
        assert!(
            profile
                .stretches()
                .all(|stretch| stretch.velocity_correction == 0.0)
        );
    }
}

/// A stop from the limit of the velocity to a place that is a millionth of the way further: the stretches below the limit take it.
#[test]
fn what_is_spread_leads_beyond_no_limit() {
    for sign in [1.0, -1.0] {
        let start = State {
            velocity: sign * LIMITS.velocity(),
            ..State::at_rest(0)
        };
        let end = Profile::stop(&start, &LIMITS).unwrap().end_position();
        for share in [-1.5e-6, -0.5e-6, 0.5e-6, 1.5e-6] {
            let by = Position::from_units((end.units() as f64 * share) as i64);
            let profile = Profile::to_rest(&start, end.moved_by(by), &LIMITS).unwrap();
            assert_eq!(profile.stretches().count(), 3);
            for (point, _) in all_extrema(&profile) {
                assert!(point.v.abs() <= 100.0, "{share}: {point:?}");
            }
        }
    }
}

#[test]
fn the_extent_is_where_the_axis_turns() {
    // Too fast for its target: overshoots and comes back.
    let start = State {
        velocity: 50.0,
        ..State::at_rest(1_000)
    };
    let profile = Profile::to_rest(&start, Position::from_counts(1_100), &LIMITS).unwrap();
    let (lowest, highest) = profile.extent();
    let last = profile.duration().whole_cycles();
    let sampled: Vec<i32> = (0..=last)
        .map(|cycle| profile.position(Time::from_cycles(cycle)).counts())
        .collect();
    assert_eq!(lowest.counts(), 1_000);
    assert_eq!(Some(&highest.counts()), sampled.iter().max());
    assert!(highest.counts() > 1_500);
    // The same mirrored, and without a limit of the jerk.
    let start = State {
        velocity: -50.0,
        ..State::at_rest(-1_000)
    };
    let mirrored = Profile::to_rest(&start, Position::from_counts(-1_100), &LIMITS).unwrap();
    assert_eq!(mirrored.extent().0.counts(), -highest.counts());
    assert_eq!(mirrored.extent().1.counts(), -1_000);
    let profile =
        Profile::to_rest(&start, Position::from_counts(-1_100), &trapezoid(&LIMITS)).unwrap();
    assert_eq!(profile.extent().0.counts(), -1_000 - 50 * 50 / 4);
}

#[test]
fn a_profile_of_rest_rests() {
    let rest = Profile::rest(-3);
    assert!(rest.is_done(Time::ZERO));
    assert_eq!(rest.duration(), Time::ZERO);
    assert_eq!(rest.position(Time::MAX).counts(), -3);
    assert_eq!(rest.state(Time::ZERO), State::at_rest(-3));
    assert_eq!(rest.stretches().count(), 0);
    assert_eq!(rest.extent().0, rest.extent().1);
    assert_eq!(rest.start_position(), rest.end_position());
}

#[test]
fn a_move_is_done_at_its_end_and_not_before() {
    let profile =
        Profile::to_rest(&State::at_rest(0), Position::from_counts(500), &LIMITS).unwrap();
    let end = profile.duration();
    assert!(profile.is_done(end));
    assert!(!profile.is_done(Time::from_ticks(end.ticks() - 1)));
    assert!(!profile.is_done(Time::ZERO));
}

/// What the README says of the memory.
#[test]
fn values_are_small() {
    assert_eq!(size_of::<Profile>(), 352);
    assert_eq!(size_of::<Result<Profile, PlanError>>(), 360);
    assert_eq!(size_of::<TimeScale>(), 24);
}
