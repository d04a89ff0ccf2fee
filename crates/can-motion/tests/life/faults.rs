//! The bus fails: the controller has no room, nothing gets out, or it is bus-off.

use can_motion::facts::{Knowledge, Loss, Power};
use can_motion::family::CommonFault;
use can_motion::{AxisState, CommandError, CommonEvent, GroupId, Progress, Reaction};

use crate::drive::Call;
use crate::family::{Axis, Fault, Frame, Kind, axis};
use crate::rig::{G, Rig, faulted, of_bus};

const BUS_FAULT: Option<Fault> = Some(Fault::Common(CommonFault::Bus));

#[test]
fn a_controller_without_room_stops_what_is_in_use_after_20_ms() {
    let mut rig = Rig::streaming(&[axis(1)]);
    rig.can.room = 0;
    for _ in 0..19 {
        rig.cycle();
        assert_eq!(rig.fault(0), None);
    }
    // One frame is enough to start anew.
    rig.can.room = 1;
    assert_eq!(rig.send(), [Frame::SetPoint(1, 0)]);
    for _ in 0..19 {
        assert_eq!((rig.cycle(), rig.fault(0)), (vec![], None));
    }
    rig.cycle();
    assert_eq!(rig.fault(0), BUS_FAULT);
    rig.can.room = 9;
    assert_eq!(rig.cycle(), []);
    let facts = rig.seen(0).facts;
    assert_eq!(
        (facts.knowledge, facts.power),
        (Knowledge::Unknown, Power::OnUnconfirmed)
    );
}

#[test]
fn only_axes_that_have_or_want_power_are_stopped_by_a_full_controller() {
    for knows_room in [false, true] {
        let wanting = Axis {
            group: 1,
            ..axis(2)
        };
        let mut rig = Rig::ready(&[axis(1), wanting]);
        rig.can.knows_room = knows_room;
        rig.can.room = 0;
        rig.master
            .enable(rig.now, GroupId(1))
            .expect("a ready drive");
        rig.says(2, crate::rig::FINE);
        assert_eq!((rig.send(), rig.progress), (vec![], Progress::Blocked));
        for _ in 0..19 {
            rig.cycle();
        }
        assert_eq!(rig.fault(1), None);
        rig.cycle();
        assert_eq!([rig.fault(0), rig.fault(1)], [None, BUS_FAULT]);
    }
}

#[test]
fn a_group_whose_frames_never_get_out_stops_after_20_ms() {
    for is_plain in [false, true] {
        let own = |address, group| Axis {
            group,
            is_plain,
            ..axis(address)
        };
        let mut rig = Rig::ready(&[own(1, 0), own(2, 0), own(3, 1)]);
        rig.master.enable(rig.now, G).expect("ready drives");
        let partners = [1, 2];
        for address in partners {
            rig.says(address, crate::rig::FINE);
        }
        rig.cycle();
        rig.cycle();
        for address in partners {
            rig.says(address, rig.power(true));
        }
        rig.cycle();
        rig.events();
        let ticks = rig.seen(0).ticks;
        for _ in 0..19 {
            rig.now = rig.now + 1_000;
            rig.master.begin_cycle(rig.now);
        }
        // A drive that only streams is not called in a cycle.
        assert_eq!(rig.seen(0).ticks - ticks, if is_plain { 0 } else { 19 });
        assert_eq!(rig.states()[..2], [AxisState::Streaming; 2]);
        rig.now = rig.now + 1_000;
        rig.master.begin_cycle(rig.now);
        assert_eq!(
            [rig.fault(0), rig.fault(1), rig.fault(2)],
            [BUS_FAULT, BUS_FAULT, None]
        );
        assert_eq!(rig.send(), []);
    }
}

#[test]
fn the_outage_of_a_ramp_is_no_concern_of_a_partner_that_is_off() {
    let ramps = |address, group| Axis {
        group,
        reaction: Reaction::RampDown,
        ..axis(address)
    };
    let mut rig = Rig::ready(&[ramps(1, 0), ramps(2, 0), ramps(3, 1)]);
    for group in [G, GroupId(1)] {
        rig.master.enable(rig.now, group).expect("ready drives");
    }
    let mut rig = rig.stream();
    rig.master.halt(rig.now, GroupId(1));
    rig.master.set_target(0, 900).expect("in the travel");
    rig.cycle();
    rig.fails(2, Fault::Of(Loss::Drive));
    rig.says(2, rig.power(false));
    rig.master.disable(rig.now, G);
    // It slows down, its goal is off, and nothing of it gets out.
    assert_eq!(
        rig.states(),
        [
            AxisState::RampingDown,
            AxisState::Faulted,
            AxisState::Holding
        ]
    );
    rig.events();
    for _ in 0..20 {
        rig.now = rig.now + 1_000;
        rig.master.begin_cycle(rig.now);
    }
    let is_fault = |kind: &Kind| matches!(kind, Kind::Common(CommonEvent::Fault(_)));
    let mut told = rig.events();
    told.retain(|(_, kind)| is_fault(kind));
    assert_eq!(told, [faulted(0, CommonFault::Bus)]);
    assert_eq!(rig.fault(0), BUS_FAULT);
    assert_eq!(rig.power_of(1), Power::Off);
    assert_eq!(rig.fault(2), None);
}

#[test]
fn drives_that_hold_need_no_frames() {
    let plain = Axis {
        is_plain: true,
        ..axis(1)
    };
    let mut rig = Rig::holding(&[
        plain,
        Axis {
            is_plain: true,
            ..axis(2)
        },
    ]);
    let ticks = rig.seen(0).ticks;
    for _ in 0..1_000 {
        assert_eq!(rig.cycle(), []);
    }
    assert_eq!(rig.seen(0).ticks - ticks, 1_000);
    assert!(rig.every(AxisState::Holding));
}

#[test]
fn some_axes_stream_on_beside_others_that_do_more() {
    let plain = |address, group| Axis {
        group,
        is_plain: true,
        ..axis(address)
    };
    let mut rig = Rig::ready(&[plain(1, 0), plain(2, 1), plain(3, 2)]);
    for group in [1, 2].map(GroupId) {
        rig.master.enable(rig.now, group).expect("ready drives");
    }
    for address in [2, 3] {
        rig.says(address, crate::rig::FINE);
    }
    rig.cycle();
    rig.cycle();
    for address in [2, 3] {
        rig.says(address, rig.power(true));
    }
    let ticks = [0, 1, 2].map(|axis| rig.seen(axis).ticks);
    let sent = [Frame::SetPoint(2, 0), Frame::SetPoint(3, 0)];
    assert_eq!(rig.cycle(), sent);
    rig.master.set_target(1, 20).expect("in the travel");
    assert_eq!(rig.cycle(), [Frame::SetPoint(2, 10), sent[1]]);
    assert_eq!(
        [0, 1, 2].map(|axis| rig.seen(axis).ticks - ticks[axis]),
        [2, 0, 0]
    );
    rig.master.stop(rig.now, GroupId(1));
    assert_eq!(rig.cycle(), [Frame::SetPoint(2, 18), sent[1]]);
    assert_eq!(rig.seen(1).ticks - ticks[1], 1);
    // Without the power or the anchor for it nothing streams on.
    rig.fails(3, Fault::Of(Loss::Contact));
    assert_eq!(rig.cycle(), [Frame::SetPoint(2, 24)]);
    assert_eq!(rig.seen(2).ticks - ticks[2], 1);
}

#[test]
fn bus_off_stops_everything_once() {
    let mut rig = Rig::streaming(&[axis(1), axis(2)]);
    let now = rig.now;
    rig.master.on_bus_recovered(now);
    assert_eq!(rig.events(), []);
    rig.master.on_bus_off(now);
    rig.master.on_bus_off(now);
    let events = rig.events();
    assert_eq!(events[0], of_bus(CommonEvent::BusOff));
    assert_eq!(events[1], faulted(0, CommonFault::Bus));
    let told = events.iter().filter(|event| **event == events[0]).count();
    assert_eq!((told, rig.fault(1)), (1, BUS_FAULT));
    for axis in [0, 1] {
        let told = rig.seen(axis).calls;
        assert_eq!(
            told.iter().filter(|call| **call == Call::Abandon).count(),
            1
        );
    }
    assert_eq!(rig.master.clear(now, G), Err(CommandError::BusOff));
    rig.master.disable(now, G);
    assert_eq!((rig.cycle(), rig.progress), (vec![], Progress::Idle));
    rig.events();
    rig.master.on_bus_recovered(now);
    assert_eq!(rig.events(), [of_bus(CommonEvent::BusRecovered)]);
    assert_eq!(
        rig.send(),
        [Frame::Switch(1, false), Frame::Switch(2, false)]
    );
}
