//! A vehicle that follows twists.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::process::ExitCode;

use can_motion::wheel::WheelConfig;
use diff_drive::{DiffDrive, Odometry, Phase, Twist};
use zlac8030l::NodeId;

use super::follow::{Motion, Wheels};
use super::recording::WheelRecording;
use super::stream::{Due, Twists};
use super::summary::{Counts, Summary, VehiclePose, WheelCounts};
use super::{Arguments, CYCLE_US};
use crate::confirm::confirm;
use crate::hub::bus::Bus;
use crate::hub::error::HubError;
use crate::hub::look::Look;
use crate::hub::nodes::named;
use crate::hub::station::WheelStation;
use crate::interrupt;
use crate::output::{print, print_json, tell};
use crate::recording::AxisAbout;
use crate::twist::{TwistError, Vehicle};

/// Largest number that 60FFh holds, whatever it counts (Z34); one less, because rounding is carried on.
const MOST_NUMBER: f64 = 999.0;
/// Cycles in which the wheels ramp down after the last twist, at most.
const LAST_CYCLES: u32 = 1_000;

/// Twists, a vehicle and its way.
struct Driving {
    twists: Twists,
    vehicle: Vehicle,
    control: DiffDrive,
    odometry: Odometry,
    log: Option<BufWriter<File>>,
    phase: Phase,
    dead_man_stops: u32,
    limited_cycles: u32,
    /// Cycles since the last twist was given out.
    over: u32,
    stopped_by: Option<TwistError>,
    now_us: u64,
    is_told: bool,
}

impl Driving {
    fn tell_of(&mut self, phase: Phase) {
        if phase == self.phase {
            return;
        }
        match phase {
            Phase::TimedOut => {
                self.dead_man_stops += 1;
                tell("no twist came in time: the wheels ramp to 0");
            }
            Phase::Following if self.phase == Phase::TimedOut => {
                tell("a twist came: the wheels go on");
            }
            Phase::Following | Phase::Waiting => {}
        }
        self.phase = phase;
    }
}

impl Motion for Driving {
    fn targets(&mut self, now_us: u64, _: u64) -> Option<Vec<i32>> {
        self.now_us = now_us;
        let due = if self.over > 0 {
            Ok(Due::Over)
        } else {
            self.twists.due(now_us)
        };
        match due {
            Ok(Due::Twist(line)) => self.control.set_twist(now_us, line.twist),
            Ok(Due::Nothing) => {}
            Ok(Due::Over) => {
                // The end of the twists is a stop, and no silence.
                self.control.set_twist(now_us, Twist::ZERO);
                self.over += 1;
            }
            Err(error) => {
                // The wheels ramp down on their curve, and the error is said at the end.
                self.stopped_by = Some(error);
                self.over = 1;
                self.control.set_twist(now_us, Twist::ZERO);
            }
        }
        let command = self.control.step(now_us);
        self.tell_of(command.phase);
        self.limited_cycles += u32::from(command.is_limited);
        let stands = (command.left, command.right) == (0, 0);
        if self.over > 1 && stands || self.over > LAST_CYCLES {
            return None;
        }
        let (left, right) = self.vehicle.mounted((command.left, command.right));
        Some(vec![left, right])
    }

    fn note(&mut self, station: &WheelStation<'_>, wheels: &Wheels) -> Result<(), HubError> {
        let positions = wheels.positions(station).unwrap_or_default();
        let [left, right] = positions[..] else {
            return Ok(());
        };
        let (left, right) = self.vehicle.mounted((left, right));
        let pose = match self.odometry.update(left, right) {
            Ok(pose) => pose,
            Err(error) => {
                tell(format_args!("the odometry lost its way: {error}"));
                self.odometry.rebase(left, right);
                self.odometry.pose()
            }
        };
        if let Some(log) = &mut self.log {
            writeln!(
                log,
                "{:.6},{:.6},{:.6},{:.6},{left},{right}",
                self.now_us as f64 * 1e-6,
                pose.x_m,
                pose.y_m,
                pose.heading_rad
            )
            .map_err(HubError::Print)?;
        }
        self.is_told = true;
        Ok(())
    }
}

/// A vehicle that may drive.
struct Prepared {
    vehicle: Vehicle,
    speed_resolution: u16,
    wheels: Wheels,
    configs: Vec<WheelConfig>,
}

/// Checks everything, asks, drives, prints where the vehicle is.
pub(super) fn run(arguments: &Arguments, source: &str) -> Result<ExitCode, HubError> {
    let nodes = nodes_of(arguments)?;
    let twists = Twists::open(source)?;
    let mut bus = Bus::open(&arguments.link)?;
    let sides = ["left", "right"].into_iter().zip(&nodes);
    let axes = sides.map(|(side, &node)| AxisAbout {
        name: side.to_owned(),
        ..AxisAbout::of_node(node)
    });
    let file = (source != "-").then(|| Path::new(source));
    let recording = WheelRecording::open(arguments, axes.collect(), file, bus.link())?;
    let log = open_log(arguments);
    let prepared = log.and_then(|log| Ok((log, prepare(arguments, &nodes, &mut bus)?)));
    let (recording, (log, prepared)) = recording.with(prepared, bus.link())?;
    let mut driving = Driving {
        twists,
        control: prepared.vehicle.drive(prepared.speed_resolution),
        odometry: prepared.vehicle.odometry(),
        vehicle: prepared.vehicle,
        log,
        phase: Phase::Waiting,
        dead_man_stops: 0,
        limited_cycles: 0,
        over: 0,
        stopped_by: None,
        now_us: 0,
        is_told: false,
    };
    if !arguments.json {
        tell("the wheels are being enabled; Ctrl-C slows them down and switches them off");
    }
    let (configs, wheels) = (&prepared.configs, &prepared.wheels);
    let ended = recording.follow(&mut bus, configs, wheels, &mut driving)?;
    let mut summary = summary_of(&driving, ended.counts, &wheels.nodes());
    ended.close(&mut summary);
    let printed = if arguments.json {
        print_json(&summary)
    } else {
        print(&summary)
    };
    printed.map_err(HubError::Print)?;
    match driving.stopped_by {
        Some(error) => Err(HubError::Stream(format!(
            "{source}: {error}. The wheels were stopped there and their power is off"
        ))),
        None => Ok(summary.exit_code()),
    }
}

/// Looks at the drives, checks the vehicle against them, asks.
fn prepare(arguments: &Arguments, nodes: &[NodeId], bus: &mut Bus) -> Result<Prepared, HubError> {
    let look = |&node: &NodeId| Look::at(bus, node);
    let looks: Vec<Look> = nodes.iter().map(look).collect::<Result<_, _>>()?;
    let look = alike(&looks)?;
    let vehicle = arguments
        .twist
        .vehicle(look.counts_per_turn)
        .map_err(|error| HubError::Input(error.to_string()))?;
    if look.units(vehicle.max_rpm) > MOST_NUMBER {
        return Err(HubError::Input(format!(
            "--max-rpm {}: at 1/{} r/min (202Fh:05) a wheel can be told at most {:.1} r/min",
            vehicle.max_rpm,
            look.speed_resolution,
            MOST_NUMBER / f64::from(look.speed_resolution)
        )));
    }
    let question = format!(
        "The vehicle on {} will DRIVE, at up to {} r/min of its wheels. Is everybody clear of it, and is the way free?",
        named(nodes),
        vehicle.max_rpm
    );
    confirm(&question, arguments.yes).map_err(HubError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(HubError::Interrupt)?;
    let wheels = Wheels::new(looks);
    let most_rpm = vehicle.max_rpm + 1.0 / f64::from(look.speed_resolution);
    let most_rpm_per_s = 2.0 * vehicle.most_rpm_per_s;
    let ascending = wheels.ascending().into_iter();
    let config = |look: &Look| look.follows_speeds(most_rpm, most_rpm_per_s, CYCLE_US);
    Ok(Prepared {
        configs: ascending.map(config).collect(),
        speed_resolution: look.speed_resolution,
        vehicle,
        wheels,
    })
}

fn summary_of(driving: &Driving, counts: Counts, nodes: &[NodeId]) -> Summary {
    let pose = driving.odometry.pose();
    let (left_counts, right_counts) = driving.odometry.travel_counts();
    let mounted = driving
        .vehicle
        .mounted((left_counts as i32, right_counts as i32));
    Summary {
        complete: counts.stands && !counts.interrupted && driving.stopped_by.is_none(),
        wheels: nodes
            .iter()
            .zip([mounted.0, mounted.1])
            .map(|(node, counts)| WheelCounts {
                node: node.get(),
                counts: driving.is_told.then_some(counts),
            })
            .collect(),
        pose: Some(VehiclePose {
            x_m: pose.x_m,
            y_m: pose.y_m,
            heading_rad: pose.heading_rad,
            from_start_m: pose.distance_m(),
            left_counts,
            right_counts,
        }),
        dead_man_stops: driving.dead_man_stops,
        limited_cycles: driving.limited_cycles,
        ..Summary::new(counts)
    }
}

fn nodes_of(arguments: &Arguments) -> Result<Vec<NodeId>, HubError> {
    let named = arguments.motion.hub_motors().unwrap_or_default();
    match named {
        [left, right] => Ok(vec![*left, *right]),
        other => Err(HubError::Input(format!(
            "a vehicle has two wheels: name them with --drives zlac:LEFT,RIGHT, got {} nodes",
            other.len()
        ))),
    }
}

/// Both wheels count alike.
fn alike(looks: &[Look]) -> Result<Look, HubError> {
    match looks {
        [left, right]
            if left.counts_per_turn == right.counts_per_turn
                && left.speed_resolution == right.speed_resolution =>
        {
            Ok(*left)
        }
        [left, right] => Err(HubError::Input(format!(
            "the wheels do not count alike: {} and {} counts a turn (200Bh), 1/{} and 1/{} r/min (202Fh:05); give them the same with `motionctl write --drives zlac`",
            left.counts_per_turn,
            right.counts_per_turn,
            left.speed_resolution,
            right.speed_resolution
        ))),
        _ => Err(HubError::Input("a vehicle has two wheels".to_owned())),
    }
}

fn open_log(arguments: &Arguments) -> Result<Option<BufWriter<File>>, HubError> {
    let Some(path) = &arguments.odometry else {
        return Ok(None);
    };
    let file = File::create(path)
        .map_err(|error| HubError::File(format!("cannot write {}: {error}", path.display())))?;
    let mut log = BufWriter::new(file);
    writeln!(log, "time_s,x_m,y_m,heading_rad,left_counts,right_counts")
        .map_err(HubError::Print)?;
    Ok(Some(log))
}
