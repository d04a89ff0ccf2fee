//! `motionctl sim`: a motion from a file on simulated drives.

mod arguments;
mod axis_summary;
mod bench;
mod buses;
mod error;
mod faults;
mod live;
mod outcome;
mod setup;
mod spectator;
mod summary;
mod watch;
mod wheels;

use std::process::ExitCode;

pub(crate) use arguments::Arguments;
pub(crate) use bench::wire_frame;
use error::SimError;

/// Checks everything, runs the motion, prints the summary.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, SimError> {
    if let Some(nodes) = arguments.motion.hub_motors() {
        return wheels::run(arguments, nodes);
    }
    if arguments.twist.twist.is_some() {
        return Err(SimError::NotForServos { option: "--twist" });
    }
    let motion = arguments.motion.read().map_err(SimError::Motion)?;
    let setups = arguments.setups(&motion)?;
    let (cycle_us, max_step) = (arguments.servo_cycle_us(), arguments.most_step()?);
    let plan = motion.plan(cycle_us, max_step).map_err(SimError::Motion)?;
    let drives = setups.iter().flat_map(|setup| setup.drives.clone());
    let drives: Vec<_> = drives.collect();
    let axes = motion.axes_about(&drives).map_err(SimError::Motion)?;
    let buses = buses::open(arguments, setups, axes)?;
    let written = arguments.motion.write_path(&plan);
    written.map_err(SimError::Motion)?;
    let motion = motion
        .report(&plan, &drives, max_step)
        .map_err(SimError::Motion)?;
    if !arguments.json {
        motion.show();
    }
    let results = buses::run(arguments, buses, &plan)?;
    buses::show(arguments, &motion, &results)
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    buses::schema()
}

/// The shape of what `--json` prints of hub motors.
pub(crate) fn wheels_schema() -> schemars::Schema {
    wheels::schema()
}
