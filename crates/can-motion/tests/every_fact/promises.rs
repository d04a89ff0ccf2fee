//! What is true of every combination that can be reached.

use can_motion::facts::{Brake, Facts, Goal, Knowledge, Latch, Motion, Power};
use can_motion::{AxisState, Stage};

use crate::exits;
use crate::rules::Rules;
use crate::walk::{Held, hold};

/// By set-points or by its drive itself.
pub(crate) fn moves(facts: &Facts) -> bool {
    sends(facts) || facts.motion == Motion::DriveMove
}

/// Set-points go out.
pub(crate) fn sends(facts: &Facts) -> bool {
    matches!(facts.motion, Motion::Ramp | Motion::Stream)
}

/// The drive was sent a move that a trigger would start.
pub(crate) fn is_loaded(facts: &Facts) -> bool {
    matches!(facts.motion, Motion::Loaded | Motion::Armed)
}

/// A motion of the drive itself is asked for.
pub(crate) fn asks_to_move(facts: &Facts) -> bool {
    matches!(facts.goal, Goal::Move | Goal::SyncMove)
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
        !sends(facts) || (facts.power == Power::On && facts.knowledge == Knowledge::Anchored),
        "moves only anchored and on",
    )?;
    hold(
        !sends(facts) || matches!(facts.brake, Brake::Absent | Brake::Open),
        "moves only with an open brake",
    )?;
    of_own_moves(facts)?;
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
        facts.goal == Goal::Off || facts.goal == Goal::Hold || facts.latch == Latch::None,
        "no wish to stream or move outlives a fault",
    )?;
    exits::keeps_back(rules, facts)?;
    exits::lets_out(rules, facts)?;
    of_view(facts)
}

/// What a drive does by itself.
fn of_own_moves(facts: &Facts) -> Held {
    hold(
        !asks_to_move(facts)
            || (facts.power == Power::On
                && facts.knowledge == Knowledge::Anchored
                && matches!(facts.brake, Brake::Absent | Brake::Open)),
        "a drive is asked to move by itself only anchored, on, and with an open brake",
    )?;
    hold(
        !asks_to_move(facts) || !sends(facts),
        "set-points and a motion of the drive itself exclude each other",
    )?;
    hold(
        facts.motion != Motion::DriveMove || facts.goal != Goal::Stream,
        "no set-points are wanted while the drive moves by itself",
    )?;
    hold(
        !is_loaded(facts) || facts.goal != Goal::Move && facts.goal != Goal::Stream,
        "a loaded move is started by its trigger or left alone",
    )?;
    hold(
        !(is_loaded(facts) || facts.motion == Motion::DriveMove)
            || !matches!(facts.power, Power::Off | Power::OnWanted),
        "a drive without power makes and keeps no move",
    )
}

/// What the state that users see says about the facts.
fn of_view(facts: &Facts) -> Held {
    let state = AxisState::of(facts, Stage::Probing);
    let is_fine = facts.latch == Latch::None;
    let is_shown = match state {
        AxisState::Streaming => facts.motion == Motion::Stream && facts.power == Power::On,
        AxisState::RampingDown => facts.motion == Motion::Ramp && facts.power == Power::On,
        AxisState::DriveMoving => {
            facts.motion == Motion::DriveMove && asks_to_move(facts) && facts.power == Power::On
        }
        AxisState::DriveStopping => facts.motion == Motion::DriveMove && !asks_to_move(facts),
        AxisState::Loaded => is_fine && is_loaded(facts),
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
            is_fine
                && facts.power == Power::On
                && facts.knowledge == Knowledge::Anchored
                && facts.motion == Motion::Rest
        }
        _ => false,
    };
    hold(is_shown, "the state shown is that of the facts")?;
    hold(
        state != AxisState::Holding || facts.goal != Goal::Off,
        "what is shown as holding is meant to hold",
    )?;
    hold(
        state.is_enabled()
            == (sends(facts) || matches!(state, AxisState::Holding | AxisState::DriveMoving))
            && (!state.is_enabled() || facts.power == Power::On),
        "shown as enabled only when the drive said so",
    )?;
    hold(
        (facts.motion == Motion::Stream) == (state == AxisState::Streaming)
            && sends(facts) == state.sends_set_points(),
        "shown as streaming exactly when it streams",
    )
}
