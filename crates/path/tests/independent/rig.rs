//! Feeds a path and collects what comes out.

use super::{Ideal, judge};
use path::machine::{Cartesian, Scale};
use path::{Arc, Join, Path};
use trajectory::{Limits, Position};

pub(crate) const COUNTS_PER_UNIT: f64 = 3.2768;
/// 500 mm/s, 2000 mm/s², 40000 mm/s³ in counts of 1/3.2768 µm per cycle.
pub(crate) const LIMITS: [f64; 3] = [500.0, 2.0, 0.04];

fn limits(limits: [f64; 3]) -> Limits {
    let [v, a, j] = limits.map(|limit| (limit * COUNTS_PER_UNIT) as f32);
    Limits::new(v, a, j).unwrap()
}

/// A long queue is prepared many pieces at a time, a short one within the time of a cycle.
pub(crate) const LONG: usize = 256;
pub(crate) const SHORT: usize = 24;

pub(crate) type Tool<const Q: usize> = Path<Cartesian<3>, 3, 3, Q>;

pub(crate) fn tool() -> Tool<LONG> {
    tool_with([LIMITS; 3])
}

/// Limits of each axis in units per cycle.
pub(crate) fn tool_with<const Q: usize>(axes: [[f64; 3]; 3]) -> Tool<Q> {
    let scale = Scale::from_fixed((COUNTS_PER_UNIT * 4_294_967_296.0) as i64).unwrap();
    let machine = Cartesian { scales: [scale; 3] };
    Path::new(machine, axes.map(limits), [Position::ZERO; 3]).unwrap()
}

pub(crate) fn place(units: [f64; 3]) -> [Position; 3] {
    units.map(|unit| Position::from_units((unit * 16_777_216.0).round() as i64))
}

pub(crate) fn units(place: [Position; 3]) -> [f64; 3] {
    place.map(|position| position.units() as f64 / 16_777_216.0)
}

#[derive(Debug, Clone)]
pub(crate) enum Piece {
    Line([f64; 3]),
    Arc([f64; 2], f64, [f64; 3]),
}

pub(crate) struct Run {
    pub(crate) axes: Vec<Vec<f64>>,
    pub(crate) places: Vec<[f64; 3]>,
    pub(crate) ideal: Ideal,
}

/// Feeds the pieces as the queue has room, and collects every cycle.
pub(crate) fn run<const Q: usize>(
    tool: &mut Tool<Q>,
    pieces: &[Piece],
    feed: f32,
    join: Join,
    mut each: impl FnMut(&mut Tool<Q>, usize),
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
    for cycle in 0..400_000 {
        while let Some(piece) = next {
            if !tool.has_room() {
                break;
            }
            feed_one(tool, piece, feed, join, &mut ideal);
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

/// With a long queue and with a short one; returns the run with the long one.
pub(crate) fn check(name: &str, pieces: &[Piece], feed: f32, join: Join, tolerance: f64) -> Run {
    check_with::<SHORT>(name, pieces, feed, join, tolerance);
    check_with::<LONG>(name, pieces, feed, join, tolerance)
}

fn check_with<const Q: usize>(
    name: &str,
    pieces: &[Piece],
    feed: f32,
    join: Join,
    tolerance: f64,
) -> Run {
    let mut tool = tool_with::<Q>([LIMITS; 3]);
    let run = run(&mut tool, pieces, feed, join, |_, _| {});
    report(name, run, &tool, tolerance)
}

pub(crate) fn report<const Q: usize>(name: &str, run: Run, tool: &Tool<Q>, tolerance: f64) -> Run {
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
    let target = run.ideal.end;
    assert!(
        (0..3).all(|axis| (end[axis] - target[axis]).abs() < 0.01),
        "{end:?} {target:?}"
    );
    assert!(tool.is_at_rest());
    run
}

/// The same, stopped after so many cycles, until it stands.
pub(crate) fn run_until<const Q: usize>(
    tool: &mut Tool<Q>,
    pieces: &[Piece],
    feed: f32,
    join: Join,
    at: usize,
) -> Run {
    let mut ideal = Ideal::at(units(tool.end()));
    let mut rest = pieces.iter();
    let mut run = Run {
        axes: vec![vec![0.0]; 3],
        places: vec![units(tool.place())],
        ideal: Ideal::at([0.0; 3]),
    };
    for cycle in 0..100_000 {
        if cycle < at
            && tool.has_room()
            && let Some(piece) = rest.next()
        {
            feed_one(tool, piece, feed, join, &mut ideal);
        }
        if cycle == at {
            tool.stop();
        }
        for (axis, position) in run.axes.iter_mut().zip(tool.advance()) {
            axis.push(position.units() as f64 / 16_777_216.0);
        }
        run.places.push(units(tool.place()));
        if cycle > at && tool.is_at_rest() {
            break;
        }
    }
    run.ideal = ideal;
    run
}

pub(crate) fn feed_one<const Q: usize>(
    tool: &mut Tool<Q>,
    piece: &Piece,
    feed: f32,
    join: Join,
    ideal: &mut Ideal,
) {
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
}
