//! Whatever segments a sender sends, whenever it sends them, and whatever is ordered meanwhile: what goes out keeps the limits, and nothing
//! moves that was not admitted.

mod judge;

use board_link::segment::{
    AxisSegment, Begin, PlayerState, Segment, SegmentConfig, SegmentQueue, Shape, StreamPhase,
};
use board_link::{AxisLimits, WhenDry};
use judge::Judge;
use proptest::prelude::*;
use trajectory::{Limits, Position};

const AXES: usize = 2;

/// What is ordered before a cycle.
#[derive(Debug, Clone, Copy)]
enum Order {
    Pause,
    Resume,
    Override(u16),
    Stop,
    /// The sender is silent for so many cycles.
    Silence(u32),
}

fn order() -> impl Strategy<Value = Order> {
    prop_oneof![
        2 => Just(Order::Pause),
        2 => Just(Order::Resume),
        4 => (0..=200_u16).prop_map(Order::Override),
        1 => Just(Order::Stop),
        4 => (0..900_u32).prop_map(Order::Silence),
    ]
}

/// A segment as it is wanted: the velocities at its end as shares of the limit, and how it gets there.
#[derive(Debug, Clone, Copy)]
struct Wanted {
    ticks: u64,
    shape: u8,
    velocity: [f32; AXES],
    /// Of the mean of both velocities.
    way: [f32; AXES],
    step: f32,
}

fn wanted() -> impl Strategy<Value = Wanted> {
    (
        prop_oneof![1 => (1_u64 << 31)..(20 << 32), 5 => (20_u64 << 32)..(400 << 32)],
        0..9_u8,
        [(); AXES].map(|()| prop_oneof![1 => Just(0.0_f32), 3 => -1.0_f32..1.0]),
        [(); AXES].map(|()| 0.9_f32..1.1),
        prop_oneof![3 => Just(0.0_f32), 1 => -1.5_f32..1.5],
    )
        .prop_map(|(ticks, shape, velocity, way, step)| Wanted {
            ticks,
            shape,
            velocity,
            way,
            step,
        })
}

#[derive(Debug, Clone)]
struct Scenario {
    limits: AxisLimits,
    wanted: Vec<Wanted>,
    orders: Vec<(u32, Order)>,
    waits: bool,
    percent: u16,
}

fn scenario() -> impl Strategy<Value = Scenario> {
    (
        (
            1.0_f32..100.0,
            0.02_f32..3.0,
            proptest::option::of(0.05_f32..1.0),
        ),
        proptest::collection::vec(wanted(), 3..60),
        proptest::collection::vec((0..600_u32, order()), 0..14),
        any::<bool>(),
        prop_oneof![Just(100_u16), 0..=200_u16],
    )
        .prop_map(
            |((velocity, acceleration, jerk), wanted, orders, waits, percent)| {
                let motion = match jerk {
                    Some(share) => Limits::new(velocity, acceleration, share * acceleration),
                    None => Limits::without_jerk(velocity, acceleration),
                };
                let limits = AxisLimits {
                    motion: motion.unwrap(),
                    lowest: Position::from_counts(-30_000),
                    highest: Position::from_counts(30_000),
                };
                Scenario {
                    limits,
                    wanted,
                    orders,
                    waits,
                    percent,
                }
            },
        )
}

fn units(counts: f64) -> i64 {
    (counts * Position::UNITS as f64).round() as i64
}

impl Scenario {
    /// The segment from a state of every axis: position and velocity.
    fn segment(
        &self,
        wanted: &Wanted,
        state: &[(f64, f64); AXES],
    ) -> (Segment, [(f64, f64); AXES]) {
        let cycles = wanted.ticks as f64 / (1_u64 << 32) as f64;
        let mut after = *state;
        let mut axes = board_link::segment::OfAxes::new();
        for axis in 0..AXES {
            let (at, velocity) = state[axis];
            // A step that is within an acceleration, or not.
            let leaving = velocity + f64::from(wanted.step * self.limits.motion.acceleration());
            let most = f64::from(self.limits.velocity());
            // What the acceleration allows, and sometimes a little more.
            let change = f64::from(self.limits.acceleration()) * cycles * 0.4;
            let goal = f64::from(wanted.velocity[axis]) * most;
            let arriving = goal.clamp(leaving - change, leaving + change);
            let way = (leaving + arriving) / 2.0 * cycles * f64::from(wanted.way[axis]);
            let shape = match wanted.shape {
                0 => Shape::Line,
                1 => Shape::MinimumJerk,
                2..5 => Shape::Quintic {
                    leaving: units(leaving * cycles),
                    leaving_acceleration: 0,
                    arriving: units(arriving * cycles),
                    arriving_acceleration: 0,
                },
                _ => Shape::Cubic {
                    leaving: units(leaving * cycles),
                    arriving: units(arriving * cycles),
                },
            };
            let (end, last) = match shape {
                Shape::Line => (at + leaving * cycles, leaving),
                Shape::MinimumJerk => (at + change * cycles * 0.2, 0.0),
                _ => (at + way, arriving),
            };
            let end = units(end);
            after[axis] = (end as f64 / Position::UNITS as f64, last);
            let _ = axes.push(AxisSegment { end, shape });
        }
        let duration = wanted.ticks;
        (Segment { duration, axes }, after)
    }

    fn run(&self) -> Result<Outcome, TestCaseError> {
        let mut queue = SegmentQueue::<AXES, 17>::new();
        let config = SegmentConfig::with_cycles_per_second(1_000);
        let (mut admission, mut player) = queue.split(&[self.limits; AXES], config).unwrap();
        let when_dry = if self.waits {
            WhenDry::Wait
        } else {
            WhenDry::End
        };
        let begin = Begin {
            stream: 3,
            start: Some(20),
            when_dry,
            percent: self.percent,
            from: [0; AXES].into_iter().collect(),
        };
        let stand = [Position::ZERO; AXES];
        admission.begin(&begin, &stand, 0).unwrap();
        let mut outcome = Outcome::default();
        let mut state = [(0.0, 0.0); AXES];
        let mut wanted = self.wanted.iter();
        let mut orders = self.orders.clone();
        orders.reverse();
        let (mut silent_until, mut next_order_at) = (0, 30);
        let mut out = stand;
        for cycle in 1..400_000_u32 {
            if cycle >= next_order_at {
                match orders.pop() {
                    Some((wait, order)) => {
                        next_order_at = cycle + wait;
                        match order {
                            Order::Pause => drop(admission.pause()),
                            Order::Resume => drop(admission.resume()),
                            Order::Override(percent) => drop(admission.set_override(percent)),
                            Order::Stop => drop(admission.stop()),
                            Order::Silence(cycles) => silent_until = cycle + cycles,
                        }
                    }
                    // In the end everything goes on.
                    None => {
                        let _ = admission.resume();
                        if admission.player().percent < 20 {
                            let _ = admission.set_override(100);
                        }
                        next_order_at = cycle + 3_000;
                    }
                }
            }
            if cycle >= silent_until {
                while admission.credit() > 0
                    && let Some(next) = wanted.next()
                {
                    let (segment, after) = self.segment(next, &state);
                    let index = admission.next_index();
                    if admission.push(3, index, &segment).is_ok() {
                        outcome.admitted.push(after);
                        state = after;
                    } else {
                        outcome.refused += 1;
                    }
                }
                if wanted.len() == 0 && admission.end(3).is_err() {
                    // It does not end at rest; nothing follows, so it runs dry.
                    silent_until = u32::MAX;
                }
            }
            if player.advance(cycle.into(), &stand, &mut out) {
                for (judge, &position) in outcome.judges.iter_mut().zip(&out) {
                    judge.see(position);
                }
            }
            let phase = player.phase();
            let waits = matches!(phase, StreamPhase::Dry | StreamPhase::Waiting);
            if !phase.is_active() || (waits && silent_until == u32::MAX && cycle > 30) {
                outcome.end = out;
                outcome.player = admission.player();
                return Ok(outcome);
            }
        }
        Err(TestCaseError::fail("it never ended"))
    }
}

#[derive(Debug, Default)]
struct Outcome {
    judges: [Judge; AXES],
    admitted: Vec<[(f64, f64); AXES]>,
    refused: usize,
    end: [Position; AXES],
    player: PlayerState,
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, ..ProptestConfig::default() })]

    #[test]
    fn what_goes_out_keeps_the_limits(scenario in scenario()) {
        let outcome = scenario.run()?;
        let limits = scenario.limits.motion;
        for judge in &outcome.judges {
            let (velocity, acceleration) = (f64::from(limits.velocity()), f64::from(limits.acceleration()));
            prop_assert!(judge.velocity <= velocity * 1.000_1, "{} of {velocity}", judge.velocity);
            prop_assert!(
                judge.acceleration <= acceleration * 1.000_1 + 1e-5,
                "{} of {acceleration}", judge.acceleration
            );
            let jerk = f64::from(limits.jerk());
            prop_assert!(judge.jerk <= jerk * 1.001 + 1e-5, "{} of {jerk}", judge.jerk);
            prop_assert!(
                judge.lowest >= -30_000 && judge.highest <= 30_000,
                "{} to {}", judge.lowest, judge.highest
            );
        }
        let player = outcome.player;
        prop_assert!(player.finished as usize <= outcome.admitted.len());
        if player.phase == StreamPhase::Complete {
            // The sum is exact.
            let last = outcome.admitted.last().copied().unwrap_or_default();
            prop_assert_eq!(player.finished as usize, outcome.admitted.len());
            for (end, last) in outcome.end.iter().zip(last) {
                prop_assert_eq!(end.units(), units(last.0));
            }
        }
    }
}

/// The generator makes what the test is about.
#[test]
fn the_scenarios_reach_every_end_and_every_kind_of_refusal() {
    use proptest::strategy::ValueTree as _;
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let mut ends = std::collections::BTreeMap::new();
    let (mut admitted, mut refused) = (0, 0);
    for _ in 0..500 {
        let scenario = scenario().new_tree(&mut runner).unwrap().current();
        let outcome = scenario.run().unwrap();
        *ends
            .entry(format!("{:?}", outcome.player.phase))
            .or_insert(0) += 1;
        admitted += outcome.admitted.len();
        refused += outcome.refused;
    }
    assert!(ends.len() >= 4, "{ends:?}");
    assert!(ends.values().all(|&count| count > 10), "{ends:?}");
    assert!(admitted > 1_000 && refused > 1_000, "{admitted} {refused}");
}
