//! What happens to one axis is no reason for another to wait, to stop late or to lose its velocity.

use can_motion::facts::Power;
use can_motion::{AxisState, DriveMove, Procedure};
use dyn_can::{Alarm, FunctionCode, MaxSpeed, SetParamGroup2};

use crate::own_moves::slow_servo;
use crate::support::Call;
use crate::support::servos::{Servos, Told, line, servo};

/// A write waits, because somebody else has switched its drive on; the polls of both drives go on.
#[test]
fn a_write_that_has_to_wait_keeps_no_poll_waiting() {
    let slow = |id| {
        servo(id).drive(|drive| drive.response_delay = drive_sim::ResponseDelay::fixed(3_000_000))
    };
    let mut machine = Servos::on(line().responses_up_to_us(3_500), &[slow(1), slow(2)]);
    let stranger = machine.add_stranger();
    machine.become_ready();
    // Its next status is the first that shows it.
    machine.until_asked(0, FunctionCode::ReadDriveStatus, |machine| machine.run(1));
    machine.run(5);
    machine.stranger_switches(stranger, 0, true);
    machine.until_asked(0, FunctionCode::ReadDriveStatus, |machine| machine.run(1));
    let group = SetParamGroup2 {
        max_speed: MaxSpeed::new(33).ok(),
        max_acceleration: None,
    };
    machine.start(0, Procedure::WriteGroup2(group)).unwrap();
    machine.run(200);
    assert_eq!(machine.0.axis(0).facts.power, Power::FoundOn);
    let mark = machine.mark();
    machine.run(200);
    let told = machine.told_since(mark);
    for axis in [0, 1] {
        for function in [FunctionCode::ReadDriveStatus, FunctionCode::GeneralRead] {
            let polls = told
                .iter()
                .filter(|to| (to.axis, to.told) == (axis, Told::Reading(function)));
            assert!(polls.count() >= 5, "{function:?} of axis {axis}");
        }
    }
    // It leaves when it may.
    machine.stranger_switches(stranger, 0, false);
    let mark = machine.mark();
    machine.run(200);
    let written = Told::Write(FunctionCode::SetParamGroup2);
    assert_eq!(machine.commands_since(mark, 0), [written]);
}

/// The mailboxes take three of four set-points while the bus is blocked for a cycle: only the fourth axis has something to catch up.
#[test]
fn a_set_point_that_is_late_leaves_the_others_their_velocity() {
    let servos: Vec<_> = (1..=4)
        .map(|id| servo(id).ramp_change(1).unwatched())
        .collect();
    let mut machine = Servos::streaming(&servos);
    for velocity in 0..=40 {
        machine.move_all(&[velocity; 4], 1);
    }
    machine.move_all(&[40; 4], 10);
    let mark = machine.mark();
    let merged = |machine: &Servos| [0, 1, 2, 3].map(|axis| machine.0.axis(axis).counters.merged);
    let before = merged(&machine);
    machine.block_bus_for_ms(1);
    machine.move_all(&[40; 4], 200);
    let steps = [0, 1, 2, 3].map(|axis| machine.steps_since(mark, axis));
    let was_late = merged(&machine).map(|merged| merged > 0);
    assert_eq!(before, [0; 4]);
    assert_eq!(was_late, [false, false, false, true]);
    for (axis, steps) in steps.iter().enumerate().take(3) {
        let other = steps.iter().find(|step| **step != 40);
        assert_eq!(other, None, "axis {axis}: {steps:?}");
    }
    assert!(machine.all_stream());
}

/// An alarm of one drive ends the motion that another one makes by itself, as soon as without the alarm.
#[test]
fn the_quiet_time_behind_an_alarm_delays_no_stop() {
    let mut machine = Servos::streaming(&[slow_servo(1), slow_servo(2)]);
    machine.call(Call::Stop).unwrap();
    machine.0.run_until(AxisState::Holding);
    machine.start(1, Procedure::ReadGroup2).unwrap();
    machine.run(40);
    machine.lets_move(1, DriveMove::To(400_000)).unwrap();
    machine.run(200);
    assert_eq!(machine.0.state(1), AxisState::DriveMoving);
    machine.faults_mut(0).raise_alarm(Alarm::OverCurrent);
    machine.run(2);
    assert!(machine.fault(0).is_some());
    machine.run(1);
    let is_stop = |told: &Told| matches!(told, Told::Own(FunctionCode::GoAbsolutePosPtp, at) if *at < 400_000);
    let commands = machine.commands_since(0, 1);
    assert!(commands.iter().any(is_stop), "{commands:?}");
}
