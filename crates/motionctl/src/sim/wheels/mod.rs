//! `motionctl sim --drives zlac`: hub motors on CANopen follow speeds from a file, such as those of a differential drive.

mod bench;
mod setup;
mod summary;

use std::process::ExitCode;

use zlac8030l::NodeId;

use super::arguments::Arguments;
use super::error::SimError;
use crate::exit;
use crate::output::{print, print_json};
use crate::recording::create;
use crate::trajectory::{Plan, WithMotion};
use bench::Bench;
use setup::{MOST_SPEED, MOST_WHEELS, Setup};

/// First node of a list that was not given: the factory setting of a drive.
const FIRST_NODE: usize = 4;

/// Checks everything, runs the speeds, prints the summary.
pub(super) fn run(arguments: &Arguments, nodes: &[NodeId]) -> Result<ExitCode, SimError> {
    if let Some(option) = arguments.not_for_wheels() {
        return Err(SimError::NotForWheels { option });
    }
    let motion = arguments.motion.read().map_err(SimError::Motion)?;
    let setup = Setup {
        nodes: nodes_of(nodes, motion.axes())?,
        cycle_us: arguments.wheel_cycle_us(),
        bit_rate: arguments.wheel_bit_rate(),
        speed_resolution: arguments.speed_resolution,
    };
    let plan = motion
        .speeds(setup.cycle_us, setup.speed_resolution)
        .map_err(SimError::Motion)?;
    check_speeds(&plan, &setup)?;
    let candump = match &arguments.recording.candump {
        Some(path) => Some(create(path).map_err(|source| SimError::Write {
            path: path.clone(),
            source,
        })?),
        None => None,
    };
    let motion = motion.wheel_report(&plan, &setup.nodes, setup.speed_resolution);
    if !arguments.json {
        motion.show();
    }
    let summary = Bench::new(setup, candump)?.run(&plan, !arguments.json)?;
    if arguments.json {
        print_json(&WithMotion {
            motion: &motion,
            result: &summary,
        })
        .map_err(SimError::Print)?;
    } else {
        print(&summary).map_err(SimError::Print)?;
    }
    Ok(if summary.promises_kept {
        ExitCode::SUCCESS
    } else {
        exit::BROKEN_PROMISE.into()
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
