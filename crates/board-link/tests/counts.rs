//! The same streams played in positions and in whole counts: in each cycle the counts are the rounded positions, whatever is ordered.

use board_link::segment::{
    Admission, AxisSegment, Begin, Player, Segment, SegmentConfig, SegmentQueue, Shape, StreamPhase,
};
use board_link::{AxisLimits, Reason, WhenDry};
use proptest::prelude::*;
use trajectory::{Limits, Position, Time};

const AXES: usize = 3;
/// One axis fewer than there is room for.
const USED: usize = 2;
type Queue = SegmentQueue<AXES, 17>;

#[derive(Debug, Clone)]
enum Step {
    Begin { dry: WhenDry, percent: u16 },
    Push(Piece),
    Run(u16),
    Override(u16),
    Pause,
    Resume,
    Stop,
    End,
    Halt,
}

/// A segment of constant acceleration; velocities in counts a cycle at its end.
#[derive(Debug, Clone)]
struct Piece {
    ticks: u64,
    velocities: [f64; USED],
    is_fifth_degree: bool,
}

fn piece() -> impl Strategy<Value = Piece> {
    let velocity = prop_oneof![1 => Just(0.0), 3 => -40.0..40.0_f64];
    let ticks = prop_oneof![
        3 => (8..60_u64).prop_map(|cycles| cycles << 32),
        2 => (8_u64 << 32)..(200_u64 << 32),
    ];
    let rest = prop_oneof![1 => Just(true), 3 => Just(false)];
    (ticks, [velocity.clone(), velocity], rest, any::<bool>()).prop_map(
        |(ticks, velocities, rests, is_fifth_degree)| Piece {
            ticks,
            velocities: if rests { [0.0; USED] } else { velocities },
            is_fifth_degree,
        },
    )
}

fn step() -> impl Strategy<Value = Step> {
    let dry = prop_oneof![Just(WhenDry::End), Just(WhenDry::Wait)];
    let percent = prop_oneof![Just(100), 0..=200_u16];
    prop_oneof![
        3 => (dry, percent.clone()).prop_map(|(dry, percent)| Step::Begin { dry, percent }),
        40 => piece().prop_map(Step::Push),
        30 => (1..120_u16).prop_map(Step::Run),
        4 => percent.prop_map(Step::Override),
        2 => Just(Step::Pause),
        4 => Just(Step::Resume),
        1 => Just(Step::Stop),
        2 => Just(Step::End),
        1 => Just(Step::Halt),
    ]
}

/// Where the segments that were taken end, and how fast.
#[derive(Debug, Clone, Copy, Default)]
struct End {
    at: [f64; USED],
    velocities: [f64; USED],
}

fn units(counts: f64) -> i64 {
    (counts * Position::UNITS as f64).round() as i64
}

impl End {
    fn segment(&self, piece: &Piece) -> (Segment, Self) {
        let cycles = piece.ticks as f64 / (1_u64 << 32) as f64;
        let mut end = Self {
            velocities: piece.velocities,
            ..*self
        };
        let axes = (0..USED).map(|axis| {
            let (from, to) = (self.velocities[axis], piece.velocities[axis]);
            end.at[axis] += (from + to) / 2.0 * cycles;
            let (leaving, arriving) = (units(from * cycles), units(to * cycles));
            AxisSegment {
                end: units(end.at[axis]),
                shape: if piece.is_fifth_degree {
                    Shape::Quintic {
                        leaving,
                        arriving,
                        leaving_acceleration: 0,
                        arriving_acceleration: 0,
                    }
                } else {
                    Shape::Cubic { leaving, arriving }
                },
            }
        });
        let segment = Segment {
            duration: piece.ticks,
            axes: axes.collect(),
        };
        (segment, end)
    }
}

/// A board, and what its host knows.
struct Side<'q> {
    admission: Admission<'q, AXES>,
    player: Player<'q, AXES>,
}

impl<'q> Side<'q> {
    fn new(queue: &'q mut Queue) -> Self {
        let limits = AxisLimits {
            motion: Limits::without_jerk(200.0, 60.0).unwrap(),
            lowest: Position::from_counts(-(1 << 29)),
            highest: Position::from_counts(1 << 29),
        };
        let config = SegmentConfig {
            lead: Time::from_cycles(20),
            ..SegmentConfig::with_cycles_per_second(1_000)
        };
        let (admission, player) = queue.split(&[limits; USED], config).unwrap();
        Self { admission, player }
    }
}

#[derive(Debug, Default)]
struct Host {
    stream: u32,
    index: u32,
    end: End,
    now: u64,
    stand: [i32; USED],
    set_points: u32,
}

impl Host {
    /// An order to one side; both must answer alike.
    fn order(&self, side: &mut Side<'_>, step: &Step) -> Result<(), Option<Reason>> {
        let admission = &mut side.admission;
        let done = match step {
            Step::Begin { dry, percent } => {
                let stand = self.stand.map(Position::from_counts);
                let begin = Begin {
                    stream: self.stream + 1,
                    start: None,
                    when_dry: *dry,
                    percent: *percent,
                    from: stand.iter().map(|at| at.units()).collect(),
                };
                admission.begin(&begin, &stand, self.now)
            }
            Step::Push(piece) => {
                let (segment, _) = self.end.segment(piece);
                admission.push(self.stream, self.index, &segment)
            }
            Step::Override(percent) => admission.set_override(*percent),
            Step::Pause => admission.pause(),
            Step::Resume => admission.resume(),
            Step::Stop => admission.stop(),
            Step::End => admission.end(self.stream),
            Step::Halt => {
                side.player.halt();
                Ok(())
            }
            Step::Run(_) => Ok(()),
        };
        done.map_err(|refused| refused.reason())
    }

    fn run(&mut self, exact: &mut Side<'_>, counted: &mut Side<'_>) {
        self.now += 1;
        let stand = self.stand.map(Position::from_counts);
        // The last word is of no axis: it stays as it is.
        let mut positions = [Position::ZERO; USED];
        let mut counts = [77; AXES];
        let has = exact.player.advance(self.now, &stand, &mut positions);
        assert_eq!(
            counted.player.advance_counts(self.now, &stand, &mut counts),
            has
        );
        assert_eq!(exact.player.phase(), counted.player.phase());
        assert_eq!(exact.admission.player(), counted.admission.player());
        if has {
            let expected = positions.map(|position| position.counts());
            assert_eq!(counts, [expected[0], expected[1], 77], "cycle {}", self.now);
            self.stand = expected;
            self.set_points += 1;
        } else {
            assert_eq!(counts, [77; AXES]);
        }
    }

    fn take(&mut self, exact: &mut Side<'_>, counted: &mut Side<'_>, step: &Step) {
        if let Step::Run(cycles) = step {
            for _ in 0..*cycles {
                self.run(exact, counted);
            }
            return;
        }
        let done = self.order(exact, step);
        assert_eq!(self.order(counted, step), done, "{step:?}");
        match (done, step) {
            (Ok(()), Step::Begin { .. }) => {
                self.stream += 1;
                self.index = 0;
                self.end = End {
                    at: self.stand.map(f64::from),
                    velocities: [0.0; USED],
                };
            }
            (Ok(()), Step::Push(piece)) => {
                self.end = self.end.segment(piece).1;
                self.index += 1;
            }
            _ => {}
        }
    }
}

proptest! {
    #[test]
    fn counts_are_the_rounded_positions(steps in proptest::collection::vec(step(), 1..120)) {
        let [mut exact, mut counted] = [Queue::new(), Queue::new()];
        let [mut exact, mut counted] = [Side::new(&mut exact), Side::new(&mut counted)];
        let mut host = Host::default();
        host.take(&mut exact, &mut counted, &Step::Begin { dry: WhenDry::Wait, percent: 100 });
        for step in &steps {
            host.take(&mut exact, &mut counted, step);
        }
    }
}

proptest! {
    /// Nothing follows: both slow down in the same cycle, from whatever rate.
    #[test]
    fn both_run_dry_alike(
        pieces in proptest::collection::vec(piece(), 1..16),
        percent in prop_oneof![1..10_u16, 10..=200_u16],
        has_end in any::<bool>(),
    ) {
        let [mut exact, mut counted] = [Queue::new(), Queue::new()];
        let [mut exact, mut counted] = [Side::new(&mut exact), Side::new(&mut counted)];
        let mut host = Host::default();
        host.take(&mut exact, &mut counted, &Step::Begin { dry: WhenDry::Wait, percent });
        for piece in pieces {
            host.take(&mut exact, &mut counted, &Step::Push(piece));
        }
        if has_end {
            host.take(&mut exact, &mut counted, &Step::End);
        }
        host.take(&mut exact, &mut counted, &Step::Run(30_000));
    }
}

#[test]
fn a_long_stream_is_played() {
    let [mut exact, mut counted] = [Queue::new(), Queue::new()];
    let [mut exact, mut counted] = [Side::new(&mut exact), Side::new(&mut counted)];
    let mut host = Host::default();
    let begin = Step::Begin {
        dry: WhenDry::End,
        percent: 100,
    };
    host.take(&mut exact, &mut counted, &begin);
    for index in 0..1_000 {
        let piece = Piece {
            ticks: 20 << 32,
            velocities: [f64::from(index % 30), -20.0]
                .map(|velocity| if index == 999 { 0.0 } else { velocity }),
            is_fifth_degree: index % 3 == 0,
        };
        let before = host.index;
        host.take(&mut exact, &mut counted, &Step::Push(piece));
        assert_eq!(host.index, before + 1);
        if index >= 10 {
            host.take(&mut exact, &mut counted, &Step::Run(20));
        }
    }
    host.take(&mut exact, &mut counted, &Step::End);
    host.take(&mut exact, &mut counted, &Step::Run(400));
    assert_eq!(counted.player.phase(), StreamPhase::Complete);
    assert!(host.set_points > 20_000, "{}", host.set_points);
}
