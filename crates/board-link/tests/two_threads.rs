//! The halves in two threads that run as fast as they can: as on a board, the cycle may come between any two instructions of the thread.

mod judge;

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use board_link::segment::{
    Admission, AxisSegment, Begin, Player, Segment, SegmentConfig, SegmentQueue, Shape, StreamPhase,
};
use board_link::{AxisLimits, WhenDry};
use judge::Judge;
use trajectory::{Limits, Position, Time};

const AXES: usize = 2;
const STREAMS: u32 = 60;
const SEGMENTS: u32 = 40;

fn limits() -> AxisLimits {
    AxisLimits {
        motion: Limits::without_jerk(100.0, 1.5).unwrap(),
        lowest: Position::from_counts(-1_000_000),
        highest: Position::from_counts(1_000_000),
    }
}

fn units(counts: f64) -> i64 {
    (counts * Position::UNITS as f64).round() as i64
}

/// Segments that all end in motion but the last one.
fn segment(place: u32, from: f64) -> (Segment, f64) {
    let velocity = |place: u32| {
        if place == 0 || place == SEGMENTS {
            0.0
        } else {
            15.0
        }
    };
    let (leaving, arriving) = (velocity(place), velocity(place + 1));
    let end = from + (leaving + arriving) / 2.0 * 20.0;
    let shape = Shape::Cubic {
        leaving: units(leaving * 20.0),
        arriving: units(arriving * 20.0),
    };
    let part = AxisSegment {
        end: units(end),
        shape,
    };
    let segment = Segment {
        duration: Time::from_cycles(20).ticks(),
        axes: [part; AXES].into_iter().collect(),
    };
    (segment, end)
}

/// Plays until nobody sends any more; returns where the axes are.
fn play(mut player: Player<'_, AXES>, is_over: &AtomicBool) -> Position {
    let mut at = [Position::ZERO; AXES];
    let mut judge = Judge::default();
    let mut now = 0;
    while !is_over.load(Ordering::Acquire) {
        now += 1;
        let stand = at;
        if player.advance(now, &stand, &mut at) {
            judge.see(at[0]);
            assert!(judge.velocity <= 100.0, "cycle {now}: {judge:?}");
            assert!(judge.acceleration <= 1.500_1, "cycle {now}: {judge:?}");
        }
    }
    at[0]
}

#[test]
fn a_cycle_between_any_two_instructions_keeps_the_limits() {
    let mut queue = SegmentQueue::<AXES, 9>::new();
    let config = SegmentConfig {
        lead: Time::from_cycles(100),
        ..SegmentConfig::with_cycles_per_second(1_000)
    };
    let (mut admission, player) = queue.split(&[limits(); AXES], config).unwrap();
    let is_over = AtomicBool::new(false);
    let mut from = 0.0;
    let last = std::thread::scope(|scope| {
        let cycle = scope.spawn(|| play(player, &is_over));
        for stream in 1..=STREAMS {
            let at = Position::from_units(units(from));
            let begin = Begin {
                stream,
                start: None,
                when_dry: WhenDry::Wait,
                percent: 100,
                from: [at.units(); AXES].into_iter().collect(),
            };
            admission.begin(&begin, &[at; AXES], 0).unwrap();
            for place in 0..SEGMENTS {
                let (segment, end) = segment(place, from);
                while admission.credit() == 0 {
                    assert!(!cycle.is_finished());
                    std::thread::yield_now();
                }
                admission.push(stream, place, &segment).unwrap();
                from = end;
            }
            admission.end(stream).unwrap();
            while admission.player().phase.is_active() {
                assert!(!cycle.is_finished());
                std::thread::yield_now();
            }
            assert_eq!(admission.player().phase, StreamPhase::Complete);
            assert_eq!(admission.player().finished, SEGMENTS);
        }
        is_over.store(true, Ordering::Release);
        cycle.join().unwrap()
    });
    assert_eq!(last.units(), units(from));
}

/// A stop is obeyed wherever in a cycle it comes, also in one that is worked out anew.
#[test]
fn a_stop_between_any_two_instructions_is_obeyed() {
    const STREAMS: u32 = 500;
    let mut queue = SegmentQueue::<1, 4>::new();
    let config = SegmentConfig {
        longest: Time::from_cycles(1 << 24),
        ..SegmentConfig::with_cycles_per_second(1_000)
    };
    let (mut admission, player) = queue.split(&[limits()], config).unwrap();
    let stopped = AtomicU32::new(0);
    std::thread::scope(|scope| {
        let cycle = scope.spawn(|| obey(player, &stopped, STREAMS));
        let mut random = fastrand::Rng::with_seed(9);
        for stream in 1..=STREAMS {
            let wait_for = |admission: &Admission<'_, 1>, is_there: fn(StreamPhase) -> bool| {
                while !is_there(admission.player().phase) {
                    assert!(!cycle.is_finished());
                }
            };
            wait_for(&admission, |phase| !phase.is_active());
            let begin = Begin {
                stream,
                start: None,
                when_dry: WhenDry::End,
                percent: 100,
                from: [0].into_iter().collect(),
            };
            admission.begin(&begin, &[Position::ZERO], 0).unwrap();
            let part = AxisSegment {
                end: units(900_000.0),
                shape: Shape::MinimumJerk,
            };
            let segment = Segment {
                duration: Time::from_cycles(1_000_000).ticks(),
                axes: [part].into_iter().collect(),
            };
            admission.push(stream, 0, &segment).unwrap();
            wait_for(&admission, |phase| phase == StreamPhase::Moving);
            let mut spin = |most| (0..random.u32(0..most)).for_each(|_| std::hint::spin_loop());
            spin(300);
            // A cycle that is worked out anew, and a stop in the middle of it.
            admission.set_override(100).unwrap();
            spin(60);
            admission.stop().unwrap();
            stopped.store(stream, Ordering::Release);
        }
        cycle.join().unwrap();
    });
}

/// Plays until every stream was stopped.
fn obey(mut player: Player<'_, 1>, stopped: &AtomicU32, streams: u32) {
    let mut now = 0;
    for stream in 1..=streams {
        let mut cycles_after = 0;
        while player.phase().is_active() || stopped.load(Ordering::Acquire) < stream {
            now += 1;
            let is_stopped = stopped.load(Ordering::Acquire) >= stream;
            player.advance_counts(now, &[Position::ZERO], &mut [0]);
            cycles_after += u32::from(is_stopped && player.phase().is_active());
            // A ramp from a standstill takes far less.
            assert!(cycles_after < 1_000, "stream {stream}");
        }
    }
}
