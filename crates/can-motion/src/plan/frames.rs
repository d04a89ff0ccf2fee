//! The longest frames of a configuration.

use can_frame::wire::{INTERFRAME_BITS, bound_bits, exact_bits, worst_bits};
use dyn_can::{Dialect, DriveId, FunctionCode, ReadSelector};

use super::setup::RequestMix;
use crate::servo::config::{AxisConfig, DialectChoice};
use crate::servo::poll_kind::PollKind;

/// Longest request of the protocol in bytes: Set_Param_Group3.
const LONGEST_REQUEST: u8 = 5;

/// Longest reply of the protocol in bytes: Read_Param_Group3 of revision 1.6A.
const LONGEST_REPLY: u8 = 6;

/// Largest step whose set-point has one data byte.
const ONE_BYTE_STEP: u16 = 127;

/// Shortest frame of the protocol, without stuff bits: no data.
const SHORTEST_BITS: u16 = 47;

/// What is asked and answered, over all axes, in bits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Exchange {
    /// Axes that are asked at all.
    pub(super) axes: u64,
    /// Longest request.
    pub(super) request_bits: u16,
    /// Shortest request without its interframe space.
    pub(super) shortest_request_bits: u16,
    /// Longest reply.
    pub(super) reply_bits: u16,
}

impl Exchange {
    /// Where there are several groups, one is enabled, or checked anew after a fault, while another streams.
    pub(super) const fn of(axes: &[AxisConfig], mix: RequestMix, is_polled: bool) -> Self {
        let mix = if has_several_groups(axes) {
            RequestMix::Any
        } else {
            mix
        };
        match mix {
            RequestMix::Polls if is_polled => Self::of_polls(axes),
            RequestMix::Polls => Self::NONE,
            RequestMix::Any => Self {
                axes: axes.len() as u64,
                request_bits: bound_bits(LONGEST_REQUEST),
                shortest_request_bits: SHORTEST_BITS - INTERFRAME_BITS,
                reply_bits: bound_bits(LONGEST_REPLY),
            },
        }
    }

    const NONE: Self = Self {
        axes: 0,
        request_bits: 0,
        shortest_request_bits: u16::MAX,
        reply_bits: 0,
    };

    const fn of_polls(axes: &[AxisConfig]) -> Self {
        let mut exchange = Self::NONE;
        let mut rest = axes;
        while let Some((axis, behind)) = rest.split_first() {
            let mut is_asked = false;
            let mut kinds: &[PollKind] = &PollKind::ALL;
            while let Some((kind, others)) = kinds.split_first() {
                if axis.polls.of(*kind).is_some() {
                    is_asked = true;
                    exchange = exchange.with(axis, *kind);
                }
                kinds = others;
            }
            exchange.axes += is_asked as u64;
            rest = behind;
        }
        exchange
    }

    const fn with(mut self, axis: &AxisConfig, kind: PollKind) -> Self {
        let request_bits = poll_bits(axis, kind);
        let shortest_bits = request_bits.saturating_sub(INTERFRAME_BITS);
        let reply_bits = reply_bits(axis.drive, kind);
        if request_bits > self.request_bits {
            self.request_bits = request_bits;
        }
        if shortest_bits < self.shortest_request_bits {
            self.shortest_request_bits = shortest_bits;
        }
        if reply_bits > self.reply_bits {
            self.reply_bits = reply_bits;
        }
        self
    }
}

const fn has_several_groups(axes: &[AxisConfig]) -> bool {
    let mut rest = axes;
    while let [first, behind @ ..] = rest {
        if let [second, ..] = behind
            && first.group.0 != second.group.0
        {
            return true;
        }
        rest = behind;
    }
    false
}

/// Length of a poll, which is exact: its payload is known.
#[must_use]
pub const fn poll_bits(axis: &AxisConfig, kind: PollKind) -> u16 {
    let id = axis.drive.can_id(function(kind));
    match kind {
        PollKind::Position => exact_bits(id, &[ReadSelector::Position as u8]),
        PollKind::Torque => exact_bits(id, &[ReadSelector::Torque as u8]),
        PollKind::Status | PollKind::Speed | PollKind::Counter => match axis.dialect {
            DialectChoice::Fixed(Dialect {
                read_dummy: Some(dummy),
                ..
            }) => exact_bits(id, &[dummy]),
            _ => exact_bits(id, &[]),
        },
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
    let id = drive.can_id(function(kind));
    let (mut len, mut bits) = (1, 0);
    while len <= longest {
        if worst_bits(id, len) > bits {
            bits = worst_bits(id, len);
        }
        len += 1;
    }
    bits
}

/// Longest set-point of an axis, or the enable or disable command that takes its place.
#[must_use]
pub const fn set_point_bits(axis: &AxisConfig) -> u16 {
    let switch = worst_bits(axis.drive.can_id(FunctionCode::ServoDisable), 1);
    let id = axis.drive.can_id(FunctionCode::GoRelativePosPd);
    let mut bits = worst_bits(id, 1);
    if axis.limits.max_step.get() > ONE_BYTE_STEP && worst_bits(id, 2) > bits {
        bits = worst_bits(id, 2);
    }
    if switch > bits { switch } else { bits }
}

/// Half way between the longest set-point of these axes and the same without stuff bits.
pub(super) const fn usual_set_point_bits(axes: &[AxisConfig]) -> u32 {
    let (mut longest, mut rest) = (0, axes);
    while let Some((axis, behind)) = rest.split_first() {
        let bits = set_point_bits(axis);
        if bits > longest {
            longest = bits;
        }
        rest = behind;
    }
    let bytes = if longest > bound_bits(1) { 2 } else { 1 };
    (SHORTEST_BITS + 8 * bytes + longest) as u32 / 2
}

/// Longest alarm frame of these axes.
#[must_use]
pub const fn alarm_bits(axes: &[AxisConfig]) -> u16 {
    let mut bits = 0;
    let mut rest = axes;
    while let Some((axis, behind)) = rest.split_first() {
        let own = worst_bits(axis.drive.can_id(FunctionCode::DriveError), 1);
        if own > bits {
            bits = own;
        }
        rest = behind;
    }
    bits
}

const fn function(kind: PollKind) -> FunctionCode {
    match kind {
        PollKind::Status => FunctionCode::ReadDriveStatus,
        PollKind::Position | PollKind::Torque => FunctionCode::GeneralRead,
        PollKind::Speed => FunctionCode::ReadMotorSpeed,
        PollKind::Counter => FunctionCode::DiagnosticCounter,
    }
}
