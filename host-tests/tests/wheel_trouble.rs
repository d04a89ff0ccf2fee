//! Wheels when something goes wrong on the way: replies, frames, the bus, and what a quick stop leaves behind.

use can_motion::AxisState;
use can_motion::wheel::{
    FeedbackTiming, WheelConfig, WheelEventKind, WheelFault, WheelLimits, WheelMasterConfig,
    WheelMode,
};
use drive_sim::{ControllerConfig, Frame, ReplyDamage, ZlacDriveConfig};
use embedded_can::nb::Can as _;
use host_tests::rig::{GROUP, WheelRig};
use zlac8030l::{NodeId, objects};

const SYNC: WheelMasterConfig = WheelMasterConfig {
    feedback: FeedbackTiming::Sync,
    ..WheelMasterConfig::DEFAULT
};

/// Two wheels, nodes 1 and 2.
fn pair(wheel: WheelConfig, change: impl Fn(&mut ZlacDriveConfig)) -> WheelRig {
    let nodes = [1, 2].map(|number| NodeId::new(number).unwrap());
    let wheels = nodes.map(|node| WheelConfig { node, ..wheel });
    let drives = nodes.map(|node| {
        let mut drive = ZlacDriveConfig::new(node);
        change(&mut drive);
        drive
    });
    WheelRig::wheels(SYNC, &wheels, drives.to_vec())
}

fn velocity() -> WheelConfig {
    host_tests::rig::wheel_config(NodeId::MIN)
}

fn position() -> WheelConfig {
    WheelConfig {
        mode: WheelMode::Position {
            profile_speed_rpm: 1_000,
        },
        // Two cycles to take a target, and the way to get to speed.
        limits: WheelLimits {
            following_error: 4_096,
            ..WheelLimits::position(-0x3FFF_FFFF, 0x3FFF_FFFF, 400, 20)
        },
        ..velocity()
    }
}

fn drive_at(rig: &mut WheelRig, target: i32, cycles: usize) {
    for _ in 0..cycles {
        for wheel in [0, 1] {
            rig.master.set_target(wheel, target).unwrap();
        }
        rig.cycle();
    }
}

fn positions(rig: &WheelRig) -> [i64; 2] {
    [0, 1].map(|wheel| rig.drive(wheel).position_counts(rig.bench.now_ns()))
}

fn speeds_rpm(rig: &WheelRig) -> [f64; 2] {
    [0, 1].map(|wheel| rig.drive(wheel).speed_rpm(rig.bench.now_ns()))
}

#[test]
fn a_quick_stop_in_the_middle_of_a_move_is_not_followed_by_the_rest_of_it() {
    let mut rig = pair(position(), |_| {});
    rig.stream();
    drive_at(&mut rig, 8_192, 10);
    let now = rig.now();
    rig.master.halt(now, GROUP);
    rig.cycles(50);
    let held = positions(&rig);
    assert!(
        held.iter().all(|counts| (1_000..8_000).contains(counts)),
        "{held:?}"
    );
    let now = rig.now();
    rig.master.resume(now, GROUP).unwrap();
    for _ in 0..100 {
        rig.cycle();
        assert_eq!(positions(&rig), held);
    }
    assert!(rig.master.all_are(GROUP, AxisState::Streaming));
    drive_at(&mut rig, 0, 100);
    assert_eq!(positions(&rig), [0, 0]);
}

#[test]
fn a_wheel_that_cannot_follow_its_speed_is_a_fault() {
    // 1 r/min more each second, in place of 1000 in a second.
    let mut rig = pair(velocity(), |drive| drive.motor_acceleration_rpm_s = 1.0);
    rig.stream();
    for _ in 0..100 {
        for wheel in [0, 1] {
            // Refused once the fault is there.
            let _ = rig.master.set_target(wheel, 100);
        }
        rig.cycle();
    }
    let fault = rig.axis(0).fault;
    let expected = matches!(
        fault,
        Some(WheelFault::FollowingSpeed {
            sent_decirpm: 1_000,
            actual_decirpm: 0..10
        })
    );
    assert!(expected, "{fault:?}");
}

/// Two wheels whose drives say that they count 1/10 r/min, and count whole ones until they are restarted (Z34).
fn pair_that_was_not_restarted() -> WheelRig {
    let wheel = WheelConfig {
        speed_resolution: 10,
        limits: WheelLimits::speed(600, 10),
        ..velocity()
    };
    let mut rig = pair(wheel, |_| {});
    let tool = rig.bench.add_master(ControllerConfig::device());
    rig.bench.advance_to(1_000_000_000);
    for node in [1, 2].map(|number| NodeId::new(number).unwrap()) {
        let frame = objects::SPEED_RESOLUTION.write(10).encode(node);
        let frame: Frame = frame.to_can().expect("eleven bits");
        rig.bench.port(tool).transmit(&frame).expect("room");
        let soon = rig.bench.now_ns() + 100_000_000;
        rig.bench.advance_to(soon);
    }
    rig
}

#[test]
fn a_drive_that_counts_other_speeds_than_it_says_is_stopped_long_before_ten_times_its_speed() {
    for sign in [1, -1] {
        let mut rig = pair_that_was_not_restarted();
        rig.stream();
        let mut fastest_rpm = 0.0_f64;
        for cycle in 1..=100 {
            for wheel in [0, 1] {
                // Up to 60 r/min. Refused once the fault is there.
                let _ = rig.master.set_target(wheel, sign * (10 * cycle).min(600));
            }
            rig.cycle();
            let speeds = speeds_rpm(&rig).map(f64::abs);
            fastest_rpm = speeds.into_iter().fold(fastest_rpm, f64::max);
        }
        let faults = [0, 1].map(|wheel| rig.axis(wheel).fault);
        let is_over = |fault: &Option<WheelFault>| {
            matches!(fault, Some(WheelFault::OverSpeed { most_decirpm: 1_200, actual_decirpm })
                if actual_decirpm.abs() > 1_200 && actual_decirpm.signum() == sign)
        };
        assert!(faults.iter().any(is_over), "{faults:?}");
        // 60 r/min are allowed, and it would have been 600.
        assert!(fastest_rpm < 180.0, "{fastest_rpm}");
    }
}

#[test]
fn spoilt_replies_delay_the_set_up_and_do_not_change_it() {
    let mut rig = pair(velocity(), |_| {});
    let damage = [
        ReplyDamage::WrongIndex,
        ReplyDamage::Drop,
        ReplyDamage::Short,
        ReplyDamage::Delay(60_000_000),
        ReplyDamage::Duplicate,
        ReplyDamage::WrongSub,
    ];
    rig.cycles(20);
    for kind in damage {
        rig.drive_mut(0).faults_mut().damage_next_reply(kind);
        // A read that is not answered three times in a row would end the set-up.
        rig.cycles(20);
    }
    rig.stream();
    assert!(
        rig.axis(0).counters.timeouts >= 5,
        "{:?}",
        rig.axis(0).counters
    );
    assert!(
        rig.drive(0).books().client_aborts >= 5,
        "the drive was told"
    );
    assert!(rig.saw(|event| matches!(event, WheelEventKind::ReplyIgnored(_))));
    let mode = rig
        .drive(0)
        .object(rig.bench.now_ns(), objects::MODE_DISPLAY.address());
    assert_eq!(mode, 3);
    drive_at(&mut rig, 50, 50);
    assert_eq!(speeds_rpm(&rig), [50.0, 50.0]);
}

#[test]
fn a_master_that_goes_silent_is_noticed_by_the_drives() {
    let mut rig = pair(velocity(), |_| {});
    rig.stream();
    drive_at(&mut rig, 100, 50);
    assert_eq!(speeds_rpm(&rig), [100.0, 100.0]);
    // No cycle is begun: the application hangs. 2000h is 300 ms by default.
    (0..40).for_each(|_| rig.skip_cycle());
    assert_eq!(speeds_rpm(&rig), [0.0, 0.0]);
    // When it comes back the wheels do not start by themselves.
    rig.cycles(100);
    assert!([0, 1].iter().all(|wheel| rig.axis(*wheel).fault.is_some()));
    assert_eq!(speeds_rpm(&rig), [0.0, 0.0]);
}

#[test]
fn after_bus_off_nothing_moves_before_the_application_says_so() {
    let mut rig = pair(velocity(), |_| {});
    rig.stream();
    drive_at(&mut rig, 100, 50);
    let now = rig.now();
    rig.master.on_bus_off(now);
    rig.cycles(60);
    // Nothing could be sent: the drives' own supervision stopped the wheels.
    assert_eq!(speeds_rpm(&rig), [0.0, 0.0]);
    assert!(
        [0, 1]
            .iter()
            .all(|wheel| rig.axis(*wheel).fault == Some(WheelFault::Bus))
    );
    let now = rig.now();
    rig.master.on_bus_recovered(now);
    rig.cycles(60);
    assert_eq!(speeds_rpm(&rig), [0.0, 0.0]);
    let now = rig.now();
    rig.master.clear(now, GROUP).unwrap();
    rig.stream();
    drive_at(&mut rig, 50, 50);
    assert_eq!(speeds_rpm(&rig), [50.0, 50.0]);
}
