//! What a family of another crate builds on: the facts with their one step and one exit, and the ledger of absolute values.

use can_motion::MoveEnd;
use can_motion::facts::{
    Brake, Class, Facts, Goal, Input, Knowledge, Latch, Loss, Motion, Power, Work, accepts,
    may_leave, step, transition,
};
use can_motion::family::{AbsoluteLedger, ValueKind, ValueLimits};

use crate::opaque::{self, consume, flag, number, pick, word};

/// Any facts and any inputs, also such that no axis reaches, then any values.
pub fn exercise() {
    let facts = facts();
    let input = input();
    consume((accepts(&facts, input), step(facts, input)));
    consume(transition(facts, input));
    consume(may_leave(pick(Class::ALL), &facts));
    consume(Class::of_cycle(&facts));
    values();
}

fn facts() -> Facts {
    Facts {
        knowledge: pick([
            Knowledge::Unknown,
            Knowledge::Checked,
            Knowledge::Standing,
            Knowledge::Anchored,
        ]),
        power: pick([
            Power::Unclear,
            Power::OnUnconfirmed,
            Power::Off,
            Power::OnWanted,
            Power::OnSent,
            Power::On,
            Power::FoundOn,
            Power::OffWanted,
            Power::OffSent,
        ]),
        motion: pick([
            Motion::Rest,
            Motion::Ramp,
            Motion::Stream,
            Motion::Loaded,
            Motion::Armed,
            Motion::DriveMove,
        ]),
        goal: pick([
            Goal::Off,
            Goal::Hold,
            Goal::Stream,
            Goal::Move,
            Goal::SyncMove,
        ]),
        latch: pick([Latch::None, Latch::Own, Latch::Group]),
        work: work(),
        brake: pick([Brake::Absent, Brake::Unclear, Brake::Open, Brake::Closed]),
    }
}

fn work() -> Work {
    pick([Work::None, Work::Read, Work::Write, Work::Repair])
}

fn input() -> Input {
    let fault = Input::Fault {
        loss: pick([
            Loss::Nothing,
            Loss::Anchor,
            Loss::Knowledge,
            Loss::Contact,
            Loss::Drive,
        ]),
        ramp: flag(),
    };
    let commands = pick([
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
        Input::StartWork(work()),
        fault,
        Input::GroupFault { ramp: flag() },
        Input::Start,
        Input::Arm,
    ]);
    let end = pick([MoveEnd::Arrived, MoveEnd::Elsewhere, MoveEnd::OtherMode]);
    let readings = pick([
        Input::Checked,
        Input::Stands,
        Input::Turns,
        Input::Anchored,
        Input::SaysOn,
        Input::SaysOff,
        Input::BrakeOpened,
        Input::BrakeClosed,
        Input::MoveEnded(end),
        Input::WorkEnded,
        Input::Restarted,
        Input::Accepted(pick(Class::ALL)),
        Input::Displaced(pick(Class::ALL)),
        Input::ConfirmTimeout,
        Input::RampDone,
    ]);
    pick([commands, readings])
}

fn values() {
    let limits = ValueLimits {
        min: number(),
        max: number(),
        max_step: word(),
        max_step_change: word(),
    };
    let mut ledger = AbsoluteLedger::new(pick([ValueKind::Position, ValueKind::Speed]));
    while flag() {
        match opaque::byte() {
            0 => ledger.anchor(number()),
            1 => ledger.end_motion(),
            2 => consume(ledger.accept_target(number(), &limits)),
            3 => consume(ledger.offer(&limits)),
            4 => ledger.accepted(),
            5 => ledger.returned(number()),
            6 => ledger.begin_ramp(word()),
            7 => ledger.begin_cycle(),
            8 => consume(ledger.cycles_to_stop(&limits)),
            9 => consume(ledger.can_stop_in(word(), &limits)),
            _ => consume((ledger.target(), ledger.sent(), ledger.has_stopped())),
        }
    }
}
