//! What ended the start before this one, as an entry of the log of faults.

use board_settings::FaultNumber;

use crate::last_words::{History, LastWords};
use crate::start::Cause;
use crate::store;

/// What ended the start before this one, where that was a failure.
pub(crate) fn of_history(cause: Cause, history: &History) -> Option<store::Fault<'_>> {
    let failure = |code, detail, place| store::Fault {
        axis: None,
        code,
        detail,
        place,
    };
    match &history.last_words {
        Some(LastWords::Panic(place)) => {
            Some(failure(FaultNumber::PANIC, place.line as i32, place.file()))
        }
        Some(LastWords::Fault(status)) => Some(failure(FaultNumber::PROCESSOR, *status as i32, "")),
        Some(LastWords::LostClock) => Some(failure(FaultNumber::CRYSTAL, 0, "")),
        None if cause == Cause::Watchdog => Some(failure(FaultNumber::WATCHDOG, 0, "")),
        None => None,
    }
}
