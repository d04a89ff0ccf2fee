//! What faults, timeouts and the end of a ramp promise.

use can_motion::facts::{Brake, Facts, Goal, Input, Knowledge, Latch, Loss, Motion, Power, Work};

use crate::promises::{is_off_due, moves};
use crate::readings::unconfirmed;
use crate::walk::{Held, hold};

pub(crate) fn of_faults(before: Facts, input: Input, after: Facts) -> Held {
    match input {
        Input::Fault { loss, ramp } => of_own_fault(before, (loss, ramp), after),
        Input::GroupFault { ramp } => {
            if before.goal == Goal::Off && !moves(&before) {
                return hold(before == after, "a fault of the group spares a bystander");
            }
            hold(
                after.latch != Latch::None,
                "a fault of one axis reaches its group",
            )?;
            hold(
                before.knowledge == after.knowledge && before.work == after.work,
                "a fault of the group takes nothing from another axis",
            )?;
            ends_motion(before, (ramp, false), after)
        }
        Input::ConfirmTimeout if before.power == Power::OnSent => hold(
            after.latch == Latch::Own && is_off_due(&after) && after.goal == Goal::Off,
            "an enable that is not confirmed is a fault, and taken back",
        ),
        Input::ConfirmTimeout => hold(
            after
                == Facts {
                    power: match before.power {
                        Power::OffSent => Power::OffWanted,
                        other => other,
                    },
                    ..before
                },
            "a disable that is not confirmed is said again, and nothing else times out",
        ),
        Input::RampDone => hold(
            after.motion
                == match before.motion {
                    Motion::Ramp => Motion::Rest,
                    other => other,
                },
            "a ramp that is done ends, and nothing else",
        ),
        _ => Ok(()),
    }
}

fn ends_motion(before: Facts, (ramp, lets_go): (bool, bool), after: Facts) -> Held {
    let expected = match before.motion {
        Motion::Stream | Motion::Ramp if ramp => Motion::Ramp,
        Motion::Stream | Motion::Ramp => Motion::Rest,
        Motion::DriveMove if lets_go => Motion::Rest,
        // It is told to stop, and loaded moves stay loaded.
        other => other,
    };
    hold(
        after.motion == expected,
        "a fault slows down where it may, and else ends every set-point at once",
    )?;
    let is_held = before.power == Power::On && before.goal != Goal::Off;
    hold(
        !is_held || after.goal == Goal::Hold || after.power != Power::On,
        "a fault lets nothing go that holds",
    )
}

fn of_own_fault(before: Facts, (loss, ramp): (Loss, bool), after: Facts) -> Held {
    hold(after.latch == Latch::Own, "a fault is latched")?;
    hold(after.work == Work::None, "a fault ends the work")?;
    let lets_go = loss == Loss::Drive;
    ends_motion(before, (ramp && loss == Loss::Nothing, lets_go), after)?;
    let most = match loss {
        Loss::Nothing => before.knowledge,
        Loss::Anchor => before.knowledge.min(Knowledge::Checked),
        Loss::Knowledge | Loss::Contact | Loss::Drive => Knowledge::Unknown,
    };
    hold(
        after.knowledge == most,
        "a fault takes the knowledge that it says, and no more",
    )?;
    let keeps_power = matches!(loss, Loss::Nothing | Loss::Anchor | Loss::Knowledge);
    let is_off_meant = is_off_due(&before)
        || before.power == Power::OnSent
        || moves(&before)
        || (loss == Loss::Drive && before.brake != Brake::Absent && before.goal != Goal::Off);
    hold(
        keeps_power
            || after.power == unconfirmed(before.power)
            || (is_off_meant && is_off_due(&after)),
        "without contact nothing is known of the power",
    )?;
    let is_held = before.power == Power::On && before.goal != Goal::Off;
    hold(
        !is_held || !keeps_power || after.power == Power::On,
        "a fault lets nothing go that holds",
    )?;
    hold(
        !is_held || loss != Loss::Contact || after.goal == Goal::Hold,
        "what held before contact was lost is still meant to hold",
    )?;
    hold(
        loss != Loss::Drive || after.goal == Goal::Off,
        "a drive that let go or started anew is not meant to hold any more",
    )
}
