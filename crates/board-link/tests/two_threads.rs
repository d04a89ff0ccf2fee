//! The halves in two threads that run as fast as they can: as on a board, the cycle may come between any two instructions of the thread.

mod judge;

use std::sync::atomic::{AtomicBool, Ordering};

use board_link::segment::{
    AxisSegment, Begin, Player, Segment, SegmentConfig, SegmentQueue, Shape, StreamPhase,
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
