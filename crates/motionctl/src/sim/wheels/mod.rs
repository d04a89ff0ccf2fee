//! `motionctl sim --drives zlac`: hub motors on CANopen follow speeds from a file, such as those of a differential drive.

mod bench;
mod faults;
mod files;
mod setup;
mod summary;
mod vehicle;

use std::path::Path;
use std::process::ExitCode;

use zlac8030l::NodeId;

use super::arguments::Arguments;
use super::error::SimError;
use crate::exit;
use crate::output::{print, print_json};
use crate::recording::{AxisAbout, Recorded, WithRecording};
use crate::schema::Either;
use crate::trajectory::{Plan, WithMotion};
use crate::twist::read_file;
use bench::Bench;
use faults::Script;
use files::{Files, write_page};
use setup::{MOST_SPEED, MOST_WHEELS, Setup};

/// First node of a list that was not given: the factory setting of a drive.
const FIRST_NODE: usize = 4;

/// A left and a right one.
const WHEELS_OF_VEHICLE: usize = 2;
/// Of a drive as it leaves the factory: 1024 lines.
const COUNTS_PER_TURN: f64 = 4_096.0;

/// Checks everything, runs the speeds, prints the summary.
pub(super) fn run(arguments: &Arguments, nodes: &[NodeId]) -> Result<ExitCode, SimError> {
    if let Some(file) = &arguments.twist.twist {
        return drive(arguments, nodes, Path::new(file));
    }
    let motion = arguments.motion.read().map_err(SimError::Motion)?;
    let setup = setup_of(
        arguments,
        nodes_of(nodes, motion.axes().map_err(SimError::Motion)?)?,
    )?;
    let plan = motion
        .speeds(setup.cycle_us, setup.speed_resolution)
        .map_err(SimError::Motion)?;
    check_speeds(&plan, &setup)?;
    let axes = motion.wheels_about(&setup.nodes);
    let recording = Files::open(arguments, &setup, axes.map_err(SimError::Motion)?)?;
    let motion = motion
        .wheel_report(&plan, &setup.nodes, setup.speed_resolution)
        .map_err(SimError::Motion)?;
    if !arguments.json {
        motion.show();
    }
    let motion_us = plan.cycles() as u64 * u64::from(setup.cycle_us);
    let (summary, recorded) = recording.watched(arguments, motion_us, |files, spectator| {
        let bench = Bench::new(setup, files.recorder, spectator)?;
        bench.run(&plan, arguments.shows_progress())
    })?;
    write_page(arguments, &recorded, &summary.for_page())?;
    let result = WithRecording {
        result: &summary,
        recording: &recorded.report,
    };
    if arguments.json {
        print_json(&WithMotion {
            motion: &motion,
            result: &result,
        })
        .map_err(SimError::Print)?;
    } else {
        print(&summary).map_err(SimError::Print)?;
    }
    Ok(exit_code(summary.promises_kept, &recorded))
}

/// Drives a vehicle by twists, and prints where it is.
fn drive(arguments: &Arguments, nodes: &[NodeId], file: &Path) -> Result<ExitCode, SimError> {
    let in_file = |source| SimError::Twist {
        path: file.to_owned(),
        source,
    };
    let lines = read_file(file).map_err(in_file)?;
    let setup = setup_of(arguments, nodes_of(nodes, WHEELS_OF_VEHICLE)?)?;
    let vehicle = arguments
        .twist
        .vehicle(COUNTS_PER_TURN)
        .map_err(SimError::Vehicle)?;
    // A number more than the limit, because rounding is carried on.
    let most_rpm = (MOST_SPEED - 1).unsigned_abs() / u32::from(setup.speed_resolution);
    if vehicle.max_rpm > f64::from(most_rpm) {
        return Err(SimError::WheelSpeed {
            most_rpm,
            actual_rpm: vehicle.max_rpm.ceil() as u32,
        });
    }
    let axes = ["left", "right"].into_iter().zip(&setup.nodes);
    let axes = axes.map(|(side, &node)| AxisAbout {
        name: side.to_owned(),
        ..AxisAbout::of_node(node)
    });
    let recording = Files::open(arguments, &setup, axes.collect())?;
    let last_s = lines.last().map_or(0.0, |line| line.time_s);
    let motion_us = (last_s * 1e6) as u64;
    let (summary, recorded) = recording.watched(arguments, motion_us, |files, spectator| {
        let bench = Bench::new(setup, files.recorder, spectator)?;
        bench.drive(&vehicle, &lines, arguments.shows_progress())
    })?;
    write_page(arguments, &recorded, &summary.for_page())?;
    if arguments.json {
        print_json(&WithRecording {
            result: &summary,
            recording: &recorded.report,
        })
        .map_err(SimError::Print)?;
    } else {
        print(&summary).map_err(SimError::Print)?;
    }
    Ok(exit_code(summary.promises_kept, &recorded))
}

fn exit_code(promises_kept: bool, recorded: &Recorded) -> ExitCode {
    if promises_kept && recorded.report.is_complete() {
        ExitCode::SUCCESS
    } else {
        exit::BROKEN_PROMISE.into()
    }
}

fn setup_of(arguments: &Arguments, nodes: Vec<NodeId>) -> Result<Setup, SimError> {
    let faults = match arguments.script_text()? {
        None => Script::default(),
        Some((path, text)) => {
            Script::parse(&text, &nodes).map_err(|what| SimError::WheelScript { path, what })?
        }
    };
    Ok(Setup {
        faults,
        nodes,
        cycle_us: arguments.wheel_cycle_us(),
        bit_rate: arguments.wheel_bit_rate(),
        speed_resolution: arguments.speed_resolution,
        ramp_ms: arguments.ramp_ms,
        response_delay: arguments.drive_options.response_delay(),
        seed: arguments.drive_options.seed(),
    })
}

/// Refuses speeds that 60FFh cannot hold.
fn check_speeds(plan: &Plan, setup: &Setup) -> Result<(), SimError> {
    let fastest = plan
        .rows()
        .flatten()
        .map(|speed| speed.unsigned_abs())
        .max();
    let resolution = u32::from(setup.speed_resolution);
    let most = MOST_SPEED.unsigned_abs();
    match fastest {
        Some(fastest) if fastest > most => Err(SimError::WheelSpeed {
            most_rpm: most / resolution,
            actual_rpm: fastest.div_ceil(resolution),
        }),
        _ => Ok(()),
    }
}

/// The node of each wheel, in the order of the columns.
fn nodes_of(given: &[NodeId], wheels: usize) -> Result<Vec<NodeId>, SimError> {
    let nodes: Vec<NodeId> = match given {
        [] => NodeId::all().skip(FIRST_NODE - 1).take(wheels).collect(),
        given => given.to_vec(),
    };
    if nodes.len() != wheels || wheels > MOST_WHEELS {
        return Err(SimError::WheelCount {
            most: MOST_WHEELS,
            columns: wheels,
            nodes: nodes.len(),
        });
    }
    Ok(nodes)
}

/// The shape of what `--json` prints: of wheels that are moved by a file, or of a vehicle.
pub(super) fn schema() -> schemars::Schema {
    type Wheels<'a> = WithMotion<'a, WithRecording<'a, summary::Summary>>;
    crate::schema::of::<Either<Wheels<'_>, WithRecording<'_, vehicle::RunSummary>>>()
}
