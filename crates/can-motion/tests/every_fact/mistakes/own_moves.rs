//! Mistakes in what is decided about motions that drives make by themselves.

use can_motion::MoveEnd;
use can_motion::facts::{
    Brake, Class, Facts, Goal, Input, Knowledge, Latch, Loss, Motion, Power, Work, accepts,
    may_leave,
};

use super::{Accepts, Change, Exit, settled, then};

fn with_motion(facts: Facts, motion: Motion) -> Facts {
    Facts { motion, ..facts }
}

fn with_goal(facts: Facts, goal: Goal) -> Facts {
    Facts { goal, ..facts }
}

/// Accepted as if the facts were these.
fn as_if(facts: &Facts, input: Input, seen: Facts) -> bool {
    let is_move = matches!(input, Input::Move | Input::SyncMove);
    accepts(if is_move { &seen } else { facts }, input)
}

/// May leave as if the facts were these.
fn leaves_as_if(class: Class, facts: &Facts, one: Class, seen: Facts) -> bool {
    may_leave(class, if class == one { &seen } else { facts })
}

pub(super) const NEEDED: &[Accepts] = &[
    ("accepts: Move under a fault", |f, i| {
        as_if(
            f,
            i,
            Facts {
                latch: Latch::None,
                ..*f
            },
        )
    }),
    ("accepts: Move without an anchor", |f, i| {
        as_if(
            f,
            i,
            Facts {
                knowledge: Knowledge::Anchored,
                ..*f
            },
        )
    }),
    ("accepts: Move of what is off", |f, i| {
        as_if(
            f,
            i,
            Facts {
                power: Power::On,
                ..*f
            },
        )
    }),
    ("accepts: Move of what streams or moves", |f, i| {
        as_if(
            f,
            i,
            Facts {
                motion: Motion::Rest,
                goal: Goal::Hold,
                ..*f
            },
        )
    }),
    ("accepts: Move with a loaded move", |f, i| {
        let is_loaded = f.motion == Motion::Loaded && f.goal == Goal::Hold;
        as_if(
            f,
            i,
            if is_loaded {
                with_motion(*f, Motion::Rest)
            } else {
                *f
            },
        )
    }),
    ("accepts: Move against a brake", |f, i| {
        as_if(
            f,
            i,
            Facts {
                brake: Brake::Open,
                ..*f
            },
        )
    }),
    ("accepts: Move beside a procedure", |f, i| {
        as_if(
            f,
            i,
            Facts {
                work: Work::None,
                ..*f
            },
        )
    }),
    ("accepts: Resume with a loaded move", |f, i| {
        let seen = with_motion(*f, Motion::Rest);
        accepts(if i == Input::Resume { &seen } else { f }, i)
    }),
    ("accepts: Arm what is not wanted any more", |f, i| {
        let seen = with_goal(*f, Goal::SyncMove);
        accepts(if i == Input::Arm { &seen } else { f }, i)
    }),
    ("accepts: Arm what was not loaded", |f, i| {
        let seen = with_motion(*f, Motion::Loaded);
        accepts(if i == Input::Arm { &seen } else { f }, i)
    }),
    ("accepts: Move never", |f, i| {
        i != Input::Move && accepts(f, i)
    }),
    ("accepts: SyncMove never", |f, i| {
        i != Input::SyncMove && accepts(f, i)
    }),
];

pub(super) const EXITS: &[Exit] = &[
    ("may_leave: a motion that was asked for together", |c, f| {
        leaves_as_if(
            c,
            f,
            Class::DriveMove,
            if f.goal == Goal::SyncMove {
                with_goal(*f, Goal::Move)
            } else {
                *f
            },
        )
    }),
    ("may_leave: a motion that nobody asked for", |c, f| {
        leaves_as_if(c, f, Class::DriveMove, with_goal(*f, Goal::Move))
    }),
    ("may_leave: a motion beside set-points", |c, f| {
        leaves_as_if(c, f, Class::DriveMove, with_motion(*f, Motion::Rest))
    }),
    ("may_leave: a motion under a fault", |c, f| {
        leaves_as_if(
            c,
            f,
            Class::DriveMove,
            Facts {
                latch: Latch::None,
                ..*f
            },
        )
    }),
    ("may_leave: a motion without an anchor", |c, f| {
        leaves_as_if(
            c,
            f,
            Class::DriveMove,
            Facts {
                knowledge: Knowledge::Anchored,
                ..*f
            },
        )
    }),
    ("may_leave: a motion without power", |c, f| {
        leaves_as_if(
            c,
            f,
            Class::DriveMove,
            Facts {
                power: Power::On,
                ..*f
            },
        )
    }),
    ("may_leave: a motion against a brake", |c, f| {
        leaves_as_if(
            c,
            f,
            Class::DriveMove,
            Facts {
                brake: Brake::Open,
                ..*f
            },
        )
    }),
    ("may_leave: a motion beside a write", |c, f| {
        leaves_as_if(
            c,
            f,
            Class::DriveMove,
            Facts {
                work: Work::None,
                ..*f
            },
        )
    }),
    ("may_leave: a second frame of a motion kept back", |c, f| {
        may_leave(c, f) && (c != Class::DriveMove || f.motion == Motion::Rest)
    }),
    ("may_leave: a load twice", |c, f| {
        leaves_as_if(
            c,
            f,
            Class::Load,
            if f.motion == Motion::Loaded {
                with_motion(*f, Motion::Rest)
            } else {
                *f
            },
        )
    }),
    ("may_leave: a load that nobody asked for", |c, f| {
        leaves_as_if(c, f, Class::Load, with_goal(*f, Goal::SyncMove))
    }),
    ("may_leave: a trigger before the answers", |c, f| {
        leaves_as_if(
            c,
            f,
            Class::Trigger,
            if f.motion == Motion::Loaded {
                with_motion(*f, Motion::Armed)
            } else {
                *f
            },
        )
    }),
    (
        "may_leave: a trigger that is not wanted any more",
        |c, f| leaves_as_if(c, f, Class::Trigger, with_goal(*f, Goal::SyncMove)),
    ),
    ("may_leave: a trigger under a fault", |c, f| {
        leaves_as_if(
            c,
            f,
            Class::Trigger,
            Facts {
                latch: Latch::None,
                ..*f
            },
        )
    }),
    ("may_leave: a stop of what is wanted", |c, f| {
        leaves_as_if(c, f, Class::DriveStop, with_goal(*f, Goal::Hold))
    }),
    ("may_leave: a stop at rest", |c, f| {
        leaves_as_if(c, f, Class::DriveStop, with_motion(*f, Motion::DriveMove))
    }),
    ("may_leave: a stop to a drive of somebody else", |c, f| {
        leaves_as_if(
            c,
            f,
            Class::DriveStop,
            Facts {
                power: Power::On,
                ..*f
            },
        )
    }),
    ("may_leave: a stop kept back under a fault", |c, f| {
        may_leave(c, f) && (c != Class::DriveStop || f.latch == Latch::None)
    }),
    ("may_leave: a stop kept back without contact", |c, f| {
        may_leave(c, f) && (c != Class::DriveStop || f.power == Power::On)
    }),
    (
        "may_leave: set-points while the drive moves by itself",
        |c, f| {
            leaves_as_if(
                c,
                f,
                Class::SetPoint,
                if f.motion == Motion::DriveMove {
                    with_motion(*f, Motion::Stream)
                } else {
                    *f
                },
            )
        },
    ),
];

pub(super) const CHANGES: &[Change] = &[
    ("Move: asks for set-points", |f, i| {
        then(f, i, i == Input::Move, |n| with_goal(n, Goal::Stream))
    }),
    ("SyncMove: does not wait for the trigger", |f, i| {
        then(f, i, i == Input::SyncMove, |n| with_goal(n, Goal::Move))
    }),
    ("Accepted: a motion is not seen", |f, i| {
        then(f, i, i == Input::Accepted(Class::DriveMove), |n| {
            with_motion(n, f.motion)
        })
    }),
    ("Accepted: a load starts the motion", |f, i| {
        then(
            f,
            i,
            i == Input::Accepted(Class::Load) && f.goal == Goal::SyncMove,
            |n| with_motion(n, Motion::DriveMove),
        )
    }),
    ("Accepted: a load is armed at once", |f, i| {
        then(
            f,
            i,
            i == Input::Accepted(Class::Load) && f.goal == Goal::SyncMove,
            |n| with_motion(n, Motion::Armed),
        )
    }),
    ("Accepted: a trigger is not seen", |f, i| {
        then(f, i, i == Input::Accepted(Class::Trigger), |n| {
            with_motion(n, f.motion)
        })
    }),
    ("Displaced: a motion that never began goes on", |f, i| {
        then(f, i, i == Input::Displaced(Class::DriveMove), |n| {
            with_motion(n, f.motion)
        })
    }),
    ("Displaced: a load that never left stays", |f, i| {
        then(f, i, i == Input::Displaced(Class::Load), |n| {
            with_motion(n, f.motion)
        })
    }),
    ("Displaced: a trigger unloads the drive", |f, i| {
        then(
            f,
            i,
            i == Input::Displaced(Class::Trigger) && f.motion == Motion::DriveMove,
            |n| with_motion(n, Motion::Rest),
        )
    }),
    (
        "Displaced: behind a stop, a trigger leaves the anchor",
        |f, i| {
            then(
                f,
                i,
                i == Input::Displaced(Class::Trigger) && f.motion == Motion::DriveMove,
                |n| Facts {
                    knowledge: f.knowledge,
                    ..n
                },
            )
        },
    ),
    ("Arm: starts the motion", |f, i| {
        then(f, i, i == Input::Arm, |n| with_motion(n, Motion::DriveMove))
    }),
    ("MoveEnded: not seen", |f, i| {
        then(f, i, matches!(i, Input::MoveEnded(_)), |_| f)
    }),
    ("MoveEnded: goes on to stream", |f, i| {
        then(
            f,
            i,
            matches!(i, Input::MoveEnded(_)) && f.goal == Goal::Move,
            |n| with_goal(n, Goal::Stream),
        )
    }),
    ("MoveEnded: a disable that waited is forgotten", |f, i| {
        then(
            f,
            i,
            matches!(i, Input::MoveEnded(_)) && f.goal == Goal::Off,
            |n| Facts {
                power: f.power,
                ..n
            },
        )
    }),
    ("MoveEnded: elsewhere, and the anchor stays", |f, i| {
        then(f, i, i == Input::MoveEnded(MoveEnd::Elsewhere), |n| Facts {
            knowledge: f.knowledge,
            ..n
        })
    }),
    ("MoveEnded: arrived, and the anchor is lost", |f, i| {
        then(f, i, i == Input::MoveEnded(MoveEnd::Arrived), |n| Facts {
            knowledge: n.knowledge.min(Knowledge::Checked),
            ..n
        })
    }),
    ("MoveEnded: in another mode, it holds", |f, i| {
        then(
            f,
            i,
            i == Input::MoveEnded(MoveEnd::OtherMode) && f.goal.is_move(),
            |n| Facts {
                goal: Goal::Hold,
                power: f.power,
                ..n
            },
        )
    }),
    ("Halt: what a drive does by itself is forgotten", |f, i| {
        then(
            f,
            i,
            i == Input::Halt && f.motion == Motion::DriveMove,
            |n| settled(with_motion(n, Motion::Rest)),
        )
    }),
    ("Stop: a loaded move is forgotten", |f, i| {
        then(f, i, i == Input::Stop, |n| match n.motion {
            Motion::Loaded | Motion::Armed => with_motion(n, Motion::Rest),
            _ => n,
        })
    }),
    ("Stop: the wish to move stays", |f, i| {
        then(f, i, i == Input::Stop && f.goal.is_move(), |n| {
            with_goal(n, f.goal)
        })
    }),
    ("Disable: the power goes while the drive moves", |f, i| {
        let is_meant =
            i == Input::Disable && f.motion == Motion::DriveMove && f.latch == Latch::None;
        then(f, i, is_meant, |n| Facts {
            power: f.power,
            goal: f.goal,
            ..n
        })
    }),
    ("Disable: under a fault it waits for the motion", |f, i| {
        let is_meant =
            i == Input::Disable && f.motion == Motion::DriveMove && f.latch != Latch::None;
        then(f, i, is_meant, |n| Facts {
            power: f.power,
            ..n
        })
    }),
    ("SaysOff: on its way, the anchor stays", |f, i| {
        then(
            f,
            i,
            i == Input::SaysOff && f.motion == Motion::DriveMove,
            |n| Facts {
                knowledge: f.knowledge,
                ..n
            },
        )
    }),
    ("SaysOff: a loaded move stays", |f, i| {
        then(
            f,
            i,
            i == Input::SaysOff && f.motion == Motion::Loaded,
            |n| with_motion(n, f.motion),
        )
    }),
    ("Fault: what a drive does by itself is forgotten", |f, i| {
        let is_fault = matches!(i, Input::Fault { loss, .. } if loss != Loss::Drive);
        then(f, i, is_fault && f.motion == Motion::DriveMove, |n| {
            settled(with_motion(n, Motion::Rest))
        })
    }),
    ("Fault: a drive that let go still moves", |f, i| {
        let lets_go = matches!(
            i,
            Input::Fault {
                loss: Loss::Drive,
                ..
            }
        );
        then(f, i, lets_go && f.motion == Motion::DriveMove, |n| {
            with_motion(n, f.motion)
        })
    }),
    (
        "Fault: a disable that waited for the motion is forgotten",
        |f, i| {
            let is_cut = matches!(
                i,
                Input::Fault {
                    loss: Loss::Contact,
                    ..
                }
            );
            then(
                f,
                i,
                is_cut && f.motion == Motion::DriveMove && f.goal == Goal::Off,
                |n| Facts {
                    power: Power::OnUnconfirmed,
                    ..n
                },
            )
        },
    ),
    ("GroupFault: the wish to move stays", |f, i| {
        then(
            f,
            i,
            matches!(i, Input::GroupFault { .. }) && f.goal.is_move(),
            |n| with_goal(n, f.goal),
        )
    }),
    ("GroupFault: a motion of a drive becomes a ramp", |f, i| {
        then(
            f,
            i,
            i == Input::GroupFault { ramp: true } && f.motion == Motion::DriveMove,
            |n| with_motion(n, Motion::Ramp),
        )
    }),
    (
        "Turns: a motion that has not begun is still wanted",
        |f, i| {
            then(f, i, i == Input::Turns && f.goal.is_move(), |n| {
                with_goal(n, f.goal)
            })
        },
    ),
    ("BrakeClosed: a motion of the drive goes on", |f, i| {
        then(f, i, i == Input::BrakeClosed && f.goal.is_move(), |_| {
            Facts {
                brake: Brake::Closed,
                ..f
            }
        })
    }),
];
