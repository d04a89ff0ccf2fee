//! Random paths with random limits, and override, pause and stop at random moments.

mod independent;

use independent::rig::{LIMITS, LONG, Piece, SHORT, Tool, feed_one, place, run, tool_with, units};
use independent::{Ideal, judge};
use path::Join;
use proptest::prelude::*;

/// Points from micrometres to centimetres apart, and arcs through them.
fn pieces() -> impl Strategy<Value = Vec<Piece>> {
    let step = (
        0.5_f64..4.2,
        0.0..core::f64::consts::TAU,
        -0.3..0.3_f64,
        -0.9..0.9_f64,
        0..3_u8,
    );
    proptest::collection::vec(step, 1..25).prop_map(|steps| {
        let mut at = [0.0_f64; 3];
        let mut pieces = Vec::new();
        for (size, heading, slope, sweep, kind) in steps {
            let length = 10_f64.powf(size);
            let next = [
                at[0] + length * heading.cos(),
                at[1] + length * heading.sin(),
                at[2] + length * slope,
            ];
            if kind == 0 && sweep.abs() > 0.01 {
                // The circle through both with this sweep: the centre is on the bisector.
                let half = core::f64::consts::PI * sweep;
                let off = 0.5 * length / half.tan();
                let centre = [
                    (at[0] + next[0]) / 2.0 - off * heading.sin(),
                    (at[1] + next[1]) / 2.0 + off * heading.cos(),
                ];
                pieces.push(Piece::Arc(centre, sweep, next));
            } else {
                pieces.push(Piece::Line(next));
            }
            at = next;
        }
        pieces
    })
}

fn joins() -> impl Strategy<Value = Join> {
    prop_oneof![
        Just(Join::Exact),
        Just(Join::Rest),
        (0.0..2.5_f64).prop_map(|size| Join::Blend(10_f64.powf(size) as f32)),
    ]
}

#[derive(Debug, Clone, Copy)]
enum Action {
    Override(u16),
    Pause,
    Resume,
}

fn actions() -> impl Strategy<Value = Vec<(usize, Action)>> {
    let action = prop_oneof![
        (1..=150_u16).prop_map(Action::Override),
        Just(Action::Pause),
        Just(Action::Resume),
        Just(Action::Resume),
    ];
    proptest::collection::vec((0..3_000_usize, action), 0..12)
}

/// Plays pieces with orders, and judges the run.
fn keeps_every_limit<const Q: usize>(
    pieces: &[Piece],
    (join, feed): (Join, f32),
    actions: &[(usize, Action)],
    (scales, most): ([f64; 3], u16),
) {
    let limits = [0, 1, 2].map(|axis: usize| {
        let scale: f64 = scales[axis];
        [
            LIMITS[0] * scale,
            LIMITS[1] * scale * scale.sqrt(),
            LIMITS[2] * scale,
        ]
    });
    let mut tool: Tool<Q> = tool_with(limits);
    tool.set_most_override(most);
    let last = actions.iter().map(|(at, _)| *at + 1).max().unwrap_or(0);
    let run = run(&mut tool, pieces, feed, join, |tool, cycle| {
        for (_, action) in actions.iter().filter(|(at, _)| *at == cycle) {
            match action {
                Action::Override(percent) => tool.set_override(*percent),
                Action::Pause => tool.pause(),
                Action::Resume => tool.resume(),
            }
        }
        if cycle == last {
            tool.set_override(100);
            tool.resume();
        }
    });
    let counts = limits.map(|limits| limits.map(|limit| limit * independent::rig::COUNTS_PER_UNIT));
    judge("random", &run.axes, &counts, 0.01);
    stays_on_the_path(&run, join);
    let end = units(tool.place());
    for (end, target) in end.iter().zip(run.ideal.end) {
        assert!((end - target).abs() < 0.05, "{end} {target}");
    }
}

fn stays_on_the_path(run: &independent::rig::Run, join: Join) {
    let tolerance = match join {
        Join::Blend(tolerance) => f64::from(tolerance),
        Join::Exact | Join::Rest => 0.0,
    };
    let deviation = run.ideal.deviation(&run.places);
    assert!(deviation <= tolerance + 0.1, "{deviation} of {tolerance}");
}

/// Each piece comes so many cycles after the one before it at the earliest.
fn keeps_every_limit_with_gaps<const Q: usize>(
    pieces: &[Piece],
    gaps: &[usize],
    join: Join,
    feed: f32,
) {
    let mut tool: Tool<Q> = tool_with([LIMITS; 3]);
    let mut run = independent::rig::Run {
        axes: vec![vec![0.0]; 3],
        places: vec![[0.0; 3]],
        ideal: Ideal::at([0.0; 3]),
    };
    let mut rest = pieces.iter().zip(gaps.iter().cycle()).peekable();
    let mut due = 0;
    for cycle in 0..400_000 {
        if cycle >= due
            && tool.has_room()
            && let Some((piece, gap)) = rest.next()
        {
            feed_one(&mut tool, piece, feed, join, &mut run.ideal);
            due = cycle + gap;
        }
        for (axis, position) in run.axes.iter_mut().zip(tool.advance()) {
            axis.push(position.units() as f64 / 16_777_216.0);
        }
        run.places.push(units(tool.place()));
        if rest.peek().is_none() && tool.is_done() {
            break;
        }
    }
    assert!(tool.is_done());
    let limit = LIMITS.map(|limit| limit * independent::rig::COUNTS_PER_UNIT);
    judge("gaps", &run.axes, &[limit; 3], 0.01);
    stays_on_the_path(&run, join);
}

/// Stops at a cycle, and goes on with another path from there.
fn stops_and_starts<const Q: usize>(pieces: &[Piece], join: Join, feed: f32, at: usize) {
    let mut tool: Tool<Q> = tool_with([LIMITS; 3]);
    let run = independent::rig::run_until(&mut tool, pieces, feed, join, at);
    stays_on_the_path(&run, join);
    let mut axes = run.axes;
    let start = units(tool.place());
    tool.line(place([start[0] + 1_000.0, start[1], start[2]]), feed, join)
        .unwrap();
    for _ in 0..100_000 {
        for (axis, position) in axes.iter_mut().zip(tool.advance()) {
            axis.push(position.units() as f64 / 16_777_216.0);
        }
        if tool.is_done() {
            break;
        }
    }
    assert!(tool.is_done());
    let limit = LIMITS.map(|limit| limit * independent::rig::COUNTS_PER_UNIT);
    judge("stop", &axes, &[limit; 3], 0.01);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]

    #[test]
    fn every_limit_is_kept_on_the_path(
        pieces in pieces(), join in joins(), feed in 1.0..500.0_f32, actions in actions(),
        scales in [0.2..5.0_f64, 0.2..5.0, 0.2..5.0], most in 100..=200_u16,
    ) {
        let mut sorted = actions;
        sorted.sort_by_key(|(at, _)| *at);
        keeps_every_limit::<LONG>(&pieces, (join, feed), &sorted, (scales, most));
        keeps_every_limit::<SHORT>(&pieces, (join, feed), &sorted, (scales, most));
    }

    #[test]
    fn a_stop_ends_on_the_path_and_another_path_starts_there(
        pieces in pieces(), join in joins(), feed in 1.0..500.0_f32, at in 1..2_000_usize,
    ) {
        stops_and_starts::<LONG>(&pieces, join, feed, at);
        stops_and_starts::<SHORT>(&pieces, join, feed, at);
    }

    #[test]
    fn pieces_that_come_late_are_passed_within_every_limit(
        pieces in pieces(), gaps in proptest::collection::vec(1..400_usize, 1..8),
        join in joins(), feed in 1.0..500.0_f32,
    ) {
        keeps_every_limit_with_gaps::<LONG>(&pieces, &gaps, join, feed);
        keeps_every_limit_with_gaps::<SHORT>(&pieces, &gaps, join, feed);
    }
}
