//! The three functions under test, what can happen to an axis, and every combination that the types allow.

use can_motion::MoveEnd;
use can_motion::facts::{
    Brake, Class, Facts, Goal, Input, Knowledge, Latch, Loss, Motion, Power, Work, accepts,
    may_leave, transition,
};

use crate::walk::{Broken, Held, walk};

/// The functions under test: those of the crate, or those with a mistake in one of them.
#[derive(Clone, Copy)]
pub(crate) struct Rules {
    pub(crate) accepts: fn(&Facts, Input) -> bool,
    pub(crate) transition: fn(Facts, Input) -> Facts,
    pub(crate) may_leave: fn(Class, &Facts) -> bool,
}

/// Those of the crate.
pub(crate) const RULES: Rules = Rules {
    accepts,
    transition,
    may_leave,
};

impl Rules {
    pub(crate) fn step(&self, facts: Facts, input: Input) -> Facts {
        if (self.accepts)(&facts, input) {
            (self.transition)(facts, input)
        } else {
            facts
        }
    }

    /// What an input makes of an axis; `None` where the input cannot happen.
    pub(crate) fn next(&self, facts: Facts, input: Input) -> Option<Facts> {
        let can_happen = match input {
            // The master asks the exit before it offers a frame.
            Input::Accepted(class) => (self.may_leave)(class, &facts),
            // Only a frame of a piece of work starts a drive anew.
            Input::Restarted => facts.work.needs_off(),
            Input::WorkEnded => facts.work != Work::None,
            _ => true,
        };
        can_happen.then(|| self.step(facts, input))
    }

    pub(crate) fn walk_one(
        &self,
        brake: Brake,
        check: impl Fn(Facts, Input, Facts) -> Held,
    ) -> Result<Vec<Facts>, Broken> {
        let next = |facts, input| self.next(facts, input);
        walk(&[Facts::start(brake)], &inputs(), next, check)
    }
}

/// An axis without a brake, and one with a brake that the master operates.
pub(crate) const BRAKES: [Brake; 2] = [Brake::Absent, Brake::Unclear];

/// Everything that can happen to an axis.
pub(crate) fn inputs() -> Vec<Input> {
    let mut all = vec![
        Input::Enable,
        Input::Adopt,
        Input::Resume,
        Input::Rearm,
        Input::Stop,
        Input::Halt,
        Input::Disable,
        Input::Clear,
        Input::Move,
        Input::SyncMove,
        Input::StartWork(Work::None),
        Input::StartWork(Work::Read),
        Input::StartWork(Work::Write),
        Input::StartWork(Work::Repair),
        Input::Checked,
        Input::Stands,
        Input::Turns,
        Input::Anchored,
        Input::SaysOn,
        Input::SaysOff,
        Input::BrakeOpened,
        Input::BrakeClosed,
        Input::WorkEnded,
        Input::Restarted,
        Input::ConfirmTimeout,
        Input::RampDone,
        Input::GroupFault { ramp: true },
        Input::GroupFault { ramp: false },
        Input::Start,
        Input::Arm,
    ];
    all.extend(ENDS.map(Input::MoveEnded));
    all.extend(Class::ALL.map(Input::Accepted));
    all.extend(Class::ALL.map(Input::Displaced));
    for loss in LOSSES {
        all.extend([true, false].map(|ramp| Input::Fault { loss, ramp }));
    }
    all
}

pub(crate) const ENDS: [MoveEnd; 3] = [MoveEnd::Arrived, MoveEnd::Elsewhere, MoveEnd::OtherMode];

const LOSSES: [Loss; 5] = [
    Loss::Nothing,
    Loss::Anchor,
    Loss::Knowledge,
    Loss::Contact,
    Loss::Drive,
];

pub(crate) const MOTIONS: [Motion; 6] = [
    Motion::Rest,
    Motion::Ramp,
    Motion::Stream,
    Motion::Loaded,
    Motion::Armed,
    Motion::DriveMove,
];

pub(crate) const GOALS: [Goal; 5] = [
    Goal::Off,
    Goal::Hold,
    Goal::Stream,
    Goal::Move,
    Goal::SyncMove,
];

/// Every combination that the types allow, whether it can be reached or not.
pub(crate) fn every_combination() -> Vec<Facts> {
    let mut all = Vec::new();
    for knowledge in [
        Knowledge::Unknown,
        Knowledge::Checked,
        Knowledge::Standing,
        Knowledge::Anchored,
    ] {
        for power in [
            Power::Unclear,
            Power::OnUnconfirmed,
            Power::Off,
            Power::OnWanted,
            Power::OnSent,
            Power::On,
            Power::FoundOn,
            Power::OffWanted,
            Power::OffSent,
        ] {
            for motion in MOTIONS {
                for goal in GOALS {
                    for latch in [Latch::None, Latch::Own, Latch::Group] {
                        for work in [Work::None, Work::Read, Work::Write, Work::Repair] {
                            for brake in [Brake::Absent, Brake::Unclear, Brake::Open, Brake::Closed]
                            {
                                all.push(Facts {
                                    knowledge,
                                    power,
                                    motion,
                                    goal,
                                    latch,
                                    work,
                                    brake,
                                });
                            }
                        }
                    }
                }
            }
        }
    }
    all
}
