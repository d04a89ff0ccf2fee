//! `motionctl keyframes`: a program as the motion that the firmware compiles in.
//!
//! [`fit`] chooses keyframes and velocities so that what the board plays is nowhere further from the path than a tolerance, and measures that
//! with the code of the board; [`source`] writes them as Rust.

mod arguments;
mod error;
mod fit;
mod report;
mod source;

use std::process::ExitCode;

use dyn_can::StepLimit;

use crate::backup::create_file;
use crate::backup::file::require_room;
use crate::output::{print, print_json};
use crate::trajectory::WithMotion;
pub(crate) use arguments::Arguments;
use error::KeyframesError;
use fit::Fitted;
use report::Report;

/// Checks the program, fits keyframes to its path and writes them.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, KeyframesError> {
    let options = &arguments.motion;
    if options.program.program.is_none() {
        return Err(KeyframesError::NoProgram);
    }
    require_room(&arguments.file, arguments.force)?;
    let motion = options.read()?;
    let cycle_us = arguments.cycle_us;
    let plan = motion.plan(cycle_us, StepLimit::MAX)?;
    let drives = motion.drives()?;
    let gears = motion.gear_numbers()?;
    let told = motion.report(&plan, &drives, StepLimit::MAX)?;
    options.write_path(&plan)?;
    let checked = plan.program().ok_or(KeyframesError::NoProgram)?;
    for (motor, counts) in checked.names().iter().zip(checked.last()) {
        if counts != 0 {
            let motor = motor.clone();
            return Err(KeyframesError::Elsewhere { motor, counts });
        }
    }
    let rows = checked.exact_rows()?;
    let fitted = Fitted::new(&rows, cycle_us, arguments.tolerance_counts)?;
    let report = Report::new(&arguments.file, &fitted, cycle_us);
    let text = source::write(&report, &fitted, &told, &drives, &gears);
    create_file(&arguments.file, &text, arguments.force)?;
    let printed = if arguments.json {
        print_json(&WithMotion {
            motion: &told,
            result: &report,
        })
    } else {
        print(format_args!("{told}\n{report}"))
    };
    printed.map_err(KeyframesError::Print)?;
    Ok(ExitCode::SUCCESS)
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<WithMotion<'_, report::Report>>()
}
