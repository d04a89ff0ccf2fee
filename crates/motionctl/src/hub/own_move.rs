//! One move in position mode, with the profile of the drive.

use std::process::ExitCode;

use schemars::JsonSchema;
use serde::Serialize;
use zlac8030l::objects;

use super::bus::Bus;
use super::error::HubError;
use super::look::Look;
use super::station::WheelStation;
use crate::counted::counted;
use crate::exit;
use crate::interrupt;
use crate::output::{print, print_json, tell};

const CYCLE_US: u32 = 20_000;
/// How far from its target a wheel may stand, in turns.
const ARRIVAL_TURNS: f64 = 0.005;
/// How long it must stand there.
const ARRIVAL_US: u64 = 200_000;
/// Time beyond that of the profile.
const PATIENCE_US: f64 = 5e6;

/// A move of one wheel.
#[derive(Debug, Clone, Copy)]
pub(super) struct OwnMove {
    pub(super) to: Target,
    pub(super) rpm: u16,
    pub(super) rpm_per_s: f64,
}

/// Where a move ends, in counts.
#[derive(Debug, Clone, Copy)]
pub(super) enum Target {
    /// From where the wheel stands.
    By(i32),
    /// Where the drive counts so much.
    To(i32),
}

/// Where a move has led.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct MoveEnd {
    node: u8,
    /// The distance asked for, in counts.
    asked_counts: i32,
    /// The distance that the drive reports.
    read_counts: Option<i32>,
    /// Where the drive says that it stands.
    position_counts: Option<i32>,
    arrived: bool,
    /// It was stopped by Ctrl-C.
    interrupted: bool,
}

/// Moves, switches off and prints where the move has led. The user has agreed, and Ctrl-C is listened to.
///
/// # Errors
/// The first thing that went wrong, with what became of the power of the drive.
pub(super) fn run(
    bus: &mut Bus,
    look: &Look,
    wanted: OwnMove,
    json: bool,
) -> Result<ExitCode, HubError> {
    // Before the drive is enabled: what cannot be done is refused with its power off.
    let from = bus.read(look.node, objects::ACTUAL_POSITION)?;
    let target = target_of(look, wanted.to, from)?;
    let way = target.abs_diff(from);
    if !json {
        tell(format_args!(
            "node {} is being enabled and moved; Ctrl-C stops it",
            look.node
        ));
    }
    let wheel = look.makes_a_move(way, wanted.rpm, wanted.rpm_per_s);
    let mut station = WheelStation::new(bus.link(), &[wheel], CYCLE_US)?;
    let moved = make_move(&mut station, look, wanted, (from, target));
    let (end, _) = station.end(moved)?;
    show(&end, json)?;
    Ok(match end {
        MoveEnd {
            interrupted: true, ..
        } => exit::INTERRUPTED.into(),
        MoveEnd { arrived: true, .. } => ExitCode::SUCCESS,
        _ => exit::BROKEN_PROMISE.into(),
    })
}

fn position(station: &WheelStation<'_>) -> Option<i32> {
    let wheel = station.snapshots().next()?;
    wheel.feedback.position_counts.map(|read| read.value)
}

fn make_move(
    station: &mut WheelStation<'_>,
    look: &Look,
    wanted: OwnMove,
    (from, target): (i32, i32),
) -> Result<MoveEnd, HubError> {
    station.bring_up()?;
    let asked = target.wrapping_sub(from);
    let limit_us = longest_us(look, wanted, asked);
    let tolerance = (ARRIVAL_TURNS * look.counts_per_turn).round() as u32;
    let start = station.now();
    let mut there_since = None;
    let mut end = MoveEnd {
        node: look.node.get(),
        asked_counts: asked,
        read_counts: None,
        position_counts: None,
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
    end.position_counts = position(station);
    end.read_counts = end.position_counts.map(|read| read.wrapping_sub(from));
    Ok(end)
}

fn target_of(look: &Look, to: Target, from: i32) -> Result<i32, HubError> {
    let target = match to {
        Target::To(counts) => i64::from(counts),
        Target::By(counts) => i64::from(from) + i64::from(counts),
    };
    let most = zlac8030l::MoveKind::Absolute.limit();
    i32::try_from(target)
        .ok()
        .filter(|target| target.abs() <= most)
        .ok_or_else(|| {
            HubError::Input(format!(
                "node {} takes positions of -{most}..={most} counts (Z39), the move would end at {target}: move less, or make the position 0 with `motionctl origin --drives zlac:{} --set`",
                look.node, look.node
            ))
        })
}

/// The time of the profile, and more.
fn longest_us(look: &Look, wanted: OwnMove, asked: i32) -> f64 {
    let rpm = f64::from(wanted.rpm);
    let turns = f64::from(asked.unsigned_abs()) / look.counts_per_turn.max(1.0);
    let at_speed_s = turns / rpm * 60.0;
    let ramps_s = 2.0 * rpm / wanted.rpm_per_s;
    (at_speed_s + ramps_s) * 1e6 + PATIENCE_US
}

fn show(end: &MoveEnd, json: bool) -> Result<(), HubError> {
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

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<MoveEnd>()
}
