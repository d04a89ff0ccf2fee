//! `motionctl run`: a motion from a file on the drives of a real bus, in real time.

mod arguments;
mod error;
mod follow;
mod summary;

use std::process::ExitCode;

use dyn_can::{DriveId, StepLimit};

use crate::confirm::confirm;
use crate::drive_ids::list;
use crate::interrupt;
use crate::link::Link;
use crate::station::Station;
use crate::trajectory::{Plan, WithMotion};
pub(crate) use arguments::Arguments;
use error::RunError;
use follow::Follow;

/// Checks everything, asks, runs the motion, prints the summary.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, RunError> {
    let motion = arguments.motion.read().map_err(RunError::Motion)?;
    let drives = motion.drives().map_err(RunError::Motion)?;
    let max_step = arguments.max_step.unwrap_or(StepLimit::MAX);
    let plan = motion
        .plan(arguments.cycle_us, max_step)
        .map_err(RunError::Motion)?;
    let report = motion.report(&plan, &drives, max_step);
    if !arguments.json {
        report.show();
    }
    let mut link = arguments.link.open().map_err(RunError::Open)?;
    let station = station(arguments, &mut link, &drives, &plan)?;
    confirm(&question(arguments, &drives, &plan), arguments.yes).map_err(RunError::NotConfirmed)?;
    interrupt::listen().map_err(RunError::Interrupt)?;
    let follow = Follow::new(station, &drives, arguments.axes.scale());
    let summary = follow.run(&plan, !arguments.json);
    if arguments.json {
        println!(
            "{}",
            serde_json::to_string_pretty(&WithMotion {
                motion: &report,
                result: &summary,
            })
            .map_err(RunError::Json)?
        );
    } else {
        println!("{summary}");
    }
    Ok(summary.exit_code())
}

fn station<'link>(
    arguments: &Arguments,
    link: &'link mut Link,
    drives: &[DriveId],
    plan: &Plan,
) -> Result<Station<'link>, RunError> {
    let max_step = arguments.max_step.unwrap_or_else(|| catch_up(plan));
    let mut ascending = drives.to_vec();
    ascending.sort_unstable();
    let axes: Vec<_> = ascending
        .iter()
        .map(|&drive| arguments.axes.axis(drive, max_step, arguments.polls()))
        .collect();
    Station::new(link, &axes, arguments.cycle_us).map_err(RunError::Config)
}

/// A quarter above the largest step of the motion: an axis that is behind catches up, and never much faster than planned.
fn catch_up(plan: &Plan) -> StepLimit {
    let step = i32::from(plan.largest_step());
    StepLimit::new((step + step / 4).max(1)).unwrap_or(StepLimit::MAX)
}

fn question(arguments: &Arguments, drives: &[DriveId], plan: &Plan) -> String {
    let seconds = plan.cycles() as f64 * f64::from(arguments.cycle_us) * 1e-6;
    format!(
        "The motors of drives {} will be enabled and MOVE for {seconds:.1} s, at most {} counts in {} us. Is everybody clear of the machine?",
        list(drives),
        plan.largest_step(),
        arguments.cycle_us
    )
}
