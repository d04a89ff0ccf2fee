//! ZLAC8030L hub-motor drives.

use can_motion::Instant;
use can_motion::wheel::{WheelConfig, WheelEventKind, WheelMode, WheelSnapshot, Zlac};
use dyn_can::DataFrame;
use zlac8030l::{ControlWord, objects};

use super::Board;

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
}

/// Beyond the scale is beyond every limit.
fn permille_of_most(deciamperes: i16) -> i16 {
    const MOST_DECIAMPERES: i32 = 300;
    let permille = i32::from(deciamperes) * 1_000 / MOST_DECIAMPERES;
    permille.clamp(i16::MIN.into(), i16::MAX.into()) as i16
}
