//! A motion that one drive makes by itself: who may be told, what goes out, and how it ends.

use can_motion::facts::{Class, Goal, Knowledge, Loss, Motion, Work};
use can_motion::family::{Meaning, MoveReport, Wanted};
use can_motion::{
    AxisState, BusUser, CommandError, Confirmation, DriveMove, Master, MoveEnd, MoveError,
    MoveRefusal, Reason,
};

use crate::drive::{Call, MOVE};
use crate::family::{Axis, Fault, Frame, Script, axis};
use crate::rig::{G, Rig, went};

const TO: DriveMove = DriveMove::To(50);

/// An axis whose drive can move by itself.
const fn moving(address: u8) -> Axis {
    Axis {
        moves: true,
        ..axis(address)
    }
}

/// All drives hold, and nothing is left to take back.
fn holding(axes: &[Axis]) -> Rig {
    let mut rig = Rig::holding(axes);
    assert_eq!(rig.send(), []);
    rig
}

/// What the drive says of its motion.
fn ended(end: MoveEnd) -> Meaning<Fault> {
    Meaning {
        own_move: Some(MoveReport::Ended(end)),
        ..Meaning::NONE
    }
}

/// The drive of axis 0 moves by itself.
fn under_way(axes: &[Axis]) -> Rig {
    let mut rig = holding(axes);
    rig.master
        .start_move(rig.now, 0, TO)
        .expect("a drive that holds");
    rig.wants(
        axes[0].address,
        Some(Wanted::urgent(Class::DriveMove, MOVE)),
    );
    assert_eq!(rig.cycle(), [Frame::Ask(axes[0].address, MOVE)]);
    assert_eq!(rig.state(0), AxisState::DriveMoving);
    rig
}

#[test]
fn a_drive_is_told_where_to_go_and_holds_when_it_has_arrived() {
    let mut rig = holding(&[moving(1), moving(2)]);
    let before = rig.times_told(0);
    let at = rig.now;
    rig.master
        .start_move(at, 0, TO)
        .expect("a drive that holds");
    assert_eq!(rig.told_since(0, before), [Call::BeginMove(TO)]);
    rig.wants(1, Some(Wanted::urgent(Class::DriveMove, MOVE)));
    assert_eq!(rig.cycle(), [Frame::Ask(1, MOVE)]);
    let states = [AxisState::DriveMoving, AxisState::Holding];
    assert_eq!(rig.states(), states);
    // No set-point goes beside it.
    assert_eq!(rig.cycle(), []);
    rig.says(1, ended(MoveEnd::Arrived));
    let end = Call::EndMove(rig.now, Some(MoveEnd::Arrived));
    assert_eq!(rig.seen(0).calls.last(), Some(&end));
    let facts = rig.seen(0).facts;
    assert_eq!(
        (facts.goal, facts.motion, facts.knowledge),
        (Goal::Hold, Motion::Rest, Knowledge::Anchored)
    );
    let told = [
        went(0, AxisState::Holding, AxisState::DriveMoving, Reason::Sent),
        went(
            0,
            AxisState::DriveMoving,
            AxisState::Holding,
            Reason::MoveEnded,
        ),
    ];
    assert_eq!(rig.events(), told);
    // The other drive was told nothing of it.
    let is_of_move = |call: &Call| matches!(call, Call::BeginMove(_) | Call::EndMove(..));
    assert!(!rig.seen(1).calls.iter().any(is_of_move));
}

#[test]
fn time_counts_anew_when_the_drive_begins_to_move() {
    let mut rig = holding(&[moving(1)]);
    rig.master
        .start_move(rig.now, 0, TO)
        .expect("a drive that holds");
    rig.cycle();
    rig.wants(1, Some(Wanted::urgent(Class::DriveMove, MOVE)));
    rig.cycle();
    let began = rig.now;
    rig.cycle();
    rig.says(1, Meaning::NONE);
    let heard = Call::Heard(rig.master.cycle_counters().cycles, began);
    assert_eq!(rig.seen(0).calls.last(), Some(&heard));
}

#[test]
fn a_move_that_was_not_told_yet_is_dropped_by_a_stop() {
    let stops: [fn(&mut Rig); 3] = [
        |rig| rig.master.stop(rig.now, G),
        |rig| rig.master.halt(rig.now, G),
        |rig| rig.master.disable(rig.now, G),
    ];
    for stop in stops {
        let mut rig = holding(&[moving(1)]);
        rig.master
            .start_move(rig.now, 0, TO)
            .expect("a drive that holds");
        rig.wants(1, Some(Wanted::urgent(Class::DriveMove, MOVE)));
        stop(&mut rig);
        let end = Call::EndMove(rig.now, None);
        assert!(rig.seen(0).calls.contains(&end));
        assert!(!rig.cycle().contains(&Frame::Ask(1, MOVE)));
    }
}

#[test]
fn a_command_for_a_motion_that_comes_back_is_sent_again_in_the_same_cycle() {
    let mut rig = under_way(&[moving(1)]);
    rig.wants(1, Some(Wanted::urgent(Class::DriveMove, MOVE)));
    rig.master.on_displaced(rig.now, &Frame::Ask(1, MOVE));
    assert_eq!(rig.state(0), AxisState::Holding);
    assert_eq!(rig.seen(0).facts.goal, Goal::Move);
    assert_eq!(rig.send(), [Frame::Ask(1, MOVE)]);
    assert_eq!(rig.state(0), AxisState::DriveMoving);
    // A switch that comes back gives no place to a further request.
    let mut rig = Rig::holding(&[axis(1)]);
    rig.master.disable(rig.now, G);
    assert_eq!(rig.cycle(), [Frame::Switch(1, false)]);
    rig.wants(1, Some(Wanted::urgent(Class::Poll, 1)));
    assert_eq!(rig.cycle(), [Frame::Ask(1, 1)]);
    rig.wants(1, Some(Wanted::urgent(Class::Poll, 2)));
    rig.master.on_displaced(rig.now, &Frame::Switch(1, false));
    assert_eq!(rig.send(), [Frame::Switch(1, false)]);
}

#[test]
fn a_stop_takes_back_what_the_controller_holds_for_the_motion() {
    let mut rig = under_way(&[moving(1)]);
    rig.can.held = vec![Frame::Ask(1, MOVE)];
    rig.send();
    assert_eq!(rig.can.held.len(), 1);
    rig.master.stop(rig.now, G);
    rig.send();
    assert_eq!(rig.can.held, []);
    // It never reached the drive, which holds.
    assert_eq!(rig.state(0), AxisState::Holding);
    let end = Call::EndMove(rig.now, None);
    assert_eq!(rig.seen(0).calls.last(), Some(&end));

    // A motion that has ended leaves nothing to take back.
    let mut rig = under_way(&[moving(1)]);
    rig.can.held = vec![Frame::Ask(1, MOVE)];
    rig.says(1, ended(MoveEnd::Arrived));
    rig.send();
    assert_eq!(rig.can.held.len(), 1);
    // Nor does one that was not told yet.
    let mut rig = holding(&[moving(1)]);
    rig.master
        .start_move(rig.now, 0, TO)
        .expect("a drive that holds");
    rig.can.held = vec![Frame::Ask(1, MOVE)];
    rig.master.stop(rig.now, G);
    rig.send();
    assert_eq!(rig.can.held.len(), 1);
}

#[test]
fn a_stopped_motion_is_stopping_until_the_drive_says_how_it_ended() {
    let mut rig = under_way(&[moving(1)]);
    rig.events();
    rig.master.halt(rig.now, G);
    assert_eq!(rig.state(0), AxisState::DriveStopping);
    assert_eq!(rig.cycle(), []);
    let before = rig.times_told(0);
    rig.says(1, ended(MoveEnd::Elsewhere));
    let end = Call::EndMove(rig.now, Some(MoveEnd::Elsewhere));
    assert_eq!(rig.told_since(0, before).last(), Some(&end));
    assert_eq!(rig.state(0), AxisState::AwaitingStandstill);
    assert_eq!(rig.seen(0).facts.goal, Goal::Hold);
}

#[test]
fn only_a_drive_that_holds_and_has_nothing_else_to_do_is_told_to_move() {
    let mut rig = Rig::streaming(&[moving(1)]);
    let state = CommandError::State {
        axis: 0,
        expected: AxisState::Holding,
        actual: AxisState::Streaming,
    };
    let refused = rig.master.start_move(rig.now, 0, TO);
    assert_eq!(refused, Err(state.into()));
    let nobody = MoveError::NoSuchAxis { axes: 1, actual: 1 };
    assert_eq!(rig.master.start_move(rig.now, 1, TO), Err(nobody));

    let mut rig = holding(&[moving(1), axis(2)]);
    let (now, before) = (rig.now, [0, 1].map(|axis| rig.times_told(axis)));
    let unsupported = MoveError::Refused {
        axis: 1,
        refusal: MoveRefusal::Unsupported,
    };
    assert_eq!(rig.master.start_move(now, 1, TO), Err(unsupported));
    let travel = MoveError::Refused {
        axis: 0,
        refusal: MoveRefusal::Travel {
            min: 0,
            max: 1_000,
            actual: 1_001,
        },
    };
    let refused = rig.master.start_move(now, 0, DriveMove::To(1_001));
    assert_eq!(refused, Err(travel));
    // A procedure that only reads is no reason to refuse set-points, but a motion of the drive.
    let given = Confirmation::Given;
    rig.master
        .start(now, 0, Work::Read, given)
        .expect("a drive that answers");
    let busy = CommandError::Busy { axis: 0 };
    assert_eq!(rig.master.start_move(now, 0, TO), Err(busy.into()));
    rig.master.resume(now, G).expect("drives that hold");
    rig.master.halt(now, G);
    rig.says(
        1,
        Meaning {
            work_ended: true,
            ..Meaning::NONE
        },
    );
    rig.master.on_bus_off(now);
    let refused = rig.master.start_move(now, 0, TO);
    assert_eq!(refused, Err(CommandError::BusOff.into()));
    let refused = rig.master.start_moves(now, &[(0, TO)]);
    assert_eq!(refused, Err(CommandError::BusOff.into()));
    let is_begun = |call: &Call| matches!(call, Call::BeginMove(_));
    for axis in [0, 1] {
        assert!(!rig.told_since(axis, before[axis]).iter().any(is_begun));
    }
    // Without a trigger a drive may do more.
    let mut rig = holding(&[moving(1)]);
    let started = rig.master.start_move(rig.now, 0, DriveMove::Speed(9));
    assert_eq!(started, Ok(()));
}

#[test]
fn nothing_of_a_group_moves_while_one_of_it_has_a_fault() {
    let soft = Fault::Of(Loss::Nothing);
    let partner = Axis {
        group: 1,
        ..moving(3)
    };
    let mut rig = Rig::ready(&[moving(1), axis(2), partner]);
    for group in [0, 1].map(can_motion::GroupId) {
        rig.master.enable(rig.now, group).expect("ready drives");
    }
    let mut rig = rig.stream();
    for group in [0, 1].map(can_motion::GroupId) {
        rig.master.halt(rig.now, group);
    }
    // Only axis 1 keeps its fault.
    rig.master.disable(rig.now, G);
    let off = rig.cycle();
    assert_eq!(off, [Frame::Switch(1, false), Frame::Switch(2, false)]);
    rig.cycle();
    for address in [1, 2] {
        rig.says(address, rig.power(false));
    }
    rig.fails(2, soft);
    assert_eq!((rig.fault(0), rig.fault(1)), (None, Some(soft)));
    // The drive of another group is not concerned.
    let started = rig.master.start_move(rig.now, 2, TO);
    assert_eq!(started, Ok(()));
    rig.says(1, rig.power(true));
    rig.master.adopt(rig.now, G).expect("a drive found on");
    rig.says(1, crate::rig::FINE);
    assert_eq!(rig.state(0), AxisState::Holding);
    let faulted = CommandError::Faulted {
        axis: 1,
        fault: soft,
    };
    let refused = rig.master.start_move(rig.now, 0, TO);
    assert_eq!(refused, Err(faulted.into()));
}

#[test]
fn a_master_without_axes_moves_none() {
    let mut master = Master::<3, Script<false>>::vacant();
    let now = can_motion::Instant::default();
    let nobody = MoveError::NoSuchAxis { axes: 0, actual: 2 };
    assert_eq!(master.start_move(now, 2, TO), Err(nobody));
    let together = master.start_moves(now, &[(2, TO)]);
    assert_eq!(together, Err(MoveError::NotTogether));
}
