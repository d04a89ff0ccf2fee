//! More axes than a word of the processor has bits.

use can_motion::facts::Class;
use can_motion::family::Meaning;
use can_motion::{AxisState, BusUser, GroupId, Instant};

use crate::family::{Axis, BUS, Bus, Frame, Place, ask, axis};
use crate::rig::{FINE, G, RigOf};

type Many = RigOf<false, 64>;

/// So many axes, all streaming.
fn streaming(bus: Bus, axes: &[Axis]) -> Many {
    let mut rig = Many::on(bus, axes);
    rig.all_say(Meaning {
        is_checked: true,
        ..rig.power(false)
    });
    rig.master.enable(rig.now, G).expect("ready drives");
    rig.stream()
}

fn forty(each: impl Fn(Axis) -> Axis) -> Vec<Axis> {
    (1..=40).map(|address| each(axis(address))).collect()
}

#[test]
fn forty_axes_send_forty_set_points_in_order() {
    for is_plain in [false, true] {
        let mut rig = streaming(BUS, &forty(|axis| Axis { is_plain, ..axis }));
        rig.master.set_target(39, 5).expect("in the travel");
        let set_point = |address| Frame::SetPoint(address, if address == 40 { 5 } else { 0 });
        let all: Vec<Frame> = (1..=40).map(set_point).collect();
        let ticks = [0, 39].map(|axis| rig.seen(axis).ticks);
        assert_eq!(rig.cycle(), all);
        assert_eq!(rig.cycle(), all);
        // Those that only stream are not called.
        let called = if is_plain { 0 } else { 2 };
        let ticks = [0, 39].map(|axis| rig.seen(axis).ticks - ticks[axis / 39]);
        assert_eq!(ticks, [called; 2]);
        assert_eq!(rig.send(), []);
        assert_eq!(rig.master.cycle_counters().late, 0);
        // One that finds no room waits.
        rig.can.room = 39;
        assert_eq!(rig.cycle(), all[..39]);
        rig.can.room = 9;
        assert_eq!(rig.send(), all[39..]);
        rig.can.room = 99;
        // One that comes back is owed again, whichever it is.
        for address in [8, 40] {
            rig.master.on_displaced(rig.now, &set_point(address));
            assert_eq!(rig.send(), [set_point(address)]);
        }
    }
}

#[test]
fn a_controller_without_room_is_full_for_the_last_axis_too() {
    let mut rig = streaming(BUS, &forty(|axis| axis));
    rig.master.halt(rig.now, G);
    rig.master.disable(rig.now, G);
    (rig.can.knows_room, rig.can.room) = (true, 39);
    assert_eq!(rig.cycle().len(), 39);
    assert_eq!(rig.progress, can_motion::Progress::Blocked);
    rig.can.room = 9;
    assert_eq!(rig.send(), [Frame::Switch(40, false)]);
}

#[test]
fn drives_that_share_a_bit_are_each_asked_when_their_time_has_come() {
    let sure = |axis| Axis {
        sure_for_us: 50_000,
        is_plain: true,
        ..axis
    };
    let mut rig = streaming(BUS, &forty(sure));
    rig.cycle();
    for (address, overdue) in [(3, -2), (35, -4)] {
        rig.wants(address, ask(address, Class::Poll, overdue));
    }
    let asked: Vec<Vec<Frame>> = (0..6).map(|_| rig.cycle().split_off(40)).collect();
    let of = |address: u8| vec![Frame::Ask(address, address)];
    assert_eq!(asked, [vec![], of(3), vec![], of(35), vec![], vec![]]);
}

#[test]
fn the_time_of_the_last_drive_comes_too() {
    let mut axes = forty(|axis| Axis {
        is_plain: true,
        ..axis
    });
    let from = Instant::from_us(1_043_000);
    for index in [5, 38] {
        axes[index].asks_from = from;
    }
    let mut rig = streaming(BUS, &axes);
    for address in [6, 39] {
        rig.wants(address, ask(address, Class::Poll, 0));
    }
    let mut asked = Vec::new();
    for _ in 0..60 {
        let sent = rig.cycle().split_off(40);
        asked.extend(sent.into_iter().map(|frame| (rig.now, frame)));
    }
    let expected = [(from, Frame::Ask(6, 6)), (from + 1_000, Frame::Ask(39, 39))];
    assert_eq!(asked, expected);
}

#[test]
fn a_request_fits_beside_the_frames_of_all_that_stream_on() {
    // 40 frames of 100 bits.
    let plain = |axis: Axis| Axis {
        is_plain: true,
        frame_bits: 100,
        poll_bits: axis.address,
        ..axis
    };
    for (enough_bits, expected) in [(4_001, 1), (4_000, 40), (3_999, 40)] {
        let place = Place {
            needs_requests: true,
            enough_bits: Some(enough_bits),
            ..BUS.place
        };
        let mut rig = streaming(Bus { place, ..BUS }, &forty(plain));
        for address in 1..=40 {
            rig.wants(address, ask(address, Class::Poll, 1));
        }
        let sent = rig.cycle();
        assert_eq!(sent.len(), 41);
        assert_eq!(sent[40], Frame::Ask(expected, expected));
    }
}

#[test]
fn commands_reach_a_group_beyond_the_first_32_axes() {
    let mut axes = forty(|axis| axis);
    axes[38].group = 1;
    let mut rig = Many::ready(&axes);
    rig.master
        .enable(rig.now, GroupId(1))
        .expect("a ready drive");
    rig.says(39, FINE);
    assert_eq!(rig.cycle(), [Frame::Switch(39, true)]);
    rig.cycle();
    rig.says(39, rig.power(true));
    assert_eq!(rig.state(38), AxisState::Streaming);
    assert_eq!(rig.state(6), AxisState::Ready);
    assert_eq!(rig.cycle(), [Frame::SetPoint(39, 0)]);
}
