//! Ramps and targets stay where the axis may be.

use can_motion::Reaction;
use dyn_can::Alarm;

use crate::support::servos::{Servos, servo, servos};
use crate::support::wheels::{Wheels, hub, hubs};
use crate::support::{Call, assert_none};

/// Two axes that move at different speeds, the slower one near an end of its travel: how far it goes beyond.
fn beyond(sign: i32, stop: impl Fn(&mut Servos)) -> i64 {
    let end = 4_015 * sign;
    let near = servo(2).travel(end.min(-5_000), end.max(5_000));
    let near = if sign > 0 {
        near.travel(-5_000, end)
    } else {
        near.travel(end, 5_000)
    };
    let fast = servo(1).ramp_change(2);
    let third = servo(3).react(|reactions| reactions.alarm = Reaction::RampDown);
    let mut machine = Servos::streaming(&[fast, near, third]);
    // 20 counts a cycle for 200 cycles leave 15 counts of travel.
    machine.move_all(&[300 * sign, 20 * sign, 0], 200);
    stop(&mut machine);
    machine.run(400);
    let reached = machine.taken(1);
    (reached - i64::from(end)) * i64::from(sign)
}

/// Finding 6.
#[test]
fn a_common_ramp_does_not_leave_the_travel() {
    let mut found = Vec::new();
    for sign in [1, -1] {
        let by_stop = beyond(sign, |machine| machine.call(Call::Stop).unwrap());
        if by_stop > 0 {
            found.push(format!(
                "stop, direction {sign}: {by_stop} counts beyond the travel"
            ));
        }
        let by_disable = beyond(sign, |machine| machine.call(Call::Disable).unwrap());
        if by_disable > 0 {
            found.push(format!(
                "disable, direction {sign}: {by_disable} counts beyond the travel"
            ));
        }
        let by_fault = beyond(sign, |machine| {
            machine.faults_mut(2).raise_alarm(Alarm::OverCurrent);
        });
        if by_fault > 0 {
            found.push(format!(
                "a fault of a partner, direction {sign}: {by_fault} counts beyond the travel"
            ));
        }
    }
    assert_none(&found);
}

/// Finding 13.
#[test]
fn a_target_far_away_in_mid_cycle_moves_nothing() {
    let mut found = Vec::new();
    for sign in [1, -1] {
        let mut machine = Servos::streaming(&[servo(1).max_step(1_000).backlog(1_000)]);
        let target = machine.target(0) + sign * 1_000_000;
        machine.0.cycle_with(|rig| {
            let _ = rig.master.set_target(0, target);
        });
        machine.run(50);
        let moved = machine.taken(0);
        if moved != 0 {
            found.push(format!(
                "a target {} counts away, 1000 are allowed, moved the drive by {moved} counts before the fault {:?}",
                sign * 1_000_000,
                machine.fault(0)
            ));
        }
    }
    assert_none(&found);
}

/// Beyond the list: a stop that comes with a new target.
#[test]
fn a_wheel_that_is_stopped_at_rest_does_not_start() {
    let mut found = Vec::new();
    for call in [Call::Stop, Call::Disable] {
        let mut machine = Wheels::streaming(&hubs(2));
        machine.drive_at(&[0, 0], 20);
        machine.set_target(0, 300);
        machine.set_target(1, 300);
        machine.call(call).unwrap();
        let mut most = 0.0_f64;
        for _ in 0..200 {
            machine.run(1);
            most = most.max(machine.speed_rpm(0).abs());
        }
        if most > 1.0 {
            found.push(format!(
                "{call:?} in the cycle of the first target: the wheel starts, reaches {most} r/min and turns at {} two seconds later, fault {:?}",
                machine.speed_rpm(0),
                machine.fault(0)
            ));
        }
    }
    for call in [Call::Stop, Call::Disable] {
        let position = [1, 2].map(|node| {
            hub(node)
                .position(60)
                .limits(|limits| limits.values.max_step = 40)
        });
        let mut machine = Wheels::streaming(&position);
        machine.run(20);
        machine.set_target(0, 20_000);
        machine.call(call).unwrap();
        machine.run(1_000);
        let travel = machine.travel(0);
        if travel.abs() > 100 {
            found.push(format!(
                "{call:?} in the cycle of the first target: a wheel in position mode went {travel} counts"
            ));
        }
    }
    assert_none(&found);
}

/// The ramp of servos that stand ends at once and moves nothing.
#[test]
fn a_servo_that_is_stopped_at_rest_does_not_start() {
    for call in [Call::Stop, Call::Disable, Call::Halt] {
        let mut machine = Servos::streaming(&servos(2));
        machine.set_target(0, 5_000);
        machine.call(call).unwrap();
        machine.run(300);
        assert_eq!(machine.taken(0), 0, "{call:?}");
    }
}
