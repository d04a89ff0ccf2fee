//! A flying cutter: an axis that waits, follows a belt as fast as the belt for a while, and goes back. The speed of the belt is measured
//! anew in every cycle: `cargo run -p trajectory --example follow`.

use std::error::Error;

use trajectory::{Limits, Position, Time, Tracker};

const HOME: Position = Position::ZERO;

fn main() -> Result<(), Box<dyn Error>> {
    // Counts per cycle, per cycle² and per cycle³.
    let limits = Limits::new(80.0, 1.0, 0.05)?;
    let mut cutter = Tracker::at_rest(0, limits);
    let mut mark = Position::from_counts(-3_000);
    let mut before = cutter.state();
    for cycle in 0..1_000_u32 {
        let belt = belt_velocity(cycle);
        let follows = (100..600).contains(&cycle);
        if follows {
            cutter.follow(mark, belt)?;
        } else {
            cutter.next(HOME)?;
        }
        mark = mark.moved_by(Position::at_velocity(belt, Time::from_cycles(1)));
        let now = cutter.state();
        assert!((now.velocity - before.velocity).abs() <= 1.000_01);
        assert!((now.acceleration - before.acceleration).abs() <= 0.050_001);
        before = now;
        if cycle % 100 == 99 {
            let lag = if follows {
                mark.distance_from(now.position)
            } else {
                HOME.distance_from(now.position)
            };
            println!(
                "{:>4}: {:>6} counts, {:>5.1} per cycle, {:>5} to go",
                cycle + 1,
                now.position.counts(),
                now.velocity,
                lag.counts()
            );
        }
    }
    assert!(cutter.is_there());
    Ok(())
}

/// It starts, runs, and swings a little.
fn belt_velocity(cycle: u32) -> f32 {
    let swing = 0.25 * (0.05 * cycle as f32).sin();
    (0.2 * cycle as f32).min(40.0) + swing
}
