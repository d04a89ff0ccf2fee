//! Whatever a sender sends, whenever it sends it, and whatever is ordered meanwhile: what goes out keeps the limits.
//!
//! The judge knows nothing of curves and rates: it takes the positions of the cycles and their finite differences.

mod judge;

use board_link::{AxisLimits, Config, Phase, SetPointBuffer, WhenDry};
use judge::Judge;
use proptest::prelude::*;
use trajectory::{Limits, Position, Time};

const AXES: usize = 2;
type Buffer = SetPointBuffer<AXES, 64>;

/// What is ordered before a cycle.
#[derive(Debug, Clone, Copy)]
enum Order {
    Pause,
    Resume,
    Override(u16),
    /// The sender is silent for so many cycles.
    Silence(u32),
}

fn order() -> impl Strategy<Value = Order> {
    prop_oneof![
        Just(Order::Pause),
        Just(Order::Resume),
        (0..=200_u16).prop_map(Order::Override),
        (0..600_u32).prop_map(Order::Silence),
    ]
}

#[derive(Debug, Clone)]
struct Scenario {
    velocity: f32,
    acceleration: f32,
    jerk: Option<f32>,
    spacing: u32,
    /// Changes of the velocity from one set-point to the next, as shares of the largest that is taken; above 1 it is refused.
    changes: Vec<[f32; AXES]>,
    orders: Vec<(u32, Order)>,
    when_dry: bool,
}

fn scenario() -> impl Strategy<Value = Scenario> {
    (
        1.0_f32..300.0,
        0.02_f32..3.0,
        proptest::option::of(0.05_f32..1.0),
        8..60_u32,
        proptest::collection::vec([-1.2_f32..1.2, -1.2_f32..1.2], 10..80),
        proptest::collection::vec((0..400_u32, order()), 0..12),
        any::<bool>(),
    )
        .prop_map(
            |(velocity, acceleration, jerk, spacing, changes, orders, when_dry)| Scenario {
                velocity,
                acceleration,
                jerk: jerk.map(|share| share * acceleration),
                spacing,
                changes,
                orders,
                when_dry,
            },
        )
}

impl Scenario {
    fn limits(&self) -> AxisLimits {
        let motion = match self.jerk {
            Some(jerk) => Limits::new(self.velocity, self.acceleration, jerk),
            None => Limits::without_jerk(self.velocity, self.acceleration),
        };
        AxisLimits {
            motion: motion.unwrap(),
            lowest: Position::from_counts(-30_000),
            highest: Position::from_counts(30_000),
        }
    }

    /// Set-points of a sender that changes its velocity at will.
    fn set_points(&self) -> Vec<(Time, [Position; AXES])> {
        let spacing = self.spacing as f32;
        let (mut at, mut velocity) = ([0.0_f64; AXES], [0.0_f32; AXES]);
        let mut list = vec![(Time::from_cycles(7), [Position::ZERO; AXES])];
        for (number, changes) in self.changes.iter().enumerate() {
            for axis in 0..AXES {
                let most = self.acceleration * spacing * 0.6;
                let wanted = velocity[axis] + changes[axis] * most;
                velocity[axis] = wanted.clamp(-1.05 * self.velocity, 1.05 * self.velocity);
                at[axis] += f64::from(velocity[axis] * spacing);
            }
            let time = Time::from_cycles(7 + (number as u32 + 1) * self.spacing);
            let units = at.map(|at| Position::from_units((at * Position::UNITS as f64) as i64));
            list.push((time, units));
        }
        list
    }

    fn run(&self) -> Result<(Buffer, [Judge; AXES]), TestCaseError> {
        let config = Config {
            when_dry: if self.when_dry {
                WhenDry::Wait
            } else {
                WhenDry::End
            },
            ..Config::with_cycles_per_second(1_000)
        };
        let limits = [self.limits(); AXES];
        let mut buffer = Buffer::new(&limits, &[Position::ZERO; AXES], config).unwrap();
        let mut judges = [Judge::default(); AXES];
        let mut set_points = self.set_points().into_iter().peekable();
        let mut orders = self.orders.clone();
        orders.reverse();
        let mut positions = [Position::ZERO; AXES];
        let (mut silent_until, mut next_order_at) = (0, 0);
        for cycle in 0..200_000_u32 {
            if cycle >= next_order_at {
                match orders.pop() {
                    Some((wait, order)) => {
                        next_order_at = cycle + wait;
                        match order {
                            Order::Pause => buffer.pause(),
                            Order::Resume => buffer.resume(),
                            Order::Override(percent) => buffer.set_override(percent).unwrap(),
                            Order::Silence(cycles) => silent_until = cycle + cycles,
                        }
                    }
                    // In the end everything goes on.
                    None => {
                        buffer.resume();
                        if buffer.percent() < 20.0 {
                            buffer.set_override(100).unwrap();
                        }
                        next_order_at = cycle + 1_000;
                    }
                }
            }
            if cycle >= silent_until {
                while buffer.credit() > 0
                    && let Some((time, positions)) = set_points.next()
                {
                    let _ = buffer.push(time, &positions);
                }
                if set_points.peek().is_none() {
                    buffer.end();
                }
            }
            let phase = buffer.advance(&mut positions);
            for (judge, &position) in judges.iter_mut().zip(&positions) {
                judge.see(position);
            }
            if matches!(phase, Phase::Complete | Phase::DriedUp) {
                return Ok((buffer, judges));
            }
        }
        Err(TestCaseError::fail("it never ended"))
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1_000, ..ProptestConfig::default() })]

    #[test]
    fn what_goes_out_keeps_the_limits(scenario in scenario()) {
        let (buffer, judges) = scenario.run()?;
        let (limits, spacing) = (scenario.limits(), f64::from(scenario.spacing));
        for judge in &judges {
            // What the rounding of set-points to counts is allowed to need, and floats.
            let velocity = f64::from(limits.motion.velocity()) + 1.0 / spacing;
            let acceleration = f64::from(limits.motion.acceleration()) + 5.0 / (spacing * spacing);
            let jerk = f64::from(limits.motion.jerk()) + 20.0 / (spacing * spacing * spacing);
            prop_assert!(judge.velocity <= velocity * 1.001, "{} of {velocity}", judge.velocity);
            prop_assert!(
                judge.acceleration <= acceleration * 1.001,
                "{} of {acceleration}", judge.acceleration
            );
            prop_assert!(judge.jerk <= jerk * 1.001 + 1e-5, "{} of {jerk}", judge.jerk);
            // A float of 24 bits.
            prop_assert!(judge.lowest >= -30_000 && judge.highest <= 30_000);
        }
        // Every set-point was taken or refused, or was not sent any more.
        let counters = buffer.counters();
        let sent = counters.taken + counters.refused_in_all();
        prop_assert!(sent as usize <= scenario.changes.len() + 1);
    }
}
