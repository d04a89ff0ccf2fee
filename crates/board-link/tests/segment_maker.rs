//! Segments of set-points: a board with the same limits takes each of them, and is at each set-point in its cycle.

use board_link::host::{SegmentMaker, SegmentMakerConfig};
use board_link::segment::{
    Begin, Segment, SegmentConfig, SegmentPreview, SegmentQueue, Shape, StreamPhase,
};
use board_link::{AxisLimits, Refusal, WhenDry};
use proptest::prelude::*;
use trajectory::{Limits, Position, Time};

const AXES: usize = 2;

fn limits(velocity: f32, acceleration: f32, jerk: Option<f32>) -> AxisLimits {
    let motion = match jerk {
        Some(jerk) => Limits::new(velocity, acceleration, jerk),
        None => Limits::without_jerk(velocity, acceleration),
    };
    AxisLimits {
        motion: motion.unwrap(),
        lowest: Position::from_counts(-20_000),
        highest: Position::from_counts(20_000),
    }
}

fn config() -> SegmentMakerConfig {
    SegmentMakerConfig {
        longest_gap: Time::from_cycles(10_000),
        kept: 56,
        least_kept: Time::from_cycles(300),
    }
}

const STAND: [Position; AXES] = [Position::from_counts(1_000), Position::from_counts(-77)];

fn maker(limits: &[AxisLimits; AXES]) -> SegmentMaker<AXES> {
    let preview = SegmentPreview::new(limits, &STAND).unwrap();
    SegmentMaker::new(preview, &STAND, config()).unwrap()
}

/// Where the axes are in each cycle of a board that plays these segments.
fn played(limits: &[AxisLimits; AXES], segments: &[Segment]) -> Vec<[Position; AXES]> {
    let mut queue = SegmentQueue::<AXES, 57>::new();
    let config = SegmentConfig::with_cycles_per_second(1_000);
    let (mut admission, mut player) = queue.split(limits, config).unwrap();
    let begin = Begin {
        stream: 1,
        start: None,
        when_dry: WhenDry::End,
        percent: 100,
        from: STAND.iter().map(|at| at.units()).collect(),
    };
    admission.begin(&begin, &STAND, 0).unwrap();
    let (mut sent, mut rows, mut out) = (0, Vec::new(), STAND);
    for cycle in 1.. {
        while sent < segments.len() && admission.credit() > 0 {
            admission.push(1, sent as u32, &segments[sent]).unwrap();
            sent += 1;
        }
        if sent == segments.len() {
            admission.end(1).unwrap();
        }
        if player.advance(cycle, &STAND, &mut out) {
            rows.push(out);
        }
        if !player.phase().is_active() {
            assert_eq!(player.phase(), StreamPhase::Complete);
            return rows;
        }
    }
    rows
}

/// A point of a wavy path that begins and ends at rest.
fn wave(share: f64) -> [Position; AXES] {
    let eased = share.powi(3) * (10.0 - 15.0 * share + 6.0 * share * share);
    let units = |counts: f64| Position::from_units((counts * Position::UNITS as f64) as i64);
    [
        STAND[0].moved_by(units(3_000.0 * eased)),
        STAND[1].moved_by(units(
            500.0 * (core::f64::consts::TAU * eased).sin() * eased,
        )),
    ]
}

#[test]
fn a_board_is_at_each_set_point_in_its_cycle() {
    let limits = [limits(60.0, 1.0, None); AXES];
    let mut maker = maker(&limits);
    let points: Vec<_> = (0..=80_u32)
        .map(|step| wave(f64::from(step) / 80.0))
        .collect();
    let mut segments = Vec::new();
    for (step, point) in (0..).zip(&points) {
        let made = maker.push(Time::from_cycles(1_000 + 20 * step), point);
        segments.extend(made.unwrap());
    }
    assert_eq!(segments.len(), 79);
    assert_eq!(maker.spacing(), Some(Time::from_cycles(20)));
    segments.extend(maker.finish().unwrap());
    let rows = played(&limits, &segments);
    for (step, point) in points.iter().enumerate().skip(1) {
        assert_eq!(&rows[20 * step], point, "set-point {step}");
    }
    let latest = maker.latest().unwrap();
    assert_eq!(latest.1, points[80]);
    let late = maker.push(Time::from_cycles(5_000), &points[80]);
    assert_eq!(late, Err(Refusal::Ended));
}

#[test]
fn an_end_in_motion_takes_longer_or_is_refused() {
    let of = |speed: i32| {
        let limits = [limits(60.0, 0.3, None); AXES];
        let mut maker = maker(&limits);
        let mut at = STAND;
        for step in 0..60 {
            // Faster by 0.005 counts a cycle from one to the next, up to a constant speed.
            let way = (step * 2).min(speed);
            at[0] = at[0].moved_by(Position::from_counts(way));
            maker
                .push(Time::from_cycles(20 * step as u32 + 20), &at)
                .unwrap();
        }
        (maker.finish(), maker.latest().unwrap().1.to_vec(), at)
    };
    let (last, latest, at) = of(40);
    let last = last.unwrap().unwrap();
    assert!(last.duration > 20 << 32 && last.duration <= 60 << 32);
    assert_eq!((last.axes[0].end, latest[0]), (at[0].units(), at[0]));
    assert!(matches!(
        last.axes[0].shape,
        Shape::Quintic { arriving: 0, .. }
    ));
    let (last, latest, at) = of(118);
    assert!(
        matches!(last, Err(Refusal::Acceleration { axis: 0, .. })),
        "{last:?}"
    );
    assert_eq!(latest[0], at[0]);
}

#[test]
fn what_is_no_next_set_point_is_refused_and_changes_nothing() {
    let limits = [limits(30.0, 1.0, Some(0.05)); AXES];
    let mut maker = maker(&limits);
    let at = Time::from_cycles;
    let counts = |counts| STAND.map(|stand| stand.moved_by(Position::from_counts(counts)));
    let refused = maker.push(at(1_000), &counts(2)).unwrap_err();
    assert!(matches!(refused, Refusal::Start { axis: 0, .. }));
    assert_eq!(maker.push(at(1_000), &STAND), Ok(None));
    for (time, positions, number) in [
        (at(1_000), counts(0), 4),
        (Time::from_ticks((1_000 << 32) + 1), counts(0), 5),
        (at(11_001), counts(0), 6),
        (at(2_000), counts(20_000), 7),
        (at(1_010), counts(400), 8),
    ] {
        let refused = maker.push(time, &positions).unwrap_err();
        assert_eq!(refused.number(), number, "{refused}");
    }
    assert_eq!(maker.push(at(1_020), &counts(1)), Ok(None));
    let refused = maker.push(at(1_040), &counts(500)).unwrap_err();
    assert_eq!(refused.number(), 9, "{refused}");
    let refused = maker.push(at(1_040), &counts(120)).unwrap_err();
    assert_eq!(refused.number(), 10, "{refused}");
    assert_eq!(maker.latest().map(|latest| latest.0), Some(at(1_020)));
    assert!(maker.push(at(1_040), &counts(2)).unwrap().is_some());
}

#[test]
fn the_memory_of_the_board_must_last() {
    let limits = [limits(30.0, 1.0, None); AXES];
    let mut maker = maker(&limits);
    for step in 0..56 {
        maker
            .push(Time::from_cycles(1_000 + 5 * step), &STAND)
            .unwrap();
    }
    let refused = maker.push(Time::from_cycles(1_280), &STAND).unwrap_err();
    let expected = Time::from_cycles(1_300);
    let actual = Time::from_cycles(1_280);
    assert_eq!(refused, Refusal::Close { expected, actual });
    assert!(maker.push(expected, &STAND).is_ok());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    /// Whatever set-points come: what is made of those that are taken a board takes, too, to its end at rest.
    #[test]
    fn a_board_takes_whatever_is_made(
        motion in (1.0_f32..60.0, 0.02_f32..3.0, proptest::option::of(0.001_f32..1.0)),
        steps in proptest::collection::vec(
            (1_u64 << 31..60_u64 << 32, [(); AXES].map(|()| -1.2_f64..1.2), 0..8_u8),
            2..50,
        ),
    ) {
        let limits = [limits(motion.0, motion.1, motion.2); AXES];
        let mut maker = maker(&limits);
        let (mut time, mut at, mut speed) = (Time::from_cycles(1), STAND, [0.0_f64; AXES]);
        let mut segments = Vec::new();
        prop_assert_eq!(maker.push(time, &at), Ok(None));
        for (ticks, pushes, kind) in steps {
            let next = time.after(Time::from_ticks(ticks));
            let cycles = ticks as f64 / (1_u64 << 32) as f64;
            let mut to = at;
            let mut faster = speed;
            for axis in 0..AXES {
                // Mostly what the acceleration allows.
                let most = f64::from(motion.1) * cycles * if kind == 0 { 4.0 } else { 0.3 };
                faster[axis] += pushes[axis] * most;
                let way = faster[axis] * cycles * Position::UNITS as f64;
                to[axis] = to[axis].moved_by(Position::from_units(way as i64));
            }
            if let Ok(made) = maker.push(next, &to) {
                segments.extend(made);
                (time, at, speed) = (next, to, faster);
            }
        }
        match maker.finish() {
            Ok(last) => {
                segments.extend(last);
                if !segments.is_empty() {
                    let rows = played(&limits, &segments);
                    prop_assert_eq!(rows.last(), Some(&at));
                }
            }
            Err(refusal) => prop_assert!((7..=10).contains(&refusal.number()), "{}", refusal),
        }
    }
}
