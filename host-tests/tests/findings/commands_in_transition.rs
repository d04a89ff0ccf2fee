//! Each call of the application at each moment between power-on and streaming, and on the way back.

use can_motion::Reaction;

use dyn_can::FunctionCode;

use crate::support::servos::{Servos, Told, line, servo, servos};
use crate::support::wheels::{Wheels, hub, hubs};
use crate::support::{Call, assert_none};

/// More cycles than servos and wheels need from enable to streaming.
const ENABLING_CYCLES: usize = 300;

/// What is on, or gets set-points, although a call in each cycle between enable and streaming wanted it off.
fn servos_not_stopped_by(call: Call) -> Vec<String> {
    let mut found = Vec::new();
    for later in 0..ENABLING_CYCLES {
        let mut machine = Servos::new(&servos(2));
        machine.become_ready();
        machine.call(Call::Enable).unwrap();
        machine.run(later);
        if machine.all_stream() {
            break;
        }
        assert!(later + 1 < ENABLING_CYCLES, "still being enabled");
        let was_on = [0, 1].map(|axis| machine.energised(axis));
        machine.call(call).unwrap();
        // A frame may have waited in a mailbox.
        machine.run(2);
        let mark = machine.mark();
        machine.run(600);
        for (axis, was_on) in was_on.into_iter().enumerate() {
            let set_points = machine.steps_since(mark, axis).len();
            let on = machine.energised(axis);
            let may_hold = was_on && call != Call::Disable;
            if set_points > 0 || on && !may_hold {
                found.push(format!(
                    "{call:?} {later} cycles after enable: axis {axis} is {} and got {set_points} set-points afterwards",
                    word(on)
                ));
            }
        }
    }
    found
}

/// Finding 7.
#[test]
fn stop_while_enabling_leaves_off_what_was_not_on() {
    assert_none(&servos_not_stopped_by(Call::Stop));
}

/// Finding 7.
#[test]
fn halt_while_enabling_leaves_off_what_was_not_on() {
    assert_none(&servos_not_stopped_by(Call::Halt));
}

/// Finding 19: disable is not ignored while enabling.
#[test]
fn disable_while_enabling_switches_off() {
    assert_none(&servos_not_stopped_by(Call::Disable));
}

/// The same for wheels: those that turn, stream, or are on although they were to be disabled.
fn wheels_not_stopped_by(call: Call) -> Vec<String> {
    let mut found = Vec::new();
    for later in 0..ENABLING_CYCLES {
        let mut machine = Wheels::new(&hubs(2));
        machine.become_ready();
        machine.call(Call::Enable).unwrap();
        machine.run(later);
        if machine.all_stream() {
            break;
        }
        assert!(later + 1 < ENABLING_CYCLES, "still being enabled");
        let was_on = machine.energised(0) || machine.energised(1);
        machine.call(call).unwrap();
        machine.drive_at(&[100, 100], 200);
        for axis in 0..2 {
            let (on, speed) = (machine.energised(axis), machine.speed_rpm(axis));
            let may_hold = was_on && call != Call::Disable;
            if speed.abs() > 1.0 || on && !may_hold || machine.all_stream() {
                found.push(format!(
                    "{call:?} {later} cycles after enable: wheel {axis} is {} and turns at {speed} r/min",
                    word(on)
                ));
            }
        }
    }
    found
}

/// Finding 7.
#[test]
fn stop_while_wheels_are_enabled_leaves_off_what_was_not_on() {
    assert_none(&wheels_not_stopped_by(Call::Stop));
}

/// Finding 7.
#[test]
fn halt_while_wheels_are_enabled_leaves_off_what_was_not_on() {
    assert_none(&wheels_not_stopped_by(Call::Halt));
}

/// Finding 19.
#[test]
fn disable_while_wheels_are_enabled_switches_off() {
    assert_none(&wheels_not_stopped_by(Call::Disable));
}

/// Finding 19: an enable command that the controller gave back is sent again while it is wanted, and not when it is not.
#[test]
fn a_displaced_enable_is_sent_again_only_while_it_is_wanted() {
    for disable in [false, true] {
        let mut machine = Servos::new(&servos(1));
        machine.become_ready();
        machine.lose_switches(0, 1);
        machine.call(Call::Enable).unwrap();
        let mark = machine.mark();
        while machine.commands_since(mark, 0).is_empty() {
            machine.run(1);
        }
        // The drive never got it.
        if disable {
            machine.call(Call::Disable).unwrap();
        }
        machine.switch_comes_back(0, true);
        machine.run(300);
        let commands = machine.commands_since(mark, 0);
        if disable {
            assert!(!machine.energised(0), "{commands:?}");
            assert!(!commands[1..].contains(&Told::On), "{commands:?}");
        } else {
            assert_eq!(commands, [Told::On, Told::On]);
            assert!(machine.energised(0) && machine.streams(0));
        }
    }
}

/// Finding 19: a status that nobody asked for confirms nothing.
#[test]
fn a_status_that_was_not_asked_for_does_not_confirm_an_enable() {
    let mut machine = Servos::new(&servos(1));
    machine.become_ready();
    machine.lose_switches(0, 1);
    machine.call(Call::Enable).unwrap();
    let mark = machine.mark();
    while machine.commands_since(mark, 0).is_empty() {
        machine.run(1);
    }
    for _ in 0..250 {
        let status = dyn_can::Reply::DriveStatus(dyn_can::DriveStatus::from_byte(0));
        // The drive answers within the cycle, so that the question of this cycle is not asked yet.
        machine
            .0
            .cycle_with(|rig| Servos::reply_comes_in(rig, 0, status));
    }
    assert_eq!(machine.steps_since(mark, 0), Vec::<i32>::new());
    assert!(machine.fault(0).is_some() && !machine.energised(0));
}

/// Finding 19: the shaft must have stood for the whole time, and a turn in between begins it anew.
#[test]
fn the_shaft_stands_for_the_whole_time_before_the_drive_is_enabled() {
    let mut machine = Servos::on(line().responses_up_to_us(3_500), &[slow(1)]);
    machine.become_ready();
    let (mark, from) = (machine.mark(), machine.now_ns());
    machine.call(Call::Enable).unwrap();
    machine.run(140);
    // One reading of 1 r/min, 140 ms after the first one of 0.
    machine.until_asked(0, FunctionCode::ReadMotorSpeed, |machine| machine.run(1));
    let turns = dyn_can::Reply::MotorSpeed(1);
    machine
        .0
        .cycle_with(|rig| Servos::reply_comes_in(rig, 0, turns));
    let turned = machine.now_ns();
    while machine.commands_since(mark, 0).is_empty() {
        machine.run(1);
    }
    let on = machine.now_ns();
    assert!(
        on - turned >= 148_000_000,
        "on {} us after a turn, {} us after enable",
        (on - turned) / 1_000,
        (on - from) / 1_000
    );
}

/// A servo that answers after 3 ms, so that a test can answer before it.
fn slow(id: i32) -> crate::support::servos::Servo {
    servo(id).drive(|drive| drive.response_delay = drive_sim::ResponseDelay::fixed(3_000_000))
}

/// Finding 19, wheels.
#[test]
fn a_wheel_stands_for_the_whole_time_before_it_is_enabled() {
    let mut machine = Wheels::new(&hubs(1));
    machine.become_ready();
    let from = machine.now_ns();
    machine.call(Call::Enable).unwrap();
    let mark = machine.mark();
    while machine.words_since(mark, 0).last() == Some(&0) || machine.words_since(mark, 0).is_empty()
    {
        machine.run(1);
    }
    let us = (machine.now_ns() - from) / 1_000;
    assert!(us >= 100_000, "enabled after {us} us");
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

/// What is wrong long after two calls in motion, with each distance between them.
fn after_both(first: Call, second: Call) -> Vec<String> {
    let mut found = Vec::new();
    for later in [0, 1, 2, 5, 10, 20, 30, 60] {
        let mut machine = Servos::streaming(&[servo(1).ramp_change(4), servo(2)]);
        machine.move_all(&[100, 50], 100);
        machine.call(first).unwrap();
        machine.run(later);
        machine.call(second).unwrap();
        machine.run(500);
        let mark = machine.mark();
        machine.run(50);
        // Once is enough: what was to be off must not be held again by a later stop or halt.
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
    found
}

/// Finding 19: disable is not ignored while ramping.
#[test]
fn disable_after_anything_switches_off() {
    let firsts = [Call::Stop, Call::Halt, Call::Disable];
    let found = firsts.map(|first| after_both(first, Call::Disable));
    assert_none(&found.concat());
}

#[test]
fn stop_and_halt_after_each_other_hold() {
    let calls = [Call::Stop, Call::Halt];
    let pairs = calls
        .into_iter()
        .flat_map(|first| calls.map(|second| after_both(first, second)));
    assert_none(&pairs.collect::<Vec<_>>().concat());
}

#[test]
fn stop_after_disable_does_not_keep_it_on() {
    assert_none(&after_both(Call::Disable, Call::Stop));
}

/// Beyond the list.
#[test]
fn halt_after_disable_does_not_keep_it_on() {
    assert_none(&after_both(Call::Disable, Call::Halt));
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
            let partner = servo(2).react(|reactions| reactions.data_error = reaction);
            let mut machine = Servos::new(&[servo(1), partner]);
            machine.become_ready();
            machine.call(Call::Enable).unwrap();
            machine.run(later);
            if machine.all_stream() {
                break;
            }
            // One data error, which nothing repeats.
            machine.0.cycle_with(|rig| {
                Servos::comes_in(rig, 1, FunctionCode::DriveError, &[0xFF]);
            });
            machine.run(400);
            let mark = machine.mark();
            let cleared = machine.call(Call::Clear);
            let (on, believed) = (machine.energised(0), machine.believed_on(0));
            machine.run(100);
            let sent = machine.steps_since(mark, 0).len();
            if on != believed || sent > 0 {
                found.push(format!(
                    "data error of the partner {later} cycles after enable, {reaction:?}, clear {cleared:?}: the drive is {}, the master says {}, {sent} set-points",
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
                    let (on, believed, moved) = after_two_calls(position, first, second, later);
                    let wants_off = first == Call::Disable || second == Call::Disable;
                    // A free wheel may coast.
                    if on == wants_off || on != believed || on && moved != 0 {
                        found.push(format!(
                            "{}: {first:?}, {later} cycles later {second:?}: the wheel is {}, the master says {}, it runs {moved} counts in the fourth second",
                            if position { "position" } else { "speed" },
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

/// Whether a wheel is on, what the master says, and how far it runs long after two calls in motion.
fn after_two_calls(position: bool, first: Call, second: Call, later: usize) -> (bool, bool, i64) {
    let wheels = [1, 2].map(|node| match position {
        true => hub(node).position(60),
        false => hub(node),
    });
    let mut machine = Wheels::streaming(&wheels);
    let target = if position { 40_000 } else { 200 };
    machine.drive_at(&[target, target], 50);
    machine.call(first).unwrap();
    machine.run(later);
    machine.call(second).unwrap();
    machine.run(300);
    let travel = machine.travel(0);
    machine.run(100);
    let moved = machine.travel(0) - travel;
    (machine.energised(0), machine.believed_on(0), moved)
}

/// Beyond the list: a move that a wheel makes by itself is stopped by `stop`, too.
#[test]
fn each_call_ends_a_move_that_a_wheel_makes_by_itself() {
    let mut found = Vec::new();
    for call in [Call::Stop, Call::Halt, Call::Disable] {
        let mut machine = Wheels::streaming(&[hub(1).position(60), hub(2).position(60)]);
        let target = machine.sent(0) + 40_000;
        machine.drive_at(&[target, target], 50);
        machine.call(call).unwrap();
        let from = machine.travel(0);
        machine.run(600);
        let moved = machine.travel(0) - from;
        if moved > 4_096 {
            found.push(format!(
                "{call:?} in a move: the wheel runs another {moved} counts in six seconds"
            ));
        }
    }
    assert_none(&found);
}
