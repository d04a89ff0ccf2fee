//! A move with a cycle of 1 ms, in millimetres, that is stopped on its way: `cargo run -p trajectory --example move_and_stop`.

use std::error::Error;

use trajectory::units::{Ratio, Units};
use trajectory::{Position, Profile, State, Time};

const CYCLE_US: u32 = 1_000;

fn main() -> Result<(), Box<dyn Error>> {
    // 65536 counts a turn, 5 mm a turn, positions in micrometres.
    let units = Units::new(Ratio::new(65_536, 5_000)?, 0);
    // 200 mm/s, 1 m/s², 10 m/s³; the stop may brake harder.
    let limits = units.limits(200e3, 1e6, 10e6, CYCLE_US)?;
    let hard = units.limits(200e3, 4e6, 80e6, CYCLE_US)?;
    let (lowest_um, highest_um) = (0, 120_000);

    let target = Position::from_counts(units.to_counts(100_000)?);
    let profile = Profile::to_rest(&State::at_rest(0), target, &limits)?;
    println!("100 mm take {} cycles", profile.duration().whole_cycles());
    for cycle in (0..300).step_by(50) {
        let at = Time::from_cycles(cycle);
        println!("{cycle:>4} ms {:>8} counts", profile.position(at).counts());
    }

    // Something happens after 300 ms: where does the axis stand if it brakes at once?
    let now = profile.state(Time::from_cycles(300));
    let stop = Profile::stop(&now, &hard)?;
    let end_um = units.to_units(stop.end_position().counts())?;
    println!(
        "braking takes {} cycles, to {:.3} mm",
        stop.duration().whole_cycles(),
        f64::from(end_um) / 1e3
    );
    let (lowest, highest) = stop.extent();
    assert!(units.to_units(lowest.counts())? >= lowest_um);
    assert!(units.to_units(highest.counts())? <= highest_um);
    Ok(())
}
