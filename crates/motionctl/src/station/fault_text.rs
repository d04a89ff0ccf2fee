//! One message for one fault: the drive, what is wrong, and what to do.

use can_motion::{DriftCause, Fault};
use dyn_can::{Alarm, DriveId};

use super::pc_master::STUCK_US;

/// The message for a fault of a drive.
pub(crate) fn fault_text(drive: DriveId, fault: Fault) -> String {
    match (words(fault), next_step(fault)) {
        (words, Some(next)) => format!("drive {drive}: {words}; {next}"),
        (words, None) => format!("drive {drive}: {words}"),
    }
}

fn words(fault: Fault) -> String {
    match fault {
        Fault::AlarmStatus(alarm) => format!("alarm, {}", alarm_cause(alarm)),
        Fault::AlarmFrame => "alarm, and it does not say which".to_owned(),
        Fault::Bus => format!(
            "no set-point got out for {} ms, or the adapter did not answer for it: the bus or its adapter stands still",
            STUCK_US / 1_000
        ),
        other => other.to_string(),
    }
}

fn alarm_cause(alarm: Alarm) -> String {
    let cause = match alarm {
        Alarm::LostPhase => {
            "its motor is more than 180 degrees away from its set-points, blocked or too slow"
        }
        Alarm::OverCurrent => "its motor or cable is short, or the load is far too large",
        Alarm::OverheatOrOverpower => "it is too hot, or it gave too much power for too long",
        Alarm::CommandRefused => "it refuses commands that do not fit its state",
        Alarm::None | Alarm::Unknown(_) => return alarm.to_string(),
    };
    format!("{alarm}: {cause}")
}

/// What the user can do, where the words do not say it.
fn next_step(fault: Fault) -> Option<&'static str> {
    Some(match fault {
        Fault::AlarmFrame | Fault::AlarmStatus(_) => {
            "its shaft is free now. Remove the cause, then switch the drive off and on: most alarms need that"
        }
        Fault::Lost => {
            "check its power, wiring, termination, bit rate and id, or look with `motionctl scan`"
        }
        Fault::Bus => "check cable, termination and the other nodes, then start anew",
        Fault::DataError | Fault::UnknownError { .. } => "look for a second master on the bus",
        Fault::Config(_) => "`motionctl write` sets config",
        Fault::FollowingError { .. } => {
            "look whether it is blocked, too slow for the motion, or reports in another unit (--read-back)"
        }
        Fault::Drift {
            cause: DriftCause::MoreThanOneStep,
            ..
        } => "look whether it reports in another unit (--read-back)",
        Fault::Backlog { .. } => {
            "this computer or its adapter is too slow for this cycle: use a longer --cycle-us"
        }
        Fault::Reboot { .. } => "look at its power supply",
        Fault::ConfirmTimeout => "let its shaft come to rest, then try again",
        _ => return None,
    })
}
