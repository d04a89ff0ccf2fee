//! What every single change promises. Stated as what is true before and after an input, never by asking `step` what is right.

use can_motion::facts::{
    Brake, Class, Facts, Goal, Input, Knowledge, Latch, Loss, Motion, Power, Work,
};

use can_motion::MoveEnd;

use crate::faults;
use crate::needs;
use crate::own_moves;
use crate::promises::{is_off_due, moves, of_facts, sends};
use crate::readings;
use crate::rules::Rules;
use crate::walk::{Held, hold};

/// Every promise about one axis.
pub(crate) fn every_promise(rules: &Rules, before: Facts, input: Input, after: Facts) -> Held {
    of_facts(rules, &before)?;
    of_facts(rules, &after)?;
    let is_taken = (rules.accepts)(&before, input);
    hold(
        is_taken || before == after,
        "what is refused changes nothing",
    )?;
    needs::is_fit_for(rules, &before, input)?;
    if is_taken {
        of_commands(before, input, after)?;
        of_work(before, input, after)?;
        faults::of_faults(before, input, after)?;
    }
    load_is_caught(rules, before, input, after)?;
    never_refused(is_taken, input)?;
    nothing_resumes(before, input, after, is_taken)?;
    power_is_meant(before, input, after, is_taken)?;
    readings::of_knowledge(before, input, after)?;
    readings::of_power(before, input, after)?;
    own_moves::frames_count(before, input, after)?;
    readings::of_brake(before, input, after)
}

/// Promise 9: a load that can fall does not wait for a reading when its drive lets go.
fn load_is_caught(rules: &Rules, before: Facts, input: Input, after: Facts) -> Held {
    let lets_go = matches!(
        input,
        Input::Fault {
            loss: Loss::Drive,
            ..
        }
    );
    let is_hanging = before.brake != Brake::Absent && before.goal != Goal::Off && lets_go;
    let was_on = matches!(before.power, Power::On | Power::OnUnconfirmed);
    hold(
        !is_hanging || !was_on || (rules.may_leave)(Class::BrakeClose, &after),
        "the brake catches a load whose drive let go",
    )
}

fn never_refused(is_taken: bool, input: Input) -> Held {
    let may_be_refused = matches!(
        input,
        Input::Enable
            | Input::Adopt
            | Input::Resume
            | Input::Rearm
            | Input::Clear
            | Input::Move
            | Input::SyncMove
            | Input::StartWork(_)
            | Input::Start
            | Input::Arm
    );
    hold(
        is_taken || may_be_refused,
        "stops, readings, faults and the bus are never refused",
    )
}

/// Promise 1: nothing resumes by itself, after anything.
fn nothing_resumes(before: Facts, input: Input, after: Facts, is_taken: bool) -> Held {
    hold(
        !sends(&after) || sends(&before) || (input == Input::Start && is_taken),
        "motion begins only when the whole group is ready",
    )?;
    own_moves::nothing_moves_by_itself(before, input, after, is_taken)?;
    hold(
        before.motion != Motion::Ramp || after.motion != Motion::Stream,
        "a ramp never turns into streaming",
    )?;
    hold(
        after.motion != Motion::Ramp
            || before.motion == Motion::Ramp
            || matches!(
                input,
                Input::Stop | Input::Disable | Input::Fault { .. } | Input::GroupFault { .. }
            ),
        "a ramp begins only by a stop or a fault",
    )?;
    let asks_to_stream = matches!(input, Input::Enable | Input::Resume | Input::Rearm) && is_taken;
    hold(
        after.goal != Goal::Stream || before.goal == Goal::Stream || asks_to_stream,
        "only enable and resume lead to streaming",
    )?;
    let asks_to_hold = input == Input::Adopt && is_taken;
    hold(
        before.goal != Goal::Off || after.goal == Goal::Off || asks_to_stream || asks_to_hold,
        "what is to be off stays so until a command",
    )?;
    hold(
        before.latch == Latch::None || after.latch != Latch::None || input == Input::Clear,
        "a fault leaves only by clear",
    )?;
    hold(
        before.latch != Latch::Own || after.latch != Latch::Group,
        "a fault of its own is not covered by one of its group",
    )
}

/// Promises 6 and 9: power comes and goes only as somebody meant it.
fn power_is_meant(before: Facts, input: Input, after: Facts, is_taken: bool) -> Held {
    let is_held = before.power == Power::On && before.goal != Goal::Off;
    let is_asked = matches!(input, Input::Disable | Input::Rearm) && is_taken;
    let is_in_other_mode = input == Input::MoveEnded(MoveEnd::OtherMode);
    let is_caught = before.brake != Brake::Absent
        && matches!(
            input,
            Input::Fault {
                loss: Loss::Drive,
                ..
            }
        );
    hold(
        !is_held || is_asked || is_caught || is_in_other_mode || !is_off_due(&after),
        "what holds is not switched off without a command",
    )?;
    let is_untouched =
        before.power.is_unclear() || matches!(before.power, Power::Off | Power::FoundOn);
    let was_held = before.goal != Goal::Off;
    hold(
        !is_untouched || input == Input::Disable || (is_caught && was_held) || !is_off_due(&after),
        "what this master did not enable is not switched off without a command",
    )?;
    hold(
        !is_off_due(&before)
            || is_off_due(&after)
            || (input == Input::SaysOff && before.power == Power::OffSent),
        "a disable is repeated until the drive confirms it",
    )?;
    let disables = before.goal == Goal::Off && moves(&before);
    let is_confirmed = input == Input::SaysOff && after.power == Power::Off;
    hold(
        !disables || moves(&after) || is_off_due(&after) || is_confirmed,
        "a disable asked for in motion follows when the motion ends",
    )?;
    let came_back = input == Input::Displaced(Class::SwitchOn);
    let is_withdrawn = (is_off_due(&after) && after.goal == Goal::Off) || came_back;
    hold(
        before.power != Power::OnSent
            || matches!(after.power, Power::OnSent | Power::OnWanted | Power::On)
            || is_withdrawn,
        "an enable under way is confirmed or taken back",
    )?;
    hold(
        !matches!(after.power, Power::OnWanted | Power::OnSent)
            || matches!(
                before.power,
                Power::Off | Power::OnWanted | Power::OnSent | Power::OffSent
            ),
        "an enable begins with a drive that is off",
    )
}

fn of_commands(before: Facts, input: Input, after: Facts) -> Held {
    match input {
        Input::Enable => {
            hold(after.goal == Goal::Stream, "enable leads to streaming")?;
            let expected = if before.power == Power::On {
                before.knowledge
            } else {
                Knowledge::Unknown
            };
            hold(
                after.knowledge == expected,
                "an axis that is off is checked and anchored anew; one that holds keeps its anchor",
            )
        }
        Input::Resume => hold(
            after.goal == Goal::Stream && after.power == Power::On,
            "resume leads from holding to streaming",
        ),
        Input::Rearm => hold(
            after.power == Power::OffWanted
                && after.knowledge == Knowledge::Checked
                && after.goal == Goal::Stream,
            "switched off and on, an axis is anchored anew",
        ),
        Input::Adopt => hold(
            after.power == Power::On
                && after.goal == Goal::Hold
                && after.knowledge == Knowledge::Unknown,
            "adopt takes over without switching, and checks and anchors anew",
        ),
        Input::Move => hold(
            after
                == Facts {
                    goal: Goal::Move,
                    ..before
                },
            "a drive is asked to move by itself, and nothing else changes",
        ),
        Input::SyncMove => hold(
            after
                == Facts {
                    goal: Goal::SyncMove,
                    ..before
                },
            "a drive is asked to move with others, and nothing else changes",
        ),
        Input::Start => hold(
            after.motion == Motion::Stream,
            "a group that is ready streams",
        ),
        Input::Clear => of_clear(before, after),
        Input::Stop | Input::Halt | Input::Disable => of_stops(before, input, after),
        _ => Ok(()),
    }
}

fn of_clear(before: Facts, after: Facts) -> Held {
    hold(after.latch == Latch::None, "clear clears")?;
    let same = (before.power, before.goal, before.motion, before.brake);
    hold(
        (after.power, after.goal, after.motion, after.brake) == same,
        "clear moves nothing and switches nothing",
    )?;
    let expected = match before.latch {
        Latch::Own => Knowledge::Unknown,
        Latch::Group | Latch::None => before.knowledge,
    };
    hold(
        after.knowledge == expected,
        "after a fault of its own, and only then, a drive is checked anew",
    )?;
    hold(
        before.latch != Latch::Own || after.work == Work::None,
        "no work keeps a repair of the new checks waiting",
    )
}

/// Promise 3: `stop`, `halt` and `disable` work in every combination.
fn of_stops(before: Facts, input: Input, after: Facts) -> Held {
    hold(
        after.motion != Motion::Stream && matches!(after.goal, Goal::Off | Goal::Hold),
        "stop, halt and disable end streaming and moves in every combination",
    )?;
    hold(
        input == Input::Halt || moves(&before) == moves(&after),
        "stop and disable slow down on the path",
    )?;
    hold(
        input != Input::Halt || !sends(&after),
        "halt ends every set-point",
    )?;
    let may_hold =
        matches!(before.power, Power::On | Power::OnUnconfirmed) && before.goal != Goal::Off;
    if input == Input::Disable {
        let waits = sends(&after) || (moves(&after) && after.latch == Latch::None);
        let is_said = waits || is_off_due(&after) || after.power == Power::Off;
        hold(
            after.goal == Goal::Off && is_said,
            "disable sends its command, whatever is known",
        )?;
        hold(
            before.power != Power::OffSent || after.power == Power::OffSent,
            "a disable command under way is repeated by time, not by calls",
        )
    } else {
        hold(
            may_hold || after.goal == Goal::Off,
            "what was not on yet stays off after a stop",
        )?;
        hold(
            !may_hold || (after.goal == Goal::Hold && after.power == before.power),
            "what was on holds after a stop",
        )
    }
}

fn of_work(before: Facts, input: Input, after: Facts) -> Held {
    if let Input::StartWork(work) = input {
        return hold(after.work == work, "work that is accepted begins");
    }
    if input == Input::WorkEnded {
        hold(after.work == Work::None, "work ends")?;
        let expected = match before.work {
            Work::Write => Knowledge::Unknown,
            _ => before.knowledge,
        };
        return hold(
            after.knowledge == expected,
            "after a write, and only then, a drive is checked anew",
        );
    }
    let is_aborted = after.latch == Latch::Own && after.work == Work::None;
    let is_cleared = input == Input::Clear && before.latch == Latch::Own;
    hold(
        after.work == before.work || is_aborted || is_cleared,
        "work ends by itself, by a fault of its own or with it",
    )
}
