//! Wheels in torque mode, and the readings that no PDO brings.

use can_motion::wheel::{
    WheelConfig, WheelConfigError, WheelEventKind, WheelFault, WheelLimits, WheelMaster,
    WheelMasterConfig, WheelMode, WheelPolls,
};
use can_motion::{AxisState, TargetError};
use drive_sim::{ZlacDriveConfig, ZlacQuirks, ZlacSurroundings};
use host_tests::rig::{GROUP, WheelRig};
use zlac8030l::{NodeId, SetUpError, objects};

fn node() -> NodeId {
    NodeId::new(4).unwrap()
}

fn torque_wheel() -> WheelConfig {
    WheelConfig::new(
        node(),
        WheelMode::Torque { slope_ma_s: 2_000 },
        WheelLimits::torque(2_000, 50, 200),
    )
}

fn rig_of(wheel: WheelConfig, drive: ZlacDriveConfig) -> WheelRig {
    WheelRig::wheels(WheelMasterConfig::DEFAULT, &[wheel], vec![drive])
}

fn rig() -> WheelRig {
    rig_of(torque_wheel(), ZlacDriveConfig::new(node()))
}

fn rpm(rig: &WheelRig) -> f64 {
    rig.drive(0).speed_rpm(rig.bench.now_ns())
}

fn is_energised(rig: &WheelRig) -> bool {
    rig.drive(0).status_word(rig.bench.now_ns()) & 0xF == 0x7
}

#[test]
fn a_current_accelerates_the_wheel_and_a_stop_brakes_it() {
    let mut rig = rig();
    rig.stream();
    assert_eq!(rig.axis(0).sent, 0);
    rig.master.set_target(0, 700).unwrap();
    rig.cycles(100);
    assert_eq!(rig.axis(0).sent, 700);
    // 1 A is twice the friction of 200 r/min a second, so 700 mA leave 80.
    assert!((40.0..90.0).contains(&rpm(&rig)), "{}", rpm(&rig));
    // 6077h counts 0.1 A by its text.
    assert_eq!(rig.axis(0).feedback.torque.unwrap().value, 7);
    // No torque is no stop: the stop is a quick stop, and the wheel stands energised.
    rig.master.stop(rig.now(), GROUP);
    rig.cycles(5);
    let mut cycles = 0;
    while rig.axis(0).state != AxisState::Holding {
        rig.cycles(1);
        cycles += 1;
        assert!(cycles < 200, "{}", rig.axis(0).state);
    }
    assert_eq!(rpm(&rig), 0.0);
    assert!(is_energised(&rig));
    rig.cycles(50);
    assert_eq!(rpm(&rig), 0.0, "it stays");
    // Resumed it has no torque, and takes the next target.
    rig.master.resume(rig.now(), GROUP).unwrap();
    rig.cycles(20);
    assert_eq!(
        (rig.axis(0).state, rig.axis(0).sent),
        (AxisState::Streaming, 0)
    );
    rig.master.set_target(0, -700).unwrap();
    rig.cycles(100);
    assert!(rpm(&rig) < -40.0, "{}", rpm(&rig));
    rig.master.halt(rig.now(), GROUP);
    rig.cycles(100);
    assert_eq!((rpm(&rig), is_energised(&rig)), (0.0, true));
    rig.master.disable(rig.now(), GROUP);
    rig.cycles(20);
    assert!(!is_energised(&rig));
}

#[test]
fn a_wheel_without_load_is_stopped_before_it_runs_away() {
    let mut rig = rig();
    rig.stream();
    rig.master.set_target(0, 2_000).unwrap();
    let mut fastest = 0.0_f64;
    for _ in 0..300 {
        rig.cycles(1);
        fastest = fastest.max(rpm(&rig));
    }
    assert!(rig.saw(|event| matches!(
        event,
        WheelEventKind::Fault(WheelFault::OverSpeed {
            most_decirpm: 2_000,
            actual_decirpm: 2_001..
        })
    )));
    // 600 r/min a second for a feedback, 20 ms and a cycle.
    assert!((200.0..235.0).contains(&fastest), "{fastest}");
    assert_eq!((rpm(&rig), is_energised(&rig)), (0.0, true));
    assert_eq!(rig.axis(0).state, AxisState::Faulted);
}

#[test]
fn a_drive_that_has_another_number_for_torque_is_refused() {
    let mut rig = rig_of(
        torque_wheel(),
        ZlacDriveConfig {
            quirks: ZlacQuirks {
                torque_mode_is_6: true,
                ..ZlacQuirks::default()
            },
            ..ZlacDriveConfig::new(node())
        },
    );
    rig.cycles(200);
    let fault = rig.axis(0).fault.expect("a fault");
    assert!(
        matches!(
            fault,
            WheelFault::SetUp(SetUpError::Differs { address, expected: 4, .. })
                if address == objects::MODE_DISPLAY.address()
        ),
        "{fault}"
    );
    assert!(!is_energised(&rig));
}

#[test]
fn torques_outside_their_range_are_refused() {
    let mut rig = rig();
    rig.stream();
    let error = rig.master.set_target(0, 2_001).unwrap_err();
    assert!(matches!(
        error,
        TargetError::Travel {
            min: -2_000,
            max: 2_000,
            actual: 2_001
        }
    ));
    let refused = |wheel: WheelConfig| {
        WheelMaster::<1>::new(WheelMasterConfig::DEFAULT, &[wheel]).unwrap_err()
    };
    let too_much = WheelConfig {
        limits: WheelLimits::torque(30_001, 50, 200),
        ..torque_wheel()
    };
    assert!(matches!(
        refused(too_much),
        WheelConfigError::Range { most: 30_000, .. }
    ));
    let no_slope = WheelConfig {
        mode: WheelMode::Torque { slope_ma_s: 0 },
        ..torque_wheel()
    };
    assert!(matches!(
        refused(no_slope),
        WheelConfigError::Setting {
            name: "slope_ma_s",
            ..
        }
    ));
}

#[test]
fn temperatures_and_voltage_are_read_on_request_and_only_then() {
    let wheel = WheelConfig {
        polls: WheelPolls {
            health_us: Some(300_000),
        },
        ..host_tests::rig::wheel_config(node())
    };
    let mut rig = rig_of(wheel, ZlacDriveConfig::new(node()));
    rig.stream();
    rig.cycles(50);
    let feedback = rig.axis(0).feedback;
    let values = (
        feedback.motor_decidegrees.map(|read| read.value),
        feedback.driver_decidegrees.map(|read| read.value),
        feedback.bus_centivolts.map(|read| read.value),
    );
    assert_eq!(values, (Some(250), Some(300), Some(4_800)));
    let device = rig.drives[0];
    rig.bench
        .device_mut(device)
        .faults_mut()
        .surroundings(ZlacSurroundings {
            motor_decidegrees: -55,
            driver_decidegrees: 451,
            bus_centivolts: 3_999,
        });
    let requests = rig.axis(0).counters.requests;
    rig.cycles(60);
    let feedback = rig.axis(0).feedback;
    assert_eq!(feedback.motor_decidegrees.unwrap().value, -55);
    assert_eq!(feedback.driver_decidegrees.unwrap().value, 451);
    assert_eq!(feedback.bus_centivolts.unwrap().value, 3_999);
    // One every 100 ms: 6 in 600 ms.
    let asked = rig.axis(0).counters.requests - requests;
    assert!((5..=7).contains(&asked), "{asked}");
    let mut quiet = rig_of(
        host_tests::rig::wheel_config(node()),
        ZlacDriveConfig::new(node()),
    );
    quiet.stream();
    let requests = quiet.axis(0).counters.requests;
    quiet.cycles(100);
    assert_eq!(quiet.axis(0).counters.requests, requests);
    assert_eq!(quiet.axis(0).feedback.bus_centivolts, None);
}
