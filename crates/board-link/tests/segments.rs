//! Segments that are taken, refused and played, from outside.

use board_link::segment::{
    Admission, AxisSegment, Begin, Player, Segment, SegmentConfig, SegmentQueue, Shape, StreamPhase,
};
use board_link::{AxisLimits, Reason, WhenDry};
use trajectory::curve::{Piece, Share};
use trajectory::{Limits, Position, Time};

const AXES: usize = 2;
type Queue = SegmentQueue<AXES, 33>;

fn limits() -> AxisLimits {
    AxisLimits {
        motion: Limits::without_jerk(100.0, 1.5).unwrap(),
        lowest: Position::from_counts(-100_000),
        highest: Position::from_counts(100_000),
    }
}

fn config() -> SegmentConfig {
    SegmentConfig::with_cycles_per_second(1_000)
}

fn units(counts: f64) -> i64 {
    (counts * Position::UNITS as f64).round() as i64
}

fn begin(start: Option<u64>, when_dry: WhenDry) -> Begin {
    Begin {
        stream: 7,
        start,
        when_dry,
        percent: 100,
        from: [0, 0].into_iter().collect(),
    }
}

/// Both axes alike.
fn segment(cycles: u32, counts: f64, shape: Shape) -> Segment {
    let part = AxisSegment {
        end: units(counts),
        shape,
    };
    Segment {
        duration: Time::from_cycles(cycles).ticks(),
        axes: [part; AXES].into_iter().collect(),
    }
}

fn cubic(leaving: f64, arriving: f64) -> Shape {
    Shape::Cubic {
        leaving: units(leaving),
        arriving: units(arriving),
    }
}

const STAND: [Position; AXES] = [Position::ZERO; AXES];

/// Plays until the phase is another one than this; returns it, and the rows.
fn play(
    player: &mut Player<'_, AXES>,
    now: &mut u64,
    phase: StreamPhase,
) -> (StreamPhase, Vec<i32>) {
    let mut rows = Vec::new();
    let mut out = STAND;
    for _ in 0..100_000 {
        if player.advance(*now, &STAND, &mut out) {
            assert_eq!(out[0], out[1]);
            rows.push(out[0].counts());
        }
        *now += 1;
        if player.phase() != phase {
            break;
        }
    }
    (player.phase(), rows)
}

#[test]
fn a_trapezoid_and_a_minimum_jerk_move_at_their_limits_are_taken_and_no_more() {
    // 100 counts per cycle are reached with 1 count per cycle² in 100 cycles: 5000 counts.
    for (factor, expected) in [(1.0, None), (0.998, Some(Reason::Velocity))] {
        let mut queue = Queue::new();
        let (mut admission, _) = queue.split(&[limits(); AXES], config()).unwrap();
        admission
            .begin(&begin(None, WhenDry::End), &STAND, 0)
            .unwrap();
        let ticks = |cycles: f64| (cycles * factor * (1_u64 << 32) as f64) as u64;
        let parts = [
            (100.0, 5_000.0, cubic(0.0, 10_000.0)),
            (50.0, 10_000.0, Shape::Line),
            (100.0, 15_000.0, cubic(10_000.0, 0.0)),
        ];
        let mut refused = None;
        for (index, (cycles, end, shape)) in parts.into_iter().enumerate() {
            let mut segment = segment(1, end, shape);
            segment.duration = ticks(cycles);
            if let Err(error) = admission.push(7, index as u32, &segment) {
                refused = Some(error);
                break;
            }
        }
        assert_eq!(refused.and_then(|error| error.reason()), expected);
        assert!(admission.end(7).is_ok());
    }
    // 10000 counts within the velocity in 187.5 cycles, within the acceleration in 240.3.
    for (cycles, expected) in [
        (241, None),
        (240, Some(Reason::Acceleration)),
        (180, Some(Reason::Velocity)),
    ] {
        let mut queue = Queue::new();
        let (mut admission, _) = queue.split(&[limits(); AXES], config()).unwrap();
        admission
            .begin(&begin(None, WhenDry::End), &STAND, 0)
            .unwrap();
        let taken = admission.push(7, 0, &segment(cycles, 10_000.0, Shape::MinimumJerk));
        assert_eq!(taken.err().and_then(|error| error.reason()), expected);
    }
}

#[test]
fn what_is_played_is_the_pieces_cycle_by_cycle_from_the_start_time_on() {
    let mut queue = Queue::new();
    let (mut admission, mut player) = queue.split(&[limits(); AXES], config()).unwrap();
    admission
        .begin(&begin(Some(500), WhenDry::End), &STAND, 100)
        .unwrap();
    // Durations that are no whole cycles.
    let durations = [217_u64 << 31, 333 << 30, (1 << 40) + 77, 250 << 32];
    let ends = [1_500.25, 2_000.0, 4_999.5, 5_600.0];
    let velocities = [0.0, 10.0, 10.7, 3.0, 0.0];
    let mut from = Position::ZERO;
    let mut pieces = Vec::new();
    let mut start = 0;
    for (index, (&duration, &end)) in durations.iter().zip(&ends).enumerate() {
        let way = |velocity: f64| velocity * duration as f64 / (1_u64 << 32) as f64;
        let mut one = segment(
            1,
            end,
            cubic(way(velocities[index]), way(velocities[index + 1])),
        );
        one.duration = duration;
        admission.push(7, index as u32, &one).unwrap();
        let to = Position::from_units(units(end));
        let [leaving, arriving] = [velocities[index], velocities[index + 1]]
            .map(|velocity| Position::from_units(units(way(velocity))));
        pieces.push((start, duration, Piece::cubic(from, to, leaving, arriving)));
        from = to;
        start += duration;
    }
    admission.end(7).unwrap();
    let mut now = 101;
    assert_eq!(
        play(&mut player, &mut now, StreamPhase::Idle),
        (StreamPhase::Waiting, vec![])
    );
    let (phase, mut rows) = play(&mut player, &mut now, StreamPhase::Waiting);
    assert_eq!((phase, now), (StreamPhase::Moving, 501));
    let (phase, rest) = play(&mut player, &mut now, StreamPhase::Moving);
    rows.extend(rest);
    assert_eq!(phase, StreamPhase::Complete);
    for (cycle, &row) in rows.iter().enumerate() {
        let time = (cycle as u64) << 32;
        let piece = pieces.iter().rfind(|piece| piece.0 <= time).unwrap();
        let expected = piece.2.at(Share::of(time - piece.0, piece.1)).counts();
        assert_eq!(row, expected, "cycle {cycle}");
    }
    assert_eq!(*rows.last().unwrap(), 5_600);
    assert_eq!(rows.len() as u64, (start >> 32) + 2);
}

/// One segment is refused for one reason; the one that is right is taken afterwards.
#[test]
fn every_refusal_has_its_number_and_moves_nothing() {
    let mut queue = Queue::new();
    let (mut admission, mut player) = queue.split(&[limits(); AXES], config()).unwrap();
    let slow = |cycles| segment(cycles, 10.0, Shape::MinimumJerk);
    let reason = |result: Result<(), board_link::Refused>| result.unwrap_err().reason().unwrap();
    assert_eq!(reason(admission.push(0, 0, &slow(100))), Reason::Ended);
    let mut wrong = begin(None, WhenDry::End);
    wrong.from.pop();
    assert_eq!(reason(admission.begin(&wrong, &STAND, 9)), Reason::Axes);
    wrong.from.push(units(1.0)).unwrap();
    assert_eq!(reason(admission.begin(&wrong, &STAND, 9)), Reason::Start);
    wrong = begin(None, WhenDry::End);
    wrong.percent = 201;
    assert_eq!(reason(admission.begin(&wrong, &STAND, 9)), Reason::Override);
    assert_eq!(
        reason(admission.begin(&begin(Some(9), WhenDry::End), &STAND, 9)),
        Reason::Past
    );
    assert_eq!(
        reason(admission.begin(&begin(Some(60_010), WhenDry::End), &STAND, 9)),
        Reason::Ahead
    );
    assert_eq!(reason(admission.pause()), Reason::NoStream);
    admission
        .begin(&begin(None, WhenDry::End), &STAND, 9)
        .unwrap();
    assert_eq!(
        reason(admission.begin(&begin(None, WhenDry::End), &STAND, 9)),
        Reason::Moving
    );
    assert_eq!(reason(admission.push(8, 0, &slow(100))), Reason::Stream);
    assert_eq!(reason(admission.push(7, 1, &slow(100))), Reason::Order);
    let mut short = slow(1);
    short.duration = (1 << 31) - 1;
    assert_eq!(reason(admission.push(7, 0, &short)), Reason::Close);
    short.duration = u64::MAX;
    assert_eq!(reason(admission.push(7, 0, &short)), Reason::Ahead);
    short = slow(100);
    short.axes.pop();
    assert_eq!(reason(admission.push(7, 0, &short)), Reason::Axes);
    let far = |end, shape| segment(10_000, end, shape);
    assert_eq!(
        reason(admission.push(7, 0, &far(100_001.0, Shape::MinimumJerk))),
        Reason::Travel
    );
    // It ends where it may, and goes farther on its way.
    assert_eq!(
        reason(admission.push(7, 0, &far(0.0, cubic(0.0, -900_000.0)))),
        Reason::Travel
    );
    assert_eq!(
        reason(admission.push(7, 0, &segment(90, 9_500.0, Shape::Line))),
        Reason::Velocity
    );
    let huge = Shape::Cubic {
        leaving: i64::MAX,
        arriving: i64::MIN,
    };
    assert_eq!(
        reason(admission.push(7, 0, &segment(90, 95.0, huge))),
        Reason::Velocity
    );
    // From rest at once with 1.1 counts per cycle, where 1.0 are the acceleration of a cycle.
    assert_eq!(
        reason(admission.push(7, 0, &segment(100, 110.0, Shape::Line))),
        Reason::VelocityStep
    );
    admission
        .push(7, 0, &segment(100, 90.0, Shape::Line))
        .unwrap();
    // The velocity is 0.9; a step to 1.9 and an acceleration, too.
    assert_eq!(
        reason(admission.push(7, 1, &segment(100, 300.0, cubic(190.0, 200.0)))),
        Reason::VelocityStep
    );
    admission
        .push(7, 1, &segment(100, 280.0, Shape::Line))
        .unwrap();
    // 1.9 counts per cycle are no rest.
    assert_eq!(reason(admission.end(7)), Reason::NotAtRest);
    assert_eq!(reason(admission.set_override(201)), Reason::Override);
    admission
        .push(7, 2, &segment(100, 380.0, cubic(190.0, 0.0)))
        .unwrap();
    for index in 3..32 {
        admission
            .push(7, index, &segment(10, 380.0, Shape::Line))
            .unwrap();
    }
    assert_eq!(admission.credit(), 0);
    assert_eq!(reason(admission.push(7, 32, &slow(10))), Reason::Full);
    admission.end(7).unwrap();
    assert_eq!(reason(admission.push(7, 32, &slow(10))), Reason::Ended);
    let mut now = 10;
    play(&mut player, &mut now, StreamPhase::Idle);
    let (phase, rows) = play(&mut player, &mut now, StreamPhase::Moving);
    assert_eq!((phase, rows.last()), (StreamPhase::Complete, Some(&380)));
}

#[test]
fn jerk_is_limited_where_a_limit_is_and_steps_of_the_acceleration_too() {
    let jerky = AxisLimits {
        motion: Limits::new(100.0, 1.5, 0.02).unwrap(),
        ..limits()
    };
    let mut queue = Queue::new();
    let (mut admission, _) = queue.split(&[jerky; AXES], config()).unwrap();
    admission
        .begin(&begin(None, WhenDry::End), &STAND, 0)
        .unwrap();
    // 60 D / T³ of 10000 counts in 391 cycles is just above half of 0.02.
    let error = admission.push(7, 0, &segment(390, 10_000.0, Shape::MinimumJerk));
    assert_eq!(error.unwrap_err().reason(), Some(Reason::Jerk));
    // A constant acceleration from rest on is a step.
    let error = admission.push(7, 0, &segment(100, 2_500.0, cubic(0.0, 5_000.0)));
    assert_eq!(error.unwrap_err().reason(), Some(Reason::AccelerationStep));
    admission
        .push(7, 0, &segment(392, 10_000.0, Shape::MinimumJerk))
        .unwrap();
}

#[test]
fn when_the_segments_run_out_the_axes_come_to_rest_on_the_path() {
    for when_dry in [WhenDry::End, WhenDry::Wait] {
        let mut queue = Queue::new();
        let (mut admission, mut player) = queue.split(&[limits(); AXES], config()).unwrap();
        admission.begin(&begin(None, when_dry), &STAND, 0).unwrap();
        admission
            .push(7, 0, &segment(100, 2_500.0, cubic(0.0, 5_000.0)))
            .unwrap();
        admission
            .push(7, 1, &segment(1_000, 52_500.0, Shape::Line))
            .unwrap();
        let mut now = 1;
        play(&mut player, &mut now, StreamPhase::Idle);
        let (phase, rows) = play(&mut player, &mut now, StreamPhase::Moving);
        let last = *rows.last().unwrap();
        assert!(last > 45_000 && last <= 52_500, "{last}");
        let late = admission.push(7, 2, &segment(100, 55_000.0, cubic(5_000.0, 0.0)));
        if when_dry == WhenDry::End {
            assert_eq!(phase, StreamPhase::DriedUp);
            assert_eq!(late.unwrap_err().reason(), Some(Reason::Late));
            continue;
        }
        assert_eq!(phase, StreamPhase::Dry);
        late.unwrap();
        admission.end(7).unwrap();
        assert_eq!(
            play(&mut player, &mut now, StreamPhase::Dry).0,
            StreamPhase::Moving
        );
        let (phase, rows) = play(&mut player, &mut now, StreamPhase::Moving);
        assert_eq!((phase, rows.last()), (StreamPhase::Complete, Some(&55_000)));
    }
}

/// At 200 %, a segment that allows it ends at rest, and one that allows 100 % follows in the last moment.
#[test]
fn what_follows_an_end_at_rest_may_allow_less() {
    for late_by in [0, 1, 2, 5, 20, 80, 200, 300] {
        let mut queue = Queue::new();
        let (mut admission, mut player) = queue.split(&[limits(); AXES], config()).unwrap();
        let mut fast = begin(None, WhenDry::Wait);
        fast.percent = 200;
        admission.begin(&fast, &STAND, 0).unwrap();
        admission
            .push(7, 0, &segment(2_000, 10_000.0, Shape::MinimumJerk))
            .unwrap();
        let (mut positions, mut is_sent) = (vec![0.0; 3], false);
        let mut out = STAND;
        for now in 1..4_000 {
            player.advance(now, &STAND, &mut out);
            positions.push(out[0].units() as f64 / Position::UNITS as f64);
            let left = 2_000_u32.saturating_sub(admission.player().time_cycles);
            if left <= 2 + late_by && !is_sent {
                is_sent = true;
                let least = segment(241, 20_000.0, Shape::MinimumJerk);
                admission.push(7, 1, &least).unwrap();
                admission.end(7).unwrap();
            }
        }
        assert_eq!(player.phase(), StreamPhase::Complete, "{late_by}");
        let most = acceleration(&positions);
        assert!(most <= 1.5, "{late_by}: {most}");
    }
}

/// The largest second difference.
fn acceleration(positions: &[f64]) -> f64 {
    let at = positions.windows(3);
    at.map(|at| (at[2] - 2.0 * at[1] + at[0]).abs())
        .fold(0.0, f64::max)
}

#[test]
fn a_pause_in_any_cycle_of_a_motion_at_its_limits_keeps_the_acceleration() {
    for pause_at in 1..250 {
        let mut queue = Queue::new();
        let (mut admission, mut player) = queue.split(&[limits(); AXES], config()).unwrap();
        admission
            .begin(&begin(None, WhenDry::End), &STAND, 0)
            .unwrap();
        let parts = [
            (100, 5_000.0, cubic(0.0, 10_000.0)),
            (50, 10_000.0, Shape::Line),
            (100, 15_000.0, cubic(10_000.0, 0.0)),
        ];
        for (index, (cycles, end, shape)) in parts.into_iter().enumerate() {
            let one = segment(cycles, end, shape);
            admission.push(7, index as u32, &one).unwrap();
        }
        admission.end(7).unwrap();
        let (mut positions, mut out) = (vec![0.0; 3], STAND);
        for now in 1..3_000 {
            match now {
                _ if now == pause_at => admission.pause().unwrap(),
                // It may have ended within the ramp.
                1_500 => drop(admission.resume()),
                _ => {}
            }
            player.advance(now, &STAND, &mut out);
            positions.push(out[0].units() as f64 / Position::UNITS as f64);
        }
        assert_eq!(player.phase(), StreamPhase::Complete, "{pause_at}");
        assert_eq!(out[0], Position::from_counts(15_000));
        let most = acceleration(&positions);
        assert!(most <= 1.5, "{pause_at}: {most}");
    }
}

#[test]
fn axes_that_stand_elsewhere_at_the_start_do_not_move() {
    let mut queue = Queue::new();
    let (mut admission, mut player) = queue.split(&[limits(); AXES], config()).unwrap();
    admission
        .begin(&begin(Some(10), WhenDry::End), &STAND, 0)
        .unwrap();
    admission
        .push(7, 0, &segment(500, 2_500.0, Shape::MinimumJerk))
        .unwrap();
    admission.end(7).unwrap();
    let moved = [Position::ZERO, Position::from_counts(2)];
    let mut out = [Position::from_counts(-99); AXES];
    for now in 1..20 {
        assert!(!player.advance(now, &moved, &mut out));
    }
    assert_eq!(player.phase(), StreamPhase::Displaced);
    assert_eq!(out, [Position::from_counts(-99); AXES]);
    // The next stream begins anew: nothing of the old one is left.
    admission
        .begin(&begin(None, WhenDry::End), &STAND, 20)
        .unwrap();
    admission
        .push(7, 0, &segment(400, 100.0, Shape::MinimumJerk))
        .unwrap();
    admission.end(7).unwrap();
    let mut now = 21;
    play(&mut player, &mut now, StreamPhase::Displaced);
    let (phase, rows) = play(&mut player, &mut now, StreamPhase::Moving);
    assert_eq!(
        (phase, rows.len(), rows.last()),
        (StreamPhase::Complete, 400, Some(&100))
    );
}

#[test]
fn a_stop_ends_on_the_way_and_a_halt_at_once() {
    for halts in [false, true] {
        let mut queue = Queue::new();
        let (mut admission, mut player) = queue.split(&[limits(); AXES], config()).unwrap();
        admission
            .begin(&begin(None, WhenDry::End), &STAND, 0)
            .unwrap();
        admission
            .push(7, 0, &segment(900, 30_000.0, Shape::MinimumJerk))
            .unwrap();
        admission.end(7).unwrap();
        let mut out = STAND;
        for now in 1..400 {
            player.advance(now, &STAND, &mut out);
        }
        let before = out[0].counts();
        if halts {
            player.halt();
            assert!(!player.advance(400, &STAND, &mut out));
            assert_eq!(out[0].counts(), before);
        } else {
            admission.stop().unwrap();
            let mut now = 400;
            let (_, rows) = play(&mut player, &mut now, StreamPhase::Moving);
            assert!(
                rows.len() > 100 && *rows.last().unwrap() < 30_000,
                "{rows:?}"
            );
        }
        assert_eq!(player.phase(), StreamPhase::Stopped);
        let late = admission.push(7, 1, &segment(900, 30_000.0, Shape::Line));
        assert_eq!(late.unwrap_err().reason(), Some(Reason::Ended));
    }
}

#[test]
fn a_queue_needs_axes_that_fit() {
    let mut queue = Queue::new();
    assert!(queue.split(&[], config()).is_none());
    assert!(queue.split(&[limits(); 3], config()).is_none());
    let mut large = SegmentQueue::<15, 2>::new();
    assert!(large.split(&[limits(); 15], config()).is_none());
}

/// Any values: nothing panics.
#[test]
fn random_segments_panic_nowhere() {
    let mut random = fastrand::Rng::with_seed(7);
    let mut queue = Queue::new();
    let (mut admission, mut player) = queue.split(&[limits(); AXES], config()).unwrap();
    let mut out = STAND;
    for now in 0..20_000 {
        let shift = random.u32(0..64);
        let mut value = || random.i64(..) >> shift;
        let shape = match value() & 3 {
            0 => Shape::Line,
            1 => Shape::MinimumJerk,
            2 => Shape::Cubic {
                leaving: value(),
                arriving: value(),
            },
            _ => Shape::Quintic {
                leaving: value(),
                leaving_acceleration: value(),
                arriving: value(),
                arriving_acceleration: value(),
            },
        };
        let axes = [
            AxisSegment {
                end: value(),
                shape,
            },
            AxisSegment {
                end: value(),
                shape: Shape::Line,
            },
        ];
        let segment = Segment {
            duration: value() as u64,
            axes: axes.into_iter().collect(),
        };
        let _ = admission.begin(&begin(None, WhenDry::Wait), &STAND, now);
        let _ = admission.push(7, admission.next_index(), &segment);
        player.advance(now, &STAND, &mut out);
        if random.u8(..) < 3 {
            let _ = admission.stop();
        }
    }
    assert!(admission_is_sane(&admission));
}

fn admission_is_sane(admission: &Admission<'_, AXES>) -> bool {
    admission.credit() as usize <= admission.capacity()
}
