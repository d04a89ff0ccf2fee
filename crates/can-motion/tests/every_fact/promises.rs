//! What is true of every combination that can be reached.

use can_motion::facts::{Brake, Facts, Goal, Knowledge, Latch, Motion, Power};
use can_motion::{AxisState, Stage};

use crate::exits;
use crate::rules::Rules;
use crate::walk::{Held, hold};

pub(crate) fn moves(facts: &Facts) -> bool {
    facts.motion != Motion::Rest
}

pub(crate) fn is_off_due(facts: &Facts) -> bool {
    matches!(facts.power, Power::OffWanted | Power::OffSent)
}

/// Promises about facts alone, with what the exit does there.
pub(crate) fn of_facts(rules: &Rules, facts: &Facts) -> Held {
    hold(
        facts.motion != Motion::Stream
            || (facts.latch == Latch::None && facts.goal == Goal::Stream),
        "streams only when it is wanted and no fault speaks against it",
    )?;
    hold(
        !moves(facts) || (facts.power == Power::On && facts.knowledge == Knowledge::Anchored),
        "moves only anchored and on",
    )?;
    hold(
        !moves(facts) || matches!(facts.brake, Brake::Absent | Brake::Open),
        "moves only with an open brake",
    )?;
    hold(
        !facts.work.needs_off() || (facts.goal == Goal::Off && !moves(facts)),
        "a write and a wish to have power exclude each other",
    )?;
    hold(
        facts.goal != Goal::Off
            || moves(facts)
            || !matches!(facts.power, Power::On | Power::OnSent | Power::OnWanted),
        "what is to be off is driven to off",
    )?;
    hold(
        facts.goal != Goal::Hold || matches!(facts.power, Power::On | Power::OnUnconfirmed),
        "only what is on, or was, is to hold",
    )?;
    hold(
        facts.goal != Goal::Stream || facts.latch == Latch::None,
        "no wish to stream outlives a fault",
    )?;
    exits::keeps_back(rules, facts)?;
    exits::lets_out(rules, facts)?;
    of_view(facts)
}

/// What the state that users see says about the facts.
fn of_view(facts: &Facts) -> Held {
    let state = AxisState::of(facts, Stage::Probing);
    let is_fine = facts.latch == Latch::None;
    let is_shown = match state {
        AxisState::Streaming => facts.motion == Motion::Stream && facts.power == Power::On,
        AxisState::RampingDown => facts.motion == Motion::Ramp && facts.power == Power::On,
        AxisState::Disabling => !moves(facts) && is_off_due(facts),
        AxisState::Faulted => !is_fine && !moves(facts) && !is_off_due(facts),
        AxisState::Enabling => {
            is_fine
                && facts.goal == Goal::Stream
                && matches!(facts.power, Power::OnWanted | Power::OnSent)
        }
        AxisState::Probing => is_fine && facts.knowledge == Knowledge::Unknown,
        AxisState::FoundOn => {
            is_fine && facts.power == Power::FoundOn && facts.knowledge != Knowledge::Unknown
        }
        AxisState::CheckingStatus => is_fine && facts.power.is_unclear(),
        AxisState::Ready => {
            is_fine
                && facts.power == Power::Off
                && facts.goal == Goal::Off
                && facts.knowledge >= Knowledge::Checked
        }
        AxisState::AwaitingStandstill => is_fine && facts.awaits_standstill(),
        AxisState::Anchoring => is_fine && facts.awaits_anchor(),
        AxisState::Holding => {
            is_fine && facts.power == Power::On && facts.knowledge == Knowledge::Anchored
        }
        _ => false,
    };
    hold(is_shown, "the state shown is that of the facts")?;
    hold(
        state != AxisState::Holding || facts.goal != Goal::Off,
        "what is shown as holding is meant to hold",
    )?;
    hold(
        state.is_enabled() == (moves(facts) || state == AxisState::Holding)
            && (!state.is_enabled() || facts.power == Power::On),
        "shown as enabled only when the drive said so",
    )?;
    hold(
        (facts.motion == Motion::Stream) == (state == AxisState::Streaming)
            && moves(facts) == state.sends_set_points(),
        "shown as streaming exactly when it streams",
    )
}
