//! Numbers of the faults, for the host. A number never changes; new ones come at the end.

use can_motion::{EventKind, Fault};

use crate::last_words::{History, LastWords};
use crate::start::Cause;
use crate::store;

/// Where the number of a fault of the bus begins: it is about no axis.
const BUS_OFF: u16 = 100;
/// Failures of the firmware before a start.
const PANIC: u16 = 200;
const PROCESSOR: u16 = 201;
const CRYSTAL: u16 = 202;
const WATCHDOG: u16 = 203;
/// One that this firmware has no number for.
const OTHER: u16 = u16::MAX;

/// The number of a fault of an axis, and what else is known of it.
pub(crate) fn number(fault: Fault) -> (u16, i32) {
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

/// The same of an event; `None` when it is no fault.
pub(crate) fn of_event(kind: &EventKind) -> Option<(u16, i32)> {
    match kind {
        EventKind::Fault(fault) => Some(number(*fault)),
        EventKind::BusOff => Some((BUS_OFF, 0)),
        _ => None,
    }
}

/// What ended the start before this one, where that was a failure.
pub(crate) fn of_history(cause: Cause, history: &History) -> Option<store::Fault<'_>> {
    let failure = |code, detail, place| store::Fault {
        axis: None,
        code,
        detail,
        place,
    };
    match &history.last_words {
        Some(LastWords::Panic(place)) => Some(failure(PANIC, place.line as i32, place.file())),
        Some(LastWords::Fault(status)) => Some(failure(PROCESSOR, *status as i32, "")),
        Some(LastWords::LostClock) => Some(failure(CRYSTAL, 0, "")),
        None if cause == Cause::Watchdog => Some(failure(WATCHDOG, 0, "")),
        None => None,
    }
}
