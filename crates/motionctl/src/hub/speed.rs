//! `motionctl speed --drives zlac`: turns wheels at a speed, for a time.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use schemars::JsonSchema;
use serde::Serialize;

use super::bus::Bus;
use super::error::HubError;
use super::jog::acceleration;
use super::look::Look;
use super::nodes::{SomeNodes, named};
use super::station::WheelStation;
use crate::confirm::confirm;
use crate::exit;
use crate::interrupt;
use crate::link::LinkOptions;
use crate::output::{print, print_json, tell};

const CYCLE_US: u32 = 10_000;
const MOST_RPM: f64 = 1_000.0;

const EXAMPLES: &str = "\
Examples:
  motionctl speed --drives zlac --slcan /dev/ttyACM0 --rpm 60 --for 5
  motionctl speed --drives zlac:4,5 --can can0 --rpm 30,-30 --for 2 --yes --json
  motionctl speed --drives zlac --can can0 --rpm 100 --for 2 --csv step.csv      speed and torque of every cycle

The wheels ramp up together, turn for the time of --for at the speed, ramp down and are switched off: a vehicle on a slope rolls away
then. Ctrl-C ramps down at once. The speed is rounded to the resolution of the drive (202Fh:05). Let the wheels hang free of the ground.

Exit status: 0 the wheels reached the speed and stand again, 1 one did not, had a fault, or did not confirm that its power is off, 2 not
confirmed, enabled already, or out of range, and nothing has moved, 3 the link failed, 130 stopped by Ctrl-C.";

/// Options of `motionctl speed --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    link: LinkOptions,
    #[command(flatten)]
    drives: SomeNodes,
    /// Speed in r/min, one for all or one each in the order of the nodes, up to 1000.
    #[arg(long, value_name = "RPM", required = true, allow_hyphen_values = true, value_delimiter = ',', value_parser = rpm)]
    rpm: Vec<f64>,
    /// Seconds at the speed.
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    seconds: f64,
    /// Fastest change of a speed in r/min per second.
    #[arg(long, value_name = "RPM_PER_S", default_value = "200", value_parser = acceleration)]
    max_acceleration: f64,
    /// Write target, speed, torque and position of every cycle.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Move without asking.
    #[arg(long)]
    yes: bool,
    /// Print what the wheels did as JSON.
    #[arg(long)]
    json: bool,
}

/// One wheel at the end.
#[derive(Debug, Clone, Serialize, JsonSchema)]
struct WheelEnd {
    node: u8,
    /// What was asked for, rounded to the resolution of the drive.
    rpm: f64,
    /// Mean of the speeds that were read in the last half of the time.
    mean_rpm: Option<f64>,
    /// How far it turned, by its own count.
    counts: Option<i32>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct End {
    wheels: Vec<WheelEnd>,
    reached: bool,
    interrupted: bool,
    merged_cycles: u64,
}

/// One wheel on its way.
#[derive(Debug, Clone)]
struct Turning {
    look: Look,
    /// In 1/n r/min.
    target: i32,
    start_counts: Option<i32>,
    end_counts: Option<i32>,
    speeds_rpm: Vec<f64>,
}

/// Asks, turns, prints what the wheels did.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    let nodes = arguments.drives.in_order();
    let speeds = speeds_of(arguments, nodes.len())?;
    let mut csv = open_csv(arguments)?;
    let mut bus = Bus::open(&arguments.link)?;
    let mut wheels = Vec::new();
    for (&node, rpm) in nodes.iter().zip(speeds) {
        let look = Look::at(&mut bus, node)?;
        wheels.push(Turning {
            target: target_of(&look, rpm)?,
            look,
            start_counts: None,
            end_counts: None,
            speeds_rpm: Vec::new(),
        });
    }
    wheels.sort_by_key(|wheel| wheel.look.node);
    let question = format!(
        "Will TURN, powered, at up to {} r/min for {} s: {}. Is everybody clear, and do they hang free?",
        arguments
            .rpm
            .iter()
            .fold(0.0, |most: f64, rpm| most.max(rpm.abs())),
        arguments.seconds,
        named(&nodes)
    );
    confirm(&question, arguments.yes).map_err(HubError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(HubError::Interrupt)?;
    let configs: Vec<_> = wheels
        .iter()
        .map(|wheel| {
            let look = &wheel.look;
            let most = f64::from(wheel.target.abs()) / look.units(1.0);
            look.follows_speeds(most, arguments.max_acceleration, CYCLE_US)
        })
        .collect();
    if !arguments.json {
        tell(format_args!(
            "being enabled and turned: {}; Ctrl-C stops",
            named(&nodes)
        ));
    }
    let mut station = WheelStation::new(bus.link(), &configs, CYCLE_US)?;
    let turned = turn(&mut station, arguments, &mut wheels, csv.as_mut());
    let (is_interrupted, _) = station.end(turned)?;
    let end = end_of(&wheels, is_interrupted, station.pace().merged);
    show(&end, arguments.json)?;
    Ok(match (is_interrupted, end.reached) {
        (true, _) => exit::INTERRUPTED.into(),
        (false, true) => ExitCode::SUCCESS,
        (false, false) => exit::BROKEN_PROMISE.into(),
    })
}

fn speeds_of(arguments: &Arguments, wheels: usize) -> Result<Vec<f64>, HubError> {
    match arguments.rpm.as_slice() {
        [one] => Ok(vec![*one; wheels]),
        each if each.len() == wheels => Ok(each.to_vec()),
        each => Err(HubError::Input(format!(
            "--rpm: expected one speed or {wheels}, one for each node, got {}",
            each.len()
        ))),
    }
}

fn target_of(look: &Look, rpm: f64) -> Result<i32, HubError> {
    let units = look.units(rpm).round();
    // 60FFh is limited to +-1000 whatever it counts (Z34).
    if units.abs() > 1_000.0 {
        return Err(HubError::Input(format!(
            "node {} counts 1/{} r/min and takes at most {} r/min, got {rpm}: lower 202Fh:05, save it and restart the drive",
            look.node,
            look.speed_resolution,
            1_000.0 / f64::from(look.speed_resolution)
        )));
    }
    if units == 0.0 {
        return Err(HubError::Input(format!(
            "node {} counts 1/{} r/min: {rpm} r/min rounds to 0; raise 202Fh:05, save it and restart the drive",
            look.node, look.speed_resolution
        )));
    }
    Ok(units as i32)
}

fn open_csv(arguments: &Arguments) -> Result<Option<BufWriter<File>>, HubError> {
    let Some(path) = &arguments.csv else {
        return Ok(None);
    };
    let file = File::create(path)
        .map_err(|error| HubError::File(format!("cannot write {}: {error}", path.display())))?;
    let mut file = BufWriter::new(file);
    writeln!(
        file,
        "time_s,node,target_rpm,speed_rpm,torque,position_counts"
    )
    .map_err(HubError::Print)?;
    Ok(Some(file))
}

/// Returns whether the user has stopped it.
fn turn(
    station: &mut WheelStation<'_>,
    arguments: &Arguments,
    wheels: &mut [Turning],
    mut csv: Option<&mut BufWriter<File>>,
) -> Result<bool, HubError> {
    station.bring_up()?;
    let fastest = wheels
        .iter()
        .map(|wheel| f64::from(wheel.target.abs()) / wheel.look.units(1.0))
        .fold(0.0, f64::max);
    let ramp_s = fastest / arguments.max_acceleration;
    let start = station.now();
    loop {
        let at_s = station.now().us_since(start) as f64 * 1e-6;
        if interrupt::requests() > 0 || at_s >= ramp_s + arguments.seconds {
            break;
        }
        let share = (at_s / ramp_s).min(1.0);
        station.cycle(|master, _| {
            for (place, wheel) in wheels.iter().enumerate() {
                // Refused after a fault, which is looked for below.
                let target = (f64::from(wheel.target) * share).round() as i32;
                let _ = master.set_target(place, target);
            }
        })?;
        if let Some((node, fault)) = station.first_fault() {
            return Err(HubError::WheelFault { node, fault });
        }
        let is_steady = at_s >= ramp_s + arguments.seconds / 2.0;
        note(station, wheels, at_s, is_steady, csv.as_deref_mut())?;
    }
    let is_interrupted = interrupt::requests() > 0;
    station.come_to_rest()?;
    note(
        station,
        wheels,
        station.now().us_since(start) as f64 * 1e-6,
        false,
        csv,
    )?;
    Ok(is_interrupted)
}

fn note(
    station: &WheelStation<'_>,
    wheels: &mut [Turning],
    at_s: f64,
    is_steady: bool,
    mut csv: Option<&mut BufWriter<File>>,
) -> Result<(), HubError> {
    for (wheel, snapshot) in wheels.iter_mut().zip(station.snapshots()) {
        let feedback = snapshot.feedback;
        let counts = feedback.position_counts.map(|read| read.value);
        wheel.start_counts = wheel.start_counts.or(counts);
        wheel.end_counts = counts.or(wheel.end_counts);
        let speed_rpm = feedback
            .speed_decirpm
            .map(|read| f64::from(read.value) / 10.0);
        if is_steady {
            wheel.speeds_rpm.extend(speed_rpm);
        }
        if let Some(csv) = &mut csv {
            let text = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
            writeln!(
                csv,
                "{at_s:.6},{},{},{},{},{}",
                snapshot.node,
                f64::from(snapshot.sent) / wheel.look.units(1.0),
                text(speed_rpm),
                text(feedback.torque.map(|read| f64::from(read.value))),
                text(counts.map(f64::from)),
            )
            .map_err(HubError::Print)?;
        }
    }
    Ok(())
}

/// How far the mean speed may be from what was asked for: 5 %, and a step of the feedback.
const TOLERANCE: f64 = 0.05;
const TOLERANCE_RPM: f64 = 0.2;

fn end_of(wheels: &[Turning], interrupted: bool, merged_cycles: u64) -> End {
    let ends: Vec<WheelEnd> = wheels
        .iter()
        .map(|wheel| {
            let readings = wheel.speeds_rpm.len();
            let mean = wheel.speeds_rpm.iter().sum::<f64>() / readings as f64;
            WheelEnd {
                node: wheel.look.node.get(),
                rpm: f64::from(wheel.target) / wheel.look.units(1.0),
                mean_rpm: (readings > 0).then_some(mean),
                counts: wheel
                    .end_counts
                    .zip(wheel.start_counts)
                    .map(|(end, start)| end.wrapping_sub(start)),
            }
        })
        .collect();
    let reached = |wheel: &WheelEnd| {
        let tolerance = TOLERANCE * wheel.rpm.abs() + TOLERANCE_RPM;
        wheel
            .mean_rpm
            .is_some_and(|mean| (mean - wheel.rpm).abs() <= tolerance)
    };
    End {
        reached: ends.iter().all(reached),
        wheels: ends,
        interrupted,
        merged_cycles,
    }
}

fn show(end: &End, json: bool) -> Result<(), HubError> {
    if json {
        print_json(end).map_err(HubError::Print)?;
        return Ok(());
    }
    for wheel in &end.wheels {
        let mean = wheel.mean_rpm.map_or_else(
            || "no speed read".to_owned(),
            |rpm| format!("{rpm:.1} r/min read"),
        );
        let counts = wheel
            .counts
            .map_or_else(|| "?".to_owned(), |counts| counts.to_string());
        print(format_args!(
            "node {}: {} r/min asked for, {mean}; it turned {counts} counts and its power is off",
            wheel.node, wheel.rpm
        ))
        .map_err(HubError::Print)?;
    }
    Ok(())
}

fn rpm(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rpm) if rpm.abs() <= MOST_RPM && rpm != 0.0 => Ok(rpm),
        _ => Err(format!(
            "must be -{MOST_RPM}..={MOST_RPM} r/min and not 0, got {text}"
        )),
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds > 0.0 && seconds <= 3_600.0 => Ok(seconds),
        _ => Err(format!("must be above 0 and up to 3600 s, got {text}")),
    }
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<End>()
}
