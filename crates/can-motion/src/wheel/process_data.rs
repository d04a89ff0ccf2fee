//! The three PDOs of a wheel: what is mapped where, and the values in them.

use zlac8030l::{
    ControlWord, DataFrame, DecodeError, FaultCode, MappingEntry, NodeId, ObjectData, ObjectValue,
    PdoMapping, PdoNumber, StatusWord, objects,
};

use crate::wheel::config::WheelMode;

/// Control word and target go to the drive in this PDO. RPDO0 keeps its factory mapping.
pub(super) const COMMAND: PdoNumber = PdoNumber::Pdo1;
/// Status, fault and speed come in this PDO.
pub(super) const STATUS: PdoNumber = PdoNumber::Pdo0;
/// Position and torque come in this PDO.
pub(super) const POSITION: PdoNumber = PdoNumber::Pdo1;

fn mapping(entries: &[MappingEntry]) -> PdoMapping {
    // At most 8 bytes of known widths, which a test checks.
    PdoMapping::new(entries).unwrap_or(PdoMapping::EMPTY)
}

pub(super) fn command_mapping(mode: WheelMode) -> PdoMapping {
    let target = match mode {
        WheelMode::Velocity => MappingEntry::of(objects::TARGET_SPEED),
        WheelMode::Position { .. } => MappingEntry::of(objects::TARGET_POSITION),
        WheelMode::Torque { .. } => MappingEntry::of(objects::TARGET_TORQUE),
    };
    mapping(&[MappingEntry::of(objects::CONTROL_WORD), target])
}

pub(super) fn status_mapping() -> PdoMapping {
    mapping(&[
        MappingEntry::of(objects::STATUS_WORD),
        MappingEntry::of(objects::FAULT_CODE),
        MappingEntry::of(objects::ACTUAL_SPEED),
    ])
}

pub(super) fn position_mapping() -> PdoMapping {
    mapping(&[
        MappingEntry::of(objects::ACTUAL_POSITION),
        MappingEntry::of(objects::ACTUAL_TORQUE),
    ])
}

pub(super) fn command(node: NodeId, mode: WheelMode, word: ControlWord, target: i32) -> DataFrame {
    let target = match mode {
        // The limits of the targets are those of the object.
        WheelMode::Torque { .. } => (target as i16).to_data(),
        WheelMode::Velocity | WheelMode::Position { .. } => target.to_data(),
    };
    let values = [word.get().to_data(), target];
    command_mapping(mode).rpdo(node, COMMAND, &values)
}

/// The target in a command; 0 in a frame that is none.
pub(super) fn target(frame: &DataFrame) -> i32 {
    match *frame.data() {
        [_, _, a, b, c, d] => i32::from_le_bytes([a, b, c, d]),
        // Torques have 16 bits.
        [_, _, a, b] => i32::from(i16::from_le_bytes([a, b])),
        _ => 0,
    }
}

/// Status, fault bits and speed in 0.1 r/min.
pub(super) fn status(frame: &DataFrame) -> Result<(StatusWord, FaultCode, i32), DecodeError> {
    let [status, fault, speed, _] = status_mapping().values(frame)?;
    let word = |data| StatusWord::new(value(data));
    Ok((word(status), FaultCode::new(value(fault)), value(speed)))
}

/// Position in counts and torque.
pub(super) fn position(frame: &DataFrame) -> Result<(i32, i16), DecodeError> {
    let [position, torque, ..] = position_mapping().values(frame)?;
    Ok((value(position), value(torque)))
}

fn value<T: ObjectValue + Default>(data: Option<ObjectData>) -> T {
    // The mapping gave each value the width of its object.
    data.and_then(|data| T::from_data(data).ok())
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bytes_are_those_of_the_mapping() {
        let node = NodeId::new(4).unwrap();
        let frame = command(
            node,
            WheelMode::Velocity,
            ControlWord::ENABLE_OPERATION,
            -100,
        );
        assert_eq!(
            (frame.id(), frame.data()),
            (0x304, &[0x0F, 0x00, 0x9C, 0xFF, 0xFF, 0xFF][..])
        );
        let torque = WheelMode::Torque { slope_ma_s: 300 };
        let frame = command(node, torque, ControlWord::QUICK_STOP, -1_000);
        assert_eq!(frame.data(), [0x02, 0x00, 0x18, 0xFC]);
        assert_eq!(target(&frame), -1_000);
        let frame =
            DataFrame::new(0x184, &[0x27, 0x40, 0x04, 0x00, 0xE8, 0x03, 0x00, 0x00]).unwrap();
        let (word, fault, speed) = status(&frame).unwrap();
        assert_eq!((word.get(), fault.get(), speed), (0x4027, 4, 1_000));
        let frame = DataFrame::new(0x284, &[0xFE, 0xFF, 0xFF, 0xFF, 0x85, 0xFF]).unwrap();
        assert_eq!(position(&frame), Ok((-2, -123)));
        assert!(position(&DataFrame::new(0x284, &[0; 8]).unwrap()).is_err());
    }
}
