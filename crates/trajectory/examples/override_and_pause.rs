//! Two axes on a line at half the speed, paused and resumed: `cargo run -p trajectory --example override_and_pause`.

use std::error::Error;

use trajectory::curve::{Keyframe, KeyframeMotion};
use trajectory::{Time, TimeScale};

fn main() -> Result<(), Box<dyn Error>> {
    let keyframes =
        [(0, [0, 0]), (1_000, [40_000, -10_000])].map(|(at_ms, positions_counts)| Keyframe {
            at_ms,
            positions_counts,
        });
    let motion = KeyframeMotion::new(&keyframes)?;
    // 100 cycles from standstill to full rate.
    let mut scale = TimeScale::new(100)?;
    scale.set_override(50)?;
    scale.resume();
    for cycle in 0..2_600 {
        match cycle {
            1_000 => scale.pause(),
            1_200 => scale.resume(),
            _ => {}
        }
        let [x, y] = motion.position(microseconds(scale.advance()));
        assert!((x + 4 * y).abs() <= 3, "the axes have left their line");
        if cycle % 200 == 0 {
            println!(
                "{cycle:>5} ms, {:>3.0} %: {x:>6} {y:>6}",
                100.0 * scale.rate()
            );
        }
    }
    Ok(())
}

/// With a cycle of 1 ms.
fn microseconds(time: Time) -> u64 {
    ((u128::from(time.ticks()) * 1_000) >> 32) as u64
}
