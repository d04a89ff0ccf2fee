//! Speeds from a file.

use std::process::ExitCode;

use can_motion::wheel::WheelConfig;
use zlac8030l::NodeId;

use super::follow::{Motion, Wheels};
use super::recording::WheelRecording;
use super::summary::{Summary, WheelCounts};
use super::{Arguments, CYCLE_US};
use crate::confirm::confirm;
use crate::hub::bus::Bus;
use crate::hub::error::HubError;
use crate::hub::look::Look;
use crate::hub::nodes::named;
use crate::hub::station::WheelStation;
use crate::interrupt;
use crate::output::{print, print_json, tell};
use crate::trajectory::{MotionFile, MotionReport, Plan, WithMotion};

/// Largest number that 60FFh holds, whatever it counts (Z34).
const MOST_NUMBER: u32 = 1_000;

/// The rows of a file.
struct Rows {
    rows: Vec<Vec<i32>>,
    start: Option<Vec<i32>>,
    end: Option<Vec<i32>>,
}

impl Motion for Rows {
    fn targets(&mut self, _: u64, cycle: u64) -> Option<Vec<i32>> {
        self.rows.get(usize::try_from(cycle).ok()?).cloned()
    }

    fn note(&mut self, station: &WheelStation<'_>, wheels: &Wheels) -> Result<(), HubError> {
        let positions = wheels.positions(station);
        self.start = self.start.take().or_else(|| positions.clone());
        self.end = positions.or_else(|| self.end.take());
        Ok(())
    }
}

/// A file whose wheels may turn.
struct Prepared {
    plan: Plan,
    report: MotionReport,
    wheels: Wheels,
    configs: Vec<WheelConfig>,
}

/// Checks everything, asks, runs the speeds, prints the summary.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    let motion = arguments.motion.read().map_err(input)?;
    let nodes = nodes_of(arguments, motion.axes().map_err(input)?)?;
    let axes = motion.wheels_about(&nodes).map_err(input)?;
    let mut bus = Bus::open(&arguments.link)?;
    let recording = WheelRecording::open(arguments, axes, arguments.motion.file(), bus.link())?;
    let prepared = prepare(arguments, &motion, &nodes, &mut bus);
    let (recording, prepared) = recording.with(prepared, bus.link())?;
    let mut rows = Rows {
        rows: prepared.plan.rows().collect(),
        start: None,
        end: None,
    };
    if !arguments.json {
        tell("the wheels are being enabled; Ctrl-C slows them down and switches them off");
    }
    let (configs, wheels) = (&prepared.configs, &prepared.wheels);
    let ended = recording.follow(&mut bus, configs, wheels, &mut rows)?;
    let counts = ended.counts;
    let turned = |place: usize| {
        let (start, end) = (rows.start.as_ref()?, rows.end.as_ref()?);
        Some(end.get(place)?.wrapping_sub(*start.get(place)?))
    };
    let wheels = nodes.iter().enumerate().map(|(place, node)| WheelCounts {
        node: node.get(),
        counts: turned(place),
    });
    let mut summary = Summary {
        complete: counts.stands && !counts.interrupted,
        wheels: wheels.collect(),
        ..Summary::new(counts)
    };
    ended.close(&mut summary);
    let printed = if arguments.json {
        print_json(&WithMotion {
            motion: &prepared.report,
            result: &summary,
        })
    } else {
        print(&summary)
    };
    printed.map_err(HubError::Print)?;
    Ok(summary.exit_code())
}

/// Looks at the drives, checks the file against them, asks.
fn prepare(
    arguments: &Arguments,
    motion: &MotionFile<'_>,
    nodes: &[NodeId],
    bus: &mut Bus,
) -> Result<Prepared, HubError> {
    let look = |&node: &NodeId| Look::at(bus, node);
    let looks: Vec<Look> = nodes.iter().map(look).collect::<Result<_, _>>()?;
    let resolution = same_resolution(&looks)?;
    let plan = motion.speeds(CYCLE_US, resolution).map_err(input)?;
    check(arguments, &plan, resolution)?;
    let report = motion
        .wheel_report(&plan, nodes, resolution)
        .map_err(input)?;
    if !arguments.json {
        report.show();
    }
    let question = format!(
        "Will be enabled and TURN for {:.1} s: {}. Is everybody clear of the machine?",
        plan.cycles() as f64 * f64::from(CYCLE_US) * 1e-6,
        named(nodes)
    );
    confirm(&question, arguments.yes).map_err(HubError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(HubError::Interrupt)?;
    let wheels = Wheels::new(looks);
    let most_rpm = fastest(&plan) as f64 / f64::from(resolution);
    let most_rpm_per_s = 2.0 * arguments.max_acceleration;
    let ascending = wheels.ascending().into_iter();
    let config = |look: &Look| look.follows_speeds(most_rpm, most_rpm_per_s, CYCLE_US);
    Ok(Prepared {
        configs: ascending.map(config).collect(),
        plan,
        report,
        wheels,
    })
}

fn input(error: impl core::fmt::Display) -> HubError {
    HubError::Input(error.to_string())
}

fn nodes_of(arguments: &Arguments, wheels: usize) -> Result<Vec<NodeId>, HubError> {
    let named = arguments.motion.hub_motors().unwrap_or_default();
    let nodes: Vec<NodeId> = match named {
        [] => NodeId::all()
            .filter(|node| *node >= NodeId::FACTORY)
            .take(wheels)
            .collect(),
        named => named.to_vec(),
    };
    if nodes.len() == wheels {
        return Ok(nodes);
    }
    Err(HubError::Input(format!(
        "--drives: expected one node for each of the {wheels} columns, got {}",
        nodes.len()
    )))
}

/// One number for all wheels: a file has one resolution.
fn same_resolution(looks: &[Look]) -> Result<u16, HubError> {
    let first = looks.first().map_or(1, |look| look.speed_resolution);
    match looks.iter().find(|look| look.speed_resolution != first) {
        None => Ok(first),
        Some(other) => Err(HubError::Input(format!(
            "node {} counts 1/{} r/min and the first one 1/{first} (202Fh:05): give them the same with `motionctl write --drives zlac`",
            other.node, other.speed_resolution
        ))),
    }
}

fn fastest(plan: &Plan) -> u32 {
    plan.rows()
        .flatten()
        .map(i32::unsigned_abs)
        .max()
        .unwrap_or(0)
        .max(1)
}

/// Refuses speeds that 60FFh cannot hold, and changes that are faster than the user allows.
fn check(arguments: &Arguments, plan: &Plan, resolution: u16) -> Result<(), HubError> {
    let per_rpm = f64::from(resolution);
    if fastest(plan) > MOST_NUMBER {
        return Err(HubError::Input(format!(
            "at 1/{resolution} r/min (202Fh:05) a wheel can be told at most {} r/min, the file has {}: lower the number in the drive",
            MOST_NUMBER / u32::from(resolution),
            f64::from(fastest(plan)) / per_rpm
        )));
    }
    let rows: Vec<Vec<i32>> = plan.rows().collect();
    let rpm_per_s = SPANS
        .map(|cycles| f64::from(most_change(&rows, cycles)) / cycles as f64)
        .into_iter()
        .fold(0.0, f64::max)
        / per_rpm
        / (f64::from(CYCLE_US) * 1e-6);
    if rpm_per_s > arguments.max_acceleration {
        return Err(HubError::Input(format!(
            "the file changes a speed by {rpm_per_s:.0} r/min per second, --max-acceleration allows {}: slow it down, or raise the limit",
            arguments.max_acceleration
        )));
    }
    Ok(())
}

/// Cycles over which a change of speed is measured: one for steps, more for ramps whose steps are smaller than a number of the drive.
const SPANS: [usize; 3] = [1, 10, 50];

/// The largest change of a speed within so many cycles. Rounding alone makes a change of up to one number.
fn most_change(rows: &[Vec<i32>], cycles: usize) -> u32 {
    let later = rows.iter().skip(cycles);
    let changes = rows.iter().zip(later).flat_map(|(before, after)| {
        let wheels = before.iter().zip(after);
        wheels.map(|(before, after)| before.abs_diff(*after))
    });
    changes.max().unwrap_or(0).saturating_sub(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ramps_below_a_number_a_cycle_are_measured_over_more_cycles() {
        // 1.2 numbers a cycle.
        let rows: Vec<Vec<i32>> = (0..60).map(|cycle| vec![cycle * 12 / 10]).collect();
        assert_eq!(SPANS.map(|cycles| most_change(&rows, cycles)), [1, 11, 59]);
        assert_eq!(most_change(&rows, 100), 0);
    }
}
