//! `motionctl jog --drives zlac`: turns one wheel a little, by hand.

use std::process::ExitCode;

use serde::Serialize;

use super::bus::Bus;
use super::error::HubError;
use super::look::Look;
use super::nodes::OneNode;
use super::station::WheelStation;
use crate::confirm::confirm;
use crate::counted::counted;
use crate::exit;
use crate::interrupt;
use crate::link::LinkOptions;
use crate::output::{print, print_json, tell};

const CYCLE_US: u32 = 20_000;
/// A jog is for looking whether a wheel turns and which way round. More is for `speed` and `run`.
const MOST_TURNS: f64 = 10.0;
const MOST_RPM: u16 = 200;
/// How far from its target a wheel may stand, in turns.
const ARRIVAL_TURNS: f64 = 0.005;
/// How long it must stand there.
const ARRIVAL_US: u64 = 200_000;
/// Time beyond that of the profile.
const PATIENCE_US: f64 = 5e6;

const EXAMPLES: &str = "\
Examples:
  motionctl jog --drives zlac --slcan /dev/ttyACM0 --turns 0.25
  motionctl jog --drives zlac:5 --can can0 --turns -1 --rpm 30 --yes

One move in position mode, with the drive's own profile. The drive is enabled for it and switched off afterwards: a vehicle on a slope
rolls away then. Ctrl-C stops by quick stop and ends the same way. Let the wheel hang free of the ground.

Exit status: 0 the wheel stands where it should, 1 it does not, or did not confirm that its power is off, 2 not confirmed, enabled
already, or out of range, and nothing has moved, 3 the link failed, 130 stopped by Ctrl-C.";

/// Options of `motionctl jog --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    link: LinkOptions,
    #[command(flatten)]
    node: OneNode,
    /// Turns of the wheel, positive as its drive counts; at most 10 either way.
    #[arg(long, value_name = "TURNS", allow_hyphen_values = true, value_parser = turns)]
    turns: f64,
    /// Highest speed in r/min, at most 200.
    #[arg(long, value_name = "RPM", default_value_t = 30, value_parser = clap::value_parser!(u16).range(1..=i64::from(MOST_RPM)))]
    rpm: u16,
    /// Fastest change of the speed in r/min per second.
    #[arg(long, value_name = "RPM_PER_S", default_value = "200", value_parser = acceleration)]
    max_acceleration: f64,
    /// Move without asking.
    #[arg(long)]
    yes: bool,
    /// Print where the jog has led as JSON.
    #[arg(long)]
    json: bool,
}

/// Where a jog has led.
#[derive(Debug, Serialize)]
struct JogEnd {
    node: u8,
    /// The distance asked for, in counts.
    asked_counts: i32,
    /// The distance that the drive reports.
    read_counts: Option<i32>,
    arrived: bool,
    /// It was stopped by Ctrl-C.
    interrupted: bool,
}

/// Asks, moves, prints where the jog has led.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    let node = arguments.node.get()?;
    let mut bus = Bus::open(&arguments.link)?;
    let look = Look::at(&mut bus, node)?;
    let question = format!(
        "The wheel of node {node} will TURN, powered, by {} at up to {} r/min and {} r/min per second. Is everybody clear, and does it hang free?",
        counted(arguments.turns, "turn", "turns"),
        arguments.rpm,
        arguments.max_acceleration
    );
    confirm(&question, arguments.yes).map_err(HubError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(HubError::Interrupt)?;
    if !arguments.json {
        tell(format_args!(
            "node {node} is being enabled and moved; Ctrl-C stops it"
        ));
    }
    let asked = (arguments.turns * look.counts_per_turn).round() as i32;
    let wheel = look.makes_a_move(asked, arguments.rpm, arguments.max_acceleration);
    let mut station = WheelStation::new(bus.link(), &[wheel], CYCLE_US)?;
    let moved = make_move(&mut station, arguments, &look, asked);
    let (end, _) = station.end(moved)?;
    show(&end, arguments.json)?;
    Ok(match end {
        JogEnd {
            interrupted: true, ..
        } => exit::INTERRUPTED.into(),
        JogEnd { arrived: true, .. } => ExitCode::SUCCESS,
        _ => exit::BROKEN_PROMISE.into(),
    })
}

fn position(station: &WheelStation<'_>) -> Option<i32> {
    let wheel = station.snapshots().next()?;
    wheel.feedback.position_counts.map(|read| read.value)
}

fn make_move(
    station: &mut WheelStation<'_>,
    arguments: &Arguments,
    look: &Look,
    asked: i32,
) -> Result<JogEnd, HubError> {
    station.bring_up()?;
    let from = station.snapshots().next().map_or(0, |wheel| wheel.sent);
    let target = from.wrapping_add(asked);
    let limit_us = longest_us(arguments);
    let tolerance = (ARRIVAL_TURNS * look.counts_per_turn).round() as u32;
    let start = station.now();
    let mut there_since = None;
    let mut end = JogEnd {
        node: look.node.get(),
        asked_counts: asked,
        read_counts: None,
        arrived: false,
        interrupted: false,
    };
    while !end.arrived && (station.now().us_since(start) as f64) < limit_us {
        station.cycle(|master, _| {
            // Refused after a fault, which is looked for below.
            let _ = master.set_target(0, target);
        })?;
        if let Some((node, fault)) = station.first_fault() {
            return Err(HubError::WheelFault { node, fault });
        }
        if interrupt::requests() > 0 {
            end.interrupted = true;
            station.come_to_rest()?;
            break;
        }
        let now = station.now();
        let is_there = position(station).is_some_and(|read| read.abs_diff(target) <= tolerance);
        there_since = if is_there {
            there_since.or(Some(now))
        } else {
            None
        };
        end.arrived = there_since.is_some_and(|since| now.us_since(since) >= ARRIVAL_US);
    }
    end.read_counts = position(station).map(|read| read.wrapping_sub(from));
    Ok(end)
}

/// The time of the profile, and more.
fn longest_us(arguments: &Arguments) -> f64 {
    let rpm = f64::from(arguments.rpm);
    let at_speed_s = arguments.turns.abs() / rpm * 60.0;
    let ramps_s = 2.0 * rpm / arguments.max_acceleration;
    (at_speed_s + ramps_s) * 1e6 + PATIENCE_US
}

fn show(end: &JogEnd, json: bool) -> Result<(), HubError> {
    if json {
        print_json(end).map_err(HubError::Print)?;
        return Ok(());
    }
    let read = end
        .read_counts
        .map_or_else(|| "no position".to_owned(), |counts| counts.to_string());
    let how = match (end.interrupted, end.arrived) {
        (true, _) => ", stopped by the user",
        (false, true) => "",
        (false, false) => ", which is not where it should be: it is blocked, or too slow",
    };
    print(format_args!(
        "asked for {}, node {} reports {read}{how}; its power is off",
        counted(end.asked_counts, "count", "counts"),
        end.node
    ))
    .map_err(HubError::Print)?;
    Ok(())
}

fn turns(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(turns) if turns.abs() <= MOST_TURNS && turns != 0.0 => Ok(turns),
        _ => Err(format!(
            "must be -{MOST_TURNS}..={MOST_TURNS} turns and not 0, got {text}"
        )),
    }
}

/// A change of speed in r/min per second that a ramp of the drive can make.
pub(super) fn acceleration(text: &str) -> Result<f64, String> {
    const LEAST: f64 = 31.0;
    const MOST: f64 = 10_000.0;
    match text.parse::<f64>() {
        Ok(rpm_per_s) if (LEAST..=MOST).contains(&rpm_per_s) => Ok(rpm_per_s),
        _ => Err(format!(
            "must be {LEAST}..={MOST} r/min per second, got {text}"
        )),
    }
}
