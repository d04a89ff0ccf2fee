//! Paths of every kind, judged.

mod independent;

use independent::rig::{COUNTS_PER_UNIT, Piece, check, place, tool};
use path::{Join, PathError};

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
    check("reversals", &back, 300.0, Join::Blend(50.0), 0.05);
}

#[test]
fn the_queue_is_full_and_runs_dry() {
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
    assert_eq!(
        tool.line(place([0.0; 3]), 1.0, Join::Exact),
        Err(PathError::Full)
    );
}
