//! Power is not taken from a load that nobody meant, and not taken for what it is not.

use can_motion::Fault;
use dyn_can::{Alarm, FunctionCode};

use crate::support::servos::{Servos, Told, servo, servos};
use crate::support::wheels::{Wheels, hub};
use crate::support::{Call, assert_none};

fn is(on: bool) -> &'static str {
    if on { "on" } else { "off" }
}

/// Promise 9: a drive that was on before its master is known to be on, is left alone, and takes no set-points.
#[test]
fn a_drive_found_on_is_known_to_be_on_and_left_alone() {
    let on = servo(1).drive(|drive| drive.enabled_after_power_on = true);
    let mut machine = Servos::new(&[on, servo(2)]);
    machine.become_checked();
    machine.run(100);
    let mut found = Vec::new();
    if !machine.believed_on(0) {
        found.push("the drive is on, the master says off".into());
    }
    let mark = machine.mark();
    let enabled = machine.call(Call::Enable);
    machine.move_all(&[10, 10], 600);
    let set_points = machine.steps_since(mark, 0).len();
    if set_points > 0 {
        found.push(format!(
            "enable gave {enabled:?}, and {set_points} set-points went to a drive that this master had not switched on and nobody adopted"
        ));
    }
    assert_none(&found);
    assert_eq!(machine.commands_since(0, 0), [], "it is left alone");
}

/// Promise 9: a drive found on is taken over by `adopt`, which switches nothing and moves nothing, and moves by a word of its own.
#[test]
fn a_drive_found_on_is_adopted_without_a_command() {
    let on = servo(1).drive(|drive| drive.enabled_after_power_on = true);
    let mut machine = Servos::new(&[on, servo(2)]);
    machine.become_checked();
    machine.call(Call::Adopt).unwrap();
    machine.move_all(&[10, 10], 600);
    assert_eq!(machine.commands_since(0, 0), []);
    assert!(machine.believed_on(0) && machine.energised(0));
    assert!(machine.believed_off(1) && !machine.energised(1));
    assert_eq!(machine.taken(0), 0, "adopt moves nothing");
    machine.call(Call::Enable).unwrap();
    machine.run(400);
    machine.move_all(&[10, 10], 100);
    let commands = [0, 1].map(|axis| machine.commands_since(0, axis));
    assert_eq!(commands, [vec![], vec![Told::On]]);
    assert_eq!([0, 1].map(|axis| machine.taken(axis)), [1_000; 2]);
}

/// Promise 9: another master switches a drive on that this one left off.
#[test]
fn a_drive_that_another_master_switches_on_is_noticed_and_left_alone() {
    let mut machine = Servos::new(&servos(2));
    machine.become_ready();
    let stranger = machine.add_stranger();
    machine.stranger_switches(stranger, 0, true);
    let mark = machine.mark();
    machine.run(200);
    let commands = machine.commands_since(mark, 0);
    assert_eq!(commands, [], "nobody asked for a command");
    assert!(machine.energised(0));
    assert!(
        machine.believed_on(0) || machine.fault(0).is_some(),
        "another master switched the drive on 200 ms ago, this one says off and has no fault"
    );
}

/// Promise 9: an alarm frees the shaft of a drive, so that its power is not what it was.
#[test]
fn after_an_alarm_the_drive_is_not_said_to_be_on() {
    let mut machine = Servos::streaming(&servos(2));
    machine.move_all(&[10, 10], 50);
    machine.faults_mut(0).raise_alarm(Alarm::OverCurrent);
    machine.run(100);
    assert!(!machine.energised(0));
    assert!(!machine.believed_on(0));
}

/// Promise 7: a drive that goes to speed mode before it is enabled takes no set-points, and one that does so after the check that
/// enabling begins with is noticed within a second of motion.
#[test]
fn a_mode_that_changed_after_the_check_is_noticed() {
    let mut found = Vec::new();
    for later in [0, 50, 154, 400] {
        let mut machine = Servos::new(&servos(1));
        machine.become_ready();
        if later > 0 {
            machine.call(Call::Enable).unwrap();
            machine.run(later);
        }
        let speed_mode = dyn_can::ConfigByte::from_byte(0x08);
        machine.faults_mut(0).misconfigure(speed_mode);
        let before = machine.steps_since(0, 0).len();
        if later == 0 {
            machine.run(20);
            let _ = machine.call(Call::Enable);
        }
        machine.move_all(&[10], 2_000);
        let set_points = machine.steps_since(0, 0).len() - before;
        let most = if later == 0 { 0 } else { 1_000 };
        if set_points > most || machine.fault(0).is_none() {
            found.push(format!(
                "the drive went to speed mode {later} ms after enable: {set_points} set-points were sent to it, fault {:?}",
                machine.fault(0)
            ));
        }
    }
    assert_none(&found);
}

/// Promise 7: the mode is guarded afterwards, also while nothing moves.
#[test]
fn a_mode_that_changed_under_a_standing_axis_is_noticed() {
    let mut machine = Servos::new(&servos(1));
    machine.become_ready();
    machine.call(Call::Enable).unwrap();
    machine.run(600);
    assert_eq!(machine.fault(0), None);
    let speed_mode = dyn_can::ConfigByte::from_byte(0x08);
    machine.faults_mut(0).misconfigure(speed_mode);
    machine.run(1_200);
    let fault = Fault::Config(speed_mode);
    assert_eq!(machine.fault(0), Some(fault));
}

/// Promise 2: a gear number that does not fit the scale of the axis is refused before anything moves.
#[test]
fn a_drive_with_another_gear_number_takes_no_set_points() {
    let other = servo(1).drive(|drive| {
        drive.group3.gear_number = dyn_can::GearNumber::new(2_048).unwrap();
    });
    let mut machine = Servos::new(&[other]);
    machine.run(400);
    let enabled = machine.call(Call::Enable);
    machine.move_all(&[10], 600);
    let set_points = machine.steps_since(0, 0).len();
    assert_eq!(
        set_points, 0,
        "the drive has gear 2048, the axis counts with 4096, enable gave {enabled:?}"
    );
}

/// Beyond the list: a fault while a group is being disabled does not leave a drive on.
#[test]
fn a_fault_in_the_ramp_of_a_disable_does_not_keep_the_drive_on() {
    let mut found = Vec::new();
    type Cause = fn(&mut Servos);
    let causes: [(&str, Cause); 4] = [
        ("alarm of the partner", |machine| {
            machine.faults_mut(1).raise_alarm(Alarm::OverCurrent);
        }),
        ("the partner is off", |machine| {
            machine.faults_mut(1).disable_itself()
        }),
        ("data error of its own", |machine| {
            machine.0.cycle_with(|rig| {
                Servos::comes_in(rig, 0, FunctionCode::DriveError, &[0xFF]);
            });
        }),
        ("bus-off for 10 ms", |machine| {
            machine.bus_off();
            machine.run(10);
            machine.bus_recovered();
        }),
    ];
    for (what, cause) in causes {
        for later in [0, 1, 5, 20, 39] {
            let mut machine = Servos::streaming(&[servo(1).ramp_change(1), servo(2)]);
            machine.move_all(&[40, 10], 100);
            machine.call(Call::Disable).unwrap();
            machine.run(later);
            cause(&mut machine);
            machine.run(1_000);
            if machine.energised(0) {
                found.push(format!(
                    "{what} {later} cycles after disable: the drive is still on a second later, the master says {}, fault {:?}",
                    is(machine.believed_on(0)),
                    machine.fault(0)
                ));
            }
        }
    }
    assert_none(&found);
}

/// Beyond the list: the same for wheels.
#[test]
fn a_fault_in_the_ramp_of_a_disable_does_not_keep_a_wheel_on() {
    let mut found = Vec::new();
    for later in [0, 1, 5, 15] {
        let mut machine = Wheels::streaming(&[hub(1), hub(2)]);
        machine.drive_at(&[200, 200], 60);
        machine.call(Call::Disable).unwrap();
        machine.run(later);
        machine.faults_mut(1).trip(0x0004);
        machine.run(300);
        if machine.energised(0) {
            found.push(format!(
                "the partner trips {later} cycles after disable: the wheel is still on three seconds later, fault {:?}",
                machine.fault(0)
            ));
        }
    }
    assert_none(&found);
}

/// Finding 19: bus-off is not ignored by the exit, and a disable that was asked for meanwhile follows the recovery.
#[test]
fn while_the_bus_is_off_nothing_leaves_and_a_disable_follows_its_recovery() {
    let mut machine = Servos::streaming(&servos(2));
    machine.move_all(&[10, 10], 50);
    machine.bus_off();
    machine.run(2);
    let mark = machine.mark();
    machine.call(Call::Disable).unwrap();
    machine.run(50);
    assert_eq!(machine.told_since(mark), [], "while the bus is off");
    machine.bus_recovered();
    machine.run(300);
    for axis in 0..2 {
        assert!(!machine.energised(axis), "axis {axis} is still on");
        assert_eq!(machine.commands_since(mark, axis), [Told::Off]);
    }
}
