//! Which frame goes out when, and what the outcome of each means.

use can_motion::facts::{Class, Power};
use can_motion::family::{CommonFault, Meaning};
use can_motion::{AxisState, BusErrorKind, BusUser, CommonEvent, GroupId, Progress};

use crate::drive::Call;
use crate::family::{Axis, BUS, Bus, Fault, Frame, Kind, ask, axis};
use crate::rig::{FINE, G, Rig, faulted, of_bus};

#[test]
fn each_moving_axis_sends_one_frame_a_cycle_in_order() {
    let mut rig = Rig::streaming(&[axis(3), axis(5), axis(9)]);
    rig.master
        .set_target(1, 25)
        .expect("a target in the travel");
    for value in [10, 20, 25, 25] {
        let sent = [
            Frame::SetPoint(3, 0),
            Frame::SetPoint(5, value),
            Frame::SetPoint(9, 0),
        ];
        assert_eq!(rig.cycle(), sent);
        assert_eq!((rig.send(), rig.progress), (vec![], Progress::Idle));
    }
    assert_eq!(rig.master.cycle_counters().late, 0);
    assert_eq!(rig.events(), []);
}

#[test]
fn switches_off_go_first_and_switches_on_last() {
    let alone = |address| Axis {
        group: address,
        ..axis(address)
    };
    let mut rig = Rig::ready(&[alone(1), alone(2), alone(3)]);
    for group in [1, 3] {
        let enabled = rig.master.enable(rig.now, GroupId(group));
        enabled.expect("a ready drive");
    }
    rig.says(3, FINE);
    rig.cycle();
    rig.cycle();
    rig.says(3, rig.power(true));
    rig.says(1, FINE);
    // What is off for good is not told so again.
    rig.master.disable(rig.now, GroupId(2));
    assert_eq!(rig.power_of(1), Power::Off);
    rig.says(2, rig.power(true));
    rig.master.disable(rig.now, GroupId(2));
    rig.wants(2, ask(7, Class::Poll, 1));
    let sent = [
        Frame::Switch(2, false),
        Frame::SetPoint(3, 0),
        Frame::Switch(1, true),
        Frame::Ask(2, 7),
    ];
    assert_eq!(rig.cycle(), sent);
    let power = [0, 1].map(|axis| rig.power_of(axis));
    assert_eq!(power, [Power::OnSent, Power::OffSent]);
    assert_eq!(rig.send(), []);
}

#[test]
fn what_finds_no_room_is_offered_again() {
    for knows_room in [false, true] {
        let mut rig = Rig::streaming(&[axis(1), axis(2)]);
        rig.can.knows_room = knows_room;
        rig.can.room = 1;
        rig.master.set_target(1, 5).expect("a target in the travel");
        assert_eq!(rig.cycle(), [Frame::SetPoint(1, 0)]);
        assert_eq!(rig.progress, Progress::Blocked);
        assert_eq!((rig.send(), rig.progress), (vec![], Progress::Blocked));
        assert_eq!(rig.seen(1).sent, 0);
        rig.can.room = 1;
        assert_eq!(rig.send(), [Frame::SetPoint(2, 5)]);
        assert_eq!(rig.progress, Progress::Idle);
        assert_eq!(rig.seen(1).sent, 5);
    }
}

#[test]
fn a_full_controller_is_blocked_only_while_something_waits() {
    let mut rig = Rig::ready(&[axis(1)]);
    rig.can.knows_room = true;
    rig.can.room = 0;
    assert_eq!((rig.cycle(), rig.progress), (vec![], Progress::Idle));
    rig.wants(1, ask(1, Class::Poll, 0));
    assert_eq!((rig.cycle(), rig.progress), (vec![], Progress::Blocked));
    rig.wants(1, None);
    assert_eq!((rig.cycle(), rig.progress), (vec![], Progress::Idle));
    rig.says(1, rig.power(true));
    rig.master.disable(rig.now, G);
    assert_eq!((rig.cycle(), rig.progress), (vec![], Progress::Blocked));
    rig.can.room = 1;
    assert_eq!(rig.send(), [Frame::Switch(1, false)]);

    let bus = Bus {
        has_sync: true,
        ..BUS
    };
    let mut rig = Rig::<false>::on(bus, &[axis(1)]);
    rig.can.knows_room = true;
    rig.can.room = 0;
    assert_eq!((rig.cycle(), rig.progress), (vec![], Progress::Blocked));
    rig.can.room = 9;
    assert_eq!(
        (rig.send(), rig.progress),
        (vec![Frame::Sync], Progress::Idle)
    );
}

#[test]
fn the_frame_of_the_bus_goes_once_behind_the_set_points() {
    let bus = Bus {
        has_sync: true,
        ..BUS
    };
    let mut rig = Rig::<false>::on(bus, &[axis(1)]);
    assert_eq!(rig.events(), [(None, Kind::Warned)]);
    rig.all_say(Meaning {
        is_checked: true,
        ..rig.power(false)
    });
    rig.master.enable(rig.now, G).expect("a ready drive");
    rig.all_say(FINE);
    // The switch waits for the frame of the bus.
    assert_eq!(rig.cycle(), [Frame::Sync, Frame::Switch(1, true)]);
    assert_eq!(rig.cycle(), [Frame::Sync]);
    rig.all_say(rig.power(true));
    rig.wants(1, ask(4, Class::Poll, 0));
    assert_eq!(
        rig.cycle(),
        [Frame::SetPoint(1, 0), Frame::Sync, Frame::Ask(1, 4)]
    );
    // One that comes back is owed again.
    rig.master.on_displaced(rig.now, &Frame::Sync);
    assert_eq!(rig.send(), [Frame::Sync]);
    rig.events();
    rig.can.fails = Some(BusErrorKind::Form);
    rig.master.halt(rig.now, G);
    assert_eq!(rig.cycle(), []);
    assert_eq!(
        rig.events()[1..],
        [of_bus(CommonEvent::BusError(BusErrorKind::Form))]
    );
    assert_eq!(rig.send(), []);
}

#[test]
fn a_displaced_set_point_is_owed_again() {
    let mut rig = Rig::streaming(&[axis(1), axis(2)]);
    rig.master
        .set_target(1, 30)
        .expect("a target in the travel");
    rig.cycle();
    rig.can.displaces = Some(Frame::SetPoint(2, 10));
    // The frame of axis 1 displaces that of axis 2, which is due anyway and takes no second step.
    assert_eq!(rig.cycle(), [Frame::SetPoint(1, 0), Frame::SetPoint(2, 10)]);
    rig.master.on_displaced(rig.now, &Frame::SetPoint(2, 10));
    assert_eq!(rig.send(), [Frame::SetPoint(2, 10)]);
    rig.master.halt(rig.now, G);
    rig.master.on_displaced(rig.now, &Frame::SetPoint(2, 10));
    assert_eq!(rig.send(), []);
    assert_eq!(rig.seen(1).sent, 0);
}

#[test]
fn a_displaced_switch_is_sent_again() {
    let mut rig = Rig::ready(&[axis(1)]);
    rig.master.enable(rig.now, G).expect("a ready drive");
    rig.all_say(FINE);
    for _ in 0..2 {
        assert_eq!(rig.cycle(), [Frame::Switch(1, true)]);
        assert_eq!(rig.power_of(0), Power::OnSent);
        rig.master.on_displaced(rig.now, &Frame::Switch(1, true));
        assert_eq!(rig.power_of(0), Power::OnWanted);
    }
    rig.master.disable(rig.now, G);
    assert_eq!((rig.cycle(), rig.power_of(0)), (vec![], Power::Off));
}

#[test]
fn what_nobody_sent_is_reported() {
    let mut rig = Rig::ready(&[axis(1)]);
    let (stranger, here) = (Frame::SetPoint(9, 0), Frame::IsAt(1, 0));
    rig.master.on_displaced(rig.now, &stranger);
    rig.master.on_frame(rig.now, &stranger);
    rig.master.on_displaced(rig.now, &here);
    rig.master.on_displaced(rig.now, &Frame::Sync);
    rig.master.on_foreign_frame(rig.now, "not one of these");
    rig.master.on_receive_error(rig.now, BusErrorKind::Overrun);
    let reported = [
        (None, Kind::Foreign(stranger)),
        (None, Kind::Foreign(stranger)),
        (None, Kind::Foreign(Frame::Sync)),
        (None, Kind::NotOurs("not one of these")),
        of_bus(CommonEvent::BusError(BusErrorKind::Overrun)),
    ];
    assert_eq!(rig.events(), reported);
    assert!(rig.seen(0).calls.contains(&Call::Returned(here)));
}

#[test]
fn a_set_point_that_fails_stops_the_group() {
    let mut rig = Rig::streaming(&[axis(1), axis(2)]);
    rig.can.fails = Some(BusErrorKind::Bit);
    assert_eq!(rig.cycle(), []);
    assert_eq!(
        [0, 1].map(|axis| rig.fault(axis)),
        [
            Some(CommonFault::Bus.into()),
            Some(CommonFault::Group.into())
        ]
    );
    let error = CommonEvent::BusError(BusErrorKind::Bit);
    let events = rig.events();
    assert_eq!(
        events[..2],
        [(Some(0), Kind::Common(error)), faulted(0, CommonFault::Bus)]
    );
    assert_eq!(rig.cycle(), []);
}

#[test]
fn other_frames_that_fail_count_as_sent() {
    let mut rig = Rig::ready(&[axis(1)]);
    rig.wants(1, ask(5, Class::Poll, 0));
    rig.can.fails = Some(BusErrorKind::Bit);
    assert_eq!((rig.cycle(), rig.send()), (vec![], vec![]));
    assert!(matches!(rig.seen(0).calls[..], [.., Call::Asked(5, _)]));
    rig.master.enable(rig.now, G).expect("a ready drive");
    rig.all_say(FINE);
    rig.can.fails = Some(BusErrorKind::Bit);
    assert_eq!((rig.cycle(), rig.power_of(0)), (vec![], Power::OnSent));
    assert_eq!(rig.fault(0), None);
}

#[test]
fn a_set_point_that_must_not_go_out_stops_the_group() {
    let guarded = Axis {
        forbidden: Some(20),
        ..axis(1)
    };
    let mut rig = Rig::streaming(&[guarded, axis(2)]);
    rig.master
        .set_target(0, 30)
        .expect("a target in the travel");
    assert_eq!(rig.cycle(), [Frame::SetPoint(1, 10), Frame::SetPoint(2, 0)]);
    assert_eq!(rig.cycle(), []);
    assert_eq!(rig.fault(0), Some(Fault::OutsideTravel));
    let other = Axis {
        group: 1,
        ..axis(2)
    };
    let mut rig = Rig::ready(&[guarded, other]);
    for group in [0, 1].map(GroupId) {
        rig.master.enable(rig.now, group).expect("a ready drive");
    }
    let mut rig = rig.stream();
    rig.master
        .set_target(0, 30)
        .expect("a target in the travel");
    rig.cycle();
    // An axis of another group is not concerned.
    assert_eq!(rig.cycle(), [Frame::SetPoint(2, 0)]);
}

#[test]
fn what_the_controller_holds_is_taken_back_from_an_axis_that_stops_at_once() {
    let mut rig = Rig::streaming(&[axis(1)]);
    rig.master
        .set_target(0, 30)
        .expect("a target in the travel");
    rig.cycle();
    rig.cycle();
    rig.can.held = vec![Frame::SetPoint(1, 20)];
    // Not while it moves.
    rig.send();
    assert_eq!(rig.can.held.len(), 1);
    rig.master.halt(rig.now, G);
    assert_eq!(rig.send(), []);
    assert_eq!(
        (rig.can.held.len(), rig.seen(0).sent, rig.seen(0).target),
        (0, 10, 10)
    );
    // Once is enough.
    rig.can.held = vec![Frame::SetPoint(1, 10)];
    rig.send();
    assert_eq!(rig.can.held.len(), 1);
}

#[test]
fn drives_with_a_frame_in_every_cycle_are_switched_and_stopped_by_it() {
    let mut rig = Rig::<true>::on(BUS, &[axis(1), axis(2)]);
    // Nothing is known of their power.
    assert_eq!((rig.cycle(), rig.progress), (vec![], Progress::Idle));
    rig.all_say(Meaning {
        is_checked: true,
        ..rig.power(false)
    });
    let stops = [Frame::Stop(1), Frame::Stop(2)];
    assert_eq!(rig.cycle(), stops);
    rig.master.enable(rig.now, G).expect("ready drives");
    rig.all_say(FINE);
    let on = [Frame::Switch(1, true), Frame::Switch(2, true)];
    assert_eq!((rig.cycle(), rig.cycle()), (on.to_vec(), on.to_vec()));
    assert_eq!(rig.power_of(1), Power::OnSent);
    rig.all_say(rig.power(true));
    assert!(rig.every(AxisState::Streaming));
    assert_eq!(rig.cycle(), [Frame::SetPoint(1, 0), Frame::SetPoint(2, 0)]);
    // A stop takes the place of the set-point that is still due.
    rig.can.room = 0;
    rig.cycle();
    rig.can.room = 9;
    rig.master.halt(rig.now, G);
    assert_eq!(rig.send(), stops);
    // It comes back: it is owed in this cycle.
    rig.master.on_displaced(rig.now, &Frame::Stop(2));
    assert_eq!(rig.send(), stops[1..]);
    rig.events();
    // It fails: the next try is the same, and no fault.
    rig.can.fails = Some(BusErrorKind::Crc);
    assert_eq!((rig.cycle(), rig.send()), (vec![], stops.to_vec()));
    let failed = (
        Some(0),
        Kind::Common(CommonEvent::BusError(BusErrorKind::Crc)),
    );
    assert_eq!(rig.events(), [failed]);
    rig.master.disable(rig.now, G);
    let off = [Frame::Switch(1, false), Frame::Switch(2, false)];
    (rig.can.knows_room, rig.can.room) = (true, 0);
    assert_eq!((rig.cycle(), rig.progress), (vec![], Progress::Blocked));
    rig.can.room = 9;
    assert_eq!(rig.send(), off);
    assert_eq!(
        (rig.power_of(0), rig.progress),
        (Power::OffSent, Progress::Idle)
    );
}
