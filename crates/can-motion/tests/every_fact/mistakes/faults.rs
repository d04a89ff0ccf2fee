//! Mistakes in what faults take.

use can_motion::facts::{Brake, Facts, Goal, Input, Knowledge, Latch, Loss, Motion, Power, Work};

use super::{Change, settled, then};

fn is_fault(input: Input) -> bool {
    matches!(input, Input::Fault { .. })
}

fn takes(input: Input, one: Loss) -> bool {
    matches!(input, Input::Fault { loss, .. } if loss == one)
}

fn is_of_group(input: Input) -> bool {
    matches!(input, Input::GroupFault { .. })
}

fn ramps(input: Input) -> bool {
    matches!(
        input,
        Input::Fault { ramp: true, .. } | Input::GroupFault { ramp: true }
    )
}

fn is_in_use(facts: &Facts) -> bool {
    facts.goal != Goal::Off || facts.motion != Motion::Rest
}

pub(super) const ALL: &[Change] = &[
    ("fault: not latched", |f, i| {
        then(f, i, is_fault(i), |n| Facts {
            latch: f.latch,
            ..n
        })
    }),
    ("fault: latched as one of the group", |f, i| {
        then(f, i, is_fault(i) && f.latch == Latch::None, |n| Facts {
            latch: Latch::Group,
            ..n
        })
    }),
    ("fault: goes on streaming", |f, i| {
        then(f, i, is_fault(i), |n| Facts {
            motion: f.motion,
            ..n
        })
    }),
    ("fault: slows down without an anchor", |f, i| {
        let is_meant = takes(i, Loss::Anchor) && f.motion == Motion::Stream;
        then(f, i, is_meant, |n| Facts {
            motion: Motion::Ramp,
            ..n
        })
    }),
    ("fault: slows down although it must halt", |f, i| {
        let is_meant = takes(i, Loss::Nothing) && f.motion == Motion::Stream;
        then(f, i, is_meant, |n| Facts {
            motion: Motion::Ramp,
            ..n
        })
    }),
    ("fault: halts although it may slow down", |f, i| {
        then(f, i, takes(i, Loss::Nothing), |n| {
            settled(Facts {
                motion: Motion::Rest,
                ..n
            })
        })
    }),
    ("fault: the work goes on", |f, i| {
        then(f, i, is_fault(i), |n| Facts { work: f.work, ..n })
    }),
    ("fault: the wish to stream outlives it", |f, i| {
        then(f, i, is_fault(i), |n| Facts { goal: f.goal, ..n })
    }),
    ("fault: lets go of what holds", |f, i| {
        then(f, i, takes(i, Loss::Nothing), |n| {
            settled(Facts {
                goal: Goal::Off,
                ..n
            })
        })
    }),
    ("fault: Nothing takes the anchor", |f, i| {
        then(f, i, takes(i, Loss::Nothing), |n| Facts {
            knowledge: n.knowledge.min(Knowledge::Checked),
            ..n
        })
    }),
    ("fault: Anchor leaves the anchor", |f, i| {
        then(f, i, takes(i, Loss::Anchor), |n| Facts {
            knowledge: f.knowledge,
            ..n
        })
    }),
    ("fault: Anchor takes the checks", |f, i| {
        then(f, i, takes(i, Loss::Anchor), |n| Facts {
            knowledge: Knowledge::Unknown,
            ..n
        })
    }),
    ("fault: Knowledge leaves the checks", |f, i| {
        then(f, i, takes(i, Loss::Knowledge), |n| Facts {
            knowledge: f.knowledge.min(Knowledge::Checked),
            ..n
        })
    }),
    ("fault: Knowledge takes the power", |f, i| {
        then(f, i, takes(i, Loss::Knowledge), |n| Facts {
            power: Power::Unclear,
            ..n
        })
    }),
    ("fault: Contact leaves the checks", |f, i| {
        then(f, i, takes(i, Loss::Contact), |n| Facts {
            knowledge: f.knowledge,
            ..n
        })
    }),
    ("fault: Contact leaves the power known", |f, i| {
        then(f, i, takes(i, Loss::Contact), |n| Facts {
            power: f.power,
            ..n
        })
    }),
    ("fault: Contact makes a drive found on one's own", |f, i| {
        let is_meant = takes(i, Loss::Contact) && f.power == Power::FoundOn;
        then(f, i, is_meant, |n| Facts {
            power: Power::OnUnconfirmed,
            ..n
        })
    }),
    ("fault: Contact forgets whose drive it is", |f, i| {
        let is_meant = takes(i, Loss::Contact) && f.power == Power::On;
        then(f, i, is_meant, |n| Facts {
            power: Power::Unclear,
            ..n
        })
    }),
    ("fault: Contact leaves the brake known", |f, i| {
        then(f, i, takes(i, Loss::Contact), |n| Facts {
            brake: f.brake,
            ..n
        })
    }),
    ("fault: Contact makes a brake", |f, i| {
        then(f, i, takes(i, Loss::Contact), |n| Facts {
            brake: Brake::Unclear,
            ..n
        })
    }),
    ("fault: Contact lets go of what holds", |f, i| {
        then(f, i, takes(i, Loss::Contact), |n| Facts {
            goal: Goal::Off,
            ..n
        })
    }),
    ("fault: Contact ends a disable under way", |f, i| {
        let is_due = matches!(f.power, Power::OffWanted | Power::OffSent);
        then(f, i, takes(i, Loss::Contact) && is_due, |n| Facts {
            power: Power::Unclear,
            ..n
        })
    }),
    ("fault: Contact forgets an enable under way", |f, i| {
        let is_meant = takes(i, Loss::Contact) && f.power == Power::OnSent;
        then(f, i, is_meant, |n| Facts {
            power: Power::Unclear,
            ..n
        })
    }),
    ("fault: Contact forgets a disable after a ramp", |f, i| {
        let is_meant = takes(i, Loss::Contact) && f.motion == Motion::Ramp;
        then(f, i, is_meant, |n| Facts {
            power: Power::Unclear,
            ..n
        })
    }),
    ("fault: Drive leaves the power known", |f, i| {
        let is_meant = takes(i, Loss::Drive) && f.power == Power::On;
        then(f, i, is_meant, |n| Facts {
            power: f.power,
            ..n
        })
    }),
    ("fault: Drive leaves the wish to hold", |f, i| {
        let is_meant = takes(i, Loss::Drive) && f.power == Power::On && f.goal != Goal::Off;
        then(f, i, is_meant, |n| Facts {
            goal: Goal::Hold,
            ..n
        })
    }),
    ("fault: Drive lets the load fall", |f, i| {
        let is_meant = takes(i, Loss::Drive) && f.power == Power::On && f.goal != Goal::Off;
        then(f, i, is_meant, |n| Facts {
            power: Power::Unclear,
            ..n
        })
    }),
    ("fault: Drive switches what was found on", |f, i| {
        let is_meant = takes(i, Loss::Drive) && f.power == Power::FoundOn;
        then(f, i, is_meant, |n| Facts {
            power: Power::OffWanted,
            ..n
        })
    }),
    ("fault of the group: stops a bystander", |f, i| {
        then(f, i, is_of_group(i) && !is_in_use(&f), |n| Facts {
            latch: Latch::Group,
            ..n
        })
    }),
    ("fault of the group: not latched", |f, i| {
        then(f, i, is_of_group(i), |n| Facts {
            latch: f.latch,
            ..n
        })
    }),
    ("fault of the group: covers one of its own", |f, i| {
        then(f, i, is_of_group(i) && is_in_use(&f), |n| Facts {
            latch: Latch::Group,
            ..n
        })
    }),
    ("fault of the group: goes on streaming", |f, i| {
        then(f, i, is_of_group(i), |n| Facts {
            motion: f.motion,
            ..n
        })
    }),
    (
        "fault of the group: halts although it may slow down",
        |f, i| {
            then(f, i, is_of_group(i) && ramps(i), |n| {
                settled(Facts {
                    motion: Motion::Rest,
                    ..n
                })
            })
        },
    ),
    (
        "fault of the group: slows down although it must halt",
        |f, i| {
            let is_meant = is_of_group(i) && f.motion == Motion::Stream;
            then(f, i, is_meant, |n| Facts {
                motion: Motion::Ramp,
                ..n
            })
        },
    ),
    (
        "fault of the group: the wish to stream outlives it",
        |f, i| then(f, i, is_of_group(i), |n| Facts { goal: f.goal, ..n }),
    ),
    ("fault of the group: lets go of what holds", |f, i| {
        then(f, i, is_of_group(i), |n| {
            settled(Facts {
                goal: Goal::Off,
                ..n
            })
        })
    }),
    ("fault of the group: ends the work of another", |f, i| {
        then(f, i, is_of_group(i), |n| Facts {
            work: Work::None,
            ..n
        })
    }),
];
