//! What happens to an axis because of its group: stops, ramps, and the reaction to a fault of a partner.

use can_motion::facts::{Class, Knowledge, Latch, Loss, Power};
use can_motion::family::{CommonFault, Meaning, ValueLimits};
use can_motion::{AxisState, CommonEvent, GroupId, Reaction, Reason};

use crate::drive::Call;
use crate::family::{Axis, Fault, Frame, Kind, axis};
use crate::rig::{FINE, G, Rig, faulted, went};

const SOFT: Fault = Fault::Of(Loss::Nothing);
const OTHER: GroupId = GroupId(1);

/// Axes 0 and 1 of group 0 and axis 2 of group 1, all streaming, with steps of 10, 4 and 10.
fn two_groups(reaction: Reaction) -> Rig {
    let in_group = |address, group| Axis {
        group,
        reaction,
        ..axis(address)
    };
    let mut rig = Rig::ready(&[in_group(1, 0), in_group(2, 0), in_group(3, 1)]);
    for group in [G, OTHER] {
        rig.master.enable(rig.now, group).expect("ready drives");
    }
    let mut rig = rig.stream();
    for target in [10, 20] {
        rig.master.set_target(0, target).expect("in the travel");
        rig.master
            .set_target(1, target / 10 * 4)
            .expect("in the travel");
        rig.master.set_target(2, target).expect("in the travel");
        rig.cycle();
    }
    rig.forget()
}

#[test]
fn a_group_streams_only_when_all_of_it_can() {
    let mut rig = Rig::ready(&[
        axis(1),
        axis(2),
        Axis {
            group: 1,
            ..axis(3)
        },
    ]);
    rig.master.enable(rig.now, G).expect("ready drives");
    rig.says(1, FINE);
    rig.cycle();
    rig.cycle();
    rig.says(1, rig.power(true));
    rig.says(3, FINE);
    let states = [AxisState::Holding, AxisState::Probing, AxisState::Ready];
    assert_eq!(rig.states(), states);
    rig.says(2, FINE);
    assert_eq!(rig.cycle(), [Frame::Switch(2, true)]);
    rig.cycle();
    rig.says(2, rig.power(true));
    rig.says(1, Meaning::NONE);
    // For the first one it is news too.
    let heard = Call::Heard(rig.master.cycle_counters().cycles, rig.now);
    assert_eq!(rig.seen(0).calls.last(), Some(&heard));
    let states = [AxisState::Streaming, AxisState::Streaming, AxisState::Ready];
    assert_eq!(rig.states(), states);
    assert!(rig.master.all_are(G, AxisState::Streaming));
    assert!(!rig.master.all_are(OTHER, AxisState::Streaming));
    assert!(rig.master.all_are(OTHER, AxisState::Ready));
    assert!(!rig.master.all_are(GroupId(7), AxisState::Ready));
}

#[test]
fn a_stop_slows_the_group_down_together_and_then_holds() {
    let mut rig = two_groups(Reaction::Halt);
    let before = [0, 1].map(|axis| rig.times_told(axis));
    rig.master.stop(rig.now, G);
    rig.can.held = vec![Frame::SetPoint(1, 20)];
    // Steps of 10 that change by 2; the steps of 4 would be through in 2 cycles.
    let ramp = [Call::BeginRamp(5)];
    assert_eq!(
        [0, 1].map(|axis| rig.told_since(axis, before[axis])),
        [ramp; 2]
    );
    assert!(rig.master.all_are(G, AxisState::RampingDown));
    let mut values = Vec::new();
    while rig.state(0) == AxisState::RampingDown {
        for frame in rig.cycle() {
            values.extend(matches!(frame, Frame::SetPoint(1, _)).then_some(frame));
        }
    }
    let ramp = [28, 34, 38, 40].map(|value| Frame::SetPoint(1, value));
    assert_eq!(values, ramp);
    assert_eq!(
        rig.told_since(0, before[0])[1..],
        [Call::EndMotion { by_ramp: true }]
    );
    assert_eq!(
        rig.states(),
        [AxisState::Holding, AxisState::Holding, AxisState::Streaming]
    );
    // A ramp ends with nothing left to take back.
    assert_eq!(rig.can.held.len(), 1);
    let stopped = rig.events();
    let by_ramp = went(
        0,
        AxisState::RampingDown,
        AxisState::Holding,
        Reason::Standstill,
    );
    assert_eq!(stopped.len(), 4);
    assert_eq!(stopped[2], by_ramp);
}

#[test]
fn the_ramp_of_a_group_does_not_depend_on_another_group() {
    let mut rig = two_groups(Reaction::RampDown);
    rig.master.halt(rig.now, G);
    rig.master.resume(rig.now, G).expect("drives that hold");
    let before = rig.times_told(0);
    rig.master.stop(rig.now, G);
    assert_eq!(rig.told_since(0, before), [Call::BeginRamp(0)]);
    assert_eq!(rig.state(2), AxisState::Streaming);
}

#[test]
fn a_halt_ends_set_points_at_once_in_its_group_alone() {
    let mut rig = two_groups(Reaction::RampDown);
    let before = rig.times_told(0);
    rig.can.room = 0;
    rig.cycle();
    rig.master.halt(rig.now, G);
    rig.can.room = usize::MAX;
    assert_eq!(rig.send(), [Frame::SetPoint(3, 20)]);
    let ended = [Call::EndMotion { by_ramp: false }];
    assert_eq!(rig.told_since(0, before), ended);
    assert_eq!(rig.cycle(), [Frame::SetPoint(3, 20)]);
    assert_eq!(rig.master.cycle_counters().late, 0);
    // What moves by itself on its way to the latest set-point is stopped too.
    rig.master.halt(rig.now, G);
    assert_eq!(rig.told_since(0, before), [ended, ended].concat());
    rig.master.stop(rig.now, G);
    assert_eq!(rig.told_since(0, before).len(), 2);
}

#[test]
fn commands_that_change_nothing_tell_nobody() {
    let mut rig = Rig::ready(&[axis(1), axis(2)]);
    let (changes, told) = (rig.master.changes(), rig.times_told(0));
    assert_eq!(changes, 4);
    rig.master.halt(rig.now, G);
    rig.master.stop(rig.now, G);
    rig.master.disable(rig.now, G);
    assert_eq!((rig.master.changes(), rig.times_told(0)), (changes, told));
    assert_eq!((rig.cycle(), rig.events()), (vec![], vec![]));
}

#[test]
fn a_fault_with_halt_stops_the_group_at_once_and_no_other() {
    let mut rig = two_groups(Reaction::Halt);
    let before = rig.times_told(0);
    rig.fails(2, SOFT);
    assert_eq!(rig.fault(0), Some(CommonFault::Group.into()));
    assert_eq!(rig.seen(0).facts.latch, Latch::Group);
    assert_eq!(rig.fault(1), Some(SOFT));
    assert_eq!(rig.fault(2), None);
    assert_eq!(rig.cycle(), [Frame::SetPoint(3, 20)]);
    let fault = Reason::Fault;
    let events = [
        faulted(1, SOFT),
        went(1, AxisState::Streaming, AxisState::Faulted, fault),
        faulted(0, CommonFault::Group),
        went(0, AxisState::Streaming, AxisState::Faulted, fault),
    ];
    assert_eq!(rig.events(), events);
    assert_eq!([0, 1].map(|axis| rig.power_of(axis)), [Power::On; 2]);
    // What happens to the first one later is no further fault of the group.
    let ended = [Call::EndMotion { by_ramp: false }];
    assert_eq!(rig.told_since(0, before), ended);
    rig.says(2, rig.power(false));
    assert_eq!(rig.told_since(0, before), ended);
    // Nor is a command to one with a fault of its group a new fault.
    rig.events();
    rig.master.disable(rig.now, G);
    let off = went(0, AxisState::Faulted, AxisState::Disabling, Reason::Command);
    assert_eq!(rig.events(), [off]);
}

#[test]
fn a_second_fault_is_told_and_the_first_one_stays() {
    let mut rig = two_groups(Reaction::Halt);
    rig.fails(2, SOFT);
    rig.events();
    rig.fails(2, SOFT);
    assert_eq!(rig.events(), []);
    let worse = Fault::Of(Loss::Knowledge);
    let before = rig.times_told(0);
    rig.fails(2, worse);
    assert_eq!(rig.events(), [faulted(1, worse)]);
    assert_eq!(rig.fault(1), Some(SOFT));
    // It goes to the group again: what moves by itself is stopped.
    assert_eq!(
        rig.told_since(0, before),
        [Call::EndMotion { by_ramp: false }]
    );
    assert_eq!(rig.seen(1).facts.knowledge, Knowledge::Unknown);
}

#[test]
fn a_fault_with_a_ramp_slows_the_group_down_together() {
    let mut rig = two_groups(Reaction::RampDown);
    let before = [0, 1].map(|axis| rig.times_told(axis));
    rig.fails(2, SOFT);
    for axis in [0, 1] {
        let told = rig.told_since(axis, before[axis]);
        assert_eq!(told.last(), Some(&Call::BeginRamp(5)));
    }
    assert!(rig.master.all_are(G, AxisState::RampingDown));
    for _ in 0..6 {
        rig.cycle();
    }
    assert!(rig.master.all_are(G, AxisState::Faulted));
    assert_eq!(rig.power_of(0), Power::On);
    // A drive that lost its anchor cannot slow down on its path; its partner can.
    let mut rig = two_groups(Reaction::RampDown);
    rig.fails(2, Fault::Of(Loss::Anchor));
    assert_eq!(
        rig.states()[..2],
        [AxisState::RampingDown, AxisState::Faulted]
    );
}

#[test]
fn no_ramp_leaves_the_travel() {
    let near_the_end = Axis {
        reaction: Reaction::RampDown,
        limits: ValueLimits::new(0, 30, 10, 2),
        ..axis(2)
    };
    let faster = Axis {
        reaction: Reaction::RampDown,
        ..axis(1)
    };
    let start = || {
        let mut rig = Rig::streaming(&[faster, near_the_end]);
        for axis in [0, 1] {
            rig.master.set_target(axis, 30).expect("in the travel");
        }
        rig.cycle();
        rig.cycle();
        rig.forget()
    };
    let mut rig = start();
    let before = rig.times_told(0);
    rig.master.stop(rig.now, G);
    assert!(rig.master.all_are(G, AxisState::Holding));
    assert_eq!(
        rig.told_since(0, before),
        [Call::EndMotion { by_ramp: false }]
    );
    let mut rig = start();
    rig.fails(1, SOFT);
    assert!(rig.master.all_are(G, AxisState::Faulted));
    assert_eq!(rig.cycle(), []);
    // Where only the one with the fault would leave its travel, the other one can slow down.
    let mut rig = start();
    rig.fails(2, SOFT);
    assert_eq!(rig.states(), [AxisState::RampingDown, AxisState::Faulted]);
    assert_eq!(rig.cycle(), [Frame::SetPoint(1, 28)]);
}

#[test]
fn a_fault_that_disables_spares_what_was_not_in_use() {
    let mut rig = two_groups(Reaction::Disable);
    rig.fails(2, SOFT);
    let off = [Frame::Switch(1, false), Frame::Switch(2, false)];
    assert_eq!(rig.cycle(), [off[0], off[1], Frame::SetPoint(3, 20)]);
    // Neither the drive with the fault nor its partner is switched off when it was found on.
    for faulty in [1, 2] {
        let disables = |address| Axis {
            reaction: Reaction::Disable,
            ..axis(address)
        };
        let mut rig = Rig::ready(&[disables(1), disables(2)]);
        rig.says(2, rig.power(true));
        rig.fails(faulty, SOFT);
        assert_eq!((rig.cycle(), rig.power_of(1)), (vec![], Power::FoundOn));
    }
    // Nor is power taken where the reaction is another.
    let mut rig = two_groups(Reaction::Halt);
    rig.fails(2, Fault::Of(Loss::Anchor));
    assert_eq!([0, 1].map(|axis| rig.power_of(axis)), [Power::On; 2]);
}

#[test]
fn power_that_goes_stops_the_partners() {
    let mut rig = two_groups(Reaction::Halt);
    rig.says(1, rig.power(false));
    assert_eq!(
        rig.states(),
        [AxisState::Faulted, AxisState::Faulted, AxisState::Streaming]
    );
    assert_eq!(rig.fault(1), Some(CommonFault::Group.into()));
    assert_eq!(rig.cycle(), [Frame::SetPoint(3, 20)]);
}

#[test]
fn a_drive_that_is_lost_is_told_once_and_shown_until_it_answers() {
    let lost = CommonFault::Lost;
    let mut rig = Rig::ready(&[axis(1)]);
    rig.fails(1, lost.into());
    assert_eq!(rig.events()[0], faulted(0, lost));
    assert_eq!(rig.events(), []);
    rig.says(1, Meaning::NONE);
    assert_eq!(rig.seen(0).calls.last(), Some(&Call::WasLost));
    rig.says(1, rig.power(false));
    rig.says(1, Meaning::NONE);
    assert_ne!(rig.seen(0).calls.last(), Some(&Call::WasLost));
    // A fault before it does not hide it.
    rig.fails(1, Fault::Of(Loss::Contact));
    rig.events();
    rig.fails(1, lost.into());
    assert_eq!(rig.events(), [faulted(0, lost)]);
    assert_eq!(rig.fault(0), Some(lost.into()));
    rig.master
        .clear(rig.now, G)
        .expect("a drive without a load");
    rig.says(1, Meaning::NONE);
    assert_ne!(rig.seen(0).calls.last(), Some(&Call::WasLost));
    rig.fails(1, Fault::Of(Loss::Contact));
    rig.says(1, Meaning::NONE);
    assert_ne!(rig.seen(0).calls.last(), Some(&Call::WasLost));
}

#[test]
fn what_wants_a_switch_is_not_forgotten_for_another() {
    let mut rig = two_groups(Reaction::Halt);
    for group in [G, OTHER] {
        rig.master.halt(rig.now, group);
        rig.master.disable(rig.now, group);
    }
    rig.can.room = 2;
    assert_eq!(
        rig.cycle(),
        [Frame::Switch(1, false), Frame::Switch(2, false)]
    );
    rig.can.room = 2;
    assert_eq!(rig.send(), [Frame::Switch(3, false)]);
    assert!(!rig.master.may_leave(2, Class::SetPoint));
    assert!(rig.master.may_leave(2, Class::SwitchOff));
    assert!(!rig.master.may_leave(3, Class::Poll));
    let told = rig.events();
    let known = |kind: &Kind| matches!(kind, Kind::Common(CommonEvent::State { .. }));
    assert!(told.iter().all(|(_, kind)| known(kind)));
}
