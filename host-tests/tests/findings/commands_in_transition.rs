//! Each call of the application at each moment between power-on and streaming, and on the way back.

use can_motion::Reaction;

use crate::support::servos::{Servos, Told, servo, servos};
use crate::support::wheels::{Wheels, hub, hubs};
use crate::support::{Call, assert_none};

/// Cycles from enable to streaming of a servo, and some more.
const ENABLING_CYCLES: usize = 200;

/// Finding 7: what was not on yet stays off after `stop` and `halt`, and what was on streams no more.
#[test]
fn stop_and_halt_while_enabling_end_it() {
    let mut found = Vec::new();
    for call in [Call::Stop, Call::Halt, Call::Disable] {
        for later in 0..ENABLING_CYCLES {
            let mut machine = Servos::new(&servos(2));
            machine.become_ready();
            machine.call(Call::Enable).unwrap();
            machine.run(later);
            let was_on = machine.energised(0) || machine.energised(1);
            if machine.all_stream() {
                break;
            }
            machine.call(call).unwrap();
            // A frame may have waited in a mailbox.
            machine.run(2);
            let mark = machine.mark();
            machine.run(600);
            for axis in 0..2 {
                let set_points = machine.steps_since(mark, axis).len();
                let on = machine.energised(axis);
                let may_hold = was_on && call != Call::Disable;
                if set_points > 0 || on && !may_hold {
                    found.push(format!(
                        "{call:?} {later} cycles after enable: axis {axis} is {} and got {set_points} set-points afterwards",
                        if on { "on" } else { "off" }
                    ));
                }
            }
        }
    }
    assert_none(&found);
}

/// Finding 7, wheels.
#[test]
fn stop_and_halt_while_wheels_are_enabled_end_it() {
    let mut found = Vec::new();
    for call in [Call::Stop, Call::Halt, Call::Disable] {
        for later in 0..60 {
            let mut machine = Wheels::new(&hubs(2));
            machine.become_ready();
            machine.call(Call::Enable).unwrap();
            machine.run(later);
            if machine.all_stream() {
                break;
            }
            machine.call(call).unwrap();
            machine.drive_at(&[100, 100], 200);
            for axis in 0..2 {
                let (on, speed) = (machine.energised(axis), machine.speed_rpm(axis));
                if speed.abs() > 1.0 || on && call == Call::Disable || machine.all_stream() {
                    found.push(format!(
                        "{call:?} {later} cycles after enable: wheel {axis} is {} and turns at {speed} r/min",
                        if on { "on" } else { "off" }
                    ));
                }
            }
        }
    }
    assert_none(&found);
}

/// Finding 4.
#[test]
fn disable_before_a_drive_was_checked_does_not_make_it_ready() {
    let mut found = Vec::new();
    for later in (0..140).step_by(35).chain(145..200) {
        let mut machine = Servos::new(&[servo(1).in_speed_mode()]);
        machine.run(later);
        machine.call(Call::Disable).unwrap();
        machine.run(400);
        let enabled = machine.call(Call::Enable);
        machine.run(600);
        let set_points = machine.steps_since(0, 0).len();
        let on = machine.commands_since(0, 0).contains(&Told::On);
        if set_points > 0 || on {
            found.push(format!(
                "disable at {later} ms: the drive is in speed mode, enable gave {enabled:?}, {set_points} set-points were sent to it"
            ));
        }
    }
    assert_none(&found);
}

/// Finding 4: a position outside the travel is found, too, whenever `disable` was called.
#[test]
fn disable_before_the_position_was_read_does_not_hide_it() {
    let mut found = Vec::new();
    for later in 145..200 {
        let outside = servo(1)
            .travel(-1_000, 1_000)
            .drive(|drive| drive.start_position_counts = 5_000);
        let mut machine = Servos::new(&[outside]);
        machine.run(later);
        machine.call(Call::Disable).unwrap();
        machine.run(400);
        let enabled = machine.call(Call::Enable);
        machine.run(600);
        let set_points = machine.steps_since(0, 0).len();
        if set_points > 0 {
            found.push(format!(
                "disable at {later} ms: {set_points} set-points outside the travel, enable gave {enabled:?}"
            ));
        }
    }
    assert_none(&found);
}

/// Promise 3: `disable` sends its command whenever the power is not confirmed off; no reading is needed first.
#[test]
fn disable_switches_off_a_drive_that_was_found_on_at_any_time() {
    let mut found = Vec::new();
    for later in (0..150).step_by(50).chain(150..180) {
        let on = servo(1).drive(|drive| drive.enabled_after_power_on = true);
        let mut machine = Servos::new(&[on]);
        machine.run(later);
        machine.call(Call::Disable).unwrap();
        machine.run(400);
        if machine.energised(0) {
            found.push(format!(
                "disable at {later} ms: the drive is still on 400 ms later"
            ));
        }
    }
    assert_none(&found);
}

/// Finding 8, in each moment of a ramp and of a disable: two calls in sequence.
#[test]
fn the_last_of_two_calls_counts() {
    let calls = [Call::Stop, Call::Halt, Call::Disable];
    let mut found = Vec::new();
    for first in calls {
        for second in calls {
            for later in [0, 1, 2, 5, 10, 20, 30, 60] {
                let mut machine = Servos::streaming(&[servo(1).ramp_change(4), servo(2)]);
                machine.move_all(&[100, 50], 100);
                machine.call(first).unwrap();
                machine.run(later);
                machine.call(second).unwrap();
                machine.run(500);
                let mark = machine.mark();
                machine.run(50);
                // Once is enough: what was to be off must not be held again by a later stop.
                let wants_off = first == Call::Disable || second == Call::Disable;
                for axis in 0..2 {
                    let set_points = machine.steps_since(mark, axis).len();
                    let (on, believed) = (machine.energised(axis), machine.believed_on(axis));
                    if set_points > 0 || on == wants_off || on != believed {
                        found.push(format!(
                            "{first:?}, {later} cycles later {second:?}: axis {axis} is {}, the master says {}, {set_points} set-points in 50 cycles",
                            word(on),
                            word(believed)
                        ));
                    }
                }
            }
        }
    }
    assert_none(&found);
}

fn word(on: bool) -> &'static str {
    if on { "on" } else { "off" }
}

/// Beyond the list: a call that meets a fault of the partner at any moment of enabling.
#[test]
fn a_fault_while_enabling_leaves_nothing_on_unsaid() {
    let mut found = Vec::new();
    for reaction in [Reaction::Halt, Reaction::RampDown, Reaction::Disable] {
        for later in 0..ENABLING_CYCLES {
            let partner = servo(2).react(|reactions| reactions.alarm = reaction);
            let mut machine = Servos::new(&[servo(1), partner]);
            machine.become_ready();
            machine.call(Call::Enable).unwrap();
            machine.run(later);
            if machine.all_stream() {
                break;
            }
            machine.faults_mut(1).raise_alarm(dyn_can::Alarm::LostPhase);
            machine.run(400);
            let mark = machine.mark();
            let cleared = machine.call(Call::Clear);
            machine.run(100);
            let (on, believed) = (machine.energised(0), machine.believed_on(0));
            let sent = machine.steps_since(mark, 0).len();
            if on != believed || sent > 0 {
                found.push(format!(
                    "partner alarms {later} cycles after enable, {reaction:?}, clear {cleared:?}: the drive is {}, the master says {}, {sent} set-points",
                    word(on),
                    word(believed)
                ));
            }
        }
    }
    assert_none(&found);
}

/// Two calls in sequence for wheels, in both modes.
#[test]
fn the_last_of_two_calls_counts_for_wheels() {
    let calls = [Call::Stop, Call::Halt, Call::Disable];
    let mut found = Vec::new();
    for position in [false, true] {
        for first in calls {
            for second in calls {
                for later in [0, 1, 3, 10, 30] {
                    let wheels = [1, 2].map(|node| match position {
                        true => hub(node).position(60),
                        false => hub(node),
                    });
                    let mut machine = Wheels::streaming(&wheels);
                    let target = if position { 20_000 } else { 200 };
                    machine.drive_at(&[target, target], 50);
                    machine.call(first).unwrap();
                    machine.run(later);
                    machine.call(second).unwrap();
                    machine.run(300);
                    let travel = machine.travel(0);
                    machine.run(100);
                    let moved = machine.travel(0) - travel;
                    let wants_off = first == Call::Disable || second == Call::Disable;
                    let (on, believed) = (machine.energised(0), machine.believed_on(0));
                    // A free wheel may coast; a move by itself of a wheel in position mode goes on for `stop`.
                    let by_itself =
                        position && !wants_off && !(first == Call::Halt || second == Call::Halt);
                    if on == wants_off || on != believed || moved != 0 && !by_itself && on {
                        found.push(format!(
                            "{}{first:?}, {later} cycles later {second:?}: the wheel is {}, the master says {}, {moved} counts in a second",
                            if position { "position: " } else { "speed: " },
                            word(on),
                            word(believed)
                        ));
                    }
                }
            }
        }
    }
    assert_none(&found);
}
