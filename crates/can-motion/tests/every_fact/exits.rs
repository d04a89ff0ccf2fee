//! What the exit promises, in every combination that the types allow.

use can_motion::facts::{Brake, Class, Facts, Goal, Knowledge, Latch, Motion, Power, Work};

use crate::promises::{asks_to_move, moves, sends};
use crate::rules::Rules;
use crate::walk::{Held, hold};

/// What must not leave.
pub(crate) fn keeps_back(rules: &Rules, facts: &Facts) -> Held {
    let leaves = |class| (rules.may_leave)(class, facts);
    let is_on = facts.power == Power::On;
    let is_off_for_good = facts.power == Power::Off && facts.goal == Goal::Off;
    let is_fine = facts.latch == Latch::None;
    if leaves(Class::SetPoint) {
        hold(
            sends(facts),
            "no set-point at rest or while the drive moves by itself",
        )?;
        hold(is_on, "no set-point without power of this master")?;
        hold(
            facts.knowledge == Knowledge::Anchored,
            "no set-point without an anchor",
        )?;
        hold(
            matches!(facts.brake, Brake::Absent | Brake::Open),
            "no set-point against a brake",
        )?;
    }
    if leaves(Class::StopFrame) {
        hold(!moves(facts), "no stop frame between set-points")?;
        hold(
            !matches!(facts.power, Power::FoundOn | Power::Unclear),
            "no frame touches a drive that may be somebody else's",
        )?;
    }
    own_moves_keep_back(rules, facts)?;
    if leaves(Class::SwitchOn) {
        hold(
            matches!(facts.power, Power::OnWanted | Power::OnSent),
            "no enable frame unless it is due",
        )?;
        hold(
            facts.knowledge == Knowledge::Anchored,
            "no enable frame without standstill and anchor",
        )?;
        hold(
            facts.goal != Goal::Off,
            "no enable frame that nobody asked for",
        )?;
        hold(is_fine, "no enable frame under a fault")?;
        hold(!facts.work.needs_off(), "no enable frame beside a write")?;
    }
    if leaves(Class::SwitchOff) {
        hold(
            matches!(facts.power, Power::OffWanted | Power::OffSent),
            "no disable frame that nobody asked for",
        )?;
        hold(
            matches!(facts.brake, Brake::Absent | Brake::Closed),
            "no disable frame before the brake is closed",
        )?;
    }
    if leaves(Class::Write) {
        hold(
            facts.work == Work::Write,
            "no write without its piece of work",
        )?;
        hold(
            is_off_for_good,
            "no write to a drive that may be on or come on",
        )?;
        hold(is_fine, "no write under a fault")?;
    }
    if leaves(Class::Repair) {
        hold(
            facts.work == Work::Repair,
            "no repair without its piece of work",
        )?;
        hold(
            is_off_for_good,
            "no repair of a drive that may be on or come on",
        )?;
    }
    brakes_keep_back(rules, facts)
}

fn own_moves_keep_back(rules: &Rules, facts: &Facts) -> Held {
    let leaves = |class| (rules.may_leave)(class, facts);
    for (class, goal, motions) in [
        (
            Class::DriveMove,
            Goal::Move,
            [Motion::Rest, Motion::DriveMove],
        ),
        (Class::Load, Goal::SyncMove, [Motion::Rest; 2]),
        (Class::Trigger, Goal::SyncMove, [Motion::Armed; 2]),
    ] {
        if !leaves(class) {
            continue;
        }
        hold(
            facts.goal == goal,
            "no motion of a drive that nobody asked for",
        )?;
        hold(
            motions.contains(&facts.motion),
            "no second motion of a drive, no trigger before every drive has its move",
        )?;
        hold(
            facts.power == Power::On && facts.knowledge == Knowledge::Anchored,
            "no motion of a drive that is not on and anchored",
        )?;
        hold(
            facts.latch == Latch::None,
            "no motion of a drive under a fault",
        )?;
        hold(
            !facts.work.needs_off(),
            "no motion of a drive beside a write",
        )?;
        hold(
            matches!(facts.brake, Brake::Absent | Brake::Open),
            "no motion of a drive against a brake",
        )?;
    }
    if leaves(Class::DriveStop) {
        hold(
            facts.motion == Motion::DriveMove && !asks_to_move(facts),
            "no command to stop what is wanted, or does not move",
        )?;
        hold(
            !matches!(facts.power, Power::Unclear | Power::FoundOn),
            "no command to stop touches a drive that may be somebody else's",
        )?;
    }
    Ok(())
}

fn brakes_keep_back(rules: &Rules, facts: &Facts) -> Held {
    let leaves = |class| (rules.may_leave)(class, facts);
    if leaves(Class::BrakeClose) {
        hold(!moves(facts), "no brake closes on a moving axis")?;
        hold(
            facts.goal == Goal::Off,
            "no brake closes on an axis that is to hold",
        )?;
        hold(
            !facts.power.is_unclear() && facts.power != Power::FoundOn,
            "no brake closes on a drive that may be somebody else's",
        )?;
        hold(
            matches!(facts.brake, Brake::Unclear | Brake::Open),
            "no brake frame without a brake to close",
        )?;
    }
    if leaves(Class::BrakeOpen) {
        hold(
            facts.power == Power::On,
            "no brake opens without a drive that holds",
        )?;
        hold(
            facts.goal != Goal::Off,
            "no brake opens on an axis that is to be off",
        )?;
        hold(facts.latch == Latch::None, "no brake opens under a fault")?;
        hold(
            matches!(facts.brake, Brake::Unclear | Brake::Closed),
            "no brake frame without a brake to open",
        )?;
    }
    Ok(())
}

/// What must be able to leave: nothing that is due waits for something that never comes.
pub(crate) fn lets_out(rules: &Rules, facts: &Facts) -> Held {
    let leaves = |class| (rules.may_leave)(class, facts);
    let is_at_rest = !moves(facts);
    let has_brake = facts.brake != Brake::Absent;
    hold(
        leaves(Class::Reading) && leaves(Class::Poll),
        "readings and polls always may leave",
    )?;
    hold(
        !sends(facts) || leaves(Class::SetPoint),
        "an axis in motion gets its set-points",
    )?;
    let may_be_ours = !matches!(facts.power, Power::FoundOn | Power::Unclear);
    hold(
        !is_at_rest || !may_be_ours || leaves(Class::StopFrame),
        "an axis at rest gets the frame that keeps it there",
    )?;
    own_moves_let_out(rules, facts)?;
    hold(
        facts.power != Power::OnWanted || leaves(Class::SwitchOn),
        "an enable command that is due may leave",
    )?;
    let is_off_due = matches!(facts.power, Power::OffWanted | Power::OffSent);
    let waits_for_brake = has_brake && facts.brake != Brake::Closed;
    hold(
        !is_off_due || waits_for_brake || leaves(Class::SwitchOff),
        "a disable command that is due may leave",
    )?;
    let may_close = (is_off_due && is_at_rest) || facts.power == Power::Off;
    hold(
        !may_close || !waits_for_brake || facts.goal != Goal::Off || leaves(Class::BrakeClose),
        "the brake of an axis that is to be off may be closed",
    )?;
    let may_open = facts.power == Power::On
        && facts.goal != Goal::Off
        && facts.latch == Latch::None
        && has_brake
        && facts.brake != Brake::Open;
    hold(
        !may_open || leaves(Class::BrakeOpen),
        "the brake of an axis that is to move may be opened",
    )?;
    let is_off_for_good = facts.power == Power::Off && facts.goal == Goal::Off;
    let is_write_due = is_off_for_good && facts.work == Work::Write && facts.latch == Latch::None;
    hold(
        !is_write_due || leaves(Class::Write),
        "a write that was accepted may leave",
    )?;
    let is_repair_due = is_off_for_good && facts.work == Work::Repair;
    hold(
        !is_repair_due || leaves(Class::Repair),
        "a repair that was accepted may leave",
    )
}

fn own_moves_let_out(rules: &Rules, facts: &Facts) -> Held {
    let leaves = |class| (rules.may_leave)(class, facts);
    let due = match (facts.goal, facts.motion) {
        (Goal::Move, Motion::Rest | Motion::DriveMove) => Some(Class::DriveMove),
        (Goal::SyncMove, Motion::Rest) => Some(Class::Load),
        (Goal::SyncMove, Motion::Armed) => Some(Class::Trigger),
        (_, Motion::DriveMove) if !asks_to_move(facts) => Some(Class::DriveStop),
        _ => None,
    };
    hold(
        due.is_none_or(leaves),
        "a motion of the drive that is due may begin, and one that is not wanted be stopped",
    )
}
