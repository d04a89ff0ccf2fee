//! A motion from a file.

use std::process::ExitCode;

use dyn_can::StepLimit;

use super::arguments::Arguments;
use super::error::RunError;
use super::{Axis, admit, ask, follow, listen, open_control};
use crate::control::Wishes;
use crate::link::Link;
use crate::output::{print, print_json};
use crate::set_points::TimedMotion;
use crate::station::Needs;
use crate::trajectory::{MotionFile, Plan, WithMotion};

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, RunError> {
    let motion = arguments.motion.read().map_err(RunError::Motion)?;
    let plan = motion
        .plan(arguments.cycle_us, StepLimit::MAX)
        .map_err(RunError::Motion)?;
    let axes = axes(arguments, &motion, &plan)?;
    let drives: Vec<_> = axes.iter().map(|axis| axis.drive).collect();
    let report = motion.report(&plan, &drives, StepLimit::MAX);
    if !arguments.json {
        report.show();
    }
    for axis in &axes {
        let within = arguments.limits.check(axis.drive, &axis.needs);
        within.map_err(RunError::Limit)?;
    }
    let wishes = Wishes::new();
    let control = open_control(arguments, &wishes)?;
    let mut link = arguments.link.open().map_err(RunError::Open)?;
    let (mut source, axes) = source(arguments, &mut link, &plan, axes)?;
    let seconds = plan.cycles() as f64 * f64::from(arguments.cycle_us) * 1e-6;
    ask(arguments, &axes, &format!("for {seconds:.1} s"))?;
    let follow = follow(arguments, &mut link, &axes)?;
    let listening = listen(arguments, control, &wishes)?;
    let summary = follow.run(&mut source, &wishes, !arguments.json);
    drop(listening);
    if arguments.json {
        print_json(&WithMotion {
            motion: &report,
            result: &summary,
        })
        .map_err(RunError::Print)?;
    } else {
        print(&summary).map_err(RunError::Print)?;
    }
    Ok(summary.exit_code())
}

fn axes(
    arguments: &Arguments,
    motion: &MotionFile<'_>,
    plan: &Plan,
) -> Result<Vec<Axis>, RunError> {
    let drives = motion.drives().map_err(RunError::Motion)?;
    let gears = motion.gear_numbers().map_err(RunError::Motion)?;
    let axis = |(axis, (drive, gear))| {
        let positions: Vec<i32> = plan.rows().map(|row| row[axis]).collect();
        Axis {
            drive,
            gear,
            needs: Needs::of(&positions, gear, arguments.cycle_us),
            first_counts: plan.first_counts(axis),
        }
    };
    Ok(drives
        .into_iter()
        .zip(gears)
        .enumerate()
        .map(axis)
        .collect())
}

/// The motion with the speeds that its axes have room for. A bus that cannot carry the larger steps of a higher speed carries the
/// motion as it is.
fn source<'plan>(
    arguments: &Arguments,
    link: &mut Link,
    plan: &'plan Plan,
    axes: Vec<Axis>,
) -> Result<(TimedMotion<&'plan Plan>, Vec<Axis>), RunError> {
    admit(arguments, link, &axes)?;
    let headroom = |axis: &Axis| {
        arguments
            .limits
            .headroom(&axis.needs, axis.gear, arguments.cycle_us)
    };
    let headroom = axes.iter().map(headroom).collect();
    let mut source = TimedMotion::new(plan, headroom, arguments.cycle_us);
    let at_rate = |axis: &Axis| Axis {
        needs: axis.needs.at_rate(source.highest_rate()),
        ..axis.clone()
    };
    let faster: Vec<Axis> = axes.iter().map(at_rate).collect();
    if admit(arguments, link, &faster).is_ok() {
        return Ok((source, faster));
    }
    source.hold_to(1.0);
    Ok((source, axes))
}
