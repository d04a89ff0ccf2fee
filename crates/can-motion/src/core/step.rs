//! The life of an axis as one pure function: no time, no protocol, no bus.
//!
//! Time comes in as [`Input::ConfirmTimeout`], readings as what they mean, the bus as what happened to a frame. Nothing else writes a
//! fact. `tests/every_fact.rs` walks every combination that one axis and a group of two can reach and checks every promise on each step.

use super::drive_move::MoveEnd;
use super::exit::{Class, may_leave};
use super::facts::{Brake, Facts, Goal, Knowledge, Latch, Motion, Power, Work};

/// What a fault of its own takes from an axis, beyond its motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Loss {
    /// Nothing; it can still slow down on its path.
    Nothing,
    /// Its standstill and anchor.
    Anchor,
    /// Everything that was known of the drive, except its power.
    Knowledge,
    /// Everything that was known of the drive.
    Contact,
    /// Everything, and the drive itself let go of its motor or started anew: nothing of what it was told holds.
    Drive,
}

/// Everything that can happen to an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Input {
    // The application, through the group.
    /// Power where there is none, then set-points.
    Enable,
    /// Takes over a drive that was found on, without switching it.
    Adopt,
    /// Set-points again.
    Resume,
    /// As `Resume`, for a drive that must be switched off and on first.
    Rearm,
    /// Slows down, then holds.
    Stop,
    /// Ends every set-point at once, then holds.
    Halt,
    /// Slows down, then no power.
    Disable,
    /// Forgets a fault.
    Clear,
    /// The drive makes a motion by itself.
    Move,
    /// The same, started by a trigger together with other drives.
    SyncMove,
    /// Starts a procedure.
    StartWork(Work),

    // What readings mean. One counts only when it was asked for after what it confirms had been transmitted.
    /// The drive is what it should be.
    Checked,
    /// The shaft has stood still long enough.
    Stands,
    /// The shaft turns.
    Turns,
    /// Its position became the anchor.
    Anchored,
    /// The drive reports power.
    SaysOn,
    /// The drive reports no power.
    SaysOff,
    /// The drive confirmed that the brake is open.
    BrakeOpened,
    /// The drive confirmed that the brake is closed.
    BrakeClosed,
    /// The motion that the drive made by itself ended.
    MoveEnded(MoveEnd),
    /// The procedure ended.
    WorkEnded,
    /// The drive was told to start anew: what it was told before does not hold.
    Restarted,

    // The bus.
    /// The controller accepted a frame.
    Accepted(Class),
    /// The controller gave a frame back unsent.
    Displaced(Class),

    // Time.
    /// The drive did not confirm a switch in time.
    ConfirmTimeout,
    /// The ramp reached standstill.
    RampDone,

    // Faults and the group.
    /// A fault of this axis.
    Fault {
        /// What it takes.
        loss: Loss,
        /// It may slow down on its path.
        ramp: bool,
    },
    /// A fault of another axis of the group.
    GroupFault {
        /// The group slows down; otherwise it ends every set-point at once.
        ramp: bool,
    },
    /// Every axis of the group is ready to stream.
    Start,
    /// Every drive that is to start by the trigger has answered since its move was loaded.
    Arm,
}

/// Whether the input may happen now. Commands that stop, readings and faults always may.
#[must_use]
pub fn accepts(facts: &Facts, input: Input) -> bool {
    let is_idle = !facts.work.needs_off() && !facts.moves();
    let is_fine = is_idle && facts.latch == Latch::None && facts.motion == Motion::Rest;
    let is_off = facts.goal == Goal::Off && facts.power == Power::Off;
    let is_held = facts.goal == Goal::Hold && facts.power == Power::On;
    let is_checked = facts.knowledge >= Knowledge::Checked;
    let is_anchored = facts.knowledge == Knowledge::Anchored;
    match input {
        Input::Enable => is_fine && is_checked && (is_off || is_held),
        Input::Adopt => {
            is_fine && is_checked && facts.goal == Goal::Off && facts.power == Power::FoundOn
        }
        Input::Resume => is_fine && is_held && is_anchored,
        Input::Move | Input::SyncMove => {
            is_fine
                && is_held
                && is_anchored
                && facts.work == Work::None
                && matches!(facts.brake, Brake::Absent | Brake::Open)
        }
        // Switching off lets go of a load, so one that can fall is not switched in passing.
        Input::Rearm => is_fine && is_held && is_checked && facts.brake == Brake::Absent,
        Input::Start => {
            is_fine
                && is_anchored
                && facts.goal == Goal::Stream
                && facts.power == Power::On
                && matches!(facts.brake, Brake::Absent | Brake::Open)
        }
        Input::StartWork(Work::Read) => facts.work == Work::None,
        Input::StartWork(Work::Write) => {
            is_fine && is_checked && is_off && facts.work == Work::None
        }
        Input::StartWork(Work::Repair) => is_idle && is_off && facts.work == Work::None,
        Input::Arm => {
            facts.motion == Motion::Loaded
                && facts.goal == Goal::SyncMove
                && facts.latch == Latch::None
        }
        Input::StartWork(Work::None) => false,
        // Whether a drive still holds its load must be known before anything is decided about it.
        Input::Clear => is_idle && (facts.goal == Goal::Off || !facts.power.is_unclear()),
        _ => true,
    }
}

/// What is true after the input. One that is not accepted changes nothing.
#[must_use]
pub fn step(facts: Facts, input: Input) -> Facts {
    if accepts(&facts, input) {
        transition(facts, input)
    } else {
        facts
    }
}

/// What an input makes of the facts, whether it is accepted or not.
#[must_use]
pub fn transition(facts: Facts, input: Input) -> Facts {
    let mut next = facts;
    match input {
        Input::Enable
        | Input::Adopt
        | Input::Resume
        | Input::Rearm
        | Input::Stop
        | Input::Halt
        | Input::Disable
        | Input::Clear => command(&mut next, input),
        Input::Move => next.goal = Goal::Move,
        Input::SyncMove => next.goal = Goal::SyncMove,
        Input::Arm => next.motion = Motion::Armed,
        Input::MoveEnded(end) if next.motion == Motion::DriveMove => move_ended(&mut next, end),
        Input::StartWork(work) => next.work = work,
        Input::WorkEnded => {
            // What was written may have changed what was checked.
            if next.work == Work::Write {
                lose(&mut next, Knowledge::Unknown);
            }
            next.work = Work::None;
        }
        Input::Restarted => {
            lose(&mut next, Knowledge::Unknown);
            lose_power(&mut next);
        }
        Input::Checked | Input::Stands | Input::Turns | Input::Anchored => learn(&mut next, input),
        Input::SaysOn => says_on(&mut next),
        Input::SaysOff => says_off(&mut next),
        Input::BrakeOpened if next.brake != Brake::Absent => next.brake = Brake::Open,
        Input::BrakeClosed if next.brake != Brake::Absent => {
            next.brake = Brake::Closed;
            if next.moves() || next.goal.is_move() {
                // Nobody asked for it: without its set-points the motion must not go on when the brake opens.
                fail(&mut next, Loss::Anchor, false);
            }
        }
        Input::Accepted(class) => accepted(&mut next, class),
        Input::Displaced(class) => displaced(&mut next, class),
        Input::ConfirmTimeout => match next.power {
            Power::OnSent => fail(&mut next, Loss::Anchor, false),
            // It is told again until it confirms.
            Power::OffSent => next.power = Power::OffWanted,
            _ => {}
        },
        Input::RampDone if next.motion == Motion::Ramp => next.motion = Motion::Rest,
        Input::Fault { loss, ramp } => fail(&mut next, loss, ramp),
        Input::GroupFault { ramp } => group_fault(&mut next, ramp),
        Input::Start => next.motion = Motion::Stream,
        _ => {}
    }
    settle(&mut next);
    next
}

fn command(facts: &mut Facts, input: Input) {
    match input {
        Input::Enable => {
            facts.goal = Goal::Stream;
            if facts.power == Power::Off {
                // What the drive is and how it is configured, that its shaft stands and where, is read after the word was given.
                lose(facts, Knowledge::Unknown);
            }
        }
        Input::Adopt => {
            facts.goal = Goal::Hold;
            facts.power = Power::On;
            lose(facts, Knowledge::Unknown);
        }
        Input::Resume => facts.goal = Goal::Stream,
        Input::Rearm => {
            facts.goal = Goal::Stream;
            facts.power = Power::OffWanted;
            lose(facts, Knowledge::Checked);
        }
        Input::Stop => {
            slow_down(facts);
            hold_or_off(facts);
        }
        Input::Halt => {
            end_set_points(facts);
            hold_or_off(facts);
        }
        Input::Disable => {
            slow_down(facts);
            facts.goal = Goal::Off;
            // Said at once and without a reading first, whatever is known; once, until it is time to repeat it.
            let is_said = facts.power == Power::OffSent;
            // A drive that moves by itself is stopped before its power goes, but not where a fault asks for that.
            let is_under_way = facts.sends_set_points()
                || (facts.motion == Motion::DriveMove && facts.latch == Latch::None);
            if !is_under_way && facts.power.may_be_on() && !is_said {
                facts.power = Power::OffWanted;
            }
        }
        Input::Clear => {
            if facts.latch == Latch::Own {
                lose(facts, Knowledge::Unknown);
                // A reading: the checks may have to repair something.
                facts.work = Work::None;
            }
            facts.latch = Latch::None;
        }
        _ => {}
    }
}

fn learn(facts: &mut Facts, input: Input) {
    facts.knowledge = match (input, facts.knowledge) {
        (Input::Checked, Knowledge::Unknown) => Knowledge::Checked,
        // Not while the power changes: the shaft may move as the drive lets go or takes hold.
        (Input::Stands, Knowledge::Checked) if facts.awaits_standstill() => Knowledge::Standing,
        (Input::Anchored, Knowledge::Standing) if facts.awaits_anchor() => Knowledge::Anchored,
        (Input::Turns, known) if !facts.moves() => known.min(Knowledge::Checked),
        (_, known) => known,
    };
}

fn accepted(facts: &mut Facts, class: Class) {
    facts.power = match (class, facts.power) {
        (Class::SwitchOn, Power::OnWanted) => Power::OnSent,
        (Class::SwitchOff, Power::OffWanted) => Power::OffSent,
        (_, power) => power,
    };
    facts.motion = match (class, facts.motion, facts.goal) {
        (Class::DriveMove, Motion::Rest, Goal::Move)
        | (Class::Trigger, Motion::Armed, Goal::SyncMove) => Motion::DriveMove,
        (Class::Load, Motion::Rest, Goal::SyncMove) => Motion::Loaded,
        (_, motion, _) => motion,
    };
    // A command for the brake counts when the drive confirms it; until then the brake may be anywhere.
    if matches!(class, Class::BrakeOpen | Class::BrakeClose) && facts.brake != Brake::Absent {
        facts.brake = Brake::Unclear;
    }
}

/// The frame never reached the drive. What is not wanted any more is not wanted again.
fn displaced(facts: &mut Facts, class: Class) {
    facts.power = match (class, facts.power) {
        (Class::SwitchOn, Power::OnSent) => Power::OnWanted,
        (Class::SwitchOff, Power::OffSent) => Power::OffWanted,
        (_, power) => power,
    };
    facts.motion = match (class, facts.motion, facts.goal) {
        (Class::DriveMove, Motion::DriveMove, goal) if goal != Goal::SyncMove => Motion::Rest,
        (Class::Load, Motion::Loaded | Motion::Armed, _) => Motion::Rest,
        (Class::Trigger, Motion::DriveMove, Goal::SyncMove) => Motion::Armed,
        (Class::Trigger, Motion::DriveMove, Goal::Off | Goal::Hold) => {
            // The loaded move is not wanted any more, and a command to stop may have moved the drive meanwhile.
            lose(facts, Knowledge::Checked);
            Motion::Loaded
        }
        (_, motion, _) => motion,
    };
}

/// A motion of the drive itself ended, by itself or because it was told to stop.
fn move_ended(facts: &mut Facts, end: MoveEnd) {
    facts.motion = Motion::Rest;
    if facts.goal.is_move() {
        facts.goal = Goal::Hold;
    }
    match end {
        MoveEnd::Arrived => {}
        MoveEnd::Elsewhere => lose(facts, Knowledge::Checked),
        MoveEnd::OtherMode => {
            facts.goal = Goal::Off;
            lose(facts, Knowledge::Unknown);
        }
    }
}

/// Power follows the goal, whichever way the goal came about.
fn settle(facts: &mut Facts) {
    if facts.goal.is_move() && facts.knowledge != Knowledge::Anchored {
        // Where the motion would begin is not known any more.
        facts.goal = Goal::Hold;
    }
    let may_come_on = facts.latch == Latch::None
        && !facts.work.needs_off()
        && facts.knowledge == Knowledge::Anchored;
    facts.power = match (facts.goal, facts.power) {
        (Goal::Hold | Goal::Stream, Power::Off) if may_come_on => Power::OnWanted,
        // The command did not go out. Without its anchor the axis waits for a new one.
        (Goal::Off, Power::OnWanted) => Power::Off,
        (_, Power::OnWanted) if !may_come_on => Power::Off,
        (Goal::Off, Power::On | Power::OnSent) if !facts.moves() => Power::OffWanted,
        (_, power) => power,
    };
    // A drive without power makes no move, and starts none by a trigger.
    if facts.power == Power::Off && !facts.sends_set_points() {
        if facts.motion == Motion::DriveMove {
            // Somewhere on its way.
            lose(facts, Knowledge::Checked);
        }
        facts.motion = Motion::Rest;
    }
}

fn lose(facts: &mut Facts, to: Knowledge) {
    facts.knowledge = facts.knowledge.min(to);
}

/// Nothing that the drive was told holds; a drive that is to be off is told again.
fn lose_power(facts: &mut Facts) {
    facts.power = match facts.power {
        Power::OffWanted | Power::OffSent => Power::OffWanted,
        Power::OnSent | Power::On | Power::OnUnconfirmed => Power::OnUnconfirmed,
        Power::Unclear | Power::Off | Power::OnWanted | Power::FoundOn => Power::Unclear,
    };
    if facts.brake != Brake::Absent {
        facts.brake = Brake::Unclear;
    }
}

fn slow_down(facts: &mut Facts) {
    if facts.motion == Motion::Stream {
        facts.motion = Motion::Ramp;
    }
}

/// What the drive does by itself goes on until it obeys the command to stop.
fn end_set_points(facts: &mut Facts) {
    if facts.sends_set_points() {
        facts.motion = Motion::Rest;
    }
}

/// An axis that is on holds; one on its way there goes off.
fn hold_or_off(facts: &mut Facts) {
    let holds = facts.goal != Goal::Off && matches!(facts.power, Power::On | Power::OnUnconfirmed);
    facts.goal = if holds { Goal::Hold } else { Goal::Off };
}

fn fail(facts: &mut Facts, loss: Loss, ramp: bool) {
    facts.latch = Latch::Own;
    if ramp && loss == Loss::Nothing {
        slow_down(facts);
    } else {
        end_set_points(facts);
    }
    if loss == Loss::Drive && facts.motion == Motion::DriveMove {
        // Free, or started anew: it moves no more.
        facts.motion = Motion::Rest;
    }
    facts.work = Work::None;
    hold_or_off(facts);
    // What was to be off when the fault came stays so, whatever is lost with it.
    settle(facts);
    match loss {
        Loss::Nothing => {}
        Loss::Anchor => lose(facts, Knowledge::Checked),
        Loss::Knowledge => lose(facts, Knowledge::Unknown),
        Loss::Contact | Loss::Drive => {
            lose(facts, Knowledge::Unknown);
            if facts.goal == Goal::Off && facts.power == Power::On {
                // The command that waited for the end of its motion does not wait any longer.
                facts.power = Power::OffWanted;
            }
            lose_power(facts);
        }
    }
    if loss == Loss::Drive {
        if facts.brake != Brake::Absent && facts.goal != Goal::Off {
            // The load hung on this drive: its brake closes at once, before any reading.
            facts.power = Power::OffWanted;
        }
        facts.goal = Goal::Off;
    }
}

fn group_fault(facts: &mut Facts, ramp: bool) {
    if !facts.is_in_use() {
        return;
    }
    if facts.latch == Latch::None {
        facts.latch = Latch::Group;
    }
    if ramp {
        slow_down(facts);
    } else {
        end_set_points(facts);
    }
    hold_or_off(facts);
}

fn says_on(facts: &mut Facts) {
    facts.power = match (facts.goal, facts.power) {
        (_, Power::On) => Power::On,
        // It did not take the disable command.
        (_, Power::OffWanted | Power::OffSent) => Power::OffWanted,
        (Goal::Off, _) => Power::FoundOn,
        (_, Power::OnSent | Power::OnUnconfirmed) => Power::On,
        // On without having been told: nothing moves on such a drive.
        (_, _) => {
            fail(facts, Loss::Anchor, false);
            facts.goal = Goal::Off;
            Power::FoundOn
        }
    };
}

fn says_off(facts: &mut Facts) {
    match facts.power {
        // From before the command that is due: an enable command may be under way, so a disable command is sent first.
        Power::OnSent | Power::OnWanted | Power::OffWanted => return,
        Power::On => {
            fail(facts, Loss::Anchor, false);
            facts.goal = Goal::Off;
        }
        power if power.is_unclear() => facts.goal = Goal::Off,
        _ => {}
    }
    facts.power = Power::Off;
}

/// Whether a request of this class has a turn: it may leave, or may once the repair has begun that it is for. One that has to wait
/// must not keep the requests of others waiting.
pub(crate) fn may_be_asked(class: Class, facts: &Facts) -> bool {
    let begins = class == Class::Repair && accepts(facts, Input::StartWork(Work::Repair));
    begins || may_leave(class, facts)
}
