//! `motionctl run`: a motion from a file on the drives of a real bus, in real time.

mod arguments;
mod error;
mod follow;
mod live;
mod recording;
mod summary;

use std::process::ExitCode;

use can_motion::{AxisConfig, ReadBackScale};
use dyn_can::{DriveId, GearNumber, StepLimit};

use crate::confirm::confirm;
use crate::drive_ids::about;
use crate::interrupt;
use crate::link::Link;
use crate::output::{print, print_json, tell};
use crate::recording::WithRecording;
use crate::station::{Needs, Seen, Station, look};
use crate::trajectory::{Plan, WithMotion};
pub(crate) use arguments::Arguments;
use error::{GearDifference, RunError};
use follow::{Follow, places};
use recording::{RunRecording, write_page};

/// One axis of the motion, in the order of the columns.
#[derive(Debug)]
struct Axis {
    drive: DriveId,
    gear: GearNumber,
    needs: Needs,
}

/// Checks everything, asks, runs the motion, prints the summary.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, RunError> {
    let motion = arguments.motion.read().map_err(RunError::Motion)?;
    let plan = motion
        .plan(arguments.cycle_us, StepLimit::MAX)
        .map_err(RunError::Motion)?;
    let drives = motion.drives().map_err(RunError::Motion)?;
    let gears = motion.gear_numbers().map_err(RunError::Motion)?;
    let axes: Vec<Axis> = drives
        .iter()
        .zip(gears)
        .enumerate()
        .map(|(axis, (&drive, gear))| {
            let positions: Vec<i32> = plan.rows().map(|row| row[axis]).collect();
            Axis {
                drive,
                gear,
                needs: Needs::of(&positions, gear, arguments.cycle_us),
            }
        })
        .collect();
    let report = motion.report(&plan, &drives, StepLimit::MAX);
    if !arguments.json {
        report.show();
    }
    for axis in &axes {
        let within = arguments.limits.check(axis.drive, &axis.needs);
        within.map_err(RunError::Limit)?;
    }
    let recording = RunRecording::begin(arguments, motion.axes_about(&drives))?;
    let mut link = arguments.link.open().map_err(RunError::Open)?;
    if recording.is_some() {
        link.keep_frames();
    }
    admit(arguments, &mut link, &axes)?;
    confirm(&question(arguments, &drives, &plan), arguments.yes).map_err(RunError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(RunError::Interrupt)?;
    if !arguments.json {
        tell(format_args!("limits: {}", arguments.limits));
        if arguments.polls().status_us.is_none() {
            tell(
                "note: with --status-hz 0 nobody notices a drive that leaves the bus or loses its power",
            );
        }
    }
    let seen = match ask(arguments, &mut link, &axes) {
        Ok(seen) => seen,
        Err(error) => {
            if let Some(recording) = recording {
                recording.give_up(&mut link);
            }
            return Err(error);
        }
    };
    let configs = configs(arguments, &axes, |drive| {
        let seen = seen.iter().find(|seen| seen.drive == drive);
        seen.map_or(0, |seen| seen.position_counts)
    });
    let mut station =
        Station::new(&mut link, &configs, arguments.cycle_us).map_err(RunError::Config)?;
    let scales = axes.iter().map(|axis| arguments.axes.scale(axis.gear));
    let scales: Vec<ReadBackScale> = scales.collect();
    let view = match recording {
        Some(recording) => recording.attach(arguments, &mut station, &places(&drives), &scales)?,
        None => None,
    };
    let follow = Follow::new(station, &drives, scales);
    let (summary, recorded) = follow.run(&plan, !arguments.json && view.is_none());
    if let Some(view) = view {
        view.end(&summary.verdict(), summary.is_completed());
    }
    let is_recorded = write_page(arguments, &recorded, &summary) && recorded.report.is_complete();
    if arguments.json {
        print_json(&WithMotion {
            motion: &report,
            result: &WithRecording {
                result: &summary,
                recording: &recorded.report,
            },
        })
        .map_err(RunError::Print)?;
    } else {
        print(&summary).map_err(RunError::Print)?;
    }
    Ok(summary.exit_code(is_recorded))
}

/// The axes as the master wants them: with their limits around these positions, in ascending order of drive id.
fn configs(
    arguments: &Arguments,
    axes: &[Axis],
    position: impl Fn(DriveId) -> i32,
) -> Vec<AxisConfig> {
    let config = |axis: &Axis| {
        let limits = arguments.limits.of_axis(
            &axis.needs,
            position(axis.drive),
            axis.gear,
            arguments.cycle_us,
        );
        arguments
            .axes
            .axis(axis.drive, axis.gear, limits, arguments.polls())
    };
    let mut configs: Vec<AxisConfig> = axes.iter().map(config).collect();
    configs.sort_unstable_by_key(|config| config.drive);
    configs
}

/// Refuses what the bus cannot carry, before anything is asked or sent.
fn admit(arguments: &Arguments, link: &mut Link, axes: &[Axis]) -> Result<(), RunError> {
    let configs = configs(arguments, axes, |_| 0);
    Station::new(link, &configs, arguments.cycle_us)
        .map(drop)
        .map_err(RunError::Config)
}

/// Asks the drives what they are and where they stand, and refuses a scale that is not theirs.
fn ask(arguments: &Arguments, link: &mut Link, axes: &[Axis]) -> Result<Vec<Seen>, RunError> {
    let mut ascending: Vec<DriveId> = axes.iter().map(|axis| axis.drive).collect();
    ascending.sort_unstable();
    let seen = look(link, arguments.axes, &ascending).map_err(RunError::Look)?;
    let of = |drive: DriveId| seen.iter().find(|seen| seen.drive == drive);
    let differences: Vec<GearDifference> = axes
        .iter()
        .filter_map(|axis| {
            Some(GearDifference {
                drive: axis.drive,
                expected: axis.gear,
                actual: of(axis.drive)?.gear,
            })
        })
        .collect();
    if differences.iter().any(GearDifference::is_one) {
        return Err(RunError::Gear(differences));
    }
    Ok(seen)
}

fn question(arguments: &Arguments, drives: &[DriveId], plan: &Plan) -> String {
    let seconds = plan.cycles() as f64 * f64::from(arguments.cycle_us) * 1e-6;
    format!(
        "{} for {seconds:.1} s, {}. Is everybody clear of the machine?",
        about(
            drives,
            "will be enabled and its motor will MOVE",
            "will be enabled and their motors will MOVE"
        ),
        arguments.limits
    )
}
