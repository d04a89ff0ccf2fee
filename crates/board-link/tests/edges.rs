//! Set-points where a player goes over from one thing to the next: ends of segments between two ticks, streams behind each other, limits that
//! come later.

use board_link::segment::{
    Admission, AxisSegment, Begin, Player, Segment, SegmentConfig, SegmentQueue, Shape, StreamPhase,
};
use board_link::{AxisLimits, WhenDry};
use trajectory::{Limits, Position, Time};

type Queue = SegmentQueue<1, 9>;

fn split(queue: &mut Queue, velocity: f32) -> (Admission<'_, 1>, Player<'_, 1>) {
    let limits = AxisLimits {
        motion: Limits::without_jerk(velocity, velocity).unwrap(),
        lowest: Position::from_counts(-(1 << 29)),
        highest: Position::from_counts(1 << 29),
    };
    let config = SegmentConfig {
        lead: Time::from_cycles(5),
        ..SegmentConfig::with_cycles_per_second(1_000)
    };
    queue.split(&[limits], config).unwrap()
}

fn begin(stream: u32, percent: u16, at: i32) -> Begin {
    Begin {
        stream,
        start: None,
        when_dry: WhenDry::End,
        percent,
        from: [units(at)].into_iter().collect(),
    }
}

fn units(counts: i32) -> i64 {
    Position::from_counts(counts).units()
}

fn segment(ticks: u64, end: i32, shape: Shape) -> Segment {
    let axis = AxisSegment {
        end: units(end),
        shape,
    };
    Segment {
        duration: ticks,
        axes: [axis].into_iter().collect(),
    }
}

/// One cycle in counts, one way or the other.
fn advance(player: &mut Player<'_, 1>, in_counts: bool, now: u64, at: i32) -> Option<i32> {
    let stand = [Position::from_counts(at)];
    if in_counts {
        let mut out = [0];
        return player
            .advance_counts(now, &stand, &mut out)
            .then_some(out[0]);
    }
    let mut out = [Position::ZERO];
    player
        .advance(now, &stand, &mut out)
        .then_some(out[0].counts())
}

/// Three segments in 200 cycles: each ends between two ticks, so that a cycle falls just before the end of the last one.
#[test]
fn just_before_its_end_a_segment_is_nearly_at_its_end() {
    for (way, in_counts) in [
        (1_000, false),
        (1_000, true),
        (300_000, false),
        (300_000, true),
    ] {
        let mut queue = Queue::new();
        let (mut admission, mut player) = split(&mut queue, 20_000.0);
        admission
            .begin(&begin(1, 100, 0), &[Position::ZERO], 0)
            .unwrap();
        for index in 0..3 {
            let end = (index as i32 + 1) * way;
            let segment = segment(((200_u64 << 32) + 1) / 3, end, Shape::MinimumJerk);
            admission.push(1, index, &segment).unwrap();
        }
        admission.end(1).unwrap();
        let mut at = 0;
        for now in 1..300 {
            let Some(set_point) = advance(&mut player, in_counts, now, at) else {
                continue;
            };
            // The peak is 15 eighths of the mean.
            let step = set_point - at;
            assert!(
                (0..=way * 15 / 8 * 3 / 200 + 1).contains(&step),
                "{now}: {step}"
            );
            at = set_point;
        }
        assert_eq!((player.phase(), at), (StreamPhase::Complete, 3 * way));
    }
}

/// Streams are told apart by 16 bits.
#[test]
fn curves_of_65536_streams_before_are_not_played() {
    let mut queue = Queue::new();
    let (mut admission, mut player) = split(&mut queue, 100.0);
    let line = |end| segment(100 << 32, end, Shape::Line);
    admission
        .begin(&begin(1, 100, 0), &[Position::ZERO], 0)
        .unwrap();
    admission.push(1, 0, &line(5_000)).unwrap();
    let mut at = 0;
    for now in 1..10 {
        at = advance(&mut player, true, now, at).unwrap_or(at);
    }
    player.halt();
    assert_eq!(at, 400);
    let stand = [Position::from_counts(at)];
    for stream in 2..=65_537 {
        admission.begin(&begin(stream, 100, at), &stand, 0).unwrap();
        if stream <= 65_536 {
            player.halt();
        }
    }
    admission.push(65_537, 0, &line(at - 1_000)).unwrap();
    for now in 1..4 {
        let expected = at - 10 * (now as i32 - 1);
        assert_eq!(advance(&mut player, true, now, at), Some(expected));
    }
}

/// At twice the speed a segment comes that allows no more than its own.
#[test]
fn a_segment_that_allows_less_slows_down_both_ways_in_the_same_cycle() {
    let cubic = |cycles: u64, end: i32, from: i32, to: i32| {
        let [leaving, arriving] = [from, to].map(|velocity| units(velocity * cycles as i32));
        segment(cycles << 32, end, Shape::Cubic { leaving, arriving })
    };
    let segments = [
        cubic(100, 1_000, 0, 20),
        cubic(1_000, 21_000, 20, 20),
        cubic(100, 31_500, 20, 190),
    ];
    let [mut exact, mut counted] = [Queue::new(), Queue::new()];
    let [mut exact, mut counted] = [&mut exact, &mut counted].map(|queue| split(queue, 200.0));
    for (admission, _) in [&mut exact, &mut counted] {
        admission
            .begin(&begin(1, 200, 0), &[Position::ZERO], 0)
            .unwrap();
        for (index, segment) in (0..2).zip(&segments) {
            admission.push(1, index, segment).unwrap();
        }
    }
    for now in 1..500 {
        if now == 200 {
            assert_eq!(counted.0.player().percent, 200);
            for (admission, _) in [&mut exact, &mut counted] {
                admission.push(1, 2, &segments[2]).unwrap();
            }
        }
        let at = advance(&mut exact.1, false, now, 0);
        assert_eq!(advance(&mut counted.1, true, now, 0), at);
        assert_eq!(counted.0.player(), exact.0.player(), "cycle {now}");
        if now == 300 {
            assert!(counted.0.player().percent < 190);
        }
    }
}
