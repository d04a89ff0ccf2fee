//! The longest frames of an axis, in bits with the interframe space. A byte more always makes a frame longer.

use can_frame::wire::{exact_bits, worst_bits};
use dyn_can::{Dialect, DriveId, FunctionCode, ReadSelector};

use crate::servo::config::{AxisConfig, DialectChoice};
use crate::servo::poll_kind::PollKind;

/// Largest step whose set-point has one data byte.
const ONE_BYTE_STEP: u16 = 127;

/// Length of a poll, which is exact: its payload is known.
#[must_use]
pub const fn poll_bits(axis: &AxisConfig, kind: PollKind) -> u16 {
    let id = axis.drive.can_id(kind.reply_kind().function());
    match (kind, axis.dialect) {
        (PollKind::Position, _) => exact_bits(id, &[ReadSelector::Position as u8]),
        (PollKind::Torque, _) => exact_bits(id, &[ReadSelector::Torque as u8]),
        (
            _,
            DialectChoice::Fixed(Dialect {
                read_dummy: Some(dummy),
                ..
            }),
        ) => exact_bits(id, &[dummy]),
        _ => exact_bits(id, &[]),
    }
}

/// Longest reply to a poll (1.6A section 6: position 1..4 bytes, torque 1..2, speed 2, status and counter 1).
#[must_use]
pub const fn reply_bits(drive: DriveId, kind: PollKind) -> u16 {
    let longest = match kind {
        PollKind::Status | PollKind::Counter => 1,
        PollKind::Torque | PollKind::Speed => 2,
        PollKind::Position => 4,
    };
    worst_bits(drive.can_id(kind.reply_kind().function()), longest)
}

/// Longest set-point of an axis, or the enable or disable command that takes its place.
#[must_use]
pub const fn set_point_bits(axis: &AxisConfig) -> u16 {
    let id = axis.drive.can_id(FunctionCode::GoRelativePosPd);
    if axis.limits.max_step.get() > ONE_BYTE_STEP {
        return worst_bits(id, 2);
    }
    let switch = worst_bits(axis.drive.can_id(FunctionCode::ServoDisable), 1);
    let step = worst_bits(id, 1);
    if switch > step { switch } else { step }
}

/// Longest alarm frame of an axis.
#[must_use]
pub const fn alarm_bits(axis: &AxisConfig) -> u16 {
    worst_bits(axis.drive.can_id(FunctionCode::DriveError), 1)
}
