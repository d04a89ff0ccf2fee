//! All four outcomes of `embedded_can::nb::Can::transmit` are entered in the books: a scripted driver decides the fate of
//! each set-point, the sum of what it kept is compared with what the master counted.

use std::collections::VecDeque;

use can_motion::{AxisState, EventKind, Fault, Progress, service};
use drive_sim::{Frame, TxOrder};
use dyn_can::{DriveId, FunctionCode};
use embedded_can::nb::Can;
use embedded_can::{Frame as _, Id};
use host_tests::rig::{Rig, is_anchored};
use proptest::prelude::*;

/// What the driver does with the next set-point.
#[derive(Debug, Clone, Copy)]
enum Fate {
    Accept,
    Displace,
    Block,
    Fail,
}

/// A driver that keeps set-points in a list, and does with each what it is told.
#[derive(Debug, Default)]
struct Scripted {
    fates: VecDeque<Fate>,
    kept: Vec<Frame>,
}

#[derive(Debug)]
struct Broken;

impl embedded_can::Error for Broken {
    fn kind(&self) -> embedded_can::ErrorKind {
        embedded_can::ErrorKind::Bit
    }
}

impl Can for Scripted {
    type Frame = Frame;
    type Error = Broken;

    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, Broken> {
        match self.fates.pop_front().unwrap_or(Fate::Block) {
            Fate::Accept => {
                self.kept.push(*frame);
                Ok(None)
            }
            Fate::Displace => {
                let displaced = self.kept.pop();
                self.kept.push(*frame);
                Ok(displaced)
            }
            Fate::Block => Err(nb::Error::WouldBlock),
            Fate::Fail => Err(nb::Error::Other(Broken)),
        }
    }

    fn receive(&mut self) -> nb::Result<Frame, Broken> {
        Err(nb::Error::WouldBlock)
    }
}

/// Sum of the steps for one drive among frames, read from their bytes.
fn sum_for(frames: &[Frame], drive: u16) -> i32 {
    let set_point = drive << 5 | FunctionCode::GoRelativePosPd as u16;
    let step = |frame: &Frame| match (frame.id(), frame.data()) {
        (Id::Standard(id), _) if id.as_raw() != set_point => 0,
        (_, &[byte]) => i32::from(byte as i8),
        (_, &[high, low]) => i32::from(i16::from_be_bytes([high, low])),
        (_, other) => panic!("a set-point has one or two bytes, got {other:02X?}"),
    };
    frames.iter().map(step).sum()
}

fn fate() -> impl Strategy<Value = Fate> {
    prop_oneof![4 => Just(Fate::Accept), 2 => Just(Fate::Displace), 2 => Just(Fate::Block)]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever the driver does, the books hold what it kept and owe the rest.
    #[test]
    fn kept_plus_owed_is_the_target(
        cycles in proptest::collection::vec((-300..300_i32, proptest::collection::vec(fate(), 0..6)), 1..60),
    ) {
        let mut rig = Rig::with_axes(2);
        rig.stream();
        let anchors = [0, 1].map(|axis| rig.axis(axis).sent_counts);
        let mut driver = Scripted::default();
        let mut target = 0;
        for (change, fates) in cycles {
            target += change;
            for (axis, anchor) in anchors.iter().enumerate() {
                rig.master.set_target(axis, anchor + target).unwrap();
            }
            let now = rig.now();
            rig.master.begin_cycle(now);
            driver.fates.extend(fates);
            let _ = service(&mut rig.master, &mut driver, now);
            driver.fates.clear();
            for (axis, anchor) in anchors.iter().enumerate() {
                let books = rig.axis(axis);
                prop_assert_eq!(books.sent_counts - anchor, sum_for(&driver.kept, axis as u16 + 1));
                prop_assert_eq!(books.sent_counts + books.backlog_counts, anchor + target);
            }
        }
    }
}

#[test]
fn a_blocked_driver_is_asked_again_and_nothing_is_counted() {
    let mut rig = Rig::with_axes(1);
    rig.stream();
    let before = rig.axis(0);
    rig.master.set_target(0, before.sent_counts + 50).unwrap();
    let now = rig.now();
    rig.master.begin_cycle(now);
    let mut driver = Scripted::default();
    assert_eq!(
        service(&mut rig.master, &mut driver, now),
        Progress::Blocked
    );
    assert_eq!(rig.axis(0).sent_counts, before.sent_counts);
    driver.fates.extend([Fate::Accept, Fate::Accept]);
    assert_eq!(service(&mut rig.master, &mut driver, now), Progress::Idle);
    assert_eq!(rig.axis(0).sent_counts, before.sent_counts + 50);
}

#[test]
fn a_displaced_set_point_is_told_and_owed_again_in_the_same_cycle() {
    let mut rig = Rig::with_axes(2);
    rig.stream();
    for axis in 0..2 {
        let sent = rig.axis(axis).sent_counts;
        rig.master.set_target(axis, sent + 7).unwrap();
    }
    let now = rig.now();
    rig.master.begin_cycle(now);
    let mut driver = Scripted::default();
    driver
        .fates
        .extend([Fate::Accept, Fate::Displace, Fate::Block]);
    assert_eq!(
        service(&mut rig.master, &mut driver, now),
        Progress::Blocked
    );
    assert_eq!(
        (rig.axis(0).backlog_counts, rig.axis(1).backlog_counts),
        (7, 0)
    );
    assert_eq!(rig.axis(0).counters.displaced, 1);
    driver.fates.push_back(Fate::Accept);
    let _ = service(&mut rig.master, &mut driver, now);
    assert_eq!(rig.axis(0).backlog_counts, 0);
    assert_eq!((sum_for(&driver.kept, 1), sum_for(&driver.kept, 2)), (7, 7));
}

#[test]
fn a_set_point_of_unknown_fate_makes_the_axis_unreferenced() {
    let mut rig = Rig::with_axes(2);
    rig.stream();
    let now = rig.now();
    rig.master.begin_cycle(now);
    let mut driver = Scripted::default();
    driver.fates.push_back(Fate::Fail);
    let _ = service(&mut rig.master, &mut driver, now);
    let axis = rig.axis(0);
    assert_eq!(
        (axis.state, axis.fault, is_anchored(&axis)),
        (AxisState::Faulted, Some(Fault::Bus), false)
    );
    assert_eq!(rig.axis(1).fault, Some(Fault::Group));
}

#[test]
fn both_orders_of_a_real_controller_deliver_exactly_the_target() {
    for order in [TxOrder::Fifo, TxOrder::ByIdentifier] {
        let drives: Vec<_> = DriveId::all()
            .take(8)
            .map(drive_sim::DynDriveConfig::new)
            .collect();
        let axes: Vec<_> = DriveId::all()
            .take(8)
            .map(host_tests::rig::axis_config)
            .collect();
        let mut rig = Rig::new(can_motion::MasterConfig::DEFAULT, &axes, drives, order);
        rig.stream();
        rig.move_all(&[11, -12, 13, -14, 150, -160, 17, 0], 500);
        rig.cycles(10);
        for axis in 0..8 {
            let expected = i64::from(rig.axis(axis).target_counts);
            assert_eq!(
                rig.drive(axis).commanded_counts(),
                expected,
                "{order:?}, axis {axis}"
            );
        }
        assert_eq!(rig.master.cycle_counters().late, 0, "{order:?}");
    }
}

#[test]
fn bus_off_stops_everything_and_the_way_back_needs_the_application() {
    let mut rig = Rig::with_axes(2);
    rig.stream();
    rig.move_all(&[25, 25], 50);
    let now = rig.now();
    rig.master.on_bus_off(now);
    let frames = rig.drive(0).books().pd_frames;
    rig.cycles(20);
    let now = rig.now();
    rig.master.on_bus_recovered(now);
    rig.cycles(500);
    // What the controller held at the time still went out, nothing else did.
    assert!(rig.drive(0).books().pd_frames <= frames + 1);
    for axis in 0..2 {
        assert_eq!(
            (rig.axis(axis).fault, is_anchored(&rig.axis(axis))),
            (Some(Fault::Bus), false)
        );
    }
    assert!(rig.saw(|kind| *kind == EventKind::BusOff));
    let now = rig.now();
    rig.master.clear(now, host_tests::rig::GROUP).unwrap();
    rig.stream();
    assert!(is_anchored(&rig.axis(0)));
    assert_eq!(
        i64::from(rig.axis(0).sent_counts),
        rig.drive(0).position_counts(rig.bench.now_ns())
    );
}
