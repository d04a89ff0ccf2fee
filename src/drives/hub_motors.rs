//! ZLAC8030L hub-motor drives.

use can_motion::Instant;
use can_motion::wheel::{WheelConfig, WheelEventKind, WheelFault, WheelMode, WheelSnapshot, Zlac};
use dyn_can::DataFrame;
use zlac8030l::{ControlWord, objects};

use super::{Board, Who};

impl Board for Zlac {
    /// By SDO: which object the command PDO of the drive carries now is not known.
    fn disable(wheel: &WheelConfig) -> Option<DataFrame> {
        let request = objects::CONTROL_WORD.write(ControlWord::DISABLE_VOLTAGE.get());
        Some(request.encode(wheel.node))
    }

    fn target(snapshot: &WheelSnapshot) -> i32 {
        snapshot.target
    }

    fn read_at(snapshot: &WheelSnapshot) -> [Option<Instant>; 2] {
        let feedback = &snapshot.feedback;
        [
            feedback.status.map(|status| status.at),
            feedback.position_counts.map(|position| position.at),
        ]
    }

    /// Only a wheel in position mode can be homed: a speed is no place, so the search of another one does not begin. The torque is in
    /// thousandths of 30 A, the most of 2015h, as the text of the guide counts 6077h, in 0.1 A (Z25).
    fn readings(wheel: &WheelConfig, snapshot: &WheelSnapshot) -> homing::Inputs {
        let reading = |value, at: Instant| homing::Reading {
            value,
            at_us: at.as_us(),
        };
        let read = &snapshot.feedback;
        let is_position = matches!(wheel.mode, WheelMode::Position { .. });
        let position = read.position_counts.filter(|_| is_position);
        homing::Inputs {
            sent_counts: snapshot.sent,
            position: position.map(|position| reading(position.value, position.at)),
            torque_permille: read.torque.map(|torque| homing::Reading {
                value: permille_of_most(torque.value),
                at_us: torque.at.as_us(),
            }),
            switch: None,
        }
    }

    fn is_bus_error(kind: &WheelEventKind) -> bool {
        matches!(kind, WheelEventKind::BusError(_))
    }

    fn write(axis: Option<u8>, kind: &WheelEventKind) {
        let who = Who(axis);
        match *kind {
            WheelEventKind::State { from, to, reason } => {
                defmt::info!("{}: {} -> {} ({})", who, from, to, reason);
            }
            WheelEventKind::Fault(fault) => write_fault(who, fault),
            WheelEventKind::FoundOn => defmt::warn!(
                "{}: it is enabled, and this board did not enable it: it is left alone until enable becomes active, or the stop circuit opens",
                who
            ),
            WheelEventKind::DisableUnconfirmed { repeated } => defmt::error!(
                "{}: it did not confirm that it is disabled, told again {=u32} x: the drive may still have power; the command is repeated until the drive confirms it",
                who,
                repeated
            ),
            WheelEventKind::SetUp(report) => defmt::info!("{}: set up, {}", who, report),
            WheelEventKind::Nmt(state) => defmt::info!("{}: {}", who, state),
            WheelEventKind::BusError(kind) => defmt::warn!("{}: error: {}", who, kind),
            WheelEventKind::BusOff => {
                defmt::error!("{}: off: check wiring, termination and bit rate", who);
            }
            WheelEventKind::BusRecovered => defmt::info!("{}: works again", who),
            other => defmt::warn!("{}: {}", who, other),
        }
    }
}

/// Beyond the scale is beyond every limit.
fn permille_of_most(deciamperes: i16) -> i16 {
    const MOST_DECIAMPERES: i32 = 300;
    let permille = i32::from(deciamperes) * 1_000 / MOST_DECIAMPERES;
    permille.clamp(i16::MIN.into(), i16::MAX.into()) as i16
}

/// What is wrong, and the next step.
fn write_fault(who: Who, fault: WheelFault) {
    match fault {
        WheelFault::SwitchedOn => {
            defmt::error!(
                "{}: enabled by somebody else: look for a second master",
                who
            );
        }
        WheelFault::EmergencyInput => defmt::error!(
            "{}: an emergency stop input of the drive is active: release it, then make enable active again",
            who
        ),
        WheelFault::Lost => defmt::error!(
            "{}: no answer: check power, wiring, termination, node and bit rate",
            who
        ),
        WheelFault::Reboot => defmt::error!("{}: it started again: look at its supply", who),
        WheelFault::FollowingSpeed {
            sent_decirpm,
            actual_decirpm,
        } => defmt::error!(
            "{}: turns at {=i32} in place of {=i32} tenths of r/min: blocked, too slow, or driven by something else",
            who,
            actual_decirpm,
            sent_decirpm
        ),
        WheelFault::FollowingError { counts } => defmt::error!(
            "{}: off by {=i32} counts: blocked, slipping, or too slow",
            who,
            counts
        ),
        WheelFault::SpeedResolution { expected, actual } => defmt::error!(
            "{}: its speeds count 1/{=u32} r/min (202Fh:05), the configuration says 1/{=u16}: correct one of the two; it is not enabled",
            who,
            actual,
            expected
        ),
        WheelFault::Bus => defmt::error!("{}: no command got out: check the bus", who),
        WheelFault::ConfirmTimeout => {
            defmt::error!("{}: it did not confirm in time, or its wheel turns", who);
        }
        WheelFault::Group => defmt::error!("{}: stopped with the others", who),
        other => defmt::error!("{}: {}", who, other),
    }
}
