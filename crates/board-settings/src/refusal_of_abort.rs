//! What a search that has found nothing tells a host.

use board_link::{Reason, Refused};
use homing::{Abort, Awaited};

/// Why an axis has not found its origin, for the host.
pub(crate) fn refused(axis: usize, abort: &Abort) -> Refused {
    let number = |reason: Reason, expected: i64, actual: i64| reason.at(axis, expected, actual);
    match *abort {
        Abort::Cancelled => Reason::HomeStopped.at(axis, 0, 0),
        Abort::TooOld {
            what,
            limit_us,
            age_us,
        } => {
            let reason = match what {
                Awaited::Torque => Reason::HomeTorqueOld,
                _ => Reason::HomePositionOld,
            };
            let age = age_us.and_then(|us| i64::try_from(us).ok()).unwrap_or(-1);
            number(reason, limit_us.into(), age)
        }
        Abort::NotStill {
            limit_counts,
            actual_counts,
        } => number(
            Reason::HomeNotStill,
            limit_counts.into(),
            actual_counts.into(),
        ),
        Abort::TorqueAtRest {
            limit_permille,
            actual_permille,
        } => number(
            Reason::HomeTorqueAtRest,
            limit_permille.into(),
            actual_permille.into(),
        ),
        Abort::NotFound { way_counts } => {
            number(Reason::HomeNotFound, way_counts.into(), way_counts.into())
        }
        Abort::TorqueWithoutError {
            limit_permille,
            actual_permille,
            ..
        } => number(
            Reason::HomeTorqueOnly,
            limit_permille.into(),
            actual_permille.into(),
        ),
        Abort::ErrorWithoutTorque {
            limit_counts,
            error_counts,
            ..
        } => number(Reason::HomeErrorOnly, limit_counts.into(), error_counts),
        Abort::TorqueAgainst {
            contact_permille,
            actual_permille,
            ..
        } => number(
            Reason::HomeTorqueAgainst,
            contact_permille.into(),
            actual_permille.into(),
        ),
        Abort::Blocked {
            limit_counts,
            actual_counts,
        } => number(Reason::HomeBlocked, limit_counts.into(), actual_counts),
        Abort::Overload {
            limit_permille,
            actual_permille,
        } => number(
            Reason::HomeOverload,
            limit_permille.into(),
            actual_permille.into(),
        ),
        Abort::NotArrived {
            limit_counts,
            actual_counts,
        } => number(
            Reason::HomeNotArrived,
            limit_counts.into(),
            actual_counts.into(),
        ),
        Abort::StillPressed {
            limit_permille,
            actual_permille,
        } => number(
            Reason::HomeStillPressed,
            limit_permille.into(),
            actual_permille.into(),
        ),
        Abort::NotRepeated {
            limit_counts,
            actual_counts,
        } => number(
            Reason::HomeNotRepeated,
            limit_counts.into(),
            actual_counts.map_or(-1, i64::from),
        ),
        Abort::SwitchStuck { way_counts } => number(Reason::HomeSwitchStuck, 0, way_counts.into()),
        Abort::SwitchUnsteady { edge_counts } => number(
            Reason::HomeSwitchUnsteady,
            edge_counts.into(),
            edge_counts.into(),
        ),
        // A move that cannot be planned.
        _ => number(Reason::HomePlan, 0, 0),
    }
}
