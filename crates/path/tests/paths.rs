//! Paths of every kind, judged.

mod independent;

use independent::{Ideal, judge};
use path::machine::{Cartesian, Scale};
use path::{Arc, Join, Path, PathError};
use trajectory::{Limits, Position};

const COUNTS_PER_UNIT: f64 = 3.2768;
/// 500 mm/s, 2000 mm/s², 40000 mm/s³ in counts of 1/3.2768 µm per cycle.
const LIMITS: [f64; 3] = [500.0, 2.0, 0.04];

fn limits() -> Limits {
    let [v, a, j] = LIMITS.map(|limit| (limit * COUNTS_PER_UNIT) as f32);
    Limits::new(v, a, j).unwrap()
}

type Tool = Path<Cartesian<3>, 3, 3, 256>;

fn tool() -> Tool {
    let scale = Scale::from_fixed((COUNTS_PER_UNIT * 4_294_967_296.0) as i64).unwrap();
    let machine = Cartesian { scales: [scale; 3] };
    Path::new(machine, [limits(); 3], [Position::ZERO; 3]).unwrap()
}

fn place(units: [f64; 3]) -> [Position; 3] {
    units.map(|unit| Position::from_units((unit * 16_777_216.0).round() as i64))
}

fn units(place: [Position; 3]) -> [f64; 3] {
    place.map(|position| position.units() as f64 / 16_777_216.0)
}

#[derive(Debug, Clone)]
enum Piece {
    Line([f64; 3]),
    Arc([f64; 2], f64, [f64; 3]),
}

struct Run {
    axes: Vec<Vec<f64>>,
    places: Vec<[f64; 3]>,
    ideal: Ideal,
}

/// Feeds the pieces as the queue has room, and collects every cycle.
fn run(
    tool: &mut Tool,
    pieces: &[Piece],
    feed: f32,
    join: Join,
    mut each: impl FnMut(&mut Tool, usize),
) -> Run {
    let mut ideal = Ideal::at(units(tool.end()));
    let mut rest = pieces.iter();
    let mut next = rest.next();
    let mut run = Run {
        axes: vec![vec![0.0]; 3],
        places: vec![units(tool.place())],
        ideal: Ideal::at([0.0; 3]),
    };
    tool.pause();
    let mut is_started = false;
    for cycle in 0..2_000_000 {
        while let Some(piece) = next {
            if !tool.has_room() {
                break;
            }
            match piece {
                Piece::Line(end) => {
                    tool.line(place(*end), feed, join).unwrap();
                    ideal.line(*end);
                }
                Piece::Arc(centre, turns, end) => {
                    let arc = Arc {
                        plane: (0, 1),
                        centre: [
                            place([centre[0], 0.0, 0.0])[0],
                            place([centre[1], 0.0, 0.0])[0],
                        ],
                        sweep: (turns * 4_294_967_296.0).round() as i64,
                        end: place(*end),
                    };
                    tool.arc(&arc, feed, join).unwrap();
                    ideal.arc(*centre, *turns, *end);
                }
            }
            next = rest.next();
        }
        if !is_started {
            tool.resume();
            is_started = true;
        }
        each(tool, cycle);
        let axes = tool.advance();
        for (axis, position) in run.axes.iter_mut().zip(axes) {
            axis.push(position.units() as f64 / 16_777_216.0);
        }
        run.places.push(units(tool.place()));
        if next.is_none() && tool.is_done() {
            run.ideal = ideal;
            return run;
        }
    }
    panic!(
        "it does not end: at {:?} of {:?}, velocity {}",
        units(tool.place()),
        units(tool.end()),
        tool.velocity()
    );
}

fn check(name: &str, pieces: &[Piece], feed: f32, join: Join, tolerance: f64) -> Run {
    let mut tool = tool();
    let run = run(&mut tool, pieces, feed, join, |_, _| {});
    report(name, run, &tool, tolerance)
}

fn report(name: &str, run: Run, tool: &Tool, tolerance: f64) -> Run {
    let limits = LIMITS.map(|limit| limit * COUNTS_PER_UNIT);
    let deviation = run.ideal.deviation(&run.places);
    println!(
        "{name}: {} cycles, deviation {deviation:.4} of {tolerance}",
        run.axes[0].len()
    );
    let shares = judge(name, &run.axes, &[limits; 3], 0.002);
    println!("   shares {shares:.3?}");
    assert!(deviation <= tolerance, "{name}: {deviation}");
    let end = run.places.last().unwrap();
    let target = run.ideal.points.last().unwrap();
    assert!(
        (0..3).all(|axis| (end[axis] - target[axis]).abs() < 0.01),
        "{end:?} {target:?}"
    );
    assert!(tool.is_at_rest());
    run
}

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

#[test]
fn debug_slot() {
    let slot = [
        Piece::Line([40_000.0, 0.0, 0.0]),
        Piece::Arc([40_000.0, 10_000.0], 0.5, [40_000.0, 20_000.0, 0.0]),
        Piece::Line([0.0, 20_000.0, 0.0]),
        Piece::Arc([0.0, 10_000.0], 0.5, [0.0, 0.0, 0.0]),
    ];
    let mut tool = tool();
    let run = run(&mut tool, &slot, 150.0, Join::Blend(10.0), |_, _| {});
    for k in 932..946 {
        println!(
            "{k} {:?} {:.4}",
            run.places[k],
            run.places[k][0] - run.places[k - 1][0]
        );
    }
}
