//! `motionctl sim`: a motion from a file on simulated drives.

mod arguments;
mod axis_summary;
mod bench;
mod csv;
mod error;
mod faults;
mod live;
mod output_file;
mod recording;
mod report;
mod setup;
mod spectator;
mod summary;
mod watch;
mod wheels;

use std::fs::File;
use std::io::BufWriter;
use std::process::ExitCode;

use crate::exit;
use crate::output::{self, tell};
use crate::trajectory::{MotionReport, Plan, WithMotion};
pub(crate) use arguments::Arguments;
use bench::Bench;
use error::SimError;
use live::LiveView;
use output_file::create;
use recording::Recording;
use setup::Setup;
use spectator::Nobody;
use summary::Summary;

/// Checks everything, runs the motion, prints the summary.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, SimError> {
    if let Some(nodes) = arguments.motion.hub_motors() {
        return wheels::run(arguments, nodes);
    }
    if arguments.twist.twist.is_some() {
        return Err(SimError::NotForServos { option: "--twist" });
    }
    let motion = arguments.motion.read().map_err(SimError::Motion)?;
    let setup = arguments.setup(&motion)?;
    let plan = motion
        .plan(setup.cycle_us, setup.max_step)
        .map_err(SimError::Motion)?;
    let candump = arguments.candump.as_deref().map(create).transpose()?;
    let table = arguments.csv.as_deref().map(create).transpose()?;
    if let Some(folder) = &arguments.report {
        report::make_folder(folder)?;
    }
    let picture = arguments
        .motion
        .path_picture(&plan, arguments.report.is_some())
        .map_err(SimError::Motion)?;
    let motion = motion
        .report(&plan, &setup.drives, setup.max_step)
        .map_err(SimError::Motion)?;
    if !arguments.json {
        motion.show();
    }
    let (summary, recording) = simulate(arguments, setup, candump, &plan)?;
    if let Some(recording) = recording {
        if let Some(table) = table {
            csv::write(table, &recording).map_err(SimError::Log)?;
        }
        if let Some(folder) = &arguments.report {
            let page = report::write(folder, &recording, &summary, picture.as_deref())?;
            tell(format_args!("report: {}", page.display()));
        }
    }
    print(arguments, &motion, &summary)?;
    Ok(if summary.promises_kept() {
        ExitCode::SUCCESS
    } else {
        exit::BROKEN_PROMISE.into()
    })
}

/// Runs the motion, with the live view or without.
fn simulate(
    arguments: &Arguments,
    setup: Setup,
    candump: Option<BufWriter<File>>,
    plan: &Plan,
) -> Result<(Summary, Option<Recording>), SimError> {
    if arguments.live {
        let mut view = LiveView::open(&setup, plan)?;
        Bench::new(setup, candump, true, &mut view)?.run(plan, false)
    } else {
        Bench::new(setup, candump, arguments.records(), &mut Nobody)?.run(plan, !arguments.json)
    }
}

fn print(arguments: &Arguments, motion: &MotionReport, summary: &Summary) -> Result<(), SimError> {
    if arguments.json {
        let result = summary;
        output::print_json(&WithMotion { motion, result }).map_err(SimError::Print)?;
    } else {
        output::print(summary).map_err(SimError::Print)?;
    }
    Ok(())
}
