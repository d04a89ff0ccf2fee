//! The faults that the board remembers over a reset, with the numbers of the firmware.

use std::cell::RefCell;
use std::rc::Rc;

use board_link::message::FaultEntry;
use can_motion::{EventKind, Fault};

use super::application::FIRMWARE;

/// As many as the boards keep.
const KEPT: usize = 32;
/// A fault of the bus: it is about no axis.
const BUS_OFF: u16 = 100;
/// One without a number.
const OTHER: u16 = u16::MAX;

/// The faults, latest last.
#[derive(Debug, Clone, Default)]
pub(super) struct FaultLog(Rc<RefCell<Kept>>);

#[derive(Debug, Default)]
struct Kept {
    entries: std::collections::VecDeque<FaultEntry>,
    next: u32,
}

impl FaultLog {
    pub(super) fn add(&self, uptime_ms: u32, axis: Option<u8>, (code, detail): (u16, i32)) {
        let mut kept = self.0.borrow_mut();
        let entry = FaultEntry {
            number: kept.next,
            uptime_ms,
            firmware: FIRMWARE.parse().unwrap_or_default(),
            axis,
            code,
            detail,
            ..FaultEntry::default()
        };
        kept.next = kept.next.wrapping_add(1);
        if kept.entries.len() == KEPT {
            kept.entries.pop_front();
        }
        kept.entries.push_back(entry);
    }

    /// 0 the latest.
    pub(super) fn get(&self, index: u32) -> Option<FaultEntry> {
        let kept = self.0.borrow();
        kept.entries.iter().rev().nth(index as usize).cloned()
    }

    pub(super) fn count(&self) -> u32 {
        self.0.borrow().entries.len() as u32
    }
}

/// The number of an event that is a fault, and what else is known of it.
pub(super) fn of_event(kind: &EventKind) -> Option<(u16, i32)> {
    match kind {
        EventKind::Fault(fault) => Some(number(*fault)),
        EventKind::BusOff => Some((BUS_OFF, 0)),
        _ => None,
    }
}

/// The number of a fault of an axis, and what else is known of it: those of the firmware.
pub(super) fn number(fault: Fault) -> (u16, i32) {
    match fault {
        Fault::AlarmFrame => (1, 0),
        Fault::AlarmStatus(alarm) => (2, alarm.code().into()),
        Fault::DataError => (3, 0),
        Fault::UnknownError { byte } => (4, byte.map_or(-1, i32::from)),
        Fault::SwitchedOff => (5, 0),
        Fault::SwitchedOn => (6, 0),
        Fault::Config(byte) => (7, byte.to_byte().into()),
        Fault::Gear { actual, .. } => (8, actual.map_or(-1, i32::from)),
        Fault::NoBrake => (9, 0),
        Fault::Lost => (10, 0),
        Fault::Backlog { counts } => (11, counts),
        Fault::Drift { counts, .. } => (12, counts),
        Fault::FollowingError { counts } => (13, counts),
        Fault::PositionJump { counts } => (14, counts),
        Fault::Reboot { actual, .. } => (15, actual.into()),
        Fault::Bus => (16, 0),
        Fault::ConfirmTimeout => (17, 0),
        Fault::PositionRange { read_back } => (18, read_back),
        Fault::NotArrived { counts } => (19, counts),
        Fault::TravelEnd { position_counts } => (20, position_counts),
        Fault::Group => (21, 0),
        _ => (OTHER, 0),
    }
}
