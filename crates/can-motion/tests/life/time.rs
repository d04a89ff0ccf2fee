//! Cycles: when the next one comes, what was missed, what was late, and the counters and events that tell it.

use can_motion::{CommonEvent, Instant};

use crate::drive::Call;
use crate::family::{BUS, Bus, Frame, Kind, axis};
use crate::rig::{G, Rig, of_bus};

#[test]
fn the_next_cycle_is_one_period_after_the_latest() {
    let bus = Bus {
        cycle_us: 2_500,
        ..BUS
    };
    let mut rig = Rig::<false>::on(bus, &[axis(1)]);
    assert_eq!(rig.master.poll_at(), Instant::default());
    rig.cycle_after(0);
    assert_eq!(rig.master.poll_at(), rig.now + 2_500);
    rig.cycle_after(2_600);
    assert_eq!(rig.master.poll_at(), rig.now + 2_500);
}

#[test]
fn half_a_cycle_of_jitter_misses_none() {
    let mut rig = Rig::streaming(&[axis(1)]);
    let before = rig.master.cycle_counters();
    for (gap_us, missed) in [
        (1_499, 0),
        (1_500, 1),
        (2_499, 1),
        (2_500, 2),
        (10_000, 9),
        (1, 0),
    ] {
        let told = rig.times_told(0);
        rig.cycle_after(gap_us);
        let (merges, events) = if missed > 0 {
            (
                vec![Call::Merged],
                vec![of_bus(CommonEvent::CyclesMissed(missed))],
            )
        } else {
            (vec![], vec![])
        };
        assert_eq!((rig.told_since(0, told), rig.events()), (merges, events));
    }
    let counters = rig.master.cycle_counters();
    assert_eq!(counters.cycles - before.cycles, 6);
    assert_eq!((counters.missed - before.missed, counters.late), (13, 0));
}

#[test]
fn a_set_point_that_missed_its_cycle_is_merged_and_told() {
    let mut rig = Rig::streaming(&[axis(1), axis(2)]);
    rig.can.room = 1;
    rig.cycle();
    let told = [0, 1].map(|axis| rig.times_told(axis));
    rig.can.room = 9;
    assert_eq!(rig.cycle().len(), 2);
    assert_eq!(rig.master.cycle_counters().late, 1);
    let merged = (Some(1), Kind::Common(CommonEvent::SetPointMerged));
    assert_eq!(rig.events(), [merged]);
    // One that was on time has nothing to catch up: it keeps its velocity. It would fall behind, and fault, for what happened to another.
    assert_eq!(rig.told_since(0, told[0]), []);
    assert_eq!(rig.told_since(1, told[1]), [Call::Merged]);
    rig.cycle();
    assert_eq!(rig.master.cycle_counters().late, 1);
    // An axis at rest has nothing to merge.
    rig.master.halt(rig.now, G);
    let told = rig.times_told(0);
    rig.cycle_after(5_000);
    assert_eq!(rig.told_since(0, told), []);
}

#[test]
fn a_set_point_that_is_void_is_not_late() {
    let mut rig = Rig::streaming(&[axis(1), axis(2)]);
    rig.can.room = 0;
    rig.cycle();
    rig.master.halt(rig.now, G);
    rig.can.room = 9;
    assert_eq!(rig.cycle(), []);
    assert_eq!(rig.master.cycle_counters().late, 0);
}

#[test]
fn events_that_nobody_reads_are_counted() {
    let mut rig = Rig::ready(&[axis(1)]);
    let stranger = Frame::Stop(9);
    for _ in 0..70 {
        can_motion::BusUser::on_frame(&mut rig.master, rig.now, &stranger);
    }
    assert_eq!(rig.master.cycle_counters().events_dropped, 6);
    assert_eq!(rig.events().len(), 64);
    let event = rig.master.next_event();
    assert_eq!(event, None);
    can_motion::BusUser::on_frame(&mut rig.master, rig.now, &stranger);
    let event = rig.master.next_event().expect("the latest");
    assert_eq!((event.at, event.axis), (rig.now, None));
}
