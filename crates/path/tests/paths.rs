//! Paths of every kind, judged.

mod independent;

use independent::rig::{
    COUNTS_PER_UNIT, LIMITS, LONG, Piece, SHORT, Tool, check, place, tool, tool_with, units,
};
use independent::{Ideal, judge};
use path::machine::{Cartesian, Scale};
use path::{Arc, Join, Path, PathError};
use trajectory::{Limits, Position};

#[test]
fn a_line() {
    check(
        "line",
        &[Piece::Line([100_000.0, 30_000.0, -5_000.0])],
        300.0,
        Join::Exact,
        0.01,
    );
    check(
        "short line",
        &[Piece::Line([3.0, 1.0, 0.0])],
        300.0,
        Join::Exact,
        0.01,
    );
}

#[test]
fn a_circle() {
    let circle = Piece::Arc([50_000.0, 0.0], 1.0, [0.0, 0.0, 0.0]);
    let run = check("circle", &[circle], 200.0, Join::Exact, 0.05);
    let worst = run
        .places
        .iter()
        .map(|[x, y, _]| ((x - 50_000.0).hypot(*y) - 50_000.0).abs())
        .fold(0.0, f64::max);
    assert!(worst * COUNTS_PER_UNIT < 0.01, "{worst}");
}

/// Where the tool still accelerates while it turns fast: the jerk of that is what bounds it.
#[test]
fn a_circle_at_the_limits() {
    let circle = Piece::Arc([50_000.0, 0.0], 2.0, [0.0, 0.0, 0.0]);
    check("fast circle", &[circle], 400.0, Join::Exact, 0.05);
    // The smaller they are, the more of the jerk comes from the direction that turns while the tool accelerates.
    for radius in [500.0, 2_000.0, 5_000.0, 10_000.0] {
        let circle = Piece::Arc([radius, 0.0], 3.0, [0.0, 0.0, 0.0]);
        check("small circle", &[circle], 400.0, Join::Exact, 0.05);
    }
}

/// Pieces in one direction, passed at speed with `Exact` and at rest with `Rest`.
#[test]
fn a_line_in_pieces_is_a_line() {
    let pieces: Vec<Piece> = (1..=8)
        .map(|k| Piece::Line([f64::from(k) * 5_000.0, 0.0, 0.0]))
        .collect();
    let slowest = |run: &independent::rig::Run| {
        let x: Vec<f64> = run.places.iter().map(|place| place[0]).collect();
        let middle = x
            .windows(2)
            .filter(|pair| pair[0] > 12_000.0 && pair[1] < 28_000.0);
        middle
            .map(|pair| pair[1] - pair[0])
            .fold(f64::MAX, f64::min)
    };
    let exact = check("in pieces", &pieces, 100.0, Join::Exact, 0.01);
    assert!(slowest(&exact) > 90.0, "{}", slowest(&exact));
    let rests = check("with rests", &pieces, 100.0, Join::Rest, 0.01);
    assert!(slowest(&rests) < 0.001, "{}", slowest(&rests));
}

#[test]
fn a_pause_stands_and_goes_on() {
    let mut tool = tool();
    tool.line(place([100_000.0, 0.0, 0.0]), 100.0, Join::Exact)
        .unwrap();
    let play = |tool: &mut Tool<LONG>, cycles: usize| {
        for _ in 0..cycles {
            tool.advance();
        }
        tool.is_at_rest()
    };
    assert!(!play(&mut tool, 400));
    tool.pause();
    assert!(play(&mut tool, 400), "it stands");
    let [x, ..] = units(tool.place());
    assert!(x > 1_000.0 && x < 99_000.0, "{x}");
    assert!(play(&mut tool, 100) && units(tool.place())[0] == x && !tool.is_done());
    tool.resume();
    assert!(!play(&mut tool, 100));
    assert!(play(&mut tool, 2_000) && tool.is_done());
}

#[test]
fn a_square() {
    let square: Vec<Piece> = [
        [50_000.0, 0.0, 0.0],
        [50_000.0, 50_000.0, 0.0],
        [0.0, 50_000.0, 0.0],
        [0.0; 3],
    ]
    .map(Piece::Line)
    .into();
    let exact = check("square", &square, 200.0, Join::Exact, 0.01);
    let blended = check("blended square", &square, 200.0, Join::Blend(100.0), 100.0);
    assert!(blended.axes[0].len() < exact.axes[0].len() * 11 / 10);
}

#[test]
fn a_helix() {
    check(
        "helix",
        &[
            Piece::Arc([10_000.0, 0.0], 5.25, [10_000.0, -10_000.0, 5_000.0]),
            Piece::Line([0.0; 3]),
        ],
        100.0,
        Join::Blend(20.0),
        20.2,
    );
}

#[test]
fn a_chain_of_small_lines() {
    let chain: Vec<Piece> = (1..2_000)
        .map(|k| {
            let angle = f64::from(k) * 0.01;
            let radius = 5_000.0 + 10.0 * f64::from(k);
            Piece::Line([
                radius * angle.cos() - 5_000.0,
                radius * angle.sin(),
                2.0 * f64::from(k),
            ])
        })
        .collect();
    check("spiral of chords", &chain, 100.0, Join::Blend(10.0), 10.0);
    let chain: Vec<Piece> = (1..3_000)
        .map(|k| {
            let angle = f64::from(k) * 0.005;
            Piece::Line([4_000.0 * angle.cos() - 4_000.0, 4_000.0 * angle.sin(), 0.0])
        })
        .collect();
    check("20 um chords", &chain, 100.0, Join::Blend(5.0), 5.0);
}

#[test]
fn lines_and_arcs() {
    let slot = [
        Piece::Line([40_000.0, 0.0, 0.0]),
        Piece::Arc([40_000.0, 10_000.0], 0.5, [40_000.0, 20_000.0, 0.0]),
        Piece::Line([0.0, 20_000.0, 0.0]),
        Piece::Arc([0.0, 10_000.0], 0.5, [0.0, 0.0, 0.0]),
    ];
    check("slot", &slot, 150.0, Join::Blend(10.0), 10.0);
    check("slot", &slot, 150.0, Join::Exact, 0.05);
    let tiny: Vec<Piece> = (0..200)
        .map(|k| {
            Piece::Arc(
                [f64::from(k) * 100.0 + 50.0, 0.0],
                if k % 2 == 0 { 0.5 } else { -0.5 },
                [f64::from(k + 1) * 100.0, 0.0, 0.0],
            )
        })
        .collect();
    check("tiny arcs", &tiny, 100.0, Join::Blend(2.0), 2.1);
    check("tiny arcs exact", &tiny, 100.0, Join::Exact, 0.1);
}

#[test]
fn sharp_corners_and_reversals() {
    let star: Vec<Piece> = (1..40)
        .map(|k| {
            let angle = f64::from(k) * 2.8;
            Piece::Line([
                20_000.0 * angle.cos() - 20_000.0,
                20_000.0 * angle.sin(),
                0.0,
            ])
        })
        .collect();
    check("star", &star, 300.0, Join::Blend(50.0), 50.0);
    let back: Vec<Piece> = (1..40)
        .map(|k| Piece::Line([if k % 2 == 0 { 0.0 } else { 3_000.0 }, 0.0, 0.0]))
        .collect();
    let run = check("reversals", &back, 300.0, Join::Blend(50.0), 0.05);
    let tips = run.places.iter().map(|[x, ..]| *x).fold(0.0, f64::max);
    assert!(tips > 2_999.95, "the tool gets to the tips: {tips}");
}

/// How near the tool comes to a corner where its direction turns by an angle.
fn nearest_to_corner(degrees: f64, join: Join) -> f64 {
    let corner = [20_000.0, 0.0, 0.0];
    let angle = degrees.to_radians();
    let end = [
        20_000.0 + 20_000.0 * angle.cos(),
        20_000.0 * angle.sin(),
        0.0,
    ];
    let pieces = [Piece::Line(corner), Piece::Line(end)];
    let run = check("corner", &pieces, 100.0, join, 50.0);
    let distance = |place: &[f64; 3]| (place[0] - corner[0]).hypot(place[1]);
    run.places.iter().map(distance).fold(f64::MAX, f64::min)
}

#[test]
fn a_corner_of_more_than_160_degrees_is_passed_at_rest() {
    for degrees in [90.0, 150.0, 159.5] {
        let missed = nearest_to_corner(degrees, Join::Blend(50.0));
        assert!(missed > 10.0, "{degrees}: {missed}");
        let missed = nearest_to_corner(degrees, Join::Exact);
        assert!(missed < 0.01, "{degrees}: {missed}");
    }
    for degrees in [160.5, 170.0, 180.0] {
        let missed = nearest_to_corner(degrees, Join::Blend(50.0));
        assert!(missed < 0.01, "{degrees}: {missed}");
    }
}

#[test]
fn a_queue_that_is_full_says_so() {
    let mut tool = tool();
    let mut pieces = 0;
    while tool.has_room() {
        pieces += 1;
        tool.line(
            place([
                f64::from(pieces) * 1_000.0,
                f64::from(pieces % 2) * 500.0,
                0.0,
            ]),
            100.0,
            Join::Blend(10.0),
        )
        .unwrap();
    }
    let end = tool.end();
    assert_eq!(
        tool.line(place([0.0; 3]), 1.0, Join::Exact),
        Err(PathError::Full)
    );
    assert_eq!(tool.end(), end);
}

/// Pieces that come when there is nearly nothing left of the one before, or later.
#[test]
fn a_queue_that_runs_dry_ends_at_rest_on_the_path() {
    for pause in [20_usize, 60, 110, 300] {
        let mut tool = tool_with::<SHORT>([LIMITS; 3]);
        let mut ideal = Ideal::at([0.0; 3]);
        let (mut axes, mut places, mut rests) = (vec![vec![0.0]; 3], vec![[0.0; 3]], 0);
        let mut pieces = 0;
        for cycle in 0..12_000 {
            if cycle >= pieces * pause && pieces < 30 && tool.has_room() {
                pieces += 1;
                let k = pieces as f64;
                let end = [k * 700.0, if k % 4.0 < 2.0 { 0.0 } else { 300.0 }, 0.0];
                tool.line(place(end), 100.0, Join::Blend(20.0)).unwrap();
                ideal.line(end);
            }
            for (axis, position) in axes.iter_mut().zip(tool.advance()) {
                axis.push(position.units() as f64 / 16_777_216.0);
            }
            places.push(units(tool.place()));
            rests += usize::from(tool.is_done());
        }
        assert!(tool.is_done() && rests > 0, "{pause}");
        let ends = units(tool.place()).into_iter().zip(units(tool.end()));
        for (at, end) in ends {
            assert!((at - end).abs() < 0.001, "{pause}: {at} {end}");
        }
        judge(
            "dry",
            &axes,
            &[LIMITS.map(|limit| limit * COUNTS_PER_UNIT); 3],
            0.002,
        );
        let deviation = ideal.deviation(&places);
        assert!(deviation <= 20.0, "{pause}: {deviation}");
    }
}

/// The front cannot stop before it any more, or just so: then it begins at rest.
#[test]
fn a_tiny_arc_that_comes_late_begins_at_rest() {
    let arc = |from: f64| Arc {
        plane: (0, 1),
        centre: [place([from, 0.0, 0.0])[0], place([50.0, 0.0, 0.0])[0]],
        sweep: 1 << 31,
        end: place([from, 100.0, 0.0]),
    };
    for late in (150..500).step_by(7) {
        let mut tool = tool_with::<SHORT>([LIMITS; 3]);
        tool.line(place([60_000.0, 0.0, 0.0]), 300.0, Join::Exact)
            .unwrap();
        let mut axes = vec![vec![0.0]; 3];
        for cycle in 0..2_000 {
            if cycle == late {
                tool.arc(&arc(60_000.0), 300.0, Join::Blend(5.0)).unwrap();
            }
            for (axis, position) in axes.iter_mut().zip(tool.advance()) {
                axis.push(position.units() as f64 / 16_777_216.0);
            }
        }
        assert!(tool.is_done());
        judge(
            "late",
            &axes,
            &[LIMITS.map(|limit| limit * COUNTS_PER_UNIT); 3],
            0.002,
        );
    }
}

/// Pieces and blends fill a queue to its last place.
#[test]
fn nothing_is_lost_where_the_queue_is_full() {
    for rests in 0..3 {
        let mut tool = tool_with::<SHORT>([LIMITS; 3]);
        tool.pause();
        let (mut ideal, mut pieces) = (Ideal::at([0.0; 3]), 0);
        let mut places = vec![[0.0; 3]];
        for cycle in 0..20_000 {
            if tool.has_room() && pieces < 40 {
                pieces += 1;
                let end = [
                    f64::from(pieces) * 400.0,
                    f64::from(pieces % 2) * 300.0,
                    0.0,
                ];
                let join = if pieces <= rests {
                    Join::Rest
                } else {
                    Join::Blend(30.0)
                };
                tool.line(place(end), 100.0, join).unwrap();
                ideal.line(end);
            }
            if cycle == 2_000 {
                tool.resume();
            }
            tool.advance();
            places.push(units(tool.place()));
        }
        assert!(tool.is_done());
        let deviation = ideal.deviation(&places);
        assert!(deviation <= 30.0, "{rests}: {deviation}");
    }
}

#[test]
fn a_path_of_short_pieces_does_not_start_before_some_are_known() {
    let mut tool = tool_with::<SHORT>([LIMITS; 3]);
    let (mut known, mut began) = (0.0, None);
    for cycle in 0..400 {
        while tool.has_room() {
            known += 5.0;
            tool.line(place([known, 0.0, 0.0]), 100.0, Join::Exact)
                .unwrap();
        }
        tool.advance();
        if began.is_none() && !tool.is_at_rest() {
            began = Some(cycle);
        }
    }
    // Not at once, and not much later than a quarter of the queue takes.
    assert!((10..150).contains(&began.unwrap()), "{began:?}");
    // A last piece is not waited for.
    let mut tool = tool_with::<SHORT>([LIMITS; 3]);
    tool.line(place([5.0, 0.0, 0.0]), 100.0, Join::Exact)
        .unwrap();
    let cycles = (0..400).find(|_| {
        tool.advance();
        !tool.is_at_rest()
    });
    assert!(cycles.unwrap() < 40, "{cycles:?}");
}

#[test]
fn what_is_no_piece_is_refused_and_changes_nothing() {
    let mut tool = tool();
    let end = place([100.0, 50.0, 0.0]);
    tool.line(end, 10.0, Join::Rest).unwrap();
    let far = place([(1 << 28) as f64 + 1.0, 0.0, 0.0]);
    for (feed, join, error) in [
        (0.0, Join::Exact, PathError::NotPositive { actual: 0.0 }),
        (-1.0, Join::Exact, PathError::NotPositive { actual: -1.0 }),
        (
            f32::INFINITY,
            Join::Rest,
            PathError::NotPositive {
                actual: f32::INFINITY,
            },
        ),
        (
            1.0,
            Join::Blend(0.0),
            PathError::NotPositive { actual: 0.0 },
        ),
        (1e-5, Join::Exact, PathError::Slow { actual: 1e-5 }),
    ] {
        assert_eq!(tool.line(place([0.0; 3]), feed, join), Err(error));
    }
    let error = PathError::Far {
        coordinate: 0,
        actual: (1 << 28) + 1,
    };
    assert_eq!(tool.line(far, 1.0, Join::Exact), Err(error));
    let half = Arc {
        plane: (0, 1),
        centre: [place([50.0, 0.0, 0.0])[0], place([50.0, 0.0, 0.0])[0]],
        sweep: 1 << 31,
        end: place([0.0, 50.0, 0.0]),
    };
    let refuse = |tool: &mut Tool<LONG>, arc: Arc<3>| tool.arc(&arc, 1.0, Join::Exact).unwrap_err();
    for plane in [(0, 3), (3, 0), (1, 1)] {
        let error = refuse(&mut tool, Arc { plane, ..half });
        assert_eq!(error, PathError::Plane { actual: plane });
    }
    let sweep = 1 << 60;
    assert_eq!(
        refuse(&mut tool, Arc { sweep, ..half }),
        PathError::Sweep { actual: sweep }
    );
    let centre = [place([100.0, 0.0, 0.0])[0], place([50.0, 0.0, 0.0])[0]];
    assert_eq!(
        refuse(&mut tool, Arc { centre, ..half }),
        PathError::Radius { actual: 0.0 }
    );
    let centre = [
        Position::from_units(i64::MIN),
        Position::from_units(i64::MAX),
    ];
    assert!(matches!(
        refuse(&mut tool, Arc { centre, ..half }),
        PathError::Radius { .. }
    ));
    // 1 of 50 is more than 1 of 64, 0.7 is not.
    let off = place([0.0, 51.0, 0.0]);
    assert!(matches!(
        refuse(&mut tool, Arc { end: off, ..half }),
        PathError::End { .. }
    ));
    let turns = 3_000_000 << 32;
    let long = Arc {
        sweep: turns,
        end,
        ..half
    };
    assert!(matches!(refuse(&mut tool, long), PathError::Long { .. }));
    assert_eq!(tool.end(), end);
    tool.arc(
        &Arc {
            end: place([0.0, 50.7, 0.0]),
            ..half
        },
        1.0,
        Join::Exact,
    )
    .unwrap();
    tool.stop();
    assert_eq!(tool.line(end, 1.0, Join::Exact), Err(PathError::Stopping));
}

/// Exactly as far as there is room, and what is shorter than 2^-8 units is nothing.
#[test]
fn the_farthest_place_and_the_shortest_line() {
    let mut tool = tool();
    tool.line(place([0.0039, 0.0, 0.0]), 1.0, Join::Exact)
        .unwrap();
    assert_eq!(tool.end(), place([0.0; 3]));
    let farthest = place([(1 << 28) as f64, -((1 << 28) as f64), 0.0]);
    tool.line(farthest, 1.0, Join::Exact).unwrap();
    assert_eq!(tool.end(), farthest);
}

#[test]
fn limits_that_would_not_let_an_axis_move_are_refused() {
    let limits = [LIMITS, LIMITS, [500.0, 2.0, 1e-8]];
    let scale = Scale::from_fixed(1 << 32).unwrap();
    let [x, y, z] = limits.map(|[v, a, j]| Limits::new(v as f32, a as f32, j as f32).unwrap());
    let machine = Cartesian { scales: [scale; 3] };
    let path = Path::<_, 3, 3, 16>::new(machine, [x, y, z], [Position::ZERO; 3]);
    assert_eq!(path.err(), Some(PathError::Limits));
}
