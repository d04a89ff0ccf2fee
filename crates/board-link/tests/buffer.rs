//! What a buffer takes, what it refuses and with which numbers, where it goes, and what it does when nothing comes any more.

use board_link::{AxisLimits, Config, Phase, Refusal, SetPointBuffer, WhenDry};
use trajectory::{Limits, Position, Time};

type Buffer = SetPointBuffer<2, 128>;

const CONFIG: Config = Config::with_cycles_per_second(1_000);
const WAITING: Config = Config {
    when_dry: WhenDry::Wait,
    ..CONFIG
};

fn limits() -> AxisLimits {
    AxisLimits {
        motion: Limits::new(100.0, 1.5, 0.3).unwrap(),
        lowest: Position::from_counts(-100_000),
        highest: Position::from_counts(100_000),
    }
}

fn buffer(config: Config) -> Buffer {
    let stand = [1_000, -500].map(Position::from_counts);
    Buffer::new(&[limits(); 2], &stand, config).unwrap()
}

fn push(buffer: &mut Buffer, cycles: u32, counts: [i32; 2]) -> Result<(), Refusal> {
    let positions = counts.map(Position::from_counts);
    buffer.push(Time::from_cycles(cycles), &positions)
}

/// A sine of 600 counts in 1.2 s on one axis, and half of it on the other, from where they stand, in whole counts.
fn sine(cycle: u32) -> [i32; 2] {
    let angle = core::f64::consts::TAU * f64::from(cycle) / 1_200.0;
    let way = 600.0 * (1.0 - angle.cos());
    [
        1_000 + way.round() as i32,
        -500 + (way / 2.0).round() as i32,
    ]
}

/// Plays until something else happens; returns the phase, the counts and the cycles that it took.
fn play(buffer: &mut Buffer, phase: Phase) -> (Phase, [i32; 2], u32) {
    let mut positions = [Position::ZERO; 2];
    for cycles in 1..1_000_000 {
        let now = buffer.advance(&mut positions);
        if now != phase {
            return (now, positions.map(Position::counts), cycles);
        }
    }
    panic!("nothing happens: {:?}", buffer.phase());
}

#[test]
fn every_refusal_says_what_was_expected_and_moves_nothing() {
    let mut buffer = buffer(CONFIG);
    let at = Position::from_counts;
    let refused = |buffer: &mut Buffer, cycles, counts| push(buffer, cycles, counts).unwrap_err();
    assert!(matches!(
        buffer.push(Time::ZERO, &[Position::ZERO; 3]),
        Err(Refusal::Axes {
            expected: 2,
            actual: 3
        })
    ));
    let error = refused(&mut buffer, 5, [1_000, -498]);
    let expected = Refusal::Start {
        axis: 1,
        expected: at(-500),
        actual: at(-498),
    };
    assert_eq!(error, expected);
    assert!(matches!(
        refused(&mut buffer, 5, [100_001, -500]),
        Refusal::Travel { axis: 0, .. }
    ));
    // A count is no distance, and the axis starts where it stands all the same.
    push(&mut buffer, 5, [1_001, -500]).unwrap();
    assert!(matches!(
        refused(&mut buffer, 5, [1_000, -500]),
        Refusal::Past { .. }
    ));
    push(&mut buffer, 25, [1_000, -500]).unwrap();
    let error = refused(&mut buffer, 20, [1_000, -500]);
    let (expected, actual) = (Time::from_cycles(25), Time::from_cycles(20));
    assert_eq!(error, Refusal::Order { expected, actual });
    let close = buffer.push(Time::from_units(25_400, 1_000), &[at(1_000), at(-500)]);
    assert!(matches!(close, Err(Refusal::Close { .. })));
    let error = refused(&mut buffer, 10_026, [1_000, -500]);
    let (expected, actual) = (Time::from_cycles(10_025), Time::from_cycles(10_026));
    assert_eq!(error, Refusal::Ahead { expected, actual });
    let error = refused(&mut buffer, 45, [1_000, -2_700]);
    assert!(
        matches!(error, Refusal::Velocity { axis: 1, expected, actual } if expected == 100.05 && actual == 110.0),
        "{error:?}"
    );
    push(&mut buffer, 45, [1_000, -500]).unwrap();
    let error = refused(&mut buffer, 65, [1_500, -500]);
    assert!(
        matches!(error, Refusal::Acceleration { axis: 0, expected, actual } if expected < 1.1 && actual > 1.2),
        "{error:?}"
    );
    let numbers = [1, 2, 3, 4, 5, 6, 7, 8, 9];
    for number in numbers {
        assert_eq!(buffer.counters().refused[number], 1, "number {number}");
    }
    assert_eq!(
        (buffer.counters().taken, buffer.counters().refused_in_all()),
        (3, 9)
    );
    buffer.end();
    assert_eq!(refused(&mut buffer, 65, [1_000, -500]), Refusal::Ended);
    let mut positions = [Position::ZERO; 2];
    while buffer.advance(&mut positions) == Phase::Moving {
        assert_eq!(positions, [at(1_000), at(-500)]);
    }
    assert_eq!(buffer.phase(), Phase::Complete);
}

#[test]
fn a_jerk_beyond_the_limit_is_refused() {
    let jerky = AxisLimits {
        motion: Limits::new(100.0, 1.5, 0.01).unwrap(),
        ..limits()
    };
    let mut buffer = Buffer::new(&[jerky; 2], &[Position::ZERO; 2], CONFIG).unwrap();
    let mut taken = Ok(());
    for (cycle, counts) in [(0, 0), (20, 0), (40, 0), (60, 200), (80, 600)] {
        taken = taken.and_then(|()| push(&mut buffer, cycle, [counts, 0]));
    }
    assert!(
        matches!(taken, Err(Refusal::Jerk { axis: 0, .. })),
        "{taken:?}"
    );
}

#[test]
fn nothing_moves_before_enough_is_there() {
    let mut buffer = buffer(CONFIG);
    let mut positions = [Position::ZERO; 2];
    for point in 0..16 {
        push(&mut buffer, 20 * point, sine(20 * point)).unwrap();
        assert_eq!(buffer.advance(&mut positions), Phase::Waiting);
        assert_eq!(positions.map(Position::counts), [1_000, -500]);
    }
    push(&mut buffer, 320, sine(320)).unwrap();
    assert_eq!(buffer.advance(&mut positions), Phase::Moving);
}

#[test]
fn whole_counts_in_every_cycle_are_no_acceleration() {
    // The room is for less than it takes to slow down, so this is slow at times, and nothing is lost.
    let mut buffer = buffer(CONFIG);
    let mut positions = [Position::ZERO; 2];
    let mut cycle = 0;
    while cycle <= 1_200 || !matches!(buffer.phase(), Phase::Complete) {
        while cycle <= 1_200 && buffer.credit() > 0 {
            push(&mut buffer, cycle, sine(cycle)).unwrap();
            cycle += 1;
        }
        if cycle > 1_200 {
            buffer.end();
        }
        buffer.advance(&mut positions);
    }
    assert_eq!(positions.map(Position::counts), [1_000, -500]);
    assert_eq!((buffer.counters().taken, buffer.counters().dry), (1_201, 0));
}

#[test]
fn an_acceleration_that_lasts_is_no_rounding() {
    // 1.4 counts per cycle² of 1.0, in whole counts, each cycle: between two of them rounding could be as much.
    let mut buffer = buffer(CONFIG);
    let taken = (0..70).find_map(|cycle: i32| {
        let way = 7 * cycle * cycle / 10;
        push(&mut buffer, cycle as u32, [1_000 + way, -500]).err()
    });
    assert!(
        matches!(taken, Some(Refusal::Acceleration { axis: 0, expected, actual }) if expected < 1.01 && actual > 1.3),
        "{taken:?}"
    );
}

#[test]
fn when_nothing_comes_the_axes_come_to_rest_at_the_last_set_point() {
    for (config, end) in [(CONFIG, Phase::DriedUp), (WAITING, Phase::Dry)] {
        let mut buffer = buffer(config);
        for point in 0..=20 {
            push(&mut buffer, 20 * point, sine(20 * point)).unwrap();
        }
        assert_eq!(play(&mut buffer, Phase::Waiting).0, Phase::Moving);
        let (phase, counts, _) = play(&mut buffer, Phase::Moving);
        assert_eq!((phase, counts, buffer.counters().dry), (end, sine(400), 1));
        let late = push(&mut buffer, 420, sine(420));
        if end == Phase::DriedUp {
            let (expected, actual) = (Time::from_cycles(400), Time::from_cycles(420));
            assert_eq!(late, Err(Refusal::Late { expected, actual }));
            continue;
        }
        late.unwrap();
        for point in 22..=60 {
            push(&mut buffer, 20 * point, sine(20 * point)).unwrap();
        }
        buffer.end();
        assert_eq!(play(&mut buffer, Phase::Dry).0, Phase::Moving);
        let (phase, counts, _) = play(&mut buffer, Phase::Moving);
        assert_eq!((phase, counts), (Phase::Complete, sine(1_200)));
    }
}

#[test]
fn a_silence_within_what_is_buffered_costs_nothing() {
    let mut buffer = buffer(CONFIG);
    let mut positions = [Position::ZERO; 2];
    let mut point = 0;
    let mut cycle = 0;
    while buffer.phase() != Phase::Complete {
        // A sender that is silent for 50 ms again and again.
        if cycle % 100 < 50 {
            while point <= 300 && buffer.credit() > 0 {
                push(&mut buffer, 20 * point, sine(20 * point)).unwrap();
                point += 1;
            }
        }
        if point > 300 {
            buffer.end();
        }
        buffer.advance(&mut positions);
        cycle += 1;
        assert!(cycle < 7_000);
    }
    // 6 s, and what the start takes.
    assert!(cycle < 6_500, "{cycle}");
    assert_eq!((buffer.counters().taken, buffer.counters().dry), (301, 0));
}

#[test]
fn a_stop_ends_on_the_way_and_a_full_buffer_says_so() {
    let mut buffer = buffer(CONFIG);
    let mut point = 0;
    while push(&mut buffer, 20 * point, sine(20 * point)).is_ok() {
        point += 1;
    }
    assert_eq!(
        (point, buffer.free(), buffer.counters().refused[11]),
        (128, 0, 1)
    );
    assert_eq!(play(&mut buffer, Phase::Waiting).0, Phase::Moving);
    let mut positions = [Position::ZERO; 2];
    for _ in 0..600 {
        buffer.advance(&mut positions);
    }
    buffer.stop();
    let (phase, counts, cycles) = play(&mut buffer, Phase::Moving);
    assert_eq!(phase, Phase::Stopped);
    assert!(cycles < 1_000, "{cycles}");
    // The second axis does half of what the first one does: on the path.
    assert!(
        (counts[0] - 1_000 - 2 * (counts[1] + 500)).abs() <= 2,
        "{counts:?}"
    );
    assert!(matches!(
        push(&mut buffer, 20 * point, [1_000, -500]),
        Err(Refusal::Ended)
    ));
}

/// Position in counts of the curve through the set-points, computed anew with floats.
fn curve(points: &[(f64, f64)], time: f64) -> f64 {
    let place = points.windows(2).position(|pair| time < pair[1].0);
    let Some(place) = place else {
        return points[points.len() - 1].1;
    };
    let chord = |at: usize| (points[at + 1].1 - points[at].1) / (points[at + 1].0 - points[at].0);
    let slope = |at: usize| {
        if at == 0 || at + 1 == points.len() {
            return (0.0, 0.0);
        }
        let (left, right) = (
            points[at].0 - points[at - 1].0,
            points[at + 1].0 - points[at].0,
        );
        let bend = 2.0 * (chord(at) - chord(at - 1)) / (left + right);
        (chord(at - 1) + bend * left / 2.0, bend)
    };
    let ((v0, a0), (v1, a1)) = (slope(place), slope(place + 1));
    let ((t0, p0), (t1, p1)) = (points[place], points[place + 1]);
    let (h, u) = (t1 - t0, (time - t0) / (t1 - t0));
    // As a Bézier curve: another way to the same polynomial.
    let b = [
        p0,
        p0 + h * v0 / 5.0,
        p0 + 2.0 * h * v0 / 5.0 + h * h * a0 / 20.0,
        p1 - 2.0 * h * v1 / 5.0 + h * h * a1 / 20.0,
        p1 - h * v1 / 5.0,
        p1,
    ];
    let mut b = b.to_vec();
    while b.len() > 1 {
        b = b
            .windows(2)
            .map(|pair| pair[0] * (1.0 - u) + pair[1] * u)
            .collect();
    }
    b[0]
}

#[test]
fn the_path_is_the_same_at_any_speed() {
    let times: Vec<u32> = (0..60)
        .map(|point: u32| 25 * point + (7 * point) % 11)
        .collect();
    let points: Vec<(f64, f64)> = times
        .iter()
        .map(|&time| (f64::from(time), f64::from(sine(time)[0])))
        .collect();
    for percent in [10, 50, 100, 200] {
        let mut buffer = buffer(CONFIG);
        buffer.set_override(percent).unwrap();
        for &time in &times {
            push(&mut buffer, time, sine(time)).unwrap();
        }
        buffer.end();
        let mut positions = [Position::ZERO; 2];
        let mut highest = 0.0_f32;
        while buffer.advance(&mut positions) != Phase::Complete {
            let time = buffer.time().ticks() as f64 / f64::from(u32::MAX);
            let exact = positions[0].units() as f64 / Position::UNITS as f64;
            assert!(
                (exact - curve(&points, time)).abs() < 0.01,
                "{percent} % at {time}"
            );
            highest = highest.max(buffer.percent());
        }
        assert!(
            (highest - f32::from(percent)).abs() < 1.0,
            "{highest} of {percent} %"
        );
    }
    assert!(buffer(CONFIG).set_override(201).is_err());
}

#[test]
fn a_buffer_needs_axes_that_fit() {
    assert!(Buffer::new(&[], &[], CONFIG).is_none());
    assert!(Buffer::new(&[limits(); 3], &[Position::ZERO; 3], CONFIG).is_none());
    assert!(Buffer::new(&[limits(); 2], &[Position::ZERO; 1], CONFIG).is_none());
}

/// Any order of calls with any values: nothing panics, and nothing moves but within its travel.
#[test]
fn random_calls_panic_nowhere() {
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state
    };
    for _ in 0..200 {
        let mut buffer = buffer(if random() % 2 == 0 { CONFIG } else { WAITING });
        let mut positions = [Position::ZERO; 2];
        for _ in 0..3_000 {
            match random() % 16 {
                0 => buffer.pause(),
                1 => buffer.resume(),
                2 => drop(buffer.set_override((random() % 300) as u16)),
                3 if random() % 200 == 0 => buffer.end(),
                4 if random() % 200 == 0 => buffer.stop(),
                5 => drop(buffer.push(
                    Time::from_ticks(random()),
                    &[random(), random()].map(|units| Position::from_units(units as i64)),
                )),
                6..11 => {
                    let last = buffer.last_time().unwrap_or_default();
                    let time = last.after(Time::from_ticks(random() >> 27));
                    let counts = [1_000, -500].map(|at| at + (random() % 3) as i32 - 1);
                    let _ = buffer.push(time, &counts.map(Position::from_counts));
                }
                _ => drop(buffer.advance(&mut positions)),
            }
        }
        buffer.advance(&mut positions);
        for position in positions {
            assert!(position.wide_counts().abs() <= 100_000);
        }
    }
}
