//! Mistakes in what readings, frames and time change.

use can_motion::facts::{
    Brake, Class, Facts, Goal, Input, Knowledge, Latch, Motion, Power, transition,
};

use super::{Change, settled, then};

const SWITCH_ON: Class = Class::SwitchOn;
const SWITCH_OFF: Class = Class::SwitchOff;

fn with_power(facts: Facts, power: Power) -> Facts {
    Facts { power, ..facts }
}

fn with_knowledge(facts: Facts, knowledge: Knowledge) -> Facts {
    Facts { knowledge, ..facts }
}

fn with_brake(facts: Facts, brake: Brake) -> Facts {
    Facts { brake, ..facts }
}

/// A report about the power that is taken for another one.
fn says(f: Facts, i: Input, one: Input, before: Power, after: Power) -> Facts {
    then(f, i, i == one && f.power == before, |n| {
        with_power(n, after)
    })
}

/// The input is not seen.
fn unseen(f: Facts, i: Input, is_meant: bool) -> Facts {
    then(f, i, is_meant, |_| f)
}

pub(super) const ALL: &[Change] = &[
    ("Checked: a rung too far", |f, i| {
        then(f, i, i == Input::Checked, |n| {
            with_knowledge(n, Knowledge::Standing)
        })
    }),
    ("Stands: without checks", |f, i| {
        then(f, i, i == Input::Stands, |n| {
            with_knowledge(n, n.knowledge.max(Knowledge::Standing))
        })
    }),
    ("Stands: counts while the power changes", |f, i| {
        let is_meant = i == Input::Stands && f.knowledge == Knowledge::Checked;
        then(f, i, is_meant, |n| with_knowledge(n, Knowledge::Standing))
    }),
    ("Anchored: without standstill", |f, i| {
        let is_meant = i == Input::Anchored && f.knowledge == Knowledge::Checked;
        then(f, i, is_meant, |n| with_knowledge(n, Knowledge::Anchored))
    }),
    ("Anchored: counts when nobody asked for it", |f, i| {
        let is_meant = i == Input::Anchored && f.knowledge == Knowledge::Standing;
        then(f, i, is_meant, |n| with_knowledge(n, Knowledge::Anchored))
    }),
    ("Turns: not seen", |f, i| unseen(f, i, i == Input::Turns)),
    ("Turns: taken for a lost anchor in motion", |f, i| {
        then(f, i, i == Input::Turns, |n| {
            with_knowledge(n, n.knowledge.min(Knowledge::Checked))
        })
    }),
    ("Restarted: the checks stay valid", |f, i| {
        then(f, i, i == Input::Restarted, |n| {
            with_knowledge(n, f.knowledge)
        })
    }),
    ("Restarted: the power stays known", |f, i| {
        then(f, i, i == Input::Restarted, |n| with_power(n, f.power))
    }),
    ("Restarted: the brake stays known", |f, i| {
        then(f, i, i == Input::Restarted, |n| with_brake(n, f.brake))
    }),
    ("SaysOn: a repeated report is a find", |f, i| {
        says(f, i, Input::SaysOn, Power::On, Power::FoundOn)
    }),
    ("SaysOn: a disable is given up", |f, i| {
        says(f, i, Input::SaysOn, Power::OffSent, Power::FoundOn)
    }),
    ("SaysOn: a disable that is due is given up", |f, i| {
        says(f, i, Input::SaysOn, Power::OffWanted, Power::FoundOn)
    }),
    ("SaysOn: a drive found on is taken over", |f, i| {
        let is_meant = i == Input::SaysOn && f.power == Power::Unclear && f.goal == Goal::Off;
        then(f, i, is_meant, |n| Facts {
            power: Power::On,
            goal: Goal::Hold,
            ..n
        })
    }),
    ("SaysOn: a drive found on is switched off", |f, i| {
        let is_meant = i == Input::SaysOn && f.power == Power::Off && f.goal == Goal::Off;
        then(f, i, is_meant, |n| with_power(n, Power::OffWanted))
    }),
    ("SaysOn: an enable is not confirmed", |f, i| {
        unseen(f, i, i == Input::SaysOn && f.power == Power::OnSent)
    }),
    ("SaysOn: what held is a find after an outage", |f, i| {
        let is_meant = i == Input::SaysOn && f.goal != Goal::Off && f.power == Power::OnUnconfirmed;
        then(f, i, is_meant, |n| with_power(n, Power::FoundOn))
    }),
    ("SaysOn: on without having been told is welcome", |f, i| {
        let is_meant = i == Input::SaysOn && f.goal == Goal::Stream && f.power == Power::Off;
        then(f, i, is_meant, |_| with_power(f, Power::On))
    }),
    ("SaysOn: the wish outlives on without command", |f, i| {
        let is_meant = i == Input::SaysOn && f.goal == Goal::Stream && f.power == Power::Off;
        then(f, i, is_meant, |n| Facts {
            goal: Goal::Stream,
            ..n
        })
    }),
    ("SaysOff: an early report ends an enable", |f, i| {
        says(f, i, Input::SaysOff, Power::OnSent, Power::Off)
    }),
    (
        "SaysOff: a report before the enable takes it back",
        |f, i| says(f, i, Input::SaysOff, Power::OnWanted, Power::Off),
    ),
    ("SaysOff: confirms a disable that was not sent", |f, i| {
        says(f, i, Input::SaysOff, Power::OffWanted, Power::Off)
    }),
    (
        "SaysOff: off without having been told is no fault",
        |f, i| {
            then(f, i, i == Input::SaysOff && f.power == Power::On, |_| {
                Facts {
                    power: Power::Off,
                    goal: Goal::Off,
                    motion: Motion::Rest,
                    ..f
                }
            })
        },
    ),
    ("SaysOff: comes on again by itself", |f, i| {
        let is_meant = i == Input::SaysOff && f.power == Power::On && f.goal != Goal::Off;
        then(f, i, is_meant, |n| Facts {
            goal: Goal::Hold,
            ..n
        })
    }),
    (
        "SaysOff: what was to hold after an outage comes on",
        |f, i| {
            let is_meant = i == Input::SaysOff && f.power == Power::OnUnconfirmed;
            then(f, i, is_meant, |n| Facts { goal: f.goal, ..n })
        },
    ),
    ("SaysOff: not seen while unclear", |f, i| {
        unseen(f, i, i == Input::SaysOff && f.power == Power::Unclear)
    }),
    ("SaysOff: a disable is never confirmed", |f, i| {
        unseen(f, i, i == Input::SaysOff && f.power == Power::OffSent)
    }),
    ("BrakeOpened: not seen", |f, i| {
        unseen(f, i, i == Input::BrakeOpened)
    }),
    ("BrakeOpened: a brake from nowhere", |f, i| {
        then(f, i, i == Input::BrakeOpened, |n| {
            with_brake(n, Brake::Open)
        })
    }),
    ("BrakeClosed: not seen", |f, i| {
        unseen(f, i, i == Input::BrakeClosed)
    }),
    ("BrakeClosed: a brake from nowhere", |f, i| {
        then(f, i, i == Input::BrakeClosed, |n| {
            with_brake(n, Brake::Closed)
        })
    }),
    ("BrakeClosed: in motion it is no fault", |f, i| {
        let is_meant = i == Input::BrakeClosed && f.motion != Motion::Rest;
        then(f, i, is_meant, |_| with_brake(f, Brake::Closed))
    }),
    ("Accepted: an enable is not noted", |f, i| {
        unseen(f, i, i == Input::Accepted(SWITCH_ON))
    }),
    ("Accepted: a disable is not noted", |f, i| {
        unseen(f, i, i == Input::Accepted(SWITCH_OFF))
    }),
    ("Accepted: a disable counts as done", |f, i| {
        let is_meant = i == Input::Accepted(SWITCH_OFF) && f.power == Power::OffWanted;
        then(f, i, is_meant, |n| with_power(n, Power::Off))
    }),
    ("Accepted: any frame counts as the enable", |f, i| {
        if matches!(i, Input::Accepted(_)) && f.power == Power::OnWanted {
            return transition(f, Input::Accepted(SWITCH_ON));
        }
        transition(f, i)
    }),
    ("Accepted: opening the brake counts as done", |f, i| {
        let is_meant = i == Input::Accepted(Class::BrakeOpen);
        then(f, i, is_meant, |n| with_brake(n, Brake::Open))
    }),
    ("Accepted: closing the brake counts as done", |f, i| {
        let is_meant = i == Input::Accepted(Class::BrakeClose);
        then(f, i, is_meant, |n| with_brake(n, Brake::Closed))
    }),
    ("Accepted: a frame makes a brake", |f, i| {
        then(f, i, i == Input::Accepted(Class::Poll), |n| {
            with_brake(n, Brake::Unclear)
        })
    }),
    ("Displaced: an enable is taken for sent", |f, i| {
        unseen(f, i, i == Input::Displaced(SWITCH_ON))
    }),
    ("Displaced: a disable is taken for sent", |f, i| {
        unseen(f, i, i == Input::Displaced(SWITCH_OFF))
    }),
    (
        "Displaced: an enable that is not wanted any more",
        |f, i| {
            let is_meant = i == Input::Displaced(SWITCH_ON) && f.power == Power::OffSent;
            then(f, i, is_meant, |n| with_power(n, Power::OnWanted))
        },
    ),
    ("ConfirmTimeout: an enable waits for ever", |f, i| {
        unseen(f, i, i == Input::ConfirmTimeout && f.power == Power::OnSent)
    }),
    ("ConfirmTimeout: a disable waits for ever", |f, i| {
        unseen(
            f,
            i,
            i == Input::ConfirmTimeout && f.power == Power::OffSent,
        )
    }),
    ("ConfirmTimeout: a disable counts as done", |f, i| {
        let is_meant = i == Input::ConfirmTimeout && f.power == Power::OffSent;
        then(f, i, is_meant, |n| with_power(n, Power::Off))
    }),
    ("ConfirmTimeout: anything times out", |f, i| {
        let is_meant = i == Input::ConfirmTimeout && f.power == Power::On;
        then(f, i, is_meant, |n| Facts {
            latch: Latch::Own,
            motion: Motion::Rest,
            ..n
        })
    }),
    ("RampDone: not seen", |f, i| {
        unseen(f, i, i == Input::RampDone)
    }),
    ("RampDone: ends streaming", |f, i| {
        then(f, i, i == Input::RampDone, |n| {
            settled(Facts {
                motion: Motion::Rest,
                ..n
            })
        })
    }),
    ("settle: on without an anchor", |f, i| {
        then(f, i, f.knowledge < Knowledge::Anchored, |n| {
            if n.goal == Goal::Stream && n.power == Power::Off {
                with_power(n, Power::OnWanted)
            } else {
                n
            }
        })
    }),
    ("settle: never comes on", |f, i| {
        then(f, i, f.power == Power::Off, |n| with_power(n, Power::Off))
    }),
    ("settle: an enable outlives the wish", |f, i| {
        then(f, i, f.power == Power::OnWanted, |n| {
            if n.goal == Goal::Off && n.power == Power::Off {
                with_power(n, Power::OnWanted)
            } else {
                n
            }
        })
    }),
    ("settle: an enable waits without an anchor", |f, i| {
        then(f, i, f.power == Power::OnWanted && i == Input::Turns, |n| {
            with_power(n, Power::OnWanted)
        })
    }),
    ("settle: what came on stays on without a wish", |f, i| {
        then(f, i, f.power == Power::OnSent, |n| {
            if n.goal == Goal::Off && n.power == Power::OffWanted {
                with_power(n, Power::OnSent)
            } else {
                n
            }
        })
    }),
    ("settle: what is on stays on after its ramp", |f, i| {
        then(f, i, f.power == Power::On && i == Input::RampDone, |n| {
            with_power(n, Power::On)
        })
    }),
    ("settle: power goes off before the ramp ends", |f, i| {
        then(f, i, i == Input::Disable && f.motion != Motion::Rest, |n| {
            with_power(n, Power::OffWanted)
        })
    }),
];
