//! Moves of several drives that one trigger starts: which may be loaded together, when the trigger goes out, and what keeps it back.

use can_motion::facts::{Class, Loss, Motion};
use can_motion::family::{Meaning, MoveReport, Wanted};
use can_motion::{
    AxisState, BusUser, CommandError, DriveMove, GroupId, MoveEnd, MoveError, MoveRefusal,
};

use crate::drive::{Call, LOAD, TRIGGER};
use crate::family::{Axis, BUS, Bus, Fault, Frame, axis};
use crate::rig::{FINE, G, Rig};

const TO: DriveMove = DriveMove::To(50);
const BY: DriveMove = DriveMove::By(5);
const OTHER: GroupId = GroupId(1);

const fn moving(address: u8, group: u8) -> Axis {
    Axis {
        moves: true,
        group,
        ..axis(address)
    }
}

/// All drives hold, and each of them may be asked in every cycle.
fn holding(axes: &[Axis]) -> Rig {
    let mut rig = Rig::on(Bus { requests: 3, ..BUS }, axes);
    rig.all_say(Meaning {
        is_checked: true,
        ..rig.power(false)
    });
    for group in [G, OTHER] {
        let _ = rig.master.enable(rig.now, group);
    }
    let mut rig = rig.stream();
    for group in [G, OTHER] {
        rig.master.halt(rig.now, group);
    }
    rig.forget()
}

const LOAD_SEEN: Meaning<Fault> = Meaning {
    own_move: Some(MoveReport::LoadSeen),
    ..Meaning::NONE
};

fn wants_load(rig: &mut Rig, address: u8) {
    rig.wants(address, Some(Wanted::urgent(Class::Load, LOAD)));
}

fn wants_trigger(rig: &mut Rig, address: u8) {
    rig.wants(address, Some(Wanted::urgent(Class::Trigger, TRIGGER)));
}

/// Axes 0 and 1 have a move loaded.
fn loaded(axes: &[Axis]) -> Rig {
    let mut rig = holding(axes);
    rig.master
        .start_moves(rig.now, &[(0, TO), (1, TO)])
        .expect("drives that hold");
    for address in [1, 2] {
        wants_load(&mut rig, address);
    }
    assert_eq!(rig.cycle(), [Frame::Ask(1, LOAD), Frame::Ask(2, LOAD)]);
    rig
}

/// And their drives have answered since.
fn armed(axes: &[Axis]) -> Rig {
    let mut rig = loaded(axes);
    for address in [1, 2] {
        rig.says(address, LOAD_SEEN);
    }
    assert_eq!(motions(&rig), [Motion::Armed; 2]);
    rig
}

fn motions(rig: &Rig) -> [Motion; 2] {
    [0, 1].map(|axis| rig.seen(axis).facts.motion)
}

#[test]
fn moves_are_loaded_then_seen_then_started_by_one_trigger() {
    let mut rig = loaded(&[moving(1, 0), moving(2, 0), moving(3, 1)]);
    assert_eq!(
        rig.states(),
        [AxisState::Loaded, AxisState::Loaded, AxisState::Holding]
    );
    // The trigger waits until every drive of them has answered.
    rig.says(2, LOAD_SEEN);
    assert_eq!(motions(&rig), [Motion::Loaded; 2]);
    rig.says(2, LOAD_SEEN);
    assert_eq!(motions(&rig), [Motion::Loaded; 2]);
    rig.says(1, LOAD_SEEN);
    assert_eq!(motions(&rig), [Motion::Armed; 2]);
    wants_trigger(&mut rig, 2);
    assert_eq!(rig.cycle(), [Frame::Trigger]);
    assert_eq!(
        rig.states(),
        [
            AxisState::DriveMoving,
            AxisState::DriveMoving,
            AxisState::Holding
        ]
    );
    rig.says(
        1,
        Meaning {
            own_move: Some(MoveReport::Ended(MoveEnd::Arrived)),
            ..Meaning::NONE
        },
    );
    assert_eq!(rig.state(0), AxisState::Holding);
    let end = Call::EndMove(rig.now, Some(MoveEnd::Arrived));
    assert_eq!(rig.seen(0).calls.last(), Some(&end));
    // The third drive was told nothing.
    let is_begun = |call: &Call| matches!(call, Call::BeginMove(_));
    assert!(!rig.seen(2).calls.iter().any(is_begun));
}

#[test]
fn an_answer_of_a_drive_that_is_not_loaded_yet_arms_nothing() {
    let mut rig = holding(&[moving(1, 0), moving(2, 0), moving(3, 1)]);
    rig.master
        .start_moves(rig.now, &[(0, TO), (1, TO)])
        .expect("drives that hold");
    wants_load(&mut rig, 1);
    rig.cycle();
    for address in [2, 3, 1] {
        rig.says(address, LOAD_SEEN);
    }
    assert_eq!(motions(&rig), [Motion::Loaded, Motion::Rest]);
    wants_trigger(&mut rig, 1);
    assert_eq!(rig.cycle(), []);
}

#[test]
fn two_groups_may_be_loaded_one_after_the_other_only() {
    let mut rig = armed(&[moving(1, 0), moving(2, 0), moving(3, 1)]);
    // Its trigger would start the others too.
    let refused = rig.master.start_moves(rig.now, &[(2, TO)]);
    assert_eq!(refused, Err(MoveError::OldLoad { axis: 0 }));
    let refused = rig.master.start_moves(rig.now, &[(2, BY)]);
    assert_eq!(refused, Err(MoveError::OldLoad { axis: 0 }));
    wants_trigger(&mut rig, 1);
    assert_eq!(rig.cycle(), [Frame::Trigger]);
    let started = rig.master.start_moves(rig.now, &[(2, BY)]);
    assert_eq!(started, Ok(()));
    // Asked for, and not loaded yet: that counts too.
    let mut rig = holding(&[moving(1, 0), moving(2, 0), moving(3, 1)]);
    rig.master
        .start_moves(rig.now, &[(0, TO)])
        .expect("a drive that holds");
    let refused = rig.master.start_moves(rig.now, &[(2, TO)]);
    assert_eq!(refused, Err(MoveError::OldLoad { axis: 0 }));
    // What answers in one group arms nothing in another.
    let mut rig = loaded(&[moving(1, 0), moving(2, 0), moving(3, 1)]);
    rig.says(1, LOAD_SEEN);
    rig.says(3, LOAD_SEEN);
    assert_eq!(motions(&rig), [Motion::Loaded; 2]);
}

#[test]
fn moves_that_start_together_are_of_one_kind_of_one_group_and_each_of_another_axis() {
    let mut rig = holding(&[moving(1, 0), moving(2, 0), moving(3, 1)]);
    let (now, changes) = (rig.now, rig.master.changes());
    let sets: [&[(usize, DriveMove)]; 6] = [
        &[],
        &[(1, TO), (0, TO), (1, TO)],
        &[(0, TO), (1, BY)],
        &[(0, BY), (1, TO)],
        &[(0, TO), (2, TO)],
        &[(0, TO), (1, TO), (0, TO)],
    ];
    for moves in sets {
        let refused = rig.master.start_moves(now, moves);
        assert_eq!(refused, Err(MoveError::NotTogether), "{moves:?}");
    }
    let nobody = MoveError::NoSuchAxis { axes: 3, actual: 3 };
    assert_eq!(
        rig.master.start_moves(now, &[(0, TO), (3, TO)]),
        Err(nobody)
    );
    let speed = MoveError::Refused {
        axis: 0,
        refusal: MoveRefusal::Unsupported,
    };
    let refused = rig.master.start_moves(now, &[(0, DriveMove::Speed(9))]);
    assert_eq!(refused, Err(speed));
    rig.wants(1, None);
    assert_eq!((rig.master.changes(), rig.cycle()), (changes, vec![]));
    let is_begun = |call: &Call| matches!(call, Call::BeginMove(_));
    assert!(!rig.seen(0).calls.iter().any(is_begun));
    for moves in [[(0, TO), (1, DriveMove::To(7))], [(1, BY), (0, BY)]] {
        let mut rig = holding(&[moving(1, 0), moving(2, 0), moving(3, 1)]);
        assert_eq!(rig.master.start_moves(rig.now, &moves), Ok(()));
        for (axis, wanted) in moves {
            let last = rig.seen(axis).calls.last().copied();
            assert_eq!(last, Some(Call::BeginMove(wanted)));
        }
    }
}

#[test]
fn a_drive_with_power_that_may_hold_an_old_load_keeps_the_trigger_back() {
    let old = |old_load| Axis {
        old_load: Some(old_load),
        ..moving(3, 1)
    };
    let start = |third: Axis| {
        let mut rig = holding(&[moving(1, 0), moving(2, 0), third]);
        (rig.master.start_moves(rig.now, &[(0, TO), (1, TO)]), rig)
    };
    let kept_back = Err(MoveError::OldLoad { axis: 2 });
    assert_eq!(start(old(TO)).0, kept_back);
    // One of the other kind would not start.
    assert_eq!(start(old(BY)).0, Ok(()));
    // Nor one that is loaded anew.
    let anew = |address| Axis {
        old_load: Some(TO),
        ..moving(address, 0)
    };
    let mut rig = holding(&[anew(1), anew(2)]);
    let started = rig.master.start_moves(rig.now, &[(0, TO), (1, TO)]);
    assert_eq!(started, Ok(()));
    // Nor one without power.
    let (_, mut rig) = start(old(TO));
    rig.master.disable(rig.now, OTHER);
    assert_eq!(rig.cycle(), [Frame::Switch(3, false)]);
    let started = rig.master.start_moves(rig.now, &[(0, TO)]);
    assert_eq!(started, kept_back);
    rig.cycle();
    rig.says(3, rig.power(false));
    assert_eq!(rig.state(2), AxisState::Ready);
    let started = rig.master.start_moves(rig.now, &[(0, TO)]);
    assert_eq!(started, Ok(()));
}

#[test]
fn what_comes_up_after_loading_keeps_the_trigger_back_and_the_moves_where_they_are() {
    let old = Axis {
        old_load: Some(TO),
        ..moving(3, 1)
    };
    let mut rig = holding(&[moving(1, 0), moving(2, 0), old]);
    rig.master.disable(rig.now, OTHER);
    rig.cycle();
    rig.cycle();
    rig.says(3, rig.power(false));
    rig.master
        .start_moves(rig.now, &[(0, TO), (1, TO)])
        .expect("drives that hold");
    for address in [1, 2] {
        wants_load(&mut rig, address);
    }
    rig.cycle();
    for address in [1, 2] {
        rig.says(address, LOAD_SEEN);
    }
    // Somebody else switches the third drive on.
    rig.says(3, rig.power(true));
    assert_eq!(rig.state(2), AxisState::FoundOn);
    wants_trigger(&mut rig, 1);
    assert_eq!(rig.cycle(), []);
    assert_eq!(rig.states()[..2], [AxisState::Loaded; 2]);
    // They stay so, and nothing starts them any more.
    wants_trigger(&mut rig, 2);
    assert_eq!(rig.cycle(), []);
    let refused = rig.master.start_moves(rig.now, &[(0, TO)]);
    assert!(refused.is_err());
}

#[test]
fn a_trigger_that_comes_back_is_sent_again_for_those_that_it_was_for() {
    let mut rig = armed(&[moving(1, 0), moving(2, 0), moving(3, 1)]);
    wants_trigger(&mut rig, 1);
    assert_eq!(rig.cycle(), [Frame::Trigger]);
    wants_trigger(&mut rig, 1);
    rig.master.on_displaced(rig.now, &Frame::Trigger);
    assert_eq!(motions(&rig), [Motion::Armed; 2]);
    // Without another cycle.
    assert_eq!(rig.send(), [Frame::Trigger]);
    assert_eq!(motions(&rig), [Motion::DriveMove; 2]);
    // One whose motion is over has nothing to start again.
    rig.says(
        2,
        Meaning {
            own_move: Some(MoveReport::Ended(MoveEnd::Arrived)),
            ..Meaning::NONE
        },
    );
    rig.master.on_displaced(rig.now, &Frame::Trigger);
    assert_eq!(motions(&rig), [Motion::Armed, Motion::Rest]);
}

#[test]
fn a_trigger_is_for_the_latest_moves_alone() {
    let mut rig = armed(&[moving(1, 0), moving(2, 0), moving(3, 1)]);
    wants_trigger(&mut rig, 1);
    assert_eq!(rig.cycle(), [Frame::Trigger]);
    // While these move, a third one is started.
    rig.master
        .start_moves(rig.now, &[(2, TO)])
        .expect("a drive that holds");
    wants_load(&mut rig, 3);
    assert_eq!(rig.cycle(), [Frame::Ask(3, LOAD)]);
    rig.says(3, LOAD_SEEN);
    wants_trigger(&mut rig, 3);
    assert_eq!(rig.cycle(), [Frame::Trigger]);
    assert!(rig.every(AxisState::DriveMoving));
    rig.master.on_displaced(rig.now, &Frame::Trigger);
    assert_eq!(
        rig.states(),
        [
            AxisState::DriveMoving,
            AxisState::DriveMoving,
            AxisState::Loaded
        ]
    );
}

#[test]
fn one_drive_of_a_group_may_be_started_by_a_trigger_while_another_holds_or_moves() {
    let mut rig = holding(&[moving(1, 0), moving(2, 0)]);
    for (axis, address) in [(0, 1), (1, 2)] {
        rig.master
            .start_moves(rig.now, &[(axis, TO)])
            .expect("a drive that holds");
        wants_load(&mut rig, address);
        assert_eq!(rig.cycle(), [Frame::Ask(address, LOAD)]);
        rig.says(address, LOAD_SEEN);
        wants_trigger(&mut rig, address);
        assert_eq!(rig.cycle(), [Frame::Trigger]);
        assert_eq!(rig.state(axis), AxisState::DriveMoving);
    }
    // What started before does not wait for the trigger that comes back.
    rig.master.on_displaced(rig.now, &Frame::Trigger);
    assert_eq!(motions(&rig), [Motion::DriveMove, Motion::Armed]);
}

#[test]
fn a_fault_of_one_keeps_all_of_them_from_starting() {
    let mut rig = armed(&[moving(1, 0), moving(2, 0)]);
    rig.fails(2, Fault::Of(Loss::Nothing));
    wants_trigger(&mut rig, 1);
    assert_eq!(rig.cycle(), []);
    assert_eq!(motions(&rig), [Motion::Armed; 2]);
    let refused = rig.master.start_moves(rig.now, &[(0, TO)]);
    assert!(matches!(
        refused,
        Err(MoveError::Command(CommandError::Faulted { axis: 0, .. }))
    ));
    // Power takes a loaded move with it.
    rig.master.disable(rig.now, G);
    rig.cycle();
    rig.cycle();
    rig.all_say(rig.power(false));
    assert_eq!(motions(&rig), [Motion::Rest; 2]);
    assert!(rig.seen(0).calls.contains(&Call::EndMove(rig.now, None)));
    rig.all_say(FINE);
}

#[test]
fn one_drive_that_loses_its_anchor_keeps_the_trigger_from_all() {
    let mut rig = armed(&[moving(1, 0), moving(2, 0)]);
    // Reset by somebody: what it was loaded with is not known any more.
    rig.says(
        2,
        Meaning {
            restarts: true,
            ..Meaning::NONE
        },
    );
    wants_trigger(&mut rig, 1);
    assert_eq!(rig.cycle(), []);
    assert_eq!(rig.state(0), AxisState::Loaded);
}
