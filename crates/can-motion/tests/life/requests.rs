//! Requests: which drive is asked next, how many a cycle, where among the frames, and until when nobody is.

use can_motion::facts::{Class, Loss, Work};
use can_motion::family::{Meaning, Wanted};
use can_motion::plan::ResponseWindow;
use can_motion::{AxisState, BusUser, Progress};

use crate::drive::Call;
use crate::family::{Axis, BUS, Bus, Fault, Frame, Place, ask, axis};
use crate::rig::{FINE, G, Rig};

fn three(bus: Bus) -> Rig {
    Rig::on(bus, &[axis(1), axis(2), axis(3)])
}

/// All are asked for a poll that is due for so many cycles.
fn all_want(rig: &mut Rig, overdue: [i32; 3]) {
    for (address, overdue) in (1..).zip(overdue) {
        rig.wants(address, ask(address, Class::Poll, overdue));
    }
}

/// The same axes streaming.
fn three_streaming(bus: Bus, axes: [Axis; 3]) -> Rig {
    let mut rig = Rig::on(bus, &axes);
    rig.all_say(Meaning {
        is_checked: true,
        ..rig.power(false)
    });
    rig.master.enable(rig.now, G).expect("ready drives");
    rig.stream()
}

#[test]
fn the_longest_due_goes_first_and_equals_take_turns() {
    let mut rig = three(BUS);
    all_want(&mut rig, [0, 2, 1]);
    assert_eq!(rig.cycle(), [Frame::Ask(2, 2)]);
    assert_eq!(rig.send(), []);
    assert_eq!(rig.cycle(), [Frame::Ask(3, 3)]);
    assert_eq!(rig.cycle(), [Frame::Ask(1, 1)]);
    assert_eq!(rig.cycle(), []);
    let mut asked = Vec::new();
    for _ in 0..6 {
        all_want(&mut rig, [5; 3]);
        asked.extend(rig.cycle());
    }
    let turns = [2, 3, 1, 2, 3, 1].map(|address| Frame::Ask(address, address));
    assert_eq!(asked, turns);
    // Nobody is asked before it is due.
    all_want(&mut rig, [-1, -1, -1]);
    assert_eq!(rig.cycle(), []);
    all_want(&mut rig, [-1, 0, -1]);
    assert_eq!(rig.cycle(), [Frame::Ask(2, 2)]);
}

#[test]
fn urgent_goes_before_every_poll() {
    let mut rig = three(BUS);
    all_want(&mut rig, [1_000_000, 3, i32::MAX - 1]);
    rig.wants(2, Some(Wanted::urgent(Class::Reading, 8)));
    assert_eq!(rig.cycle(), [Frame::Ask(2, 8)]);
    assert_eq!(rig.cycle(), [Frame::Ask(3, 3)]);
}

#[test]
fn no_more_are_asked_in_a_cycle_than_it_has_requests() {
    let mut rig = three(Bus { requests: 2, ..BUS });
    all_want(&mut rig, [1; 3]);
    assert_eq!(rig.cycle(), [Frame::Ask(1, 1), Frame::Ask(2, 2)]);
    assert_eq!(rig.cycle(), [Frame::Ask(3, 3)]);
    let mut rig = three(Bus { requests: 0, ..BUS });
    all_want(&mut rig, [1; 3]);
    assert_eq!(rig.cycle(), []);
}

#[test]
fn a_request_that_comes_back_does_not_use_its_place() {
    let mut rig = three(BUS);
    all_want(&mut rig, [1; 3]);
    assert_eq!(rig.cycle(), [Frame::Ask(1, 1)]);
    rig.master.on_displaced(rig.now, &Frame::Ask(1, 1));
    assert_eq!(rig.send(), [Frame::Ask(2, 2)]);
    assert_eq!(rig.send(), []);
}

#[test]
fn while_a_drive_starts_nobody_is_asked() {
    let mut rig = three(BUS);
    all_want(&mut rig, [1; 3]);
    rig.cycle();
    rig.says(
        1,
        Meaning {
            quiet_us: Some(3_000),
            ..Meaning::NONE
        },
    );
    let quiet_from = rig.now;
    let mut asked = Vec::new();
    for _ in 0..5 {
        let sent = rig.cycle();
        asked.push((rig.now.us_since(quiet_from), sent.len()));
    }
    assert_eq!(
        asked,
        [(1_000, 0), (2_000, 0), (3_000, 1), (4_000, 1), (5_000, 0)]
    );
    // Also one that was chosen already.
    all_want(&mut rig, [1; 3]);
    rig.can.room = 0;
    rig.cycle();
    rig.says(
        1,
        Meaning {
            quiet_us: Some(500),
            ..Meaning::NONE
        },
    );
    rig.can.room = 9;
    assert_eq!(rig.send(), []);
}

#[test]
fn a_request_knows_when_it_leaves_and_its_meaning_counts() {
    let window = Some(ResponseWindow {
        min_us: 3,
        max_us: 7,
    });
    let slow = Some(ResponseWindow {
        min_us: 5,
        max_us: 9,
    });
    let axes = [
        Axis { window, ..axis(1) },
        axis(2),
        Axis {
            window: slow,
            ..axis(3)
        },
    ];
    let mut rig = three_streaming(BUS, axes);
    rig.wants(2, ask(6, Class::Poll, 0));
    rig.can.room = 3;
    assert_eq!(rig.cycle().len(), 3);
    // 50 us into the cycle.
    rig.now = rig.now + 50;
    rig.can.room = 9;
    assert_eq!(rig.send(), [Frame::Ask(2, 6)]);
    let cycles = rig.master.cycle_counters().cycles;
    // Cycles, axes, slowest answer, frames before it, time since the cycle began.
    let us = 1_000_000 * cycles + 300_000 + 9_000 + 30 + 50;
    let asked = Call::Asked(6, rig.now + us);
    assert_eq!(rig.seen(1).calls.last(), Some(&asked));
    rig.wants(2, ask(u8::MAX, Class::Poll, 0));
    rig.cycle();
    assert_eq!(rig.fault(1), Some(Fault::Of(Loss::Contact)));
    assert_eq!(rig.state(0), AxisState::Faulted);
}

#[test]
fn requests_go_where_the_placement_says() {
    let place = Place {
        before: 0b011,
        ..BUS.place
    };
    let mut rig = three_streaming(Bus { place, ..BUS }, [axis(1), axis(2), axis(3)]);
    rig.wants(1, ask(9, Class::Poll, 0));
    let set_points = [1, 2, 3].map(|address| Frame::SetPoint(address, 0));
    let [first, second, third] = set_points;
    assert_eq!(rig.cycle(), [first, second, Frame::Ask(1, 9), third]);
    assert_eq!(rig.cycle(), set_points);
    // One that may not leave lets the frames pass.
    rig.wants(1, ask(9, Class::Write, 0));
    assert_eq!(rig.cycle(), set_points);
    // Its switch-off goes before it all.
    rig.says(2, rig.power(false));
    rig.wants(1, ask(9, Class::Poll, 0));
    rig.master.disable(rig.now, G);
    assert_eq!(
        rig.cycle(),
        [
            Frame::Switch(1, false),
            Frame::Switch(3, false),
            Frame::Ask(1, 9)
        ]
    );
}

#[test]
fn a_cycle_may_need_a_request_that_is_not_due() {
    let place = |enough_bits| Place {
        needs_requests: true,
        enough_bits,
        ..BUS.place
    };
    let on = |enough_bits| Bus {
        place: place(enough_bits),
        ..BUS
    };
    let bits = |address, poll_bits| Axis {
        poll_bits,
        frame_bits: 100 + address,
        ..axis(address)
    };
    let axes = [bits(1, 60), bits(2, 90), bits(3, 75)];
    let first = |enough_bits, overdue| {
        let mut rig = three_streaming(on(enough_bits), axes);
        all_want(&mut rig, overdue);
        let is_ask = |frame: &Frame| matches!(frame, Frame::Ask(..));
        rig.cycle().into_iter().find(is_ask)
    };
    let of = |address| Some(Frame::Ask(address, address));
    assert_eq!(first(None, [-9, -8, -7]), of(3));
    // The frames have 306 bits: the shortest request below, from there on the longest.
    assert_eq!(first(Some(307), [-9, -8, -7]), of(1));
    assert_eq!(first(Some(306), [-9, -8, -7]), of(2));
    assert_eq!(first(Some(305), [-9, -8, -7]), of(2));
    // Each within 14 cycles of the one that is due longest.
    assert_eq!(first(Some(307), [0, 0, 13]), of(1));
    assert_eq!(first(Some(307), [0, 0, 14]), of(3));
    assert_eq!(first(Some(305), [0, 0, 14]), of(3));
    assert_eq!(first(Some(307), [0, 0, i32::MAX]), of(3));
    // Only the frames of those that move count: 204 bits.
    for (enough_bits, address) in [(205, 1), (204, 2), (203, 2)] {
        let others = Axis {
            group: 1,
            ..axes[1]
        };
        let mut rig = Rig::on(on(Some(enough_bits)), &[axes[0], others, axes[2]]);
        rig.all_say(Meaning {
            is_checked: true,
            ..rig.power(false)
        });
        rig.master.enable(rig.now, G).expect("ready drives");
        for address in [1, 3] {
            rig.says(address, FINE);
        }
        rig.cycle();
        rig.cycle();
        for address in [1, 3] {
            rig.says(address, rig.power(true));
        }
        all_want(&mut rig, [1; 3]);
        let sent = rig.cycle();
        assert_eq!((sent.len(), sent.last()), (3, of(address).as_ref()));
    }
    // Without a wish there is nothing to wait for.
    let mut rig = three_streaming(on(None), axes);
    (rig.can.knows_room, rig.can.room) = (true, 3);
    assert_eq!((rig.cycle().len(), rig.progress), (3, Progress::Idle));
}

#[test]
fn a_cycle_takes_what_is_due_unless_its_placement_needs_requests() {
    let needs = Place {
        needs_requests: true,
        ..BUS.place
    };
    // Only beside frames of the cycle.
    let mut rig = three(Bus {
        place: needs,
        ..BUS
    });
    all_want(&mut rig, [-1; 3]);
    assert_eq!(rig.cycle(), []);
    let choosy = Place {
        enough_bits: Some(u32::MAX),
        ..BUS.place
    };
    let mut rig = three_streaming(
        Bus {
            place: choosy,
            ..BUS
        },
        [axis(1), axis(2), axis(3)],
    );
    all_want(&mut rig, [3, 4, 5]);
    let sent = rig.cycle();
    assert_eq!(sent.last(), Some(&Frame::Ask(3, 3)));
    all_want(&mut rig, [-1; 3]);
    assert_eq!(rig.cycle().len(), 3);
}

#[test]
fn one_drive_may_be_asked_every_time() {
    for address in 1..=3 {
        let mut rig = three(BUS);
        for request in 0..4 {
            rig.wants(address, ask(request, Class::Poll, 0));
            assert_eq!(rig.cycle(), [Frame::Ask(address, request)]);
        }
    }
}

#[test]
fn a_repair_starts_with_its_frame_and_leaves_only_without_power() {
    let mut rig = Rig::ready(&[axis(1)]);
    rig.wants(1, ask(2, Class::Repair, 0));
    assert_eq!(rig.cycle(), [Frame::Ask(1, 2)]);
    assert_eq!(rig.seen(0).facts.work, Work::Repair);
    rig.says(
        1,
        Meaning {
            work_ended: true,
            ..Meaning::NONE
        },
    );
    rig.wants(1, ask(3, Class::Poll, 0));
    assert_eq!(
        (rig.cycle(), rig.seen(0).facts.work),
        (vec![Frame::Ask(1, 3)], Work::None)
    );
    rig.says(1, rig.power(true));
    rig.wants(1, ask(2, Class::Repair, 0));
    assert_eq!((rig.cycle(), rig.seen(0).facts.work), (vec![], Work::None));
    // A procedure that is under way is not replaced.
    let mut rig = Rig::ready(&[axis(1)]);
    let given = can_motion::Confirmation::Given;
    rig.master
        .start(rig.now, 0, Work::Read, given)
        .expect("a ready drive");
    rig.wants(1, ask(2, Class::Repair, 0));
    assert_eq!((rig.cycle(), rig.seen(0).facts.work), (vec![], Work::Read));
}
