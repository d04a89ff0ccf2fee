//! What is just allowed is taken, and what is taken keeps the limits: ends exactly at the travel, several segments in a cycle, set-points that
//! lie close together.

mod judge;

use board_link::host::{SegmentMaker, SegmentMakerConfig};
use board_link::segment::{
    AxisSegment, Begin, Segment, SegmentConfig, SegmentPreview, SegmentQueue, Shape,
};
use board_link::{AxisLimits, Config, Phase, Reason, Refusal, SetPointBuffer, WhenDry};
use judge::Judge;
use proptest::prelude::*;
use trajectory::{Limits, Position, Time};

fn counts(counts: f64) -> Position {
    Position::from_units((counts * Position::UNITS as f64).round() as i64)
}

fn segment(ticks: u64, end: Position, shape: Shape) -> Segment {
    let axis = AxisSegment {
        end: end.units(),
        shape,
    };
    Segment {
        duration: ticks,
        axes: [axis].into_iter().collect(),
    }
}

/// From somewhere to exactly the highest or the lowest position, in whole counts and in parts of them.
fn moves_to_the_limit() -> impl Iterator<Item = (AxisLimits, Position, Position)> {
    let mut random = fastrand::Rng::with_seed(8);
    (0..2_000).map(move |number| {
        let scale = 10_f64.powi(1 + number % 7);
        let part = if number % 2 == 0 { 0.0 } else { random.f64() };
        let from = (random.f64() * scale).round() + part;
        let to = (scale * (1.0 + random.f64())).round() + 1.0;
        let sign = if random.bool() { 1.0 } else { -1.0 };
        let (from, to) = (counts(sign * from), counts(sign * to));
        let limits = AxisLimits {
            motion: Limits::without_jerk(1e6, 1e6).unwrap(),
            lowest: to.min(from),
            highest: to.max(from),
        };
        (limits, from, to)
    })
}

#[test]
fn a_segment_ends_exactly_at_the_travel() {
    let mut refused = Vec::new();
    for (limits, from, to) in moves_to_the_limit() {
        let at_rest = Shape::Cubic {
            leaving: 0,
            arriving: 0,
        };
        for shape in [Shape::Line, Shape::MinimumJerk, at_rest] {
            let mut preview = SegmentPreview::<1>::new(&[limits], &[from]).unwrap();
            let taken = preview.push(&segment(2_000 << 32, to, shape));
            refused.extend(
                taken
                    .err()
                    .filter(|error| error.reason() == Some(Reason::Travel)),
            );
        }
        // A count beyond is beyond.
        let mut preview = SegmentPreview::<1>::new(&[limits], &[from]).unwrap();
        let way = to.distance_from(from).units();
        let further = Position::from_units(to.units() + way.signum() * Position::UNITS);
        let taken = preview.push(&segment(2_000 << 32, further, Shape::MinimumJerk));
        assert_eq!(taken.unwrap_err().reason(), Some(Reason::Travel));
    }
    assert!(
        refused.is_empty(),
        "{} refused, {:?}",
        refused.len(),
        refused[0]
    );
}

#[test]
fn set_points_end_exactly_at_the_travel() {
    for (limits, from, to) in moves_to_the_limit() {
        let config = Config::with_cycles_per_second(1_000);
        let buffer = SetPointBuffer::<1, 64>::new(&[limits], &[from], config);
        let mut buffer = buffer.unwrap();
        buffer.push(Time::from_cycles(1_000), &[from]).unwrap();
        let taken = buffer.push(Time::from_cycles(10_000), &[to]);
        assert!(taken.is_ok(), "{taken:?}: from {from:?} to {to:?}");
    }
}

/// Lines of less than a cycle, each a little faster than the one before: what the steps of one cycle make together counts.
#[test]
fn several_steps_in_a_cycle_keep_the_limits_together() {
    let steady = Limits::without_jerk(100.0, 1.5).unwrap();
    let smooth = Limits::new(100.0, 30.0, 2.0).unwrap();
    for (motion, back) in [(steady, 20), (smooth, 1)] {
        for ticks in [1_u64 << 31, 3 << 30, 1 << 32, 3 << 31, 2 << 32] {
            let limits = AxisLimits {
                motion,
                lowest: counts(-1e6),
                highest: counts(1e6),
            };
            let (mut at, mut velocity) = (0.0, 0.0);
            let segments = (0..40).map(|place| {
                velocity += if place / back % 2 == 0 { 0.99 } else { -0.99 };
                at += velocity * ticks as f64 / (1_u64 << 32) as f64;
                segment(ticks, counts(at), Shape::Line)
            });
            let Some(judge) = play(limits, segments) else {
                assert!(ticks < 1 << 32 || back == 1, "{ticks} ticks are refused");
                continue;
            };
            assert!(judge.acceleration <= f64::from(motion.acceleration()) + 1e-3);
            assert!(back == 20 || judge.jerk <= f64::from(motion.jerk()) + 1e-3);
        }
    }
}

/// `None` when a segment is refused.
fn play(limits: AxisLimits, segments: impl Iterator<Item = Segment>) -> Option<Judge> {
    let mut queue = SegmentQueue::<1, 64>::new();
    let config = SegmentConfig::with_cycles_per_second(1_000);
    let (mut admission, mut player) = queue.split(&[limits], config).unwrap();
    let begin = Begin {
        stream: 1,
        start: None,
        when_dry: WhenDry::End,
        percent: 100,
        from: [0].into_iter().collect(),
    };
    admission.begin(&begin, &[Position::ZERO], 0).unwrap();
    for (segment, index) in segments.zip(0..) {
        admission.push(1, index, &segment).ok()?;
    }
    admission.end(1).unwrap();
    let (mut judge, mut out) = (Judge::default(), [Position::ZERO]);
    judge.see(out[0]);
    for now in 1..1_000 {
        player.advance(now, &[Position::ZERO], &mut out);
        judge.see(out[0]);
    }
    Some(judge)
}

/// At twice the speed, along set-points that need the acceleration that they may.
#[test]
fn an_override_of_dense_set_points_keeps_the_acceleration() {
    for gap in [0.5_f64, 1.0, 2.0, 3.0, 5.0, 10.0] {
        let limits = AxisLimits {
            motion: Limits::without_jerk(20.0, 0.3).unwrap(),
            lowest: counts(-1e6),
            highest: counts(1e6),
        };
        let config = Config::with_cycles_per_second(1_000);
        let buffer = SetPointBuffer::<1, 1_024>::new(&[limits], &[Position::ZERO], config);
        let mut buffer = buffer.unwrap();
        buffer.set_override(200).unwrap();
        // A sine that begins and ends smoothly: 4 counts a cycle, 0.19 counts per cycle² at its limit, of which 0.2 are allowed.
        let (fast, length) = (0.19 / 4.0, 3_000.0);
        let soft = |t: f64| {
            let u = (t / 400.0).clamp(0.0, 1.0);
            u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)
        };
        let path = |t: f64| 59.0 * soft(t) * soft(length - t) * (1.0 - (fast * t).cos());
        let (mut judge, mut out) = (Judge::default(), [Position::ZERO]);
        judge.see(out[0]);
        let mut time = 0.0;
        for _ in 0..20_000 {
            while time <= length && buffer.credit() > 0 {
                let ticks = (time * (1_u64 << 32) as f64) as u64;
                buffer
                    .push(
                        Time::from_ticks((1_000 << 32) + ticks),
                        &[counts(path(time))],
                    )
                    .unwrap();
                time += gap;
            }
            if time > length {
                buffer.end();
            }
            let phase = buffer.advance(&mut out);
            judge.see(out[0]);
            if !matches!(phase, Phase::Waiting | Phase::Moving) {
                break;
            }
        }
        assert_eq!(buffer.phase(), Phase::Complete);
        assert!(judge.acceleration <= 0.301, "{gap}: {}", judge.acceleration);
    }
}

/// A sampled move of minimum jerk from 0 to the end of the travel, which stands there for two set-points more.
#[derive(Debug, Clone)]
struct Sampled {
    way: i32,
    samples: u32,
    gap: u32,
    in_whole_counts: bool,
}

impl Sampled {
    fn limits(&self) -> AxisLimits {
        let end = Position::from_counts(self.way);
        AxisLimits {
            motion: Limits::without_jerk(1e6, 1e6).unwrap(),
            lowest: end.min(Position::ZERO),
            highest: end.max(Position::ZERO),
        }
    }

    fn set_points(&self) -> impl Iterator<Item = (Time, Position)> {
        let of = self.clone();
        (0..=of.samples + 2).map(move |sample| {
            let share = (f64::from(sample) / f64::from(of.samples)).min(1.0);
            let eased = share.powi(3) * (10.0 - 15.0 * share + 6.0 * share * share);
            let at = f64::from(of.way) * eased;
            let at = if of.in_whole_counts { at.round() } else { at };
            (Time::from_cycles(1_000 + sample * of.gap), counts(at))
        })
    }

    /// How far the parabola through the last three places leads beyond the end, and a little more.
    fn overshoot(&self) -> f64 {
        let last_way = 10.0 * f64::from(self.way.abs()) / f64::from(self.samples).powi(3);
        let rounded = if self.in_whole_counts { 0.5 } else { 0.0 };
        (last_way + rounded) * 0.15
    }

    /// The counts that go out behind a board that takes the segments of a maker.
    fn sent_in_segments(&self) -> Result<Vec<i32>, Refusal> {
        let (limits, mut segments) = (self.limits(), Vec::new());
        let config = SegmentMakerConfig {
            longest_gap: Time::from_cycles(10_000),
            kept: 56,
            least_kept: Time::from_cycles(1),
        };
        let stand = [Position::ZERO];
        let preview = SegmentPreview::<1>::new(&[limits], &stand).unwrap();
        let mut maker = SegmentMaker::new(preview, &stand, config).unwrap();
        for (time, at) in self.set_points() {
            segments.extend(maker.push(time, &[at])?);
        }
        segments.extend(maker.finish()?);
        let mut queue = SegmentQueue::<1, 128>::new();
        let config = SegmentConfig::with_cycles_per_second(1_000);
        let (mut admission, mut player) = queue.split(&[limits], config).unwrap();
        let begin = Begin {
            stream: 1,
            start: None,
            when_dry: WhenDry::End,
            percent: 100,
            from: [0].into_iter().collect(),
        };
        admission.begin(&begin, &stand, 0).unwrap();
        for (segment, index) in segments.iter().zip(0..) {
            admission.push(1, index, segment).unwrap();
        }
        admission.end(1).unwrap();
        let (mut sent, mut out) = (Vec::new(), [0]);
        for now in 1..10_000 {
            player.advance_counts(now, &stand, &mut out);
            sent.push(out[0]);
        }
        Ok(sent)
    }

    /// The counts that go out of a buffer of set-points.
    fn sent_from_buffer(&self) -> Result<Vec<i32>, Refusal> {
        let config = Config::with_cycles_per_second(1_000);
        let stand = [Position::ZERO];
        let buffer = SetPointBuffer::<1, 128>::new(&[self.limits()], &stand, config);
        let mut buffer = buffer.unwrap();
        for (time, at) in self.set_points() {
            buffer.push(time, &[at])?;
        }
        buffer.end();
        let (mut sent, mut out) = (Vec::new(), stand);
        for _ in 0..20_000 {
            buffer.advance(&mut out);
            sent.push(out[0].counts());
        }
        Ok(sent)
    }
}

fn sampled() -> impl Strategy<Value = Sampled> {
    let way = prop_oneof![1..200_i32, 1..50_000, 1..300_000];
    (way, any::<bool>(), 5..100_u32, 1..40_u32, any::<bool>()).prop_map(
        |(way, is_negative, samples, gap, in_whole_counts)| Sampled {
            way: if is_negative { -way } else { way },
            samples,
            gap,
            in_whole_counts,
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, ..ProptestConfig::default() })]

    /// What leads less than half a count beyond the end is taken, and whatever is taken sends no count beyond it.
    #[test]
    fn a_sampled_move_may_end_at_the_travel(sampled in sampled()) {
        let (low, high) = (sampled.way.min(0), sampled.way.max(0));
        for sent in [sampled.sent_in_segments(), sampled.sent_from_buffer()] {
            match sent {
                Ok(sent) => {
                    prop_assert!(sent.iter().all(|at| (low..=high).contains(at)));
                    prop_assert_eq!(sent.last(), Some(&sampled.way));
                }
                Err(refusal) => {
                    prop_assert!(matches!(refusal, Refusal::Travel { .. }), "{refusal}");
                    prop_assert!(sampled.overshoot() > 0.4, "{refusal}");
                }
            }
        }
    }
}

/// A stream that was stopped between two set-points, a little beyond the end of the travel: the next one begins there.
#[test]
fn a_stream_begins_where_another_was_stopped_beside_the_travel() {
    let limits = AxisLimits {
        motion: Limits::without_jerk(100.0, 1.0).unwrap(),
        lowest: Position::ZERO,
        highest: Position::from_counts(100),
    };
    let taken = |from: f64| {
        let mut queue = SegmentQueue::<1, 8>::new();
        let config = SegmentConfig::with_cycles_per_second(1_000);
        let (mut admission, _) = queue.split(&[limits], config).unwrap();
        let from = counts(from);
        let begin = Begin {
            stream: 1,
            start: None,
            when_dry: WhenDry::End,
            percent: 100,
            from: [from.units()].into_iter().collect(),
        };
        let stand = [Position::from_counts(from.counts())];
        admission
            .begin(&begin, &stand, 0)
            .map_err(|refused| refused.reason())
    };
    assert_eq!(taken(100.4), Ok(()));
    assert_eq!(taken(-0.4), Ok(()));
    assert_eq!(taken(100.6), Err(Some(Reason::Travel)));
    assert_eq!(taken(-0.6), Err(Some(Reason::Travel)));
}
