//! Mistakes in what commands and work change.

use can_motion::facts::{Facts, Goal, Input, Knowledge, Latch, Motion, Power, Work};

use super::{Change, settled, then};

pub(super) const ALL: &[Change] = &[
    ("Enable: the old standstill and anchor count", |f, i| {
        then(f, i, i == Input::Enable && f.power == Power::Off, |n| {
            settled(Facts {
                knowledge: f.knowledge,
                ..n
            })
        })
    }),
    ("Enable: what holds loses its anchor", |f, i| {
        then(f, i, i == Input::Enable, |n| Facts {
            knowledge: n.knowledge.min(Knowledge::Checked),
            ..n
        })
    }),
    ("Enable: only holds", |f, i| {
        then(f, i, i == Input::Enable, |n| Facts {
            goal: Goal::Hold,
            ..n
        })
    }),
    ("Adopt: streams", |f, i| {
        then(f, i, i == Input::Adopt, |n| Facts {
            goal: Goal::Stream,
            ..n
        })
    }),
    ("Adopt: stays found on", |f, i| {
        then(f, i, i == Input::Adopt, |n| Facts {
            power: Power::FoundOn,
            ..n
        })
    }),
    ("Adopt: sends a command", |f, i| {
        then(f, i, i == Input::Adopt, |n| Facts {
            power: Power::OnWanted,
            ..n
        })
    }),
    ("Adopt: takes an old anchor", |f, i| {
        then(f, i, i == Input::Adopt, |n| Facts {
            knowledge: Knowledge::Anchored,
            ..n
        })
    }),
    ("Resume: does nothing", |f, i| {
        then(f, i, i == Input::Resume, |_| f)
    }),
    ("Rearm: does not switch off", |f, i| {
        then(f, i, i == Input::Rearm, |n| Facts {
            power: Power::On,
            ..n
        })
    }),
    ("Rearm: keeps the anchor", |f, i| {
        then(f, i, i == Input::Rearm, |n| Facts {
            knowledge: f.knowledge,
            ..n
        })
    }),
    ("Rearm: only switches off", |f, i| {
        then(f, i, i == Input::Rearm, |n| Facts {
            goal: Goal::Off,
            ..n
        })
    }),
    ("Stop: does not slow down", |f, i| {
        then(f, i, i == Input::Stop, |n| Facts {
            motion: f.motion,
            ..n
        })
    }),
    ("Stop: ends every set-point", |f, i| {
        then(f, i, i == Input::Stop, |n| Facts {
            motion: Motion::Rest,
            ..n
        })
    }),
    ("Stop: keeps the wish to stream", |f, i| {
        then(f, i, i == Input::Stop, |n| Facts { goal: f.goal, ..n })
    }),
    ("Stop: lets go of what holds", |f, i| {
        then(f, i, i == Input::Stop && f.goal == Goal::Hold, |n| {
            settled(Facts {
                goal: Goal::Off,
                ..n
            })
        })
    }),
    ("Stop: what was coming on holds", |f, i| {
        then(f, i, i == Input::Stop && f.power == Power::OnSent, |n| {
            Facts {
                goal: Goal::Hold,
                power: Power::OnSent,
                ..n
            }
        })
    }),
    ("Halt: slows down", |f, i| {
        then(f, i, i == Input::Halt && f.motion == Motion::Stream, |n| {
            Facts {
                motion: Motion::Ramp,
                ..n
            }
        })
    }),
    ("Halt: keeps the wish to stream", |f, i| {
        then(f, i, i == Input::Halt, |n| Facts { goal: f.goal, ..n })
    }),
    ("Halt: a disable under way is forgotten", |f, i| {
        then(f, i, i == Input::Halt && f.power == Power::OffWanted, |n| {
            Facts {
                power: Power::On,
                goal: Goal::Hold,
                ..n
            }
        })
    }),
    ("Disable: does not slow down", |f, i| {
        then(f, i, i == Input::Disable, |n| Facts {
            motion: f.motion,
            ..n
        })
    }),
    ("Disable: switches off in motion", |f, i| {
        then(f, i, i == Input::Disable && f.power.may_be_on(), |n| {
            Facts {
                motion: Motion::Rest,
                power: Power::OffWanted,
                ..n
            }
        })
    }),
    ("Disable: only ramps down", |f, i| {
        then(f, i, i == Input::Disable && f.motion != Motion::Rest, |n| {
            Facts {
                goal: Goal::Hold,
                ..n
            }
        })
    }),
    ("Disable: waits for a reading", |f, i| {
        then(
            f,
            i,
            i == Input::Disable && f.power == Power::Unclear,
            |n| Facts {
                power: Power::Unclear,
                ..n
            },
        )
    }),
    ("Disable: spares a drive found on", |f, i| {
        then(
            f,
            i,
            i == Input::Disable && f.power == Power::FoundOn,
            |n| Facts {
                power: Power::FoundOn,
                ..n
            },
        )
    }),
    ("Disable: said again with every call", |f, i| {
        then(
            f,
            i,
            i == Input::Disable && f.power == Power::OffSent,
            |n| Facts {
                power: Power::OffWanted,
                ..n
            },
        )
    }),
    ("Disable: taken for done", |f, i| {
        then(f, i, i == Input::Disable && f.power == Power::OnSent, |n| {
            Facts {
                power: Power::Off,
                ..n
            }
        })
    }),
    ("Clear: keeps the fault", |f, i| {
        then(f, i, i == Input::Clear, |n| Facts {
            latch: f.latch,
            ..n
        })
    }),
    ("Clear: no new checks after a fault of its own", |f, i| {
        then(f, i, i == Input::Clear && f.latch == Latch::Own, |n| {
            Facts {
                knowledge: f.knowledge,
                ..n
            }
        })
    }),
    ("Clear: a reading goes on beside the new checks", |f, i| {
        then(f, i, i == Input::Clear && f.latch == Latch::Own, |n| {
            Facts { work: f.work, ..n }
        })
    }),
    ("Clear: new checks after a fault of the group", |f, i| {
        then(f, i, i == Input::Clear && f.latch == Latch::Group, |n| {
            Facts {
                knowledge: Knowledge::Unknown,
                ..n
            }
        })
    }),
    ("Clear: resumes", |f, i| {
        then(f, i, i == Input::Clear && f.latch == Latch::Group, |n| {
            Facts {
                goal: Goal::Stream,
                ..n
            }
        })
    }),
    ("StartWork: does nothing", |f, i| {
        then(f, i, matches!(i, Input::StartWork(_)), |_| f)
    }),
    ("WorkEnded: a write leaves the checks valid", |f, i| {
        then(f, i, i == Input::WorkEnded && f.work == Work::Write, |n| {
            Facts {
                knowledge: f.knowledge,
                ..n
            }
        })
    }),
    ("WorkEnded: a reading takes the knowledge", |f, i| {
        then(f, i, i == Input::WorkEnded && f.work == Work::Read, |n| {
            Facts {
                knowledge: Knowledge::Unknown,
                ..n
            }
        })
    }),
    ("WorkEnded: goes on", |f, i| {
        then(f, i, i == Input::WorkEnded, |n| Facts { work: f.work, ..n })
    }),
    ("Start: a ramp", |f, i| {
        then(f, i, i == Input::Start, |n| Facts {
            motion: Motion::Ramp,
            ..n
        })
    }),
];
