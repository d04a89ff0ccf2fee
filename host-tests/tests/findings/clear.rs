//! After `clear` the master knows what each drive does, nothing was switched, and nothing moves.

use can_motion::Reaction;

use crate::support::servos::{Servos, servo};
use crate::support::wheels::{Wheels, hub, hubs};
use crate::support::{Call, assert_none};

/// Two servos in motion, of which the second switches itself off.
fn faulted(reaction: Reaction) -> Servos {
    let partner = servo(2).react(|reactions| reactions.position = reaction);
    let mut machine = Servos::streaming(&[servo(1), partner]);
    machine.move_all(&[100, 100], 100);
    machine.faults_mut(1).disable_itself();
    machine.move_all(&[100, 100], 500);
    machine
}

fn is(on: bool) -> &'static str {
    if on { "on" } else { "off" }
}

/// What the master says of an axis that had the fault of its group, and what its drive does, after `clear`.
fn after_clear(reaction: Reaction) -> Vec<String> {
    let mut machine = faulted(reaction);
    let before = machine.energised(0);
    let mark = machine.mark();
    machine.call(Call::Clear).unwrap();
    let mut found = Vec::new();
    for cycles in [0, 300] {
        machine.run(cycles);
        let (on, believed) = (machine.energised(0), machine.believed_on(0));
        let fault = machine.fault(0);
        if on != believed || fault.is_some() {
            found.push(format!(
                "{reaction:?}, {cycles} cycles after clear: the drive is {}, the master says {}, fault {fault:?}",
                is(on),
                is(believed),
            ));
        }
    }
    let commands = machine.commands_since(mark, 0);
    let set_points = machine.steps_since(mark, 0).len();
    if machine.energised(0) != before || !commands.is_empty() || set_points > 0 {
        found.push(format!(
            "{reaction:?}: clear switched or moved something: {commands:?}, {set_points} set-points"
        ));
    }
    found
}

/// Finding 8.
#[test]
fn after_a_group_ramp_and_clear_the_master_knows_that_the_drive_is_on() {
    assert_none(&after_clear(Reaction::RampDown));
}

/// Finding 8.
#[test]
fn after_a_disabling_fault_and_clear_the_master_knows_that_the_drive_is_off() {
    assert_none(&after_clear(Reaction::Disable));
}

/// The third reaction, which was right.
#[test]
fn after_a_halting_fault_and_clear_the_master_knows_that_the_drive_is_on() {
    assert_none(&after_clear(Reaction::Halt));
}

/// Finding 8 for wheels.
#[test]
fn after_clear_the_master_knows_which_wheels_are_on() {
    let mut found = Vec::new();
    for reaction in [Reaction::Halt, Reaction::RampDown, Reaction::Disable] {
        for halted_before in [false, true] {
            let partner = hub(2).react(|reactions| reactions.drive = reaction);
            let mut machine = Wheels::streaming(&[hub(1), partner]);
            machine.drive_at(&[100, 100], 50);
            if halted_before {
                machine.call(Call::Halt).unwrap();
                machine.run(100);
                machine.call(Call::Resume).unwrap();
                machine.drive_at(&[100, 100], 50);
            }
            machine.faults_mut(1).trip(0x0004);
            machine.run(300);
            machine.faults_mut(1).remove_cause();
            let cleared = machine.call(Call::Clear);
            let (on, believed) = (machine.energised(0), machine.believed_on(0));
            if on != believed && machine.fault(0).is_none() {
                found.push(format!(
                    "{reaction:?}, halted before: {halted_before}, clear {cleared:?}: the wheel is {}, the master says {}, fault {:?}",
                    is(on),
                    is(believed),
                    machine.fault(0)
                ));
            }
        }
    }
    assert_none(&found);
}

/// Finding 2.
#[test]
fn a_wheel_in_position_mode_does_not_move_after_clear() {
    let mut found = Vec::new();
    for halted_before in [true, false] {
        for reaction in [Reaction::RampDown, Reaction::Halt, Reaction::Disable] {
            let wheels = [1, 2].map(|node| {
                hub(node)
                    .position(60)
                    .react(|reactions| reactions.drive = reaction)
            });
            let mut machine = Wheels::streaming(&wheels);
            if halted_before {
                machine.call(Call::Halt).unwrap();
                machine.run(50);
                machine.call(Call::Resume).unwrap();
                machine.run(100);
            }
            let target = machine.sent(0) + 25_000;
            machine.drive_at(&[target, target], 100);
            machine.faults_mut(1).trip(0x0004);
            machine.run(200);
            let stood = machine.travel(0);
            machine.faults_mut(1).remove_cause();
            let cleared = machine.call(Call::Clear);
            machine.run(1_000);
            let moved = machine.travel(0) - stood;
            if moved != 0 {
                found.push(format!(
                    "{reaction:?}, halted before: {halted_before}: the wheel runs {moved} counts after clear ({cleared:?}), nobody resumed"
                ));
            }
        }
    }
    assert_none(&found);
}

/// Finding 9.
#[test]
fn a_wheel_that_restarts_while_its_group_is_faulted_is_set_up_again_or_faulted() {
    let mut found = Vec::new();
    for off_ms in [0, 1, 20, 50] {
        let mut machine = Wheels::streaming(&hubs(2));
        machine.drive_at(&[100, 100], 50);
        machine.faults_mut(0).trip(0x0004);
        machine.run(100);
        machine.faults_mut(1).power_cycle(off_ms * 1_000_000);
        machine.run(100);
        machine.faults_mut(0).remove_cause();
        let _ = machine.call(Call::Clear);
        machine.run(300);
        let (on, believed) = (machine.energised(1), machine.believed_on(1));
        let (mark, fault) = (machine.mark(), machine.fault(1));
        machine.run(50);
        let commands = machine.commands_since(mark, 1).len();
        if fault.is_none() && (on != believed || !machine.is_operational(1) || commands == 0) {
            found.push(format!(
                "{off_ms} ms without power: no fault, the master says {}, the wheel is {}, operational: {}, {commands} commands in 50 cycles",
                is(believed),
                is(on),
                machine.is_operational(1),
            ));
        }
    }
    assert_none(&found);
}

/// Beyond the list: a servo that restarts while its group is faulted. It may come back switched on, somewhere else.
#[test]
fn a_servo_that_restarts_while_its_group_is_faulted_is_known_again_before_it_holds() {
    let mut found = Vec::new();
    for on_after_power in [false, true] {
        let one = servo(1).drive(|drive| {
            drive.enabled_after_power_on = on_after_power;
            drive.power_on_delay_ns = 1_000_000;
        });
        let mut machine = Servos::new(&[one, servo(2)]);
        machine.become_ready();
        machine.call(Call::Disable).unwrap();
        machine.run(100);
        machine.call(Call::Enable).unwrap();
        machine.run(400);
        machine.move_all(&[100, 100], 100);
        machine.faults_mut(1).disable_itself();
        machine.run(200);
        machine.faults_mut(0).reboot();
        machine.run(100);
        let cleared = machine.call(Call::Clear);
        machine.run(400);
        let (on, believed, fault) = (
            machine.energised(0),
            machine.believed_on(0),
            machine.fault(0),
        );
        let says = machine.target(0);
        let stands = machine.0.drive(0).position_counts(machine.now_ns());
        if fault.is_none() && (on != believed || believed && i64::from(says) != stands) {
            found.push(format!(
                "on after power-on: {on_after_power}, clear {cleared:?}: the drive is {} at {stands} counts, the master says {} at {says} counts",
                is(on),
                is(believed),
            ));
        }
    }
    assert_none(&found);
}
