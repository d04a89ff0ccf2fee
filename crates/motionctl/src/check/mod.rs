//! `motionctl check`: what a motion file would do, without a bus and without drives.

mod arguments;
mod error;
mod report;
mod svg;

use std::process::ExitCode;

use dyn_can::StepLimit;

use crate::exit;
use crate::output::{print, print_json, tell};
use crate::trajectory::WithMotion;
pub(crate) use arguments::Arguments;
use error::CheckError;
use report::Report;

/// Works out what the file would do, prints it, and draws it.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, CheckError> {
    let options = arguments.motion();
    let motion = options.read().map_err(CheckError::Motion)?;
    let plan = motion
        .plan(arguments.cycle_us, StepLimit::MAX)
        .map_err(CheckError::Motion)?;
    let drives = motion.drives().map_err(CheckError::Motion)?;
    let gears = motion.gear_numbers().map_err(CheckError::Motion)?;
    let report = Report::new(arguments, &plan, &drives, &gears);
    let motion = motion
        .report(&plan, &drives, StepLimit::MAX)
        .map_err(CheckError::Motion)?;
    if let Some(path) = &arguments.svg {
        let picture = svg::draw(&plan, &report, arguments.cycle_us).map_err(CheckError::Draw)?;
        std::fs::write(path, picture).map_err(|source| CheckError::Write {
            path: path.clone(),
            source,
        })?;
        tell(format_args!("picture: {}", path.display()));
    }
    if arguments.json {
        print_json(&WithMotion {
            motion: &motion,
            result: &report,
        })
    } else {
        print(format_args!("{motion}\n{report}"))
    }
    .map_err(CheckError::Print)?;
    Ok(if report.problems.is_empty() {
        ExitCode::SUCCESS
    } else {
        exit::BROKEN_PROMISE.into()
    })
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<WithMotion<'_, report::Report>>()
}
