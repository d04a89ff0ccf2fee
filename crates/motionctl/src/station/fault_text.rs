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
            "this computer or its adapter is too slow, or the adapter refuses frames: look at its cable, or give `motionctl run` a longer --cycle-us"
        }
        Fault::Reboot { .. } => "look at its power supply",
        Fault::ConfirmTimeout => "let its shaft come to rest, then try again",
        Fault::SwitchedOff => "look for a second master, or for a program on its serial port",
        Fault::NoBrake => "`motionctl write` sets on-position-range=127 where a brake is connected",
        Fault::Drift { .. } => {
            "look for a second master and for errors on the bus, then start anew"
        }
        Fault::PositionJump { .. } => {
            "look whether its shaft was turned by hand or slips, then start anew"
        }
        Fault::PositionRange { .. } => {
            "bring the axis back into its travel, or look whether it reports in another unit (--read-back)"
        }
        Fault::Gear { .. } => "`motionctl read` shows its gear number, `motionctl write` sets it",
        Fault::NotArrived { .. } => {
            "look whether it is blocked, whether its max-speed and max-acceleration were changed, and for errors on the bus"
        }
        Fault::TravelEnd { .. } => "run slower or shorter, or give it a wider travel",
        // What to do is in the words, or at the drive that is the cause.
        Fault::SwitchedOn | Fault::Group => return None,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use dyn_can::ConfigByte;

    use super::*;
    use crate::plain_words::{flaws_of_a_message, variants};
    use board_settings::FaultNumber;

    fn every_fault() -> Vec<Fault> {
        let mut faults = vec![
            Fault::AlarmFrame,
            Fault::DataError,
            Fault::UnknownError { byte: Some(1) },
            Fault::UnknownError { byte: None },
            Fault::SwitchedOff,
            Fault::SwitchedOn,
            Fault::Config(ConfigByte::from_byte(8)),
            Fault::Gear {
                expected: 4_096,
                actual: Some(8_192),
            },
            Fault::Gear {
                expected: 4_096,
                actual: None,
            },
            Fault::NoBrake,
            Fault::Lost,
            Fault::Backlog { counts: 1 },
            Fault::FollowingError { counts: 1 },
            Fault::PositionJump { counts: 1 },
            Fault::Reboot {
                expected: 1,
                actual: 2,
            },
            Fault::Bus,
            Fault::ConfirmTimeout,
            Fault::PositionRange { read_back: 1 },
            Fault::NotArrived { counts: 1 },
            Fault::TravelEnd { position_counts: 1 },
            Fault::Group,
        ];
        faults.extend((1..8).map(|code| Fault::AlarmStatus(Alarm::from_code(code))));
        for cause in [
            DriftCause::OneStepRepeated,
            DriftCause::OneStepLost,
            DriftCause::OneStepLostOrRepeated,
            DriftCause::MoreThanOneStep,
        ] {
            faults.push(Fault::Drift { counts: 1, cause });
        }
        faults
    }

    #[test]
    fn every_fault_is_one_message_with_its_drive_and_what_to_do() {
        let source = include_str!("../../../can-motion/src/servo/fault.rs");
        let faults = every_fault();
        for variant in variants(source, "Fault") {
            let is_there = faults
                .iter()
                .any(|fault| format!("{fault:?}").starts_with(&variant));
            assert!(is_there, "{variant} is not in this test");
        }
        let drive = DriveId::new(7).expect("a drive id");
        for fault in faults {
            let text = fault_text(drive, fault);
            let flaws = flaws_of_a_message(&text);
            assert!(flaws.is_empty(), "{text}: {flaws:?}");
            assert!(text.starts_with("drive 7: "), "{text}");
            assert_eq!(text.matches("drive 7").count(), 1, "{text}");
            // What to do: after a semicolon, or in the words where they have it.
            let says_what_to_do = text.contains("; ") || text.contains(": look for");
            assert!(says_what_to_do || fault == Fault::Group, "{text}");
            let (code, _) = fault.number();
            assert!(FaultNumber::name(code).is_some(), "{fault:?} of a board");
        }
    }

    #[test]
    fn an_alarm_has_its_name_its_cause_and_the_next_step() {
        let drive = DriveId::new(2).expect("a drive id");
        for (code, name, cause) in [
            (1, "lost phase", "180 degrees"),
            (2, "over-current", "short"),
            (3, "overheat or over-power", "too hot"),
            (4, "command refused", "do not fit its state"),
        ] {
            let text = fault_text(drive, Fault::AlarmStatus(Alarm::from_code(code)));
            for part in [
                "drive 2: alarm, ",
                name,
                cause,
                "switch the drive off and on",
            ] {
                assert_eq!(text.matches(part).count(), 1, "{part} in {text}");
            }
        }
    }
}
