//! Mistakes in `accepts`: a condition left out, or a command that must never be refused refused.

use can_motion::facts::{
    Brake, Facts, Goal, Input, Knowledge, Latch, Motion, Power, Work, accepts,
};

use super::Accepts;

const NO_FAULT: fn(&Facts) -> Facts = |facts| Facts {
    latch: Latch::None,
    ..*facts
};
const NO_WORK: fn(&Facts) -> Facts = |facts| Facts {
    work: Work::None,
    ..*facts
};
const AT_REST: fn(&Facts) -> Facts = |facts| Facts {
    motion: Motion::Rest,
    ..*facts
};
const CHECKED: fn(&Facts) -> Facts = |facts| Facts {
    knowledge: Knowledge::Checked,
    ..*facts
};
const ANCHORED: fn(&Facts) -> Facts = |facts| Facts {
    knowledge: Knowledge::Anchored,
    ..*facts
};

/// Whether the input is `one` and is accepted with these facts, or another and is accepted.
fn as_if(facts: &Facts, input: Input, one: Input, seen: Facts) -> bool {
    accepts(if input == one { &seen } else { facts }, input)
}

fn held(facts: &Facts) -> Facts {
    Facts {
        power: Power::On,
        goal: Goal::Hold,
        ..*facts
    }
}

fn off(facts: &Facts) -> Facts {
    Facts {
        power: Power::Off,
        goal: Goal::Off,
        ..*facts
    }
}

const WRITE: Input = Input::StartWork(Work::Write);
const REPAIR: Input = Input::StartWork(Work::Repair);
const READ: Input = Input::StartWork(Work::Read);

pub(super) const ALL: &[Accepts] = &[
    ("accepts: Enable under a fault", |f, i| {
        as_if(f, i, Input::Enable, NO_FAULT(f))
    }),
    ("accepts: Enable beside a write", |f, i| {
        as_if(f, i, Input::Enable, NO_WORK(f))
    }),
    ("accepts: Enable in motion", |f, i| {
        as_if(f, i, Input::Enable, AT_REST(f))
    }),
    ("accepts: Enable without checks", |f, i| {
        let seen = Facts {
            knowledge: f.knowledge.max(Knowledge::Checked),
            ..*f
        };
        as_if(f, i, Input::Enable, seen)
    }),
    ("accepts: Enable of what is not off", |f, i| {
        as_if(f, i, Input::Enable, off(f))
    }),
    ("accepts: Enable refused to what holds", |f, i| {
        accepts(f, i) && (i != Input::Enable || f.power == Power::Off)
    }),
    ("accepts: Enable refused to what is off", |f, i| {
        accepts(f, i) && (i != Input::Enable || f.power == Power::On)
    }),
    ("accepts: Adopt under a fault", |f, i| {
        as_if(f, i, Input::Adopt, NO_FAULT(f))
    }),
    ("accepts: Adopt beside a write", |f, i| {
        as_if(f, i, Input::Adopt, NO_WORK(f))
    }),
    ("accepts: Adopt without checks", |f, i| {
        as_if(f, i, Input::Adopt, CHECKED(f))
    }),
    ("accepts: Adopt against a wish to hold", |f, i| {
        let seen = Facts {
            goal: Goal::Off,
            ..*f
        };
        as_if(f, i, Input::Adopt, seen)
    }),
    ("accepts: Adopt of what was not found on", |f, i| {
        let seen = Facts {
            power: Power::FoundOn,
            ..*f
        };
        as_if(f, i, Input::Adopt, seen)
    }),
    ("accepts: Resume under a fault", |f, i| {
        as_if(f, i, Input::Resume, NO_FAULT(f))
    }),
    ("accepts: Resume of a ramp", |f, i| {
        as_if(f, i, Input::Resume, AT_REST(f))
    }),
    ("accepts: Resume of what does not hold", |f, i| {
        as_if(f, i, Input::Resume, held(f))
    }),
    ("accepts: Resume without an anchor", |f, i| {
        as_if(f, i, Input::Resume, ANCHORED(f))
    }),
    ("accepts: Rearm under a fault", |f, i| {
        as_if(f, i, Input::Rearm, NO_FAULT(f))
    }),
    ("accepts: Rearm in motion", |f, i| {
        as_if(f, i, Input::Rearm, AT_REST(f))
    }),
    ("accepts: Rearm of what does not hold", |f, i| {
        as_if(f, i, Input::Rearm, held(f))
    }),
    ("accepts: Rearm without checks", |f, i| {
        as_if(f, i, Input::Rearm, CHECKED(f))
    }),
    ("accepts: Rearm with a load that can fall", |f, i| {
        let seen = Facts {
            brake: Brake::Absent,
            ..*f
        };
        as_if(f, i, Input::Rearm, seen)
    }),
    ("accepts: Start under a fault", |f, i| {
        as_if(f, i, Input::Start, NO_FAULT(f))
    }),
    ("accepts: Start of a ramp", |f, i| {
        as_if(f, i, Input::Start, AT_REST(f))
    }),
    ("accepts: Start without an anchor", |f, i| {
        as_if(f, i, Input::Start, ANCHORED(f))
    }),
    ("accepts: Start without a wish", |f, i| {
        let seen = Facts {
            goal: Goal::Stream,
            ..*f
        };
        as_if(f, i, Input::Start, seen)
    }),
    ("accepts: Start without power", |f, i| {
        let seen = Facts {
            power: Power::On,
            ..*f
        };
        as_if(f, i, Input::Start, seen)
    }),
    ("accepts: Start against a brake", |f, i| {
        let seen = Facts {
            brake: Brake::Open,
            ..*f
        };
        as_if(f, i, Input::Start, seen)
    }),
    ("accepts: a second reading beside a write", |f, i| {
        as_if(f, i, READ, NO_WORK(f))
    }),
    ("accepts: a write under a fault", |f, i| {
        as_if(f, i, WRITE, NO_FAULT(f))
    }),
    ("accepts: a write without checks", |f, i| {
        as_if(f, i, WRITE, CHECKED(f))
    }),
    ("accepts: a write to what may be on", |f, i| {
        as_if(f, i, WRITE, off(f))
    }),
    ("accepts: a write beside a reading", |f, i| {
        as_if(f, i, WRITE, NO_WORK(f))
    }),
    ("accepts: a repair of what may be on", |f, i| {
        as_if(f, i, REPAIR, off(f))
    }),
    ("accepts: a repair in motion", |f, i| {
        as_if(f, i, REPAIR, AT_REST(f))
    }),
    ("accepts: a repair beside other work", |f, i| {
        as_if(f, i, REPAIR, NO_WORK(f))
    }),
    ("accepts: a repair refused under a fault", |f, i| {
        accepts(f, i) && (i != REPAIR || f.latch == Latch::None)
    }),
    ("accepts: work that is none", |f, i| {
        i == Input::StartWork(Work::None) || accepts(f, i)
    }),
    ("accepts: Clear of a ramp", |f, i| {
        as_if(f, i, Input::Clear, AT_REST(f))
    }),
    ("accepts: Clear in a repair", |f, i| {
        as_if(f, i, Input::Clear, NO_WORK(f))
    }),
    ("accepts: Clear while it is unclear what holds", |f, i| {
        let seen = Facts {
            goal: Goal::Off,
            ..*f
        };
        as_if(f, i, Input::Clear, seen)
    }),
    ("accepts: Clear refused while off and unclear", |f, i| {
        accepts(f, i) && (i != Input::Clear || f.power != Power::FoundOn)
    }),
    ("accepts: Disable refused under a fault", |f, i| {
        accepts(f, i) && (i != Input::Disable || f.latch == Latch::None)
    }),
    ("accepts: Stop refused while enabling", |f, i| {
        accepts(f, i) && (i != Input::Stop || f.power != Power::OnSent)
    }),
    ("accepts: Halt refused in a ramp", |f, i| {
        accepts(f, i) && (i != Input::Halt || f.motion != Motion::Ramp)
    }),
    ("accepts: a reading refused under a fault", |f, i| {
        accepts(f, i) && (i != Input::SaysOff || f.latch == Latch::None)
    }),
];
