use std::string::ToString;
use std::vec::Vec;

use proptest::prelude::*;

use super::*;

const fn keyframe(at_ms: u32, counts: i32) -> Keyframe<1> {
    Keyframe {
        at_ms,
        positions_counts: [counts],
    }
}

const THERE_AND_BACK: [Keyframe<2>; 4] = [
    Keyframe {
        at_ms: 0,
        positions_counts: [0, 0],
    },
    Keyframe {
        at_ms: 1_000,
        positions_counts: [16_000, -8_000],
    },
    Keyframe {
        at_ms: 1_500,
        positions_counts: [16_000, -8_000],
    },
    Keyframe {
        at_ms: 3_500,
        positions_counts: [0, 0],
    },
];

fn counts(counts: i32) -> Position {
    Position::from_counts(counts)
}

#[test]
fn keyframes_are_met_exactly_and_the_last_one_stays() {
    let motion = KeyframeMotion::new(&THERE_AND_BACK).unwrap();
    assert_eq!(motion.position(0), [0, 0]);
    assert_eq!(motion.position(1_000_000), [16_000, -8_000]);
    assert_eq!(motion.position(1_250_000), [16_000, -8_000]);
    assert_eq!(motion.position(3_500_000), [0, 0]);
    assert_eq!(motion.position(u64::MAX), [0, 0]);
    assert_eq!(motion.duration_us(), 3_500_000);
}

#[test]
fn the_way_is_the_minimum_jerk_profile() {
    let motion = KeyframeMotion::new(&THERE_AND_BACK).unwrap();
    // 10 u^3 - 15 u^4 + 6 u^5 by hand: 0.1035156 at 1/4, 1/2 at 1/2, 0.8964844 at 3/4.
    assert_eq!(motion.position(250_000), [1_656, -828]);
    assert_eq!(motion.position(500_000), [8_000, -4_000]);
    assert_eq!(motion.position(750_000), [14_344, -7_172]);
    assert_eq!(motion.position(2_500_000), [8_000, -4_000]);
}

#[test]
fn the_peak_step_is_15_eighths_of_the_mean() {
    const MOTION: KeyframeMotion<'static, 2> = match KeyframeMotion::new(&THERE_AND_BACK) {
        Ok(motion) => motion,
        Err(_) => panic!("the keyframes make no motion"),
    };
    const PEAKS: [u64; 2] = MOTION.peak_step_counts(1_000);
    // 16 and 8 counts a cycle on average.
    assert_eq!(PEAKS, [31, 16]);
    let at_the_middle: Vec<_> = (495..505)
        .map(|ms| MOTION.position(ms * 1_000 + 1_000)[0] - MOTION.position(ms * 1_000)[0])
        .collect();
    assert!(
        at_the_middle.iter().all(|&step| step == 30),
        "{at_the_middle:?}"
    );
}

#[test]
fn what_makes_no_motion_is_refused() {
    let of = |keyframes: &[Keyframe<1>]| KeyframeMotion::new(keyframes).map(|_| ());
    assert_eq!(of(&[]), Err(KeyframeError::Empty));
    assert_eq!(
        of(&[keyframe(5, 0)]),
        Err(KeyframeError::StartTime { actual_ms: 5 })
    );
    assert_eq!(
        of(&[keyframe(0, 7)]),
        Err(KeyframeError::StartPosition {
            axis: 0,
            actual_counts: 7
        })
    );
    assert_eq!(
        of(&[keyframe(0, 0), keyframe(10, 1), keyframe(10, 2)]),
        Err(KeyframeError::Order {
            keyframe: 2,
            after_ms: 10,
            actual_ms: 10
        })
    );
    assert_eq!(of(&[keyframe(0, 0)]), Ok(()));
}

#[test]
fn errors_name_the_place() {
    let error = KeyframeError::Order {
        keyframe: 2,
        after_ms: 10,
        actual_ms: 9,
    };
    assert_eq!(
        error.to_string(),
        "keyframe 2 must be later than 10 ms, it is at 9 ms"
    );
    let error = KeyframeError::StartPosition {
        axis: 3,
        actual_counts: 4,
    };
    assert!(error.to_string().contains("axis 3"));
}

#[test]
fn shares_are_parts_of_a_whole() {
    assert_eq!(Share::of(0, 7), Share(0));
    assert_eq!(Share::of(1, 4), Share(1 << 62));
    for (elapsed, duration) in [(7, 7), (8, 7), (0, 0), (1, 0), (u64::MAX, u64::MAX)] {
        assert_eq!(Share::of(elapsed, duration), WHOLE);
    }
    let third = Share::of(u64::MAX / 3, u64::MAX).0 as f64 / 2_f64.powi(64);
    assert!((third - 1.0 / 3.0).abs() < 1e-9);
}

#[test]
fn velocities_between_chords_are_harmonic_means() {
    let chord = |duration, velocity| Chord { duration, velocity };
    assert_eq!(chord(1.0, 2.0).velocity_before(chord(1.0, 2.0)), 2.0);
    assert_eq!(chord(1.0, 2.0).velocity_before(chord(1.0, -2.0)), 0.0);
    assert_eq!(chord(1.0, 2.0).velocity_before(chord(1.0, 0.0)), 0.0);
    // Weights 2 * 2 + 1 and 2 + 2 * 1: 9 / (5 / 3 + 4 / 1).
    let velocity = chord(1.0, 3.0).velocity_before(chord(2.0, 1.0));
    assert!((velocity - 27.0 / 17.0).abs() < 1e-6);
}

/// Passed at 8000 counts per second, and at rest at both ends.
const PASSED: [Keyframe<2>; 3] = [
    THERE_AND_BACK[0],
    THERE_AND_BACK[1],
    Keyframe {
        at_ms: 2_000,
        positions_counts: [20_000, 0],
    },
];
const VELOCITIES: [[i32; 2]; 3] = [[0, 0], [8_000, -1_000], [0, 0]];

#[test]
fn keyframes_are_passed_with_their_velocities() {
    let motion = KeyframeMotion::passing(&PASSED, &VELOCITIES).unwrap();
    assert_eq!(motion.position(0), [0, 0]);
    assert_eq!(motion.position(1_000_000), [16_000, -8_000]);
    assert_eq!(motion.position(2_000_000), [20_000, 0]);
    assert_eq!(motion.position(u64::MAX), [20_000, 0]);
    // Cubics of Hermite by hand: in the middle half of the way, less an eighth of the velocities' difference.
    assert_eq!(motion.position(500_000), [7_000, -3_875]);
    assert_eq!(motion.position(1_500_000), [19_000, -4_125]);
    // 8 counts a millisecond on both sides of the place.
    let [before, after] = [999_000, 1_001_000].map(|us| motion.position(us));
    assert_eq!(before, [15_992, -7_999]);
    assert_eq!(after, [16_008, -8_001]);
}

#[test]
fn the_peak_of_a_passage_bounds_its_steps() {
    const PEAKS: [u64; 2] = match KeyframeMotion::passing(&PASSED, &VELOCITIES) {
        Ok(motion) => motion.peak_step_counts(1_000),
        Err(_) => panic!("the keyframes make no motion"),
    };
    // 3 * 16000 - 8000 counts per second in the middle of the first one; 3 * 8000 + 1000 of the second axis.
    assert_eq!(PEAKS, [41, 26]);
    let motion = KeyframeMotion::passing(&PASSED, &VELOCITIES).unwrap();
    let mut before = [0, 0];
    for ms in 1..=2_000 {
        let at = motion.position(ms * 1_000);
        for axis in 0..2 {
            assert!(u64::from(at[axis].abs_diff(before[axis])) <= PEAKS[axis]);
        }
        before = at;
    }
}

#[test]
fn velocities_that_make_no_motion_are_refused() {
    let refused = |velocities: &[[i32; 2]]| {
        let motion = KeyframeMotion::passing(&PASSED, velocities);
        motion.unwrap_err().to_string()
    };
    assert_eq!(
        refused(&VELOCITIES[..2]),
        "expected a row of velocities for each of the 3 keyframes, got 2"
    );
    assert_eq!(
        refused(&[[0, 5], [0, 0], [0, 0]]),
        "a motion starts and ends at rest: axis 1 must have velocity 0 in keyframe 0, it has 5 counts per second"
    );
    assert_eq!(
        refused(&[[0, 0], [0, 0], [-1, 0]]),
        "a motion starts and ends at rest: axis 0 must have velocity 0 in keyframe 2, it has -1 counts per second"
    );
    let far = [
        PASSED[0],
        Keyframe {
            at_ms: 1_000,
            ..PASSED[1]
        },
        Keyframe {
            at_ms: 5_001,
            ..PASSED[2]
        },
    ];
    let fast = [[0, 0], [0, 1 << 29], [0, 0]];
    let error = KeyframeMotion::passing(&far, &fast).unwrap_err();
    assert_eq!(
        error.to_string(),
        "behind keyframe 1 axis 1 would go more than 2147483647 counts with its 536870912 counts per second: put keyframes between"
    );
    assert_eq!(
        KeyframeMotion::<2>::passing(&[], &[]),
        Err(KeyframeError::Empty)
    );
}

proptest! {
    /// Everywhere, and just before the end, where both may be the same but for bits that are left out.
    #[test]
    fn a_share_is_that_of_exact_arithmetic(
        duration in (any::<u64>(), 0..64_u32).prop_map(|(ticks, places)| (ticks >> places).max(1)),
        place in any::<u64>(),
        left in (any::<u64>(), 0..64_u32).prop_map(|(ticks, places)| ticks >> places),
    ) {
        for elapsed in [place % duration, duration - 1 - left % duration] {
            let exact = (u128::from(elapsed) << 64) / u128::from(duration);
            let share = Share::of(elapsed, duration);
            prop_assert!(share < WHOLE);
            let steps = exact.abs_diff(u128::from(share.0)) >> 32;
            prop_assert!(steps < 3, "{elapsed} of {duration}: {share:?}, not {exact}");
        }
        prop_assert_eq!(Share::of(duration, duration), WHOLE);
    }

    #[test]
    fn pieces_begin_and_end_exactly(
        from in any::<i32>(), to in any::<i32>(), leaving in -(1 << 30)..1 << 30_i32, arriving in -(1 << 30)..1 << 30_i32,
    ) {
        let (from, to) = (counts(from), counts(to));
        for piece in [
            Piece::line(from, to),
            Piece::minimum_jerk(from, to),
            Piece::cubic(from, to, counts(leaving), counts(arriving)),
        ] {
            prop_assert_eq!(piece.at(Share::of(0, 9)), from);
            prop_assert_eq!(piece.at(Share::of(9, 9)), to);
        }
    }

    #[test]
    fn pieces_are_those_of_exact_arithmetic(
        from in -1e6..1e6_f64, to in -1e6..1e6_f64, leaving in -1e6..1e6_f64, arriving in -1e6..1e6_f64, elapsed in 0..1_000_u64,
    ) {
        let position = |counts: f64| Position::from_units((counts * 16_777_216.0) as i64);
        let share = Share::of(elapsed, 1_000);
        let u = elapsed as f64 / 1_000.0;
        let (way, v, w) = (to - from, leaving, arriving);
        let cubic = from + v * u + (3.0 * way - 2.0 * v - w) * u * u + (v + w - 2.0 * way) * u.powi(3);
        let quintic = from + way * (10.0 * u.powi(3) - 15.0 * u.powi(4) + 6.0 * u.powi(5));
        for (piece, expected) in [
            (Piece::line(position(from), position(to)), from + way * u),
            (Piece::cubic(position(from), position(to), position(leaving), position(arriving)), cubic),
            (Piece::minimum_jerk(position(from), position(to)), quintic),
        ] {
            let actual = piece.at(share).units() as f64 / 16_777_216.0;
            // Positions are cut off at 2^-24 counts, times at 2^-32 of the duration.
            prop_assert!((actual - expected).abs() < 0.002, "{} {}", actual, expected);
        }
    }

    #[test]
    fn a_share_of_counts_is_the_nearest(share in any::<u64>(), way in any::<i32>()) {
        let counts = i128::from(Share(share).of_counts(way)) << 64;
        let exact = i128::from(share) * i128::from(way);
        // Half a count, and 2^-30 of one.
        prop_assert!((counts - exact).abs() <= (1 << 63) + (1 << 34), "{counts} {exact}");
    }

    #[test]
    fn a_share_of_few_counts_is_as_near(share in any::<u64>(), way in -(1_i32 << 20) + 1..1 << 20) {
        let counts = i128::from(Share(share).of_few_counts(way)) << 64;
        let exact = i128::from(share) * i128::from(way);
        prop_assert!((counts - exact).abs() <= (1 << 63) + (1 << 53), "{counts} {exact}");
    }

    /// Played from one head through all pieces and back to the start, or looked up: the same position.
    #[test]
    fn the_head_follows_the_motion(times in proptest::collection::vec(0..3_000_000_u64, 1..20)) {
        let motion = KeyframeMotion::new(&THERE_AND_BACK).unwrap();
        let mut head = Playhead::START;
        for time_us in times {
            prop_assert_eq!(motion.position_from(&mut head, time_us), motion.position(time_us));
        }
    }

    #[test]
    fn set_points_of_a_move_go_one_way(way in -3_000_000..3_000_000_i32, duration_ms in 1..5_000_u32) {
        let frames = [keyframe(0, 0), keyframe(duration_ms, way)];
        let motion = KeyframeMotion::new(&frames).unwrap();
        let [peak] = motion.peak_step_counts(1_000);
        let mut before = 0;
        for ms in 1..=duration_ms {
            let [now] = motion.position(u64::from(ms) * 1_000);
            let step = i64::from(now - before) * i64::from(way.signum());
            prop_assert!(step >= 0 && step as u64 <= peak, "{} at {} ms", step, ms);
            before = now;
        }
        prop_assert_eq!(before, way);
    }

    /// Against the cubic in double precision.
    #[test]
    fn a_passage_is_its_cubic(
        ms in 1..60_000_u32, end in -1_000_000..1_000_000_i32, velocities in [-500_000..500_000_i32, -500_000..500_000],
        share in 0.0..1.0_f64,
    ) {
        let [leaving, arriving] = velocities;
        let at = |at_ms, counts| keyframe(at_ms, counts);
        let keyframes = [at(0, 0), at(1_000, 77), at(1_000 + ms, 77 + end), at(2_000 + ms, 0)];
        let rows = [[0], [leaving], [arriving], [0]];
        let motion = KeyframeMotion::passing(&keyframes, &rows).unwrap();
        let us = (share * f64::from(ms) * 1e3) as u64;
        let u = us as f64 / 1e3 / f64::from(ms);
        let [l, r] = [leaving, arriving].map(|velocity| f64::from(velocity) * f64::from(ms) * 1e-3);
        let way = f64::from(end);
        let exact = 77.0 + l * u + (3.0 * way - 2.0 * l - r) * u * u + (l + r - 2.0 * way) * u * u * u;
        let [actual] = motion.position(1_000_000 + us);
        prop_assert!((f64::from(actual) - exact).abs() <= 0.51, "{} {}", actual, exact);
    }
}

/// What a share leaves out for each microsecond must not become counts.
#[test]
fn a_keyframe_after_a_week_is_come_to_without_a_step() {
    // A week at 3306 counts a second.
    let keyframes = [
        keyframe(0, 0),
        keyframe(604_800_000, 1_999_468_800),
        keyframe(604_801_000, 1_999_470_453),
    ];
    let motion = KeyframeMotion::passing(&keyframes, &[[0], [3_306], [0]]).unwrap();
    let end = 604_800_000_000;
    let step = motion.position(end)[0] - motion.position(end - 1_000)[0];
    assert!(
        u64::from(step.unsigned_abs()) <= motion.peak_step_counts(1_000)[0],
        "{step}"
    );
}
