//! Mistakes in `may_leave`: a condition left out, or one too many.

use can_motion::facts::{
    Brake, Class, Facts, Goal, Knowledge, Latch, Motion, Power, Work, may_leave,
};

use super::Exit;

/// The class may leave as if the facts were these.
fn as_if(class: Class, facts: &Facts, one: Class, seen: Facts) -> bool {
    may_leave(class, if class == one { &seen } else { facts })
}

fn with_latch(facts: &Facts, latch: Latch) -> Facts {
    Facts { latch, ..*facts }
}

fn with_motion(facts: &Facts, motion: Motion) -> Facts {
    Facts { motion, ..*facts }
}

fn with_power(facts: &Facts, power: Power) -> Facts {
    Facts { power, ..*facts }
}

fn with_goal(facts: &Facts, goal: Goal) -> Facts {
    Facts { goal, ..*facts }
}

fn with_brake(facts: &Facts, brake: Brake) -> Facts {
    Facts { brake, ..*facts }
}

fn with_work(facts: &Facts, work: Work) -> Facts {
    Facts { work, ..*facts }
}

fn anchored(facts: &Facts) -> Facts {
    Facts {
        knowledge: Knowledge::Anchored,
        ..*facts
    }
}

pub(super) const ALL: &[Exit] = &[
    ("may_leave: readings kept back under a fault", |c, f| {
        may_leave(c, f) && (c != Class::Reading || f.latch == Latch::None)
    }),
    ("may_leave: polls kept back at rest", |c, f| {
        may_leave(c, f) && (c != Class::Poll || f.motion != Motion::Rest)
    }),
    ("may_leave: SetPoint at rest", |c, f| {
        as_if(c, f, Class::SetPoint, with_motion(f, Motion::Stream))
    }),
    ("may_leave: SetPoint without power", |c, f| {
        as_if(c, f, Class::SetPoint, with_power(f, Power::On))
    }),
    ("may_leave: SetPoint without an anchor", |c, f| {
        as_if(c, f, Class::SetPoint, anchored(f))
    }),
    ("may_leave: SetPoint against a brake", |c, f| {
        as_if(c, f, Class::SetPoint, with_brake(f, Brake::Open))
    }),
    ("may_leave: SetPoint kept back in a ramp", |c, f| {
        may_leave(c, f) && (c != Class::SetPoint || f.motion != Motion::Ramp)
    }),
    ("may_leave: StopFrame in motion", |c, f| {
        as_if(c, f, Class::StopFrame, with_motion(f, Motion::Rest))
    }),
    ("may_leave: StopFrame to a drive found on", |c, f| {
        c == Class::StopFrame && f.power == Power::FoundOn || may_leave(c, f)
    }),
    ("may_leave: StopFrame to a drive never heard", |c, f| {
        c == Class::StopFrame && f.power == Power::Unclear && f.motion == Motion::Rest
            || may_leave(c, f)
    }),
    ("may_leave: StopFrame kept back after an outage", |c, f| {
        may_leave(c, f) && (c != Class::StopFrame || f.power != Power::OnUnconfirmed)
    }),
    ("may_leave: SwitchOn when it is not due", |c, f| {
        as_if(c, f, Class::SwitchOn, with_power(f, Power::OnWanted))
    }),
    ("may_leave: SwitchOn without an anchor", |c, f| {
        as_if(c, f, Class::SwitchOn, anchored(f))
    }),
    ("may_leave: SwitchOn without a wish", |c, f| {
        as_if(c, f, Class::SwitchOn, with_goal(f, Goal::Stream))
    }),
    ("may_leave: SwitchOn under a fault", |c, f| {
        as_if(c, f, Class::SwitchOn, with_latch(f, Latch::None))
    }),
    ("may_leave: SwitchOn beside a write", |c, f| {
        as_if(c, f, Class::SwitchOn, with_work(f, Work::None))
    }),
    ("may_leave: SwitchOff when nobody asked", |c, f| {
        as_if(c, f, Class::SwitchOff, with_power(f, Power::OffWanted))
    }),
    ("may_leave: SwitchOff before the brake is closed", |c, f| {
        as_if(c, f, Class::SwitchOff, with_brake(f, Brake::Closed))
    }),
    ("may_leave: SwitchOff only without a fault", |c, f| {
        may_leave(c, f) && (c != Class::SwitchOff || f.latch == Latch::None)
    }),
    ("may_leave: Write without its work", |c, f| {
        as_if(c, f, Class::Write, with_work(f, Work::Write))
    }),
    ("may_leave: Write to what may be on", |c, f| {
        as_if(c, f, Class::Write, with_power(f, Power::Off))
    }),
    ("may_leave: Write to what is to come on", |c, f| {
        as_if(c, f, Class::Write, with_goal(f, Goal::Off))
    }),
    ("may_leave: Write under a fault", |c, f| {
        as_if(c, f, Class::Write, with_latch(f, Latch::None))
    }),
    ("may_leave: Repair without its work", |c, f| {
        as_if(c, f, Class::Repair, with_work(f, Work::Repair))
    }),
    ("may_leave: Repair of what may be on", |c, f| {
        as_if(c, f, Class::Repair, with_power(f, Power::Off))
    }),
    ("may_leave: Repair of what is to come on", |c, f| {
        as_if(c, f, Class::Repair, with_goal(f, Goal::Off))
    }),
    ("may_leave: Repair kept back under a fault", |c, f| {
        may_leave(c, f) && (c != Class::Repair || f.latch == Latch::None)
    }),
    ("may_leave: BrakeClose in motion", |c, f| {
        as_if(c, f, Class::BrakeClose, with_motion(f, Motion::Rest))
    }),
    ("may_leave: BrakeClose of what holds", |c, f| {
        as_if(c, f, Class::BrakeClose, with_goal(f, Goal::Off))
    }),
    ("may_leave: BrakeClose of what was found on", |c, f| {
        as_if(c, f, Class::BrakeClose, with_power(f, Power::Off))
    }),
    ("may_leave: BrakeClose without a brake to close", |c, f| {
        as_if(c, f, Class::BrakeClose, with_brake(f, Brake::Open))
    }),
    (
        "may_leave: BrakeClose kept back after power went",
        |c, f| may_leave(c, f) && (c != Class::BrakeClose || f.power != Power::Off),
    ),
    ("may_leave: BrakeOpen of what is to be off", |c, f| {
        as_if(c, f, Class::BrakeOpen, with_goal(f, Goal::Hold))
    }),
    ("may_leave: BrakeOpen under a fault", |c, f| {
        as_if(c, f, Class::BrakeOpen, with_latch(f, Latch::None))
    }),
    ("may_leave: BrakeOpen without power", |c, f| {
        as_if(c, f, Class::BrakeOpen, with_power(f, Power::On))
    }),
    ("may_leave: BrakeOpen without a brake to open", |c, f| {
        as_if(c, f, Class::BrakeOpen, with_brake(f, Brake::Closed))
    }),
];
