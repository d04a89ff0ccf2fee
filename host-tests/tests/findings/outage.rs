//! The bus or the adapter is gone while axes move. Nothing may resume by itself afterwards.

use crate::support::servos::{Servos, servo, servos};
use crate::support::wheels::{Wheels, hubs};
use crate::support::{Call, assert_none};

/// Counts of each axis in a cycle while it moves.
type Steps = [i32; 3];

/// Frames that the three mailboxes may hold when the bus goes away.
const MAILBOXES: usize = 3;

/// What breaks the promises when the bus comes back after `silent_ms` in motion.
fn violations(
    steps: Steps,
    silent_ms: i32,
    goes: impl Fn(&mut Servos),
    comes: impl Fn(&mut Servos),
) -> Vec<String> {
    let mut machine = Servos::streaming(&servos(3));
    machine.move_all(&steps, 200);
    let (mark, taken) = (machine.mark(), [0, 1, 2].map(|axis| machine.taken(axis)));
    goes(&mut machine);
    let mut found = Vec::new();
    // 20 ms is the longer of 20 ms and 5 cycles; twice that is late.
    machine.move_all(&steps, 40);
    for axis in 0..3 {
        let fault = machine.fault(axis);
        if fault.is_none() {
            found.push(format!("axis {axis} has no fault after 40 ms of silence"));
        }
    }
    machine.move_all(&steps, silent_ms - 40);
    let silent = machine.mark();
    comes(&mut machine);
    machine.move_all(&steps, 300);
    for axis in 0..3 {
        let sent = machine.steps_since(silent, axis);
        let usual = steps[axis].abs();
        let large: Vec<&i32> = sent.iter().filter(|step| step.abs() > usual).collect();
        if !large.is_empty() {
            found.push(format!(
                "axis {axis}: the first steps afterwards are {:?} counts in one frame, it moved at {usual}",
                &large[..large.len().min(4)]
            ));
        }
        let moved = machine.taken(axis) - taken[axis];
        let most = i64::from(usual) * MAILBOXES as i64;
        if moved.abs() > most {
            found.push(format!(
                "axis {axis}: the drive took {moved} counts that nobody resumed, {most} may have waited in mailboxes"
            ));
        }
        if machine.streams(axis) {
            found.push(format!("axis {axis} streams again and nobody resumed it"));
        }
    }
    let count = machine.told_since(mark).len();
    found
        .iter_mut()
        .for_each(|line| *line += &format!(" ({count} frames)"));
    found
}

fn unplug_all(machine: &mut Servos) {
    (0..machine.drives()).for_each(|axis| machine.unplug(axis));
}

fn plug_in_all(machine: &mut Servos) {
    (0..machine.drives()).for_each(|axis| machine.plug_in(axis));
}

/// Finding 1.
#[test]
fn all_drives_unplugged_for_a_second_in_motion_do_not_go_on() {
    assert_none(&violations([1, -1, 40], 1_000, unplug_all, plug_in_all));
}

/// Finding 1.
#[test]
fn a_bus_that_was_blocked_for_a_second_in_motion_does_not_go_on() {
    let goes = |machine: &mut Servos| machine.block_bus_for_ms(1_000);
    assert_none(&violations([1, -1, 40], 1_000, goes, |_| {}));
}

/// Finding 1: nothing gets through an adapter, and nothing comes, for eight seconds; the motion would have ended meanwhile.
#[test]
fn an_adapter_that_was_frozen_for_eight_seconds_does_not_go_on() {
    let goes = |machine: &mut Servos| machine.freeze_adapter(true);
    let comes = |machine: &mut Servos| machine.freeze_adapter(false);
    assert_none(&violations([1, -1, 15], 8_000, goes, comes));
}

/// The largest change of the step from one frame to the next. An axis stands while it gets no set-points, so a step of at most 4 counts
/// may follow any other: it begins anew.
fn largest_change(steps: &[i32]) -> i32 {
    let change = |pair: &[i32]| match pair[1].abs() {
        0..=4 => 0,
        _ => (pair[1] - pair[0]).abs(),
    };
    steps.windows(2).map(change).max().unwrap_or(0)
}

/// Finding 1: a gap shorter than an outage is caught up within the limits of the axis.
#[test]
fn a_short_gap_is_caught_up_without_a_jump() {
    let mut found = Vec::new();
    for gap_ms in [3, 8, 15] {
        let mut machine = Servos::streaming(&[servo(1).max_step(60).ramp_change(4)]);
        machine.move_all(&[40], 200);
        let mark = machine.mark();
        machine.block_bus_for_ms(gap_ms);
        machine.move_all(&[40], 200);
        let steps = machine.steps_since(mark, 0);
        let jump = largest_change(&steps);
        let most = steps.iter().map(|step| step.abs()).max().unwrap();
        if jump > 4 || most > 60 {
            found.push(format!(
                "after a gap of {gap_ms} ms the step grows by {jump} counts in one cycle to {most}; 4 and 60 are allowed"
            ));
        }
    }
    assert_none(&found);
}

/// Finding 1: wheels, whose drives stop by themselves after 300 ms, must not start again either.
#[test]
fn wheels_do_not_go_on_after_an_outage() {
    let mut found = Vec::new();
    for silent_ms in [90, 150, 1_000] {
        let mut machine = Wheels::streaming(&hubs(2));
        machine.drive_at(&[100, 100], 50);
        machine.block_bus_for_ms(silent_ms);
        machine.drive_at(&[100, 100], silent_ms as usize / 10 + 200);
        for axis in 0..2 {
            let (fault, speed) = (machine.fault(axis), machine.speed_rpm(axis));
            if fault.is_none() || speed.abs() > 1.0 {
                found.push(format!(
                    "{silent_ms} ms without a bus: wheel {axis} turns at {speed} r/min two seconds later, fault {fault:?}"
                ));
            }
        }
        // A clear is no permission to move.
        let _ = machine.call(Call::Clear);
        machine.drive_at(&[100, 100], 300);
        for axis in 0..2 {
            let speed = machine.speed_rpm(axis);
            if speed.abs() > 1.0 {
                found.push(format!(
                    "{silent_ms} ms without a bus: wheel {axis} turns at {speed} r/min after clear"
                ));
            }
        }
    }
    assert_none(&found);
}

/// Beyond the list: the application itself hangs and then asks for where its motion would be by now.
#[test]
fn an_application_that_hung_in_motion_is_not_caught_up_with_a_jump() {
    let mut found = Vec::new();
    for hung in [5, 15, 200] {
        let mut machine = Servos::streaming(&[servo(1).ramp_change(4)]);
        machine.move_all(&[40], 200);
        let (mark, target) = (machine.mark(), machine.target(0));
        machine.hang(hung);
        let _ = machine.set_target(0, target + 40 * (hung + 1));
        machine.run(1);
        machine.move_all(&[40], 100);
        let steps = machine.steps_since(mark, 0);
        let most = steps.iter().map(|step| step.abs()).max().unwrap_or(0);
        let jump = largest_change(&steps);
        if steps.len() > 1 && jump > 4 {
            found.push(format!(
                "no cycle for {hung} ms: the step grows to {most} counts in one frame, by {jump} in a cycle, 4 are allowed; fault {:?}",
                machine.fault(0)
            ));
        }
    }
    assert_none(&found);
}
