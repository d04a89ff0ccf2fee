//! What readings and the bus may change, and what they must.

use can_motion::facts::{Brake, Class, Facts, Goal, Input, Knowledge, Latch, Loss, Motion, Power};

use crate::promises::{is_off_due, moves};
use crate::walk::{Held, hold};

pub(crate) fn of_knowledge(before: Facts, input: Input, after: Facts) -> Held {
    let rung = match input {
        Input::Checked => Some((Knowledge::Unknown, Knowledge::Checked)),
        Input::Stands => Some((Knowledge::Checked, Knowledge::Standing)),
        Input::Anchored => Some((Knowledge::Standing, Knowledge::Anchored)),
        _ => None,
    };
    let is_rung = rung == Some((before.knowledge, after.knowledge));
    hold(
        after.knowledge <= before.knowledge || is_rung,
        "knowledge grows by readings, rung by rung",
    )?;
    let is_switching = !matches!(before.power, Power::Off | Power::On);
    let is_asked = before.goal != Goal::Off && before.latch == Latch::None;
    hold(
        after.knowledge <= Knowledge::Checked || !is_rung || (is_asked && !is_switching),
        "standstill and anchor count only when asked for, and not while the power changes",
    )?;
    hold(
        input != Input::Turns || moves(&before) || after.knowledge <= Knowledge::Checked,
        "a shaft that turns at rest has no anchor",
    )?;
    hold(
        input != Input::Turns || !moves(&before) || before == after,
        "a shaft that turns in motion is as it should be",
    )?;
    hold(
        input != Input::Restarted || after.knowledge == Knowledge::Unknown,
        "a drive that starts anew is checked anew",
    )
}

/// Promises 3, 6 and 9: what a report about the power means. Where both could be, the power that may be on is assumed.
pub(crate) fn of_power(before: Facts, input: Input, after: Facts) -> Held {
    let is_off_goal = before.goal == Goal::Off;
    match (input, before.power) {
        (Input::SaysOn, Power::On) => hold(before == after, "a report of the known is no news"),
        (Input::SaysOn, Power::OffWanted | Power::OffSent) => hold(
            after.power == Power::OffWanted,
            "a drive that did not take the disable command is told again",
        ),
        (Input::SaysOn, Power::OnSent) => hold(after.power == Power::On, "on when it says so"),
        (Input::SaysOn, Power::OnUnconfirmed) if !is_off_goal => hold(
            after.power == Power::On && after.goal == before.goal,
            "what held and answers again still holds",
        ),
        (Input::SaysOn, _) if is_off_goal => hold(
            after.power == Power::FoundOn && after.latch == before.latch,
            "what is found on is left alone",
        ),
        (Input::SaysOn, _) => hold(
            after.power == Power::FoundOn && after.latch == Latch::Own && after.goal == Goal::Off,
            "on without having been told is a fault",
        ),
        (Input::SaysOff, Power::OnSent | Power::OnWanted | Power::OffWanted) => hold(
            after.power == before.power,
            "a report from before a command was transmitted confirms nothing",
        ),
        (Input::SaysOff, Power::On) => hold(
            after.latch == Latch::Own
                && !moves(&after)
                && after.goal == Goal::Off
                && after.power == Power::Off
                && after.knowledge <= Knowledge::Checked,
            "off without having been told is a fault, and it does not come on again",
        ),
        (Input::SaysOff, power) => hold(
            matches!(after.power, Power::Off | Power::OnWanted)
                && (after.goal == before.goal || power.is_unclear()),
            "off when it says so",
        ),
        (Input::Restarted, _) => hold(
            after.power == unconfirmed(before.power) || (is_off_due(&before) && is_off_due(&after)),
            "after a restart nothing is known of the power",
        ),
        _ => switches(before, input, after),
    }
}

/// What is left of the knowledge about the power when nothing is heard.
pub(crate) fn unconfirmed(power: Power) -> Power {
    match power {
        Power::OnSent | Power::On | Power::OnUnconfirmed => Power::OnUnconfirmed,
        Power::OffWanted | Power::OffSent => Power::OffWanted,
        Power::Unclear | Power::Off | Power::OnWanted | Power::FoundOn => Power::Unclear,
    }
}

fn switches(before: Facts, input: Input, after: Facts) -> Held {
    let expected = match (input, before.power) {
        (Input::Accepted(Class::SwitchOn), Power::OnWanted) => Power::OnSent,
        (Input::Accepted(Class::SwitchOff), Power::OffWanted) => Power::OffSent,
        (Input::Displaced(Class::SwitchOn), Power::OnSent) => {
            // Its anchor may be lost meanwhile: then it waits for a new one.
            return hold(
                matches!(after.power, Power::OnWanted | Power::Off)
                    && (after.power == Power::OnWanted || before.knowledge < Knowledge::Anchored),
                "an enable command that came back waits again",
            );
        }
        (Input::Displaced(Class::SwitchOff), Power::OffSent) => Power::OffWanted,
        (Input::Accepted(_) | Input::Displaced(_), power) => power,
        _ => return Ok(()),
    };
    // A motion that never began leaves a disable that waited for its end.
    let expected = match (after.power, before.motion) {
        (Power::OffWanted, Motion::DriveMove)
            if before.power == Power::On && before.goal == Goal::Off && !moves(&after) =>
        {
            Power::OffWanted
        }
        _ => expected,
    };
    hold(
        after.power == expected && after.goal == before.goal,
        "what becomes of a command is known, and no other frame counts as one",
    )
}

pub(crate) fn of_brake(before: Facts, input: Input, after: Facts) -> Held {
    let loses = matches!(
        input,
        Input::Restarted
            | Input::Fault {
                loss: Loss::Contact | Loss::Drive,
                ..
            }
    );
    let expected = match (before.brake, input) {
        (Brake::Absent, _) => Brake::Absent,
        (_, Input::BrakeOpened) => Brake::Open,
        (_, Input::BrakeClosed) => Brake::Closed,
        (_, Input::Accepted(Class::BrakeOpen | Class::BrakeClose)) => Brake::Unclear,
        _ if loses => Brake::Unclear,
        (known, _) => known,
    };
    hold(
        after.brake == expected,
        "a brake is where the drive confirmed it, and unclear after a command",
    )
}
