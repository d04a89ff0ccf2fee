//! Writes and resets beside the cycle leave only while their drive is off, and an aborted one does not leave at all.

use can_motion::{Procedure, Reaction};
use dyn_can::{Alarm, FunctionCode, MaxAcceleration, MaxSpeed, Request, SetParamGroup2};

use crate::support::servos::{Servos, Told, servo, writes};
use crate::support::wheels::{Wheels, hubs};
use crate::support::{Call, assert_none};

/// Cycles with a look at the bus after each: writes that left while the drive was on or had set-points.
fn watch(machine: &mut Servos, cycles: usize, what: &str) -> Vec<String> {
    let mut found = Vec::new();
    let from = machine.mark();
    for cycle in 0..cycles {
        let (mark, was_on) = (machine.mark(), machine.energised(0));
        machine.run(1);
        for told in machine.commands_since(mark, 0) {
            if let Told::Write(function) = told
                && was_on
                && machine.energised(0)
            {
                let streamed = machine.steps_since(from, 0).len();
                found.push(format!(
                    "{what}: {function:?} left {cycle} cycles after enable, the drive on, {streamed} set-points before it"
                ));
            }
        }
    }
    let mark = machine.mark();
    machine.run(50);
    let set_points = machine.steps_since(mark, 0).len();
    let (on, fault) = (machine.energised(0), machine.fault(0));
    if on && set_points == 0 && fault.is_none() && !machine.believed_on(0) {
        found.push(format!(
            "{what}: in the end the drive is on, the master says off, no set-point goes out, no fault"
        ));
    }
    found
}

/// Finding 3.
#[test]
fn a_write_that_was_begun_before_enable_does_not_leave_while_streaming() {
    let mut found = Vec::new();
    for (name, procedure) in writes() {
        for later in [0, 1, 2, 3, 5, 10, 15, 20, 25, 30] {
            let mut machine = Servos::new(&[servo(1)]);
            machine.become_ready();
            machine.start(0, procedure).unwrap();
            machine.run(later);
            // It may be refused, or end the procedure.
            let _ = machine.call(Call::Enable);
            found.extend(watch(
                &mut machine,
                600,
                &format!("{name}, enable {later} cycles later"),
            ));
        }
    }
    assert_none(&found);
}

/// Finding 3: the same with a procedure that a fault allows, and a clear.
#[test]
fn a_write_that_was_begun_under_a_fault_does_not_leave_after_clear_and_resume() {
    let mut found = Vec::new();
    for (name, procedure) in writes() {
        let partner = servo(2);
        let mut machine = Servos::streaming(&[servo(1), partner]);
        machine.move_all(&[10, 10], 50);
        // The partner stops; this axis has the fault of its group and stays on.
        machine.faults_mut(1).disable_itself();
        machine.run(60);
        let mark = machine.mark();
        let on = machine.energised(0);
        let started = machine.start(0, procedure);
        let _ = machine.call(Call::Clear);
        machine.run(400);
        let written: Vec<Told> = machine
            .commands_since(mark, 0)
            .into_iter()
            .filter(|told| matches!(told, Told::Write(_)))
            .collect();
        if on && !written.is_empty() {
            found.push(format!(
                "{name}: {started:?} under the fault of the group, {written:?} left with the drive on"
            ));
        }
    }
    assert_none(&found);
}

/// Finding 5: a data error comes in when the command of a procedure was chosen and not yet offered.
#[test]
fn a_command_whose_procedure_was_aborted_does_not_leave() {
    let mut found = Vec::new();
    let fault_frames = [
        ("data error", FunctionCode::DriveError, [0xFF]),
        ("alarm", FunctionCode::DriveError, [0xEE]),
    ];
    for (name, procedure) in writes() {
        for (what, function, data) in fault_frames {
            for later in 0..40 {
                let mut machine = Servos::new(&[servo(1)]);
                machine.become_ready();
                machine.start(0, procedure).unwrap();
                machine.run(later);
                if wrote(&machine) {
                    // What is written already is another story.
                    break;
                }
                let counted = machine.eeprom_writes_counted(0);
                let mark = machine.mark();
                machine
                    .0
                    .cycle_with(|rig| Servos::comes_in(rig, 0, function, &data));
                machine.run(100);
                let left = machine.commands_since(mark, 0);
                if !left.is_empty() {
                    found.push(format!(
                        "{name}, {what} {later} cycles later: {left:?} left after the fault {:?}; the drive counts {} EEPROM writes, the master {}",
                        machine.fault(0),
                        machine.eeprom_writes_made(0),
                        machine.eeprom_writes_counted(0) - counted
                    ));
                }
            }
        }
    }
    assert_none(&found);
}

/// What comes back unsent and goes out again wears the drive once.
#[test]
fn a_write_that_was_displaced_is_counted_once() {
    let both = SetParamGroup2 {
        max_speed: MaxSpeed::new(17).ok(),
        max_acceleration: MaxAcceleration::new(9).ok(),
    };
    let mut machine = Servos::new(&[servo(1)]);
    machine.become_ready();
    machine.start(0, Procedure::WriteGroup2(both)).unwrap();
    for _ in 0..100 {
        if machine.eeprom_writes_counted(0) != 0 {
            break;
        }
        machine.run(1);
    }
    assert_eq!(machine.eeprom_writes_counted(0), 2);
    machine.command_comes_back(0, Request::SetParamGroup2(both));
    assert_eq!(machine.eeprom_writes_counted(0), 0);
    machine.run(200);
    assert_eq!(machine.eeprom_writes_counted(0), 2);
}

fn wrote(machine: &Servos) -> bool {
    let commands = machine.commands_since(0, 0);
    commands.iter().any(|told| matches!(told, Told::Write(_)))
}

/// Finding 5: the reset of a wheel's fault, which an emergency message aborts before it was offered.
#[test]
fn a_fault_reset_that_was_aborted_does_not_leave() {
    let mut found = Vec::new();
    for later in 0..120 {
        let mut machine = Wheels::streaming(&hubs(2));
        machine.faults_mut(0).trip(0x0008);
        machine.run(5);
        machine.faults_mut(0).remove_cause();
        machine.call(Call::Clear).unwrap();
        let cleared = machine.mark();
        machine.run(later);
        if resets(&machine, cleared) > 0 {
            break;
        }
        let (mark, node) = (machine.mark(), machine.node(0));
        machine.0.cycle_with(|rig| {
            Wheels::comes_in(rig, 0x080 + node, &[0x00, 0x10, 0x01, 4, 0, 0, 0, 0]);
        });
        machine.run(50);
        let left = resets(&machine, mark);
        if left > 0 {
            found.push(format!(
                "an emergency message {later} cycles after clear: {left} fault resets left afterwards, nobody cleared, fault {:?}",
                machine.fault(0)
            ));
        }
    }
    assert_none(&found);
}

/// Control words with the reset bit that were written to wheel 0 since a mark.
fn resets(machine: &Wheels, mark: usize) -> usize {
    let transfers = machine.transfers_since(mark, 0);
    let is_reset = |data: &&Vec<u8>| data[..4] == [0x2B, 0x40, 0x60, 0x00] && data[4] & 0x80 != 0;
    transfers.iter().filter(is_reset).count()
}

/// Promise 10: what repairs a drive can be reached under its own fault, with the power confirmed off.
#[test]
fn a_reset_can_be_started_under_an_own_fault_with_the_drive_off() {
    let mut machine =
        Servos::streaming(&[servo(1).react(|reactions| reactions.alarm = Reaction::Disable)]);
    machine.faults_mut(0).raise_alarm(Alarm::OverCurrent);
    machine.run(300);
    assert!(!machine.energised(0));
    let mark = machine.mark();
    machine.start(0, Procedure::DriveReset).unwrap();
    machine.run(50);
    let reset = Told::Write(FunctionCode::DriveReset);
    assert_eq!(machine.commands_since(mark, 0), [reset]);
}
