//! What must be true before a command is accepted, in every combination that the types allow.

use can_motion::facts::{Brake, Facts, Goal, Input, Knowledge, Latch, Motion, Power, Work};

use crate::promises::moves;
use crate::rules::Rules;
use crate::walk::{Held, hold};

/// Holds for every input that is refused.
pub(crate) fn is_fit_for(rules: &Rules, facts: &Facts, input: Input) -> Held {
    if !(rules.accepts)(facts, input) {
        return Ok(());
    }
    let is_on = facts.power == Power::On;
    let is_off = facts.power == Power::Off && facts.goal == Goal::Off;
    let is_held = is_on && facts.goal == Goal::Hold;
    let is_anchored = facts.knowledge == Knowledge::Anchored;
    match input {
        Input::Enable => {
            has_no_objection(facts)?;
            was_checked(facts)?;
            hold(is_off || is_held, "enabled is what is off, or holds")
        }
        Input::Adopt => {
            has_no_objection(facts)?;
            was_checked(facts)?;
            let is_found = facts.power == Power::FoundOn && facts.goal == Goal::Off;
            hold(is_found, "taken over is what was found on")
        }
        Input::Resume => {
            has_no_objection(facts)?;
            hold(is_held && is_anchored, "resumed is what holds its anchor")
        }
        Input::Rearm => {
            has_no_objection(facts)?;
            was_checked(facts)?;
            hold(is_held, "switched off and on is what holds")?;
            hold(
                facts.brake == Brake::Absent,
                "a load that can fall is not let go in passing",
            )
        }
        Input::Move | Input::SyncMove => {
            has_no_objection(facts)?;
            hold(
                is_held && is_anchored,
                "asked to move by itself is what holds its anchor",
            )?;
            hold(
                matches!(facts.brake, Brake::Absent | Brake::Open),
                "a drive moves by itself with an open brake",
            )?;
            hold(
                facts.work == Work::None,
                "a drive moves by itself without a procedure beside",
            )
        }
        Input::Arm => {
            hold(
                facts.motion == Motion::Loaded && facts.goal == Goal::SyncMove,
                "a trigger waits for what is loaded and still wanted",
            )?;
            hold(facts.latch == Latch::None, "no trigger under a fault")
        }
        Input::Start => {
            has_no_objection(facts)?;
            hold(
                is_on && is_anchored && facts.goal == Goal::Stream,
                "motion begins where it is wanted, on and anchored",
            )?;
            hold(
                matches!(facts.brake, Brake::Absent | Brake::Open),
                "motion begins with an open brake",
            )
        }
        Input::StartWork(work) => of_work(facts, work, is_off),
        Input::Clear => {
            hold(
                !moves(facts) && !facts.work.needs_off(),
                "no clear while an axis slows down or is repaired",
            )?;
            hold(
                !facts.power.is_unclear() || facts.goal == Goal::Off,
                "no clear while it is unclear whether a held axis still holds",
            )
        }
        _ => Ok(()),
    }
}

fn has_no_objection(facts: &Facts) -> Held {
    hold(
        facts.latch == Latch::None,
        "no command under a fault that was not cleared",
    )?;
    hold(
        !facts.work.needs_off(),
        "no command for power beside a write",
    )?;
    hold(
        facts.motion == Motion::Rest,
        "no command for power to an axis that moves or has a loaded move",
    )
}

fn was_checked(facts: &Facts) -> Held {
    hold(
        facts.knowledge >= Knowledge::Checked,
        "what was not checked is neither enabled nor written to",
    )
}

fn of_work(facts: &Facts, work: Work, is_off: bool) -> Held {
    hold(
        facts.work == Work::None && work != Work::None,
        "one piece of work at a time",
    )?;
    if work.needs_off() {
        hold(is_off, "no write and no repair of a drive that may be on")?;
        hold(!moves(facts), "no write and no repair in motion")?;
    }
    if work == Work::Write {
        was_checked(facts)?;
        hold(
            facts.latch == Latch::None,
            "no write to a drive with a fault",
        )?;
    }
    Ok(())
}
