//! When a drive is to be asked, as worked out beforehand: it counts from cycle to cycle, until something happens or its time has come.

use can_motion::facts::Class;
use can_motion::{BusUser, Instant};

use crate::family::{Axis, Frame, ask, axis};
use crate::rig::Rig;

/// Three drives that stream on and know for so long when they are to be asked.
fn sure(sure_for_us: [u32; 3]) -> Rig {
    let mut address = 0;
    let axes = sure_for_us.map(|sure_for_us| {
        address += 1;
        Axis {
            sure_for_us,
            is_plain: true,
            ..axis(address)
        }
    });
    let mut rig = Rig::streaming(&axes);
    rig.cycle();
    rig
}

/// The cycles, counted from 1, in which each of the drives was asked in the next so many.
fn asked(rig: &mut Rig, cycles: usize) -> Vec<(usize, u8)> {
    let mut asked = Vec::new();
    for cycle in 1..=cycles {
        for frame in rig.cycle() {
            if let Frame::Ask(address, _) = frame {
                asked.push((cycle, address));
            }
        }
    }
    asked
}

#[test]
fn a_poll_comes_due_by_the_cycles_that_pass() {
    let mut rig = sure([u32::MAX; 3]);
    for (address, overdue) in [(1, -9), (2, -3), (3, -5)] {
        rig.wants(address, ask(address, Class::Poll, overdue));
    }
    assert_eq!(asked(&mut rig, 12), [(3, 2), (5, 3), (9, 1)]);
}

#[test]
fn what_stays_the_same_is_not_worked_out_again() {
    let mut rig = sure([u32::MAX, u32::MAX, 20_000]);
    let looks = |rig: &Rig| [0, 1, 2].map(|axis| rig.seen(axis).looks);
    let before = looks(&rig);
    for _ in 0..1_000 {
        rig.cycle();
    }
    let [first, second, third] = looks(&rig);
    assert_eq!([first, second], before[..2]);
    // Every 16 to 20 ms.
    assert!((50..=63).contains(&(third - before[2])), "{third}");
}

#[test]
fn what_happens_to_a_drive_is_seen_in_the_same_cycle() {
    let mut rig = sure([u32::MAX; 3]);
    assert_eq!(asked(&mut rig, 3), []);
    rig.wants(2, ask(2, Class::Poll, 0));
    assert_eq!(asked(&mut rig, 2), [(1, 2)]);
    // One that is asked for itself is due after its request went out.
    rig.wants(3, ask(3, Class::Poll, 0));
    rig.cycle();
    rig.wants(3, ask(3, Class::Poll, 0));
    rig.master.on_displaced(rig.now, &Frame::Ask(3, 3));
    assert_eq!(rig.send(), [Frame::Ask(3, 3)]);
}

#[test]
fn a_drive_whose_time_has_come_is_asked_although_nothing_has_happened_to_it() {
    // The last one waits longer than any date is believed.
    let from_us = [1_043_000, 1_150_000, 71_002_000];
    let mut address = 0;
    let axes = from_us.map(|us| {
        address += 1;
        Axis {
            asks_from: Instant::from_us(us),
            is_plain: true,
            ..axis(address)
        }
    });
    let mut rig = Rig::streaming(&axes);
    for address in [1, 2, 3] {
        rig.wants(address, ask(address, Class::Poll, 0));
    }
    let start_us = rig.now.as_us();
    let asked = asked(&mut rig, 70_200);
    let at_us = |cycle| start_us + 1_000 * cycle as u64;
    let asked: Vec<(u64, u8)> = (asked.into_iter())
        .map(|(cycle, address)| (at_us(cycle), address))
        .collect();
    let expected = [(from_us[0], 1), (from_us[1], 2), (from_us[2], 3)];
    assert_eq!(asked, expected);
}
