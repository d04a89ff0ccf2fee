//! Programs, line by line.

use path::Join;
use program::{Action, ErrorKind, Interpreter, Move, ProgramError, Settings};
use trajectory::Position;

const SETTINGS: Settings = Settings {
    axes: [true; 3],
    start: [Position::ZERO; 3],
    home: [
        Position::from_counts(-1_000),
        Position::ZERO,
        Position::from_counts(5_000),
    ],
    rapid_um_per_min: 12e6,
    tolerance_um: 10.0,
};

fn run(lines: &[&str]) -> Result<Vec<Action>, ProgramError> {
    let mut program = Interpreter::new(SETTINGS);
    let mut actions = Vec::new();
    for line in lines {
        actions.extend(program.line(line)?);
    }
    Ok(actions)
}

fn um(place: [f64; 3]) -> [Position; 3] {
    place.map(|um| Position::from_units((um * 16_777_216.0).round() as i64))
}

/// The moves: end in micrometres, sweep in turns for an arc, and feed.
fn moves(lines: &[&str]) -> Vec<([f64; 3], f64, f32)> {
    let of = |action| match action {
        Action::Move {
            path,
            feed_um_per_min,
            ..
        } => {
            let (end, sweep) = match path {
                Move::Line(end) => (end, 0.0),
                Move::Arc(arc) => (arc.end, arc.sweep as f64 / 4_294_967_296.0),
            };
            Some((
                end.map(|place| place.units() as f64 / 16_777_216.0),
                sweep,
                feed_um_per_min,
            ))
        }
        _ => None,
    };
    run(lines).unwrap().into_iter().filter_map(of).collect()
}

#[test]
fn modes_stay() {
    assert_eq!(
        moves(&[
            "%",
            "N10 G21 G90 (start)",
            "g1 x10 y-2.5 f600 ; to the corner",
            "Y5",
            "G91",
            "X1 Z-.5",
            "G20 G90 X1",
            "G0 X0"
        ]),
        [
            ([10_000.0, -2_500.0, 0.0], 0.0, 600_000.0),
            ([10_000.0, 5_000.0, 0.0], 0.0, 600_000.0),
            ([11_000.0, 5_000.0, -500.0], 0.0, 600_000.0),
            ([25_400.0, 5_000.0, -500.0], 0.0, 600_000.0),
            ([0.0, 5_000.0, -500.0], 0.0, 12e6),
        ]
    );
}

#[test]
fn arcs_turn_in_their_planes() {
    // A quarter from (10, 0) around the origin, both ways, and the whole.
    let sweep = |line: &str| moves(&["G1 F100 X10", line])[1].1;
    assert_eq!(sweep("G3 X0 Y10 I-10 J0"), 0.25);
    assert_eq!(sweep("G2 X0 Y10 I-10"), -0.75);
    assert_eq!(sweep("G3 I-10"), 1.0);
    assert_eq!(sweep("G2 X10 Y0 I-10"), -1.0);
    assert_eq!(sweep("G3 X0 Y10 R10"), 0.25);
    assert_eq!(sweep("G3 X0 Y10 R-10"), 0.75);
    assert_eq!(sweep("G2 X0 Y10 R10"), -0.25);
    assert_eq!(sweep("G3 X-10 Y0 R10"), 0.5);
    // ZX: from Z to X.
    assert_eq!(sweep("G18 G3 X0 Z-10 I-10"), 0.25);
    assert_eq!(moves(&["G1 F100 Y10", "G19 G3 Y0 Z10 J-10 X3"])[1].1, 0.25);
    let Some(Action::Move {
        path: Move::Arc(arc),
        ..
    }) = run(&["G1 F100 X10", "G3 X0 Y10 R-10"]).unwrap().pop()
    else {
        panic!("expected an arc");
    };
    assert_eq!(arc.plane, (0, 1));
    assert_eq!(arc.centre.map(Position::wide_counts), [10_000, 10_000]);
}

#[test]
fn joins_dwells_homes_and_ends() {
    let actions = run(&[
        "G64 P0.02 G1 X1 F60",
        "G61 X2",
        "G64 X3",
        "G4 P1.5",
        "M0",
        "G28 X7",
        "G28",
        "M2",
        "G99 ...",
    ])
    .unwrap();
    let joins: Vec<Join> = actions
        .iter()
        .filter_map(|action| match action {
            Action::Move { join, .. } => Some(*join),
            _ => None,
        })
        .collect();
    assert_eq!(
        joins[..3],
        [Join::Blend(20.0), Join::Exact, Join::Blend(10.0)]
    );
    assert_eq!(actions[3..5], [Action::Dwell { ms: 1_500 }, Action::Pause]);
    let ends: Vec<_> = actions[5..8]
        .iter()
        .map(|action| match action {
            Action::Move {
                path: Move::Line(end),
                ..
            } => *end,
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(
        ends,
        [
            um([7_000.0, 0.0, 0.0]),
            um([-1_000.0, 0.0, 0.0]),
            um([-1_000.0, 0.0, 5_000.0])
        ]
    );
    assert_eq!(actions[8..], [Action::End]);
}

#[test]
fn errors_name_line_and_column() {
    let of = |lines: &[&str]| {
        let error = run(lines).unwrap_err();
        (error.line, error.column, error.kind)
    };
    let unknown = |letter, actual_tenths| ErrorKind::UnknownCode {
        letter,
        actual_tenths,
    };
    assert_eq!(of(&["G0 X1", "", "G0 X1 G5"]), (3, 7, unknown('G', 50)));
    assert_eq!(of(&["G38.2 X1"]), (1, 1, unknown('G', 382)));
    assert_eq!(of(&["M3"]), (1, 1, unknown('M', 30)));
    // As the number of tenths in 32 bits it would be G0.4.
    assert!(matches!(
        of(&["G429496730 X1"]),
        (1, 1, ErrorKind::Number { letter: 'G' })
    ));
    assert_eq!(
        of(&["G1 X1 S100"]),
        (1, 7, ErrorKind::UnknownLetter { actual: 'S' })
    );
    assert_eq!(of(&["G0 X1 X2"]), (1, 7, ErrorKind::Twice { letter: 'X' }));
    assert_eq!(
        of(&["G0 G1 X2"]),
        (
            1,
            4,
            ErrorKind::Conflict {
                letter: 'G',
                actual: (0, 1)
            }
        )
    );
    assert_eq!(of(&["X1"]), (1, 1, ErrorKind::NoMotion));
    assert_eq!(of(&["G1 X1"]), (1, 4, ErrorKind::NoFeed));
    assert_eq!(of(&["F0"]), (1, 1, ErrorKind::Feed));
    assert_eq!(of(&["G0 X1 I2"]), (1, 7, ErrorKind::Unused { letter: 'I' }));
    assert_eq!(of(&["G0 X"]), (1, 4, ErrorKind::Number { letter: 'X' }));
    assert_eq!(
        of(&["G0 X1.2.3"]),
        (1, 4, ErrorKind::Number { letter: 'X' })
    );
    assert_eq!(of(&["G0 X1 (open"]), (1, 7, ErrorKind::OpenComment));
    assert_eq!(
        of(&["/G0 X1"]),
        (1, 1, ErrorKind::Character { actual: '/' })
    );
    assert_eq!(
        of(&["G0 X1 = 3"]),
        (1, 7, ErrorKind::Character { actual: '=' })
    );
    assert_eq!(of(&["G0 X300000"]), (1, 4, ErrorKind::Far));
    assert_eq!(of(&["G91 G0 X200000", "X200000"]), (2, 1, ErrorKind::Far));
    assert_eq!(of(&["G4"]), (1, 1, ErrorKind::Dwell));
    assert_eq!(of(&["G4 P-1"]), (1, 4, ErrorKind::Dwell));
    assert_eq!(of(&["G64 P0"]), (1, 5, ErrorKind::Tolerance));
    assert_eq!(of(&["G2 F1 X1"]), (1, 7, ErrorKind::ArcForm));
    assert_eq!(of(&["G2 F1 X1 R1 I1"]), (1, 7, ErrorKind::ArcForm));
    assert_eq!(of(&["G2 F1 R1"]), (1, 7, ErrorKind::ArcClosed));
    assert!(matches!(
        of(&["G2 F1 X10 R4"]),
        (1, 11, ErrorKind::ArcRadius { .. })
    ));
    assert!(matches!(
        of(&["G2 F1 X10 I4"]),
        (1, 7, ErrorKind::ArcCentre { .. })
    ));
    assert!(matches!(
        of(&[&"X".repeat(300)]),
        (1, 256, ErrorKind::Long { actual: 300 })
    ));
    // Beyond what a path can have, and beyond what 64 bits hold of 2^-24 um.
    for radius in ["R268500", "R-268500", "R999999999", "R-999999999"] {
        let line = format!("G2 F1 X10 {radius}");
        assert_eq!(of(&[&line]), (1, 11, ErrorKind::Far), "{radius}");
    }
    assert_eq!(of(&["G20 G3 F1 X10 R10600"]), (1, 15, ErrorKind::Far));
    let error = run(&["G0 X1", "G5 X1"]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "line 2, column 1: G5 is not known: expected G0 to G4, G17 to G21, G28, G61, G64, G90, G91, M0, M2 or M30"
    );
}

#[test]
fn a_line_that_is_refused_changes_nothing() {
    let mut program = Interpreter::new(SETTINGS);
    program.line("G1 X1 F100").unwrap();
    let before = program.place();
    assert!(program.line("G20 G91 X5 Q1").is_err());
    assert_eq!(program.place(), before);
    let actions: Vec<_> = program.line("X2").unwrap().into_iter().collect();
    assert!(
        matches!(actions[..], [Action::Move { path: Move::Line(end), .. }] if end == um([2_000.0, 0.0, 0.0]))
    );
}

/// The tool may be told to be anywhere: what is beyond every machine is refused, in both directions.
#[test]
fn a_start_at_the_end_of_64_bits_is_too_far() {
    for (units, line) in [(i64::MAX - 5, "G91 G0 X1"), (i64::MIN + 5, "G91 G0 X-1")] {
        let mut program = Interpreter::new(Settings {
            start: [Position::from_units(units), Position::ZERO, Position::ZERO],
            ..SETTINGS
        });
        let refused = program.line(line).unwrap_err();
        assert_eq!(refused.kind, ErrorKind::Far, "{line}");
    }
}

#[test]
fn a_dwell_of_whole_milliseconds_is_no_longer() {
    let dwell = |text: &str| {
        let [Action::Dwell { ms }] = run(&[text]).unwrap()[..] else {
            panic!("{text}");
        };
        ms
    };
    for ms in 0..=36_000 {
        let text = format!("G4 P{}.{:03}", ms / 1_000, ms % 1_000);
        assert_eq!(dwell(&text), ms, "{text}");
    }
    // Part of one is a whole one.
    assert_eq!(dwell("G4 P0.000000001"), 1);
    assert_eq!(dwell("G4 P1.0000001"), 1_001);
    assert_eq!(dwell("G4 P3600"), 3_600_000);
    assert!(run(&["G4 P3600.000000001"]).is_err());
}

#[test]
fn the_longer_arc_of_a_tiny_way_is_nearly_a_circle() {
    for (code, sign) in [("G2", -1.0), ("G3", 1.0)] {
        for way in ["X0.0000001", "X-0.000001", "Y0.00001", "Y-0.001", "X1 Y2"] {
            for radius in ["-10", "-1000", "-268000"] {
                let line = format!("{code} F100 {way} R{radius}");
                let sweep = moves(&[&line])[0].1 * sign;
                assert!((0.9..=1.0).contains(&sweep), "{line}: {sweep}");
                let line = line.replace("R-", "R");
                let sweep = moves(&[&line])[0].1 * sign;
                assert!((0.0..0.1).contains(&sweep), "{line}: {sweep}");
            }
        }
    }
}
