//! A move over the serial port: one built-in move, to a position or by a distance.
//!
//! The protocol cannot stream set-points and cannot enable a servo, and a drive that turns at constant speed would go on when
//! this program ends. A built-in move ends by itself whatever happens; its speed comes from the drive's own parameters, so it
//! is refused where they would make it faster than the user allows.

use std::thread::sleep;
use std::time::{Duration, Instant};

use dyn_can::{
    GearNumber, MaxAcceleration, MaxSpeed, OnPosRange, RangeError, StoredDriveId, units,
};
use dyn_serial::{Alarm, CommandMode, ConfigByte, Counts28, Request, ServoMode, SpeedRpm};

use super::line::Line;
use super::parameters::read;
use crate::drives::{DrivesError, Jog, JogEnd, Parameter};
use crate::interrupt;
use crate::output::tell;
use crate::station::AxisOptions;

/// Stops in every reading of the documents.
const STOP: Request = Request::TurnConstSpeed(SpeedRpm::ZERO);
/// What a move may take beyond twice its computed time.
const GRACE: Duration = Duration::from_secs(3);

/// A motor that stops is looked at so often at most and so far apart, until it stands still.
const STOP_READS: u32 = 100;
const STOP_PAUSE: Duration = Duration::from_millis(30);

/// Where a built-in move leads, in motor turns, positive clockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Way {
    /// From where the motor stands.
    By(f64),
    /// From the origin of the drive.
    To(f64),
}

/// A built-in move, and how fast and far it may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LineMove {
    pub(crate) way: Way,
    pub(crate) max_rpm: f64,
    /// The option that says so.
    pub(crate) rpm_option: &'static str,
    /// Nothing where the acceleration is left to the parameters of the drive.
    pub(crate) max_rpm_per_s: Option<f64>,
    pub(crate) max_turns: f64,
}

impl LineMove {
    pub(super) fn of_jog(jog: Jog) -> Self {
        Self {
            way: Way::By(jog.turns),
            max_rpm: jog.rpm,
            rpm_option: "--rpm",
            max_rpm_per_s: None,
            max_turns: jog.turns.abs(),
        }
    }
}

/// Checks, moves, waits for the end. Returns where the move began, in command counts from the origin of the drive, and where it led.
pub(super) fn go(
    line: &mut Line,
    axes: AxisOptions,
    drive: StoredDriveId,
    wanted: LineMove,
) -> Result<(i32, JogEnd), DrivesError> {
    require_ready(line, drive)?;
    let before = line.position(drive)?;
    let scale = axes.scale(gear(line, drive)?);
    let start_counts = scale
        .to_command_counts(before)
        .ok_or_else(|| refused(drive, "it reports a position beyond 32 bit"))?;
    let (asked_counts, request, curve) = planned(line, drive, start_counts, wanted)?;
    line.command(drive, &request)
        .map_err(|error| while_enabled(drive, error))?;
    tell(format_args!("drive {drive} moves; Ctrl-C stops it"));
    let limit = Duration::from_secs_f64(2.0 * curve.total_time_s) + GRACE;
    let arrived = wait_for_end(line, drive, limit).map_err(|error| {
        // A drive that is not heard may hear. If this is lost too, the move still ends by itself.
        let _ = line.command(drive, &STOP);
        while_enabled(drive, error)
    })?;
    if !arrived {
        stop(line, drive).map_err(|error| while_enabled(drive, error))?;
    }
    let moved = standstill(line, drive)?.wrapping_sub(before);
    let end = JogEnd {
        asked_counts,
        sent_counts: asked_counts,
        read_counts: scale.to_command_counts(moved),
        interrupted: !arrived,
        enabled: true,
    };
    if arrived {
        require_arrival(line, drive, &end)?;
    }
    Ok((start_counts, end))
}

/// A command is not acknowledged: only the position tells that it was obeyed.
fn require_arrival(line: &mut Line, drive: StoredDriveId, end: &JogEnd) -> Result<(), DrivesError> {
    let range = OnPosRange::new(read(line, drive, Parameter::OnPositionRange)?)
        .map_err(|error| refused(drive, error))?;
    let gear = gear(line, drive)?;
    // Within the range before the move and within it afterwards, in command counts.
    let steps = f64::from(range.get()) / units::gear_ratio(gear);
    let tolerance = 2 * steps.ceil() as i64 + 1;
    let missing = end
        .read_counts
        .map(|read| i64::from(end.asked_counts) - i64::from(read));
    match missing {
        Some(missing) if missing.abs() <= tolerance => Ok(()),
        _ => Err(refused(drive, not_arrived(end))),
    }
}

fn gear(line: &mut Line, drive: StoredDriveId) -> Result<GearNumber, DrivesError> {
    GearNumber::new(read(line, drive, Parameter::GearNumber)?)
        .map_err(|error| refused(drive, error))
}

fn not_arrived(end: &JogEnd) -> String {
    let asked = end.asked_counts;
    match end.read_counts {
        Some(read) => format!(
            "it was asked for {asked} counts and reports {read}: the command was lost, or --read-back is not the unit of its position"
        ),
        None => format!("it was asked for {asked} counts and reports a position beyond 32 bit"),
    }
}

/// A move needs the servo on, no alarm, commands over this port, and the position servo.
fn require_ready(line: &mut Line, drive: StoredDriveId) -> Result<(), DrivesError> {
    let fault = |reason: String| Err(DrivesError::Fault { drive, reason });
    let status = line.status(drive)?;
    if status.alarm() != Alarm::None {
        return fault(format!("{}: no move before it is cleared", status.alarm()));
    }
    if status.is_disabled() {
        return fault(
            "the servo is off, and the serial protocol can switch it on only in the stored configuration: enable it over CAN, or write config without bit 5".to_owned(),
        );
    }
    let config = ConfigByte::new(read(line, drive, Parameter::Config)?)
        .and_then(ConfigByte::config)
        .map_err(|error| refused(drive, error))?;
    if config.command_mode != CommandMode::Rs232 || config.servo_mode != ServoMode::Position {
        return fault(
            "a move needs commands by link and the position servo: see config in `motionctl read`"
                .to_owned(),
        );
    }
    Ok(())
}

/// The distance in command counts, its command, and the move that the drive's parameters make of it.
fn planned(
    line: &mut Line,
    drive: StoredDriveId,
    start_counts: i32,
    wanted: LineMove,
) -> Result<(i32, Request, units::SCurve), DrivesError> {
    let mut parameter = |parameter| read(line, drive, parameter);
    let (speed, acceleration, gear) = (
        parameter(Parameter::MaxSpeed)?,
        parameter(Parameter::MaxAcceleration)?,
        parameter(Parameter::GearNumber)?,
    );
    let number = |error: RangeError| refused(drive, error);
    let speed = MaxSpeed::new(speed).map_err(number)?;
    let acceleration = MaxAcceleration::new(acceleration).map_err(number)?;
    let gear = GearNumber::new(gear).map_err(number)?;
    let turn = f64::from(units::command_counts_per_turn(gear));
    // What is beyond 32 bit is beyond the range of the protocol too, and refused.
    let in_28_bit = |turns: f64| Counts28::new((turns * turn).round() as i32).map_err(number);
    let (counts, request) = match wanted.way {
        Way::By(turns) => {
            let distance = in_28_bit(turns)?;
            (distance.get(), Request::GoRelativePos(distance))
        }
        Way::To(turns) => {
            let end = in_28_bit(turns)?;
            let distance = end.get().wrapping_sub(start_counts);
            (distance, Request::GoAbsolutePos(end))
        }
    };
    let way = f64::from(counts).abs() / turn;
    if counts.unsigned_abs() > (wanted.max_turns * turn).ceil() as u32 {
        return Err(not_allowed(
            drive,
            format!(
                "the move leads {way:.3} turns away, --max-turns allows {}",
                wanted.max_turns
            ),
        ));
    }
    let curve = units::SCurve::new(counts, speed, acceleration, gear);
    if curve.peak_speed_rpm > wanted.max_rpm {
        return Err(not_allowed(
            drive,
            too_fast(&wanted, curve.peak_speed_rpm, gear),
        ));
    }
    match wanted.max_rpm_per_s {
        Some(most) if curve.acceleration_rpm_s > most => Err(not_allowed(
            drive,
            format!(
                "its own parameters change the speed by {:.0} r/min per second, --max-acceleration allows {most}: lower max-acceleration with `motionctl write`",
                curve.acceleration_rpm_s
            ),
        )),
        _ => Ok((counts, request, curve)),
    }
}

fn too_fast(wanted: &LineMove, peak_rpm: f64, gear: GearNumber) -> String {
    let allowed_rpm = wanted.max_rpm;
    let slower = units::max_speed_parameter(allowed_rpm, gear).map_or_else(
        || "no value of max-speed is that slow".to_owned(),
        |parameter| format!("`motionctl write` max-speed={parameter} makes it slow enough"),
    );
    format!(
        "its own parameters make this move {peak_rpm:.0} rpm fast, more than {} {allowed_rpm}: {slower}",
        wanted.rpm_option
    )
}

/// Refused before anything was sent that moves.
fn not_allowed(drive: StoredDriveId, reason: String) -> DrivesError {
    match drive.drive_id() {
        Some(drive) => DrivesError::MoveRefused { drive, reason },
        None => refused(drive, reason),
    }
}

fn refused(drive: StoredDriveId, error: impl core::fmt::Display) -> DrivesError {
    DrivesError::Fault {
        drive,
        reason: error.to_string(),
    }
}

/// What went wrong while the motor may have been turning.
fn while_enabled(drive: StoredDriveId, error: DrivesError) -> DrivesError {
    match error {
        DrivesError::Link(fault) => DrivesError::LinkWhileEnabled {
            fault,
            warning: format!(
                "No command gets through any more. Drive {drive} is ENABLED and ends its move by itself: use the emergency stop before you go near."
            ),
        },
        other => other,
    }
}

/// Returns false when the user asked to stop.
fn wait_for_end(
    line: &mut Line,
    drive: StoredDriveId,
    limit: Duration,
) -> Result<bool, DrivesError> {
    let start = Instant::now();
    while interrupt::requests() == 0 {
        let status = line.status(drive)?;
        if status.alarm() != Alarm::None {
            return Err(refused(drive, status.alarm()));
        }
        if !status.motion_busy() && status.on_position() {
            return Ok(true);
        }
        if start.elapsed() > limit {
            stop(line, drive)?;
            return Err(refused(drive, "it did not arrive in time and was stopped"));
        }
    }
    Ok(false)
}

/// Where the motor stands once it moves no more, in the unit of the drive's read-back.
fn standstill(line: &mut Line, drive: StoredDriveId) -> Result<i32, DrivesError> {
    let mut position = line.position(drive)?;
    for _ in 0..STOP_READS {
        sleep(STOP_PAUSE);
        let last = std::mem::replace(&mut position, line.position(drive)?);
        if last == position {
            break;
        }
    }
    Ok(position)
}

/// Stops, which can leave the drive in speed mode (D41), and waits for standstill.
fn stop(line: &mut Line, drive: StoredDriveId) -> Result<(), DrivesError> {
    line.command(drive, &STOP)?;
    standstill(line, drive)?;
    let config = ConfigByte::new(read(line, drive, Parameter::Config)?)
        .and_then(ConfigByte::config)
        .map_err(|error| refused(drive, error))?;
    if config.servo_mode != ServoMode::Position {
        tell(format_args!(
            "note: the stop has left drive {drive} in speed mode; a power cycle, or writing config, brings it back"
        ));
    }
    Ok(())
}
