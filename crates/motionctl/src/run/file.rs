//! A motion from a file.

use std::process::ExitCode;

use dyn_can::StepLimit;

use super::arguments::Arguments;
use super::buses::{self, Bus, admit_all};
use super::error::RunError;
use super::{Axis, ask, listen, open_control, recording};
use crate::control::Wishes;
use crate::program::ProgramInMotion;
use crate::set_points::{SetPointSource, TimedMotion};
use crate::station::Needs;
use crate::trajectory::{MotionFile, Plan};

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, RunError> {
    let motion = arguments.motion.read().map_err(RunError::Motion)?;
    let plan = motion
        .plan(arguments.cycle_us, StepLimit::MAX)
        .map_err(RunError::Motion)?;
    let axes = axes(arguments, &motion, &plan)?;
    let drives: Vec<_> = axes.iter().map(|axis| axis.drive).collect();
    let written = arguments.motion.write_path(&plan);
    written.map_err(RunError::Motion)?;
    let report = motion
        .report(&plan, &drives, StepLimit::MAX)
        .map_err(RunError::Motion)?;
    if !arguments.json {
        report.show();
    }
    for axis in &axes {
        let within = arguments.limits.check(axis.drive, &axis.needs);
        within.map_err(RunError::Limit)?;
    }
    let wishes = Wishes::new();
    let control = open_control(arguments, &wishes)?;
    let mut buses = buses::open(arguments, axes)?;
    recording::begin(arguments, &mut buses)?;
    let mut source = source(arguments, &mut buses, &plan)?;
    let source = source.as_mut();
    let seconds = plan.cycles() as f64 * f64::from(arguments.cycle_us) * 1e-6;
    ask(arguments, &drives, &format!("for {seconds:.1} s"))?;
    let (follows, view) = buses::ready(arguments, &mut buses, &wishes)?;
    let listening = listen(arguments, control, &wishes)?;
    let shows_progress = !arguments.json && view.is_none();
    let results = buses::follow_all(follows, source, &wishes, shows_progress);
    drop(listening);
    recording::end_view(view, &results);
    let summaries = recording::close(arguments, &buses, results);
    buses::show(arguments, &summaries, Some(&report), None)
}

fn axes(
    arguments: &Arguments,
    motion: &MotionFile<'_>,
    plan: &Plan,
) -> Result<Vec<Axis>, RunError> {
    let drives = match arguments.link.drives() {
        Some(drives) => motion.takes_drives(drives),
        None => motion.drives(),
    };
    let drives = drives.map_err(RunError::Motion)?;
    let gears = motion.gear_numbers().map_err(RunError::Motion)?;
    let abouts = motion.axes_about(&drives).map_err(RunError::Motion)?;
    let axis = |(axis, ((drive, gear), about))| {
        let positions: Vec<i32> = plan.rows().map(|row| row[axis]).collect();
        let mut needs = Needs::of(&positions, gear, arguments.cycle_us);
        if let Some(checked) = plan.program() {
            let positions: Vec<i32> = checked.fastest_rows().map(|row| row[axis]).collect();
            needs = needs.and(Needs::of(&positions, gear, arguments.cycle_us));
        }
        Axis {
            drive,
            gear,
            needs,
            first_counts: plan.first_counts(axis),
            about,
        }
    };
    Ok(drives
        .into_iter()
        .zip(gears)
        .zip(abouts)
        .enumerate()
        .map(axis)
        .collect())
}

/// The motion with the speeds that its axes have room for. Buses that cannot carry the larger steps of a higher speed carry the motion as
/// it is.
fn source<'plan>(
    arguments: &Arguments,
    buses: &mut [Bus],
    plan: &'plan Plan,
) -> Result<Box<dyn SetPointSource + 'plan>, RunError> {
    admit_all(arguments, buses)?;
    if let Some(checked) = plan.program() {
        let program = ProgramInMotion::new(checked);
        return Ok(Box::new(
            program.map_err(|source| RunError::Motion(source.into()))?,
        ));
    }
    let headroom = |axis: &Axis| {
        arguments
            .limits
            .headroom(&axis.needs, axis.gear, arguments.cycle_us)
    };
    let axes = buses.iter().flat_map(|bus| &bus.axes);
    let mut source = TimedMotion::new(plan, axes.map(headroom).collect(), arguments.cycle_us);
    let needs: Vec<Vec<Axis>> = buses.iter().map(|bus| bus.axes.clone()).collect();
    for axis in buses.iter_mut().flat_map(|bus| &mut bus.axes) {
        axis.needs = axis.needs.at_rate(source.highest_rate());
    }
    if admit_all(arguments, buses).is_err() {
        for (bus, axes) in buses.iter_mut().zip(needs) {
            bus.axes = axes;
        }
        source.hold_to(1.0);
    }
    Ok(Box::new(source))
}
