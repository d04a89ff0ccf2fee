//! Commands of the application, and the reason of each refusal.

use can_motion::facts::{Brake, Loss, Work};
use can_motion::family::{Family, Meaning, ProcedureRefusal};
use can_motion::{AxisState, CommandError, Confirmation, GroupId, Master, Reason, TargetError};

use crate::drive::Call;
use crate::family::{Axis, BUS, Fault, Frame, Kind, Script, axis};
use crate::rig::{G, Rig, went};

const SOFT: Fault = Fault::Of(Loss::Nothing);

fn wrong_state(
    axis: u8,
    expected: AxisState,
    actual: AxisState,
) -> Result<(), CommandError<Fault>> {
    Err(CommandError::State {
        axis,
        expected,
        actual,
    })
}

#[test]
fn a_refused_command_says_what_it_needs_and_changes_nothing() {
    let mut rig = Rig::ready(&[
        Axis {
            group: 1,
            ..axis(1)
        },
        axis(2),
        axis(3),
    ]);
    let now = rig.now;
    let changes = rig.master.changes();
    let resumed = rig.master.resume(now, G);
    assert_eq!(
        resumed,
        wrong_state(1, AxisState::Holding, AxisState::Ready)
    );
    let adopted = rig.master.adopt(now, G);
    assert_eq!(
        adopted,
        wrong_state(1, AxisState::FoundOn, AxisState::Ready)
    );
    let nowhere = GroupId(9);
    let nobody = Err(CommandError::NoSuchGroup(nowhere));
    assert_eq!(rig.master.adopt(now, nowhere), nobody);
    assert_eq!(rig.master.enable(now, nowhere), nobody);
    assert_eq!(rig.master.changes(), changes);
    // One of them is refused: none follows.
    rig.says(3, rig.power(true));
    let enabled = rig.master.enable(now, G);
    assert_eq!(
        enabled,
        wrong_state(2, AxisState::Ready, AxisState::FoundOn)
    );
    assert_eq!(rig.state(1), AxisState::Ready);
    rig.fails(2, SOFT);
    let faulted = Err(CommandError::Faulted {
        axis: 1,
        fault: SOFT,
    });
    assert_eq!(rig.master.enable(now, G), faulted);
    assert_eq!(rig.state(0), AxisState::Ready);
    // A drive that was found on and cannot be taken over.
    rig.fails(3, Fault::Of(Loss::Anchor));
    rig.master.clear(now, G).expect("drives that hold nothing");
    let adopted = rig.master.adopt(now, G);
    assert_eq!(
        adopted,
        wrong_state(2, AxisState::FoundOn, AxisState::Probing)
    );
}

#[test]
fn clear_needs_an_axis_at_rest_whose_hold_is_known() {
    let mut rig = Rig::streaming(&[axis(1)]);
    let now = rig.now;
    let cleared = rig.master.clear(now, G);
    assert_eq!(
        cleared,
        wrong_state(0, AxisState::Faulted, AxisState::Streaming)
    );
    rig.fails(1, Fault::Of(Loss::Contact));
    let unclear = Err(CommandError::Unclear { axis: 0 });
    assert_eq!(rig.master.clear(now, G), unclear);
    rig.says(1, rig.power(true));
    let before = rig.times_told(0);
    rig.master.clear(now, G).expect("a drive that holds");
    assert_eq!(
        rig.told_since(0, before),
        [Call::StartOver { is_cleared: true }]
    );
    assert_eq!((rig.state(0), rig.fault(0)), (AxisState::Probing, None));
    let checked_anew = went(0, AxisState::Faulted, AxisState::Probing, Reason::Command);
    assert_eq!(rig.events().last(), Some(&checked_anew));
}

#[test]
fn clear_without_a_fault_checks_nothing_anew() {
    let mut rig = Rig::ready(&[axis(1)]);
    let before = rig.times_told(0);
    rig.master.clear(rig.now, G).expect("an axis at rest");
    assert_eq!(rig.told_since(0, before), []);
    // A change of a drive that is still being checked does not begin the checks again.
    let mut rig = Rig::new(&[axis(1)]);
    rig.says(1, rig.power(false));
    assert_eq!(rig.told_since(0, 1), []);
}

#[test]
fn a_drive_that_must_be_switched_off_and_on_is_not_when_a_load_hangs_on_it() {
    let rearms = Axis {
        rearms: true,
        ..axis(1)
    };
    let mut rig = Rig::holding(&[rearms]);
    rig.master.resume(rig.now, G).expect("a drive that holds");
    assert_eq!(rig.cycle(), [Frame::Switch(1, false)]);
    let mut rig = Rig::holding(&[rearms]);
    rig.master.enable(rig.now, G).expect("a drive that holds");
    assert_eq!(rig.cycle(), [Frame::Switch(1, false)]);
    let mut rig = Rig::holding(&[axis(1)]);
    rig.master.enable(rig.now, G).expect("a drive that holds");
    assert_eq!(rig.state(0), AxisState::Streaming);

    let with_brake = Axis {
        brake: Brake::Unclear,
        ..rearms
    };
    let mut rig = Rig::ready(&[with_brake]);
    rig.master.enable(rig.now, G).expect("a ready drive");
    let mut rig = {
        rig.brake(1, Brake::Open);
        rig.stream()
    };
    let now = rig.now;
    let resumed = rig.master.resume(now, G);
    assert_eq!(
        resumed,
        wrong_state(0, AxisState::Holding, AxisState::Streaming)
    );
    rig.master.halt(now, G);
    let falls = Err(CommandError::LoadCanFall { axis: 0 });
    assert_eq!(rig.master.resume(now, G), falls);
    assert_eq!(rig.master.enable(now, G), falls);
    assert_eq!((rig.state(0), rig.cycle()), (AxisState::Holding, vec![]));
    rig.says(
        1,
        Meaning {
            restarts: true,
            is_checked: true,
            ..Meaning::NONE
        },
    );
    let unclear = rig.state(0);
    let enabled = rig.master.enable(now, G);
    assert_eq!(enabled, wrong_state(0, AxisState::Ready, unclear));
    // Nor is a brake the reason where there is none.
    let mut rig = Rig::holding(&[rearms]);
    rig.says(
        1,
        Meaning {
            restarts: true,
            ..rig.power(true)
        },
    );
    let enabled = rig.master.enable(rig.now, G);
    assert_eq!(
        enabled,
        wrong_state(0, AxisState::Holding, AxisState::Probing)
    );
    // Without such a need a brake is no reason.
    let mut rig = Rig::ready(&[Axis {
        brake: Brake::Unclear,
        ..axis(1)
    }]);
    let resumed = rig.master.resume(rig.now, G);
    assert_eq!(
        resumed,
        wrong_state(0, AxisState::Holding, AxisState::Ready)
    );
}

#[test]
fn targets_are_taken_while_streaming_within_the_travel() {
    let mut rig = Rig::holding(&[axis(1)]);
    let state = AxisState::Holding;
    assert_eq!(
        rig.master.set_target(0, 5),
        Err(TargetError::NotStreaming { state })
    );
    let nobody = TargetError::NoSuchAxis { axes: 1, actual: 1 };
    assert_eq!(rig.master.set_target(1, 5), Err(nobody));
    rig.master.resume(rig.now, G).expect("a drive that holds");
    let outside = TargetError::Travel {
        min: 0,
        max: 1_000,
        actual: 1_001,
    };
    assert_eq!(rig.master.set_target(0, 1_001), Err(outside));
    assert_eq!(rig.master.set_target(0, 5), Ok(()));
    assert_eq!(rig.cycle(), [Frame::SetPoint(1, 5)]);
}

#[test]
fn a_procedure_needs_a_fitting_axis_and_no_other_under_way() {
    let mut rig = Rig::ready(&[axis(1)]);
    let (now, given) = (rig.now, Confirmation::Given);
    let nobody = ProcedureRefusal::NoSuchAxis { actual: 3 };
    assert_eq!(rig.master.start(now, 3, Work::Read, given), Err(nobody));
    // The drive's own reason.
    let asked = ProcedureRefusal::NoSuchAxis { actual: 99 };
    assert_eq!(
        rig.master.start(now, 0, Work::Read, Confirmation::None),
        Err(asked)
    );
    rig.master
        .start(now, 0, Work::Write, given)
        .expect("a ready drive");
    let begun = Some(Call::BeginWork(Work::Write));
    assert_eq!(rig.seen(0).calls.last().copied(), begun);
    let busy = Err(ProcedureRefusal::Busy);
    assert_eq!(rig.master.start(now, 0, Work::Read, given), busy);
    let enabled = rig.master.enable(now, G);
    assert_eq!(enabled, Err(CommandError::Busy { axis: 0 }));
    assert_eq!(
        rig.master.clear(now, G),
        Err(CommandError::Busy { axis: 0 })
    );
    rig.says(
        1,
        Meaning {
            work_ended: true,
            ..Meaning::NONE
        },
    );
    let told = rig.seen(0).calls;
    // What was written is checked anew; its end is no abort.
    assert!(!told.contains(&Call::AbortWork));
    assert_eq!(told.last(), Some(&Call::StartOver { is_cleared: false }));
    let mut rig = Rig::holding(&[axis(1)]);
    let actual = AxisState::Holding;
    let refused = Err(ProcedureRefusal::State { actual });
    assert_eq!(rig.master.start(rig.now, 0, Work::Repair, given), refused);
    assert!(!rig.seen(0).calls.contains(&Call::BeginWork(Work::Repair)));
}

#[test]
fn a_fault_ends_a_procedure_unless_it_is_the_one_that_is_repaired() {
    let mut rig = Rig::ready(&[axis(1)]);
    let (now, given) = (rig.now, Confirmation::Given);
    rig.master
        .start(now, 0, Work::Read, given)
        .expect("a ready drive");
    let before = rig.times_told(0);
    rig.says(1, rig.power(true));
    rig.says(1, rig.power(false));
    assert_eq!(rig.seen(0).facts.work, Work::Read);
    assert!(!rig.told_since(0, before).contains(&Call::AbortWork));
    rig.fails(1, SOFT);
    assert_eq!(rig.seen(0).facts.work, Work::None);
    assert!(rig.told_since(0, before).contains(&Call::AbortWork));
    assert!(rig.events().contains(&(Some(0), Kind::WorkAborted)));
    rig.master
        .start(now, 0, Work::Repair, given)
        .expect("a drive without power");
    let changes = rig.master.changes();
    rig.fails(1, SOFT);
    assert_eq!(rig.seen(0).facts.work, Work::Repair);
    assert_eq!((rig.events(), rig.master.changes()), (vec![], changes));
    rig.says(
        1,
        Meaning {
            work_ended: true,
            ..Meaning::NONE
        },
    );
    assert_eq!(rig.events(), []);
}

#[test]
fn a_master_takes_on_other_axes_with_nothing_left_of_the_old_ones() {
    let mut rig = Rig::streaming(&[axis(1), axis(2)]);
    rig.can.room = 0;
    rig.cycle();
    rig.master.on_bus_off(rig.now);
    let few = [axis(7)];
    let plan = Script::<false>::plan(&BUS, &few);
    rig.master.take_on(&plan).expect("one axis");
    assert_eq!(
        (rig.master.state(0), rig.master.state(1)),
        (Some(AxisState::PowerOn), None)
    );
    assert_eq!(rig.events(), []);
    rig.can.room = 9;
    assert_eq!(rig.cycle(), []);
    // The old address is nobody's.
    rig.fails(2, SOFT);
    assert_eq!(rig.events().len(), 1);
    rig.fails(7, SOFT);
    assert_eq!(rig.fault(0), Some(SOFT));
    assert_eq!(rig.master.cycle_counters().cycles, 1);

    let many = [axis(1), axis(2), axis(3), axis(4)];
    let plan = Script::<false>::plan(&BUS, &many);
    assert_eq!(rig.master.take_on(&plan), Err("room for 3".to_owned()));
    assert_eq!(rig.fault(0), Some(SOFT));
    assert!(Master::<3, Script<false>>::new(BUS, &many).is_err());
}
