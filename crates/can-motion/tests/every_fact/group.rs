//! A group of two: what happens to one axis happens to its group. A model of `core/group.rs` over the same three functions.

use can_motion::facts::{Brake, Facts, Goal, Input, Latch, Loss, Motion, Power};

use crate::promises::{is_off_due, moves, of_facts};
use crate::rules::{Rules, inputs};
use crate::walk::{Broken, Held, hold, walk};

/// What a fault does to the group, and whether a ramp keeps every axis within its travel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Policy {
    RampDown,
    /// The same as a ramp that does not fit the travel.
    Halt,
    Disable,
}

pub(crate) const POLICIES: [Policy; 3] = [Policy::RampDown, Policy::Halt, Policy::Disable];

type Pair = [Facts; 2];

#[derive(Debug, Clone, Copy)]
enum Event {
    /// The application, to the group. `Rearm` stands for enable and resume where what holds is to be switched off and on.
    Command(Input),
    /// A piece of work, a reading, the bus, time or a fault, of one axis.
    Axis(usize, Input),
}

struct Group<'a> {
    rules: &'a Rules,
    policy: Policy,
    axes: Pair,
}

impl Group<'_> {
    fn accepts(&self, index: usize, input: Input) -> bool {
        (self.rules.accepts)(&self.axes[index], input)
    }

    fn apply(&mut self, index: usize, input: Input) {
        let before = self.axes[index];
        let Some(after) = self.rules.next(before, input) else {
            return;
        };
        let is_fault = matches!(input, Input::Fault { .. });
        if after == before || (is_fault && has_lost_already(&before, &after)) {
            return;
        }
        self.axes[index] = after;
        if after.latch == Latch::Own && (before.latch != Latch::Own || is_fault) {
            self.spread(index, is_in_use(&before));
        }
        if (self.rules.accepts)(&after, Input::Start)
            && (0..2).all(|index| self.accepts(index, Input::Start))
        {
            for index in 0..2 {
                self.apply(index, Input::Start);
            }
        }
    }

    fn spread(&mut self, index: usize, was_in_use: bool) {
        let ramp = self.policy == Policy::RampDown;
        for other in 0..2 {
            let is_in_use = if other == index {
                was_in_use
            } else {
                is_in_use(&self.axes[other])
            };
            if other != index {
                self.apply(other, Input::GroupFault { ramp });
            }
            if self.policy == Policy::Disable && is_in_use {
                self.apply(other, Input::Disable);
            }
        }
    }

    /// Whether the group took the command.
    fn command(&mut self, input: Input) -> bool {
        if matches!(input, Input::Stop | Input::Halt | Input::Disable) {
            for input in [Input::Halt, input] {
                for index in 0..2 {
                    if input != Input::Halt || self.policy == Policy::Halt {
                        self.apply(index, input);
                    }
                }
            }
            return true;
        }
        let concerned: Vec<(usize, Input)> = (0..2)
            .filter(|&index| input != Input::Adopt || self.axes[index].power == Power::FoundOn)
            .map(|index| (index, self.input_for(index, input)))
            .collect();
        let are_willing = concerned
            .iter()
            .all(|&(index, input)| self.accepts(index, input));
        if concerned.is_empty() || !are_willing {
            return false;
        }
        for (index, input) in concerned {
            self.apply(index, input);
        }
        true
    }

    fn input_for(&self, index: usize, input: Input) -> Input {
        let facts = &self.axes[index];
        let is_held = facts.goal == Goal::Hold && facts.power == Power::On;
        if input == Input::Rearm && !is_held {
            Input::Enable
        } else {
            input
        }
    }
}

fn is_in_use(facts: &Facts) -> bool {
    facts.goal != Goal::Off || moves(facts)
}

/// A fault that changes nothing that matters is not taken again.
fn has_lost_already(before: &Facts, after: &Facts) -> bool {
    let matters = |facts: &Facts| {
        (
            facts.latch,
            facts.knowledge,
            facts.motion,
            facts.goal,
            (facts.power == Power::On, facts.power.may_be_on()),
        )
    };
    matters(before) == matters(after)
}

fn events(policy: Policy) -> Vec<Event> {
    let mut all = Vec::new();
    for input in inputs() {
        match input {
            Input::Enable
            | Input::Adopt
            | Input::Resume
            | Input::Rearm
            | Input::Stop
            | Input::Disable
            | Input::Clear => all.push(Event::Command(input)),
            Input::Halt if policy != Policy::Halt => all.push(Event::Command(input)),
            Input::Start | Input::GroupFault { .. } | Input::Halt => {}
            Input::Fault { ramp, .. } if ramp != (policy == Policy::RampDown) => {}
            _ => all.extend([0, 1].map(|index| Event::Axis(index, input))),
        }
    }
    all
}

fn next(rules: &Rules, policy: Policy, axes: Pair, event: Event) -> Option<Pair> {
    let mut group = Group {
        rules,
        policy,
        axes,
    };
    match event {
        Event::Command(input) => {
            if !group.command(input) {
                return None;
            }
        }
        Event::Axis(index, input) => group.apply(index, input),
    }
    Some(group.axes)
}

fn check(rules: &Rules, policy: Policy, before: Pair, event: Event, after: Pair) -> Held {
    for facts in &after {
        of_facts(rules, facts)?;
    }
    hold(
        (after[0].motion == Motion::Stream) == (after[1].motion == Motion::Stream),
        "no axis of a group streams without the other",
    )?;
    let is_fine = after.iter().all(|axis| axis.latch == Latch::None);
    hold(
        !is_fine || (after[0].goal == Goal::Stream) == (after[1].goal == Goal::Stream),
        "no group of two minds",
    )?;
    for (one, other) in [(0, 1), (1, 0)] {
        if let Event::Axis(index, input) = event
            && index == one
        {
            of_the_other(
                policy,
                (before[one], after[one]),
                before[other],
                after[other],
            )?;
            a_drive_that_starts_anew_may_be_on(input, after[one])?;
            let is_asleep = !is_in_use(&before[one]) && !is_off_due(&before[one]);
            hold(
                !is_asleep || !is_off_due(&after[one]),
                "only a command switches off what is not in use",
            )?;
        }
    }
    Ok(())
}

/// What an event of one axis may do to the other.
fn of_the_other(policy: Policy, one: (Facts, Facts), before: Facts, after: Facts) -> Held {
    let is_new_fault = one.1.latch == Latch::Own && one.0.latch != Latch::Own;
    let is_concerned = is_in_use(&before);
    if is_new_fault && is_concerned {
        hold(
            after.latch != Latch::None && after.goal != Goal::Stream,
            "a fault of one reaches the other",
        )?;
        let is_let_go = is_off_due(&after) || after.power == Power::Off;
        hold(
            policy != Policy::Disable || is_let_go || (moves(&after) && after.goal == Goal::Off),
            "a fault that disables the group disables the other",
        )?;
    }
    hold(
        is_concerned || after == before,
        "a fault of one spares a bystander",
    )?;
    let is_held = before.power == Power::On && before.goal != Goal::Off;
    hold(
        policy == Policy::Disable || !is_held || after.power == Power::On,
        "a fault of one does not drop the load of the other",
    )
}

fn a_drive_that_starts_anew_may_be_on(input: Input, after: Facts) -> Held {
    let starts_anew = matches!(
        input,
        Input::Fault {
            loss: Loss::Drive,
            ..
        }
    );
    hold(
        !starts_anew || after.power.may_be_on(),
        "a drive that started anew may be on",
    )
}

/// The number of combinations of a group of two, each with or without a brake.
pub(crate) fn group_of_two(
    rules: &Rules,
    policy: Policy,
    brakes: [Brake; 2],
) -> Result<usize, Broken> {
    let seen = walk(
        &[brakes.map(Facts::start)],
        &events(policy),
        |axes, event| next(rules, policy, axes, event),
        |before, event, after| check(rules, policy, before, event, after),
    )?;
    Ok(seen.len())
}
