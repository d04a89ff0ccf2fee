//! Paths of three axes, cycle by cycle, with the figures of each call.

use core::hint::black_box;

use path::machine::{Cartesian, Scale};
use path::{Arc, Join, Path};
use trajectory::{Limits, Position};

use crate::trajectory::{Figure, Numbers};

/// Pieces of the queue.
const QUEUE: usize = 32;
/// Cycles of each kind of path.
const CYCLES: u32 = 30_000;

type Tool = Path<Cartesian<3>, 3, 3, QUEUE>;

/// Cycles: preparation, planning, front, average, set-points.
pub static FIGURE_PATH_CYCLE: Figure = Figure::new();
/// A new piece: checked and kept.
pub static FIGURE_PATH_PIECE: Figure = Figure::new();
/// Cycles that also take a new piece.
pub static FIGURE_PATH_BOTH: Figure = Figure::new();

/// The kinds of paths.
#[derive(Clone, Copy)]
enum Kind {
    LongLines,
    ShortLines,
    Arcs,
    Helices,
    Chords,
    TinyArcs,
    Stops,
    Mixed,
}

/// Of the random numbers: paths of every kind with each.
const SEEDS: [u32; 4] = [0x2468_ACE1, 0x1357_9BDF, 0x0BAD_CAFE, 0x7654_3210];

/// Runs paths of every kind. `counter` is the number of instructions so far.
pub fn exercise(counter: fn() -> u32) {
    for seed in SEEDS {
        exercise_with(seed, counter);
    }
}

fn exercise_with(seed: u32, counter: fn() -> u32) {
    let mut numbers = Numbers::new(seed);
    let nothing = {
        let before = counter();
        counter().wrapping_sub(before)
    };
    for kind in [
        Kind::LongLines,
        Kind::ShortLines,
        Kind::Arcs,
        Kind::Helices,
        Kind::Chords,
        Kind::TinyArcs,
        Kind::Stops,
        Kind::Mixed,
    ] {
        let Some(mut tool) = tool() else { return };
        for cycle in 0..CYCLES {
            if cycle % 512 == 100 {
                tool.pause();
            }
            if cycle % 512 == 200 {
                tool.resume();
            }
            if cycle % 128 == 64 {
                tool.set_override(if cycle % 256 == 64 { 40 } else { 100 });
            }
            let start = counter();
            let takes = tool.has_room() && cycle % 3 != 0;
            if takes {
                add(&mut tool, kind, &mut numbers);
            }
            let added = counter();
            black_box(black_box(&mut tool).advance());
            let end = counter();
            FIGURE_PATH_CYCLE.add(end.wrapping_sub(added).wrapping_sub(nothing));
            if takes {
                FIGURE_PATH_PIECE.add(added.wrapping_sub(start).wrapping_sub(nothing));
                FIGURE_PATH_BOTH.add(end.wrapping_sub(start).wrapping_sub(nothing));
            }
        }
    }
}

/// 500 mm/s, 5 m/s², 100 m/s³ with 3.3 counts per micrometre, 1 kHz.
fn tool() -> Option<Tool> {
    let limits = Limits::new(1_650.0, 16.5, 0.33).ok()?;
    let scale = Scale::from_fixed(14_173_392_077).ok()?;
    let machine = Cartesian { scales: [scale; 3] };
    Path::new(machine, [limits; 3], [Position::ZERO; 3]).ok()
}

fn add(tool: &mut Tool, kind: Kind, numbers: &mut Numbers) {
    let kind = match kind {
        Kind::Mixed => match numbers.next() % 7 {
            0 => Kind::LongLines,
            1 => Kind::ShortLines,
            2 => Kind::Arcs,
            3 => Kind::Chords,
            4 => Kind::TinyArcs,
            5 => Kind::Stops,
            _ => Kind::Helices,
        },
        kind => kind,
    };
    let [x, y, z] = tool.end();
    let mut moved = |size: i32| {
        let offset = (numbers.share() * size as f32) as i32;
        Position::from_counts(offset)
    };
    // Refused only when the queue is full.
    let _ = match kind {
        Kind::LongLines => {
            let end = [moved(60_000), moved(60_000), moved(20_000)];
            tool.line(end, 300.0, Join::Blend(50.0))
        }
        Kind::ShortLines | Kind::Mixed => {
            let end = [
                x.moved_by(moved(200)),
                y.moved_by(moved(200)),
                z.moved_by(moved(50)),
            ];
            tool.line(end, 300.0, Join::Blend(10.0))
        }
        Kind::Chords => {
            let end = [
                x.moved_by(Position::from_counts(20)),
                y.moved_by(moved(2)),
                z.moved_by(moved(2)),
            ];
            tool.line(end, 300.0, Join::Blend(5.0))
        }
        Kind::Stops => {
            let end = [x.moved_by(moved(400)), y.moved_by(moved(400)), z];
            tool.line(end, 300.0, Join::Rest)
        }
        Kind::Arcs | Kind::Helices | Kind::TinyArcs => {
            let size = if matches!(kind, Kind::TinyArcs) {
                60
            } else {
                8_000
            };
            let offset = [moved(size), moved(size)];
            let lift = if matches!(kind, Kind::Helices) {
                moved(3_000)
            } else {
                Position::ZERO
            };
            // Half a turn: the end is opposite of the start.
            let opposite =
                |from: Position, offset: Position| from.moved_by(offset).moved_by(offset);
            let arc = Arc {
                plane: (0, 1),
                centre: [x.moved_by(offset[0]), y.moved_by(offset[1])],
                sweep: 1 << 31,
                end: [
                    opposite(x, offset[0]),
                    opposite(y, offset[1]),
                    z.moved_by(lift),
                ],
            };
            tool.arc(&arc, 300.0, Join::Blend(50.0))
        }
    };
}
