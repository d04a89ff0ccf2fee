//! No dead end: whatever happened, a drive and a bus that work again bring the axis to where the application wants it.

use can_motion::MoveEnd;
use can_motion::facts::{Brake, Class, Facts, Goal, Input, Knowledge, Latch, Motion, Power, Work};

use crate::promises::{asks_to_move, is_loaded};
use crate::rules::{BRAKES, Rules};
use crate::walk::{Broken, Held, hold};

/// What a drive and a bus that work do next.
fn next_events(rules: &Rules, facts: &Facts) -> Vec<Input> {
    let leaves = |class| (rules.may_leave)(class, facts);
    match (facts.motion, facts.power) {
        (Motion::Ramp, _) => return vec![Input::RampDone],
        (Motion::DriveMove, _) => return vec![Input::MoveEnded(MoveEnd::Arrived)],
        (_, power) if power.is_unclear() && facts.goal == Goal::Off => return vec![Input::SaysOff],
        (_, Power::Unclear | Power::OnUnconfirmed | Power::OnSent) => return vec![Input::SaysOn],
        (_, Power::OffSent) => return vec![Input::SaysOff],
        (_, Power::OnWanted) if leaves(Class::SwitchOn) => {
            return vec![Input::Accepted(Class::SwitchOn)];
        }
        (_, Power::OffWanted) if leaves(Class::SwitchOff) => {
            return vec![Input::Accepted(Class::SwitchOff)];
        }
        _ => {}
    }
    if leaves(Class::BrakeClose) {
        return vec![Input::Accepted(Class::BrakeClose), Input::BrakeClosed];
    }
    if leaves(Class::BrakeOpen) {
        return vec![Input::Accepted(Class::BrakeOpen), Input::BrakeOpened];
    }
    if facts.is_checking() {
        return vec![Input::Checked];
    }
    if facts.awaits_standstill() {
        return vec![Input::Stands];
    }
    if facts.awaits_anchor() {
        return vec![Input::Anchored];
    }
    for class in [Class::DriveMove, Class::Load, Class::Trigger] {
        if leaves(class) {
            return vec![Input::Accepted(class)];
        }
    }
    if (rules.accepts)(facts, Input::Arm) {
        return vec![Input::Arm];
    }
    if facts.motion == Motion::Rest && (rules.accepts)(facts, Input::Start) {
        return vec![Input::Start];
    }
    Vec::new()
}

/// Where commands lead when everything works.
struct Course<'a> {
    rules: &'a Rules,
    facts: Facts,
}

impl<'a> Course<'a> {
    fn from(rules: &'a Rules, facts: Facts) -> Self {
        Self { rules, facts }.until_quiet()
    }

    fn by(self, command: Input) -> Self {
        let facts = self.rules.next(self.facts, command).unwrap_or(self.facts);
        Self { facts, ..self }.until_quiet()
    }

    /// Work begins, its frame may leave, it ends.
    fn by_work(self, work: Work, class: Class) -> Result<Self, &'static str> {
        let begun = self.rules.step(self.facts, Input::StartWork(work));
        hold(
            begun.work == work && (self.rules.may_leave)(class, &begun),
            "a drive that is off can be repaired and written to",
        )?;
        let facts = begun;
        Ok(Self { facts, ..self }.by(Input::WorkEnded))
    }

    fn until_quiet(mut self) -> Self {
        for _ in 0..40 {
            let events = next_events(self.rules, &self.facts);
            if events.is_empty() {
                break;
            }
            for event in events {
                self.facts = self.rules.next(self.facts, event).unwrap_or(self.facts);
            }
        }
        self
    }
}

fn is_off(facts: &Facts) -> bool {
    let is_braked = matches!(facts.brake, Brake::Absent | Brake::Closed);
    facts.power == Power::Off
        && facts.goal == Goal::Off
        && facts.motion == Motion::Rest
        && is_braked
}

fn is_holding(facts: &Facts) -> bool {
    let is_released = matches!(facts.brake, Brake::Absent | Brake::Open);
    facts.power == Power::On
        && facts.goal == Goal::Hold
        && facts.knowledge == Knowledge::Anchored
        && facts.latch == Latch::None
        && is_released
}

fn check(rules: &Rules, facts: Facts) -> Held {
    // Without a command.
    let alone = Course::from(rules, facts).facts;
    let is_fine = facts.latch == Latch::None;
    hold(
        !is_fine || facts.goal != Goal::Stream || alone.motion == Motion::Stream,
        "what is to stream gets there",
    )?;
    hold(
        !is_fine || facts.goal != Goal::Hold || is_holding(&alone),
        "what is to hold gets there",
    )?;
    hold(
        !asks_to_move(&facts) || is_holding(&alone) && alone.motion == Motion::Rest,
        "what is to move by itself gets there, and holds",
    )?;
    hold(
        facts.goal != Goal::Off || is_off(&alone) || alone.power == Power::FoundOn,
        "what is to be off gets there, or is found on and reported",
    )?;
    hold(
        facts.goal != Goal::Off || facts.power == Power::FoundOn || is_off(&alone),
        "only a drive that was found on is left on",
    )?;
    // Off, repaired, cleared, written to, and back.
    let off = Course::from(rules, facts).by(Input::Disable);
    hold(is_off(&off.facts), "every axis can be switched off")?;
    let off = off.by(Input::WorkEnded);
    let fine = off.by_work(Work::Repair, Class::Repair)?.by(Input::Clear);
    hold(
        fine.facts.latch == Latch::None && fine.facts.knowledge >= Knowledge::Checked,
        "every fault can be cleared when the drive is off",
    )?;
    let on = fine.by_work(Work::Write, Class::Write)?.by(Input::Enable);
    hold(
        on.facts.motion == Motion::Stream,
        "every axis gets back to streaming",
    )?;
    let held = on.by(Input::Stop);
    hold(is_holding(&held.facts), "what streams can be stopped")?;
    let enabled = Course::from(rules, held.facts).by(Input::Enable);
    hold(
        enabled.facts.motion == Motion::Stream,
        "what holds can be enabled with its group",
    )?;
    for command in [Input::Move, Input::SyncMove] {
        hold(
            (rules.accepts)(&held.facts, command),
            "the drive of what holds can be asked to move by itself",
        )?;
        let there = Course::from(rules, held.facts)
            .by(command)
            .by(Input::Resume);
        hold(
            there.facts.motion == Motion::Stream,
            "what arrived can be resumed",
        )?;
    }
    let back = held.by(Input::Resume);
    hold(
        back.facts.motion == Motion::Stream,
        "what holds can be resumed",
    )?;
    if facts.brake == Brake::Absent {
        let anew = back.by(Input::Halt).by(Input::Rearm);
        hold(
            anew.facts.motion == Motion::Stream,
            "what holds can be switched off and on",
        )?;
    }
    // With a loaded move it has to be off first.
    if facts.power == Power::FoundOn && !is_loaded(&facts) {
        let taken = Course::from(rules, facts)
            .by(Input::WorkEnded)
            .by(Input::Clear)
            .by(Input::Adopt);
        hold(
            is_holding(&taken.facts),
            "a drive that was found on can be taken over",
        )?;
    }
    Ok(())
}

/// From everywhere; the number of combinations it was tried from.
pub(crate) fn nothing_is_a_dead_end(rules: &Rules) -> Result<usize, Broken> {
    let mut count = 0;
    for brake in BRAKES {
        let seen = rules.walk_one(brake, |_, _, after| check(rules, after))?;
        count += seen.len();
    }
    Ok(count)
}
