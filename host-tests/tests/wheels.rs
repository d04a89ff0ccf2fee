//! Wheels on the virtual bus: the same master, from power-on to a stop, and what goes wrong.

use can_motion::wheel::{
    FeedbackTiming, TransferError, WheelArrival, WheelConfig, WheelEventKind, WheelFault,
    WheelLimits, WheelMasterConfig, WheelMode,
};
use can_motion::{AxisState, CommandError, Confirmation, Reaction, TargetError};
use drive_sim::ZlacDriveConfig;
use embedded_can::Frame as _;
use host_tests::rig::{GROUP, WheelRig};
use zlac8030l::{FaultCode, NodeId, SdoEnd, SdoRequest, objects};

fn node(number: i32) -> NodeId {
    NodeId::new(number).unwrap()
}

/// Wheels of nodes 1, 2, ... with these settings.
fn rig(config: WheelMasterConfig, wheel: WheelConfig, count: i32) -> WheelRig {
    let wheels: Vec<_> = (1..=count)
        .map(|number| WheelConfig {
            node: node(number),
            ..wheel
        })
        .collect();
    let drives = (1..=count).map(|number| ZlacDriveConfig::new(node(number)));
    WheelRig::wheels(config, &wheels, drives.collect())
}

fn two_wheels() -> WheelRig {
    rig(
        WheelMasterConfig::DEFAULT,
        host_tests::rig::wheel_config(node(1)),
        2,
    )
}

fn set_all(rig: &mut WheelRig, targets: [i32; 2]) {
    for (axis, target) in targets.into_iter().enumerate() {
        rig.master.set_target(axis, target).unwrap();
    }
}

fn speeds_rpm(rig: &WheelRig) -> [f64; 2] {
    [0, 1].map(|axis| rig.drive(axis).speed_rpm(rig.bench.now_ns()))
}

/// The motor holds or follows: bits 0 to 3 of the status word say operation enabled, in a quick stop too.
fn is_energised(rig: &WheelRig, axis: usize) -> bool {
    rig.drive(axis).status_word(rig.bench.now_ns()) & 0xF == 0x7
}

/// The control word of the latest frame to a node.
fn last_control_word(rig: &WheelRig, node: u16) -> u16 {
    let id = embedded_can::StandardId::new(0x300 + node).map(embedded_can::Id::Standard);
    let mut frames = rig.traffic.iter().map(|record| record.frame);
    let last = frames.rfind(|frame| Some(frame.id()) == id).unwrap();
    u16::from_le_bytes([last.data()[0], last.data()[1]])
}

fn saw_fault(rig: &WheelRig, wanted: impl Fn(&WheelFault) -> bool) -> bool {
    rig.saw(|event| matches!(event, WheelEventKind::Fault(fault) if wanted(fault)))
}

#[test]
fn from_power_on_to_speed_and_back() {
    let mut rig = two_wheels();
    rig.stream();
    assert!(rig.drive(0).is_enabled() && rig.drive(1).is_enabled());
    assert_eq!(rig.axis(0).sent, 0);
    set_all(&mut rig, [120, -60]);
    rig.cycles(100);
    assert_eq!(
        [rig.axis(0).sent, rig.axis(1).sent],
        [120, -60],
        "the targets are reached"
    );
    let [left, right] = speeds_rpm(&rig);
    assert!(
        (left - 120.0).abs() < 1.0 && (right + 60.0).abs() < 1.0,
        "{left} {right}"
    );
    assert_eq!(
        rig.axis(0)
            .feedback
            .speed_decirpm
            .map(|speed| speed.value / 10),
        Some(120)
    );
    let now = rig.now();
    rig.master.disable(now, GROUP);
    rig.run_until(AxisState::Ready);
    assert!(!rig.drive(0).is_enabled() && !rig.drive(1).is_enabled());
    assert_eq!(rig.master.cycle_counters().late, 0);
}

#[test]
fn set_up_wears_no_drive_and_finds_everything_right_the_second_time() {
    let mut rig = two_wheels();
    rig.run_until(AxisState::Ready);
    let wear = rig.drive(0).eeprom_wear();
    assert_eq!(wear, Default::default(), "no write reaches the EEPROM");
    rig.drive_mut(0).faults_mut().trip(FaultCode::new(4).get());
    rig.drive_mut(0).faults_mut().remove_cause();
    rig.cycles(5);
    let now = rig.now();
    rig.master.clear(now, GROUP).unwrap();
    rig.run_until(AxisState::Ready);
    let reports = rig.events.iter().filter_map(|event| match event.kind {
        WheelEventKind::SetUp(report) if event.axis == Some(0) => Some(report.written),
        _ => None,
    });
    let written: Vec<u16> = reports.collect();
    assert!(
        matches!(written[..], [first, 0] if first > 0),
        "{written:?}"
    );
}

#[test]
fn no_frame_changes_a_speed_by_more_than_its_limit() {
    let mut rig = two_wheels();
    rig.stream();
    set_all(&mut rig, [1_000, -1_000]);
    let mut before = 0;
    for _ in 0..120 {
        rig.cycle();
        let sent = rig.axis(0).sent;
        assert!((sent - before).abs() <= 10, "from {before} to {sent}");
        before = sent;
    }
    assert_eq!(before, 1_000);
}

#[test]
fn a_group_slows_down_in_proportion() {
    let mut rig = two_wheels();
    rig.stream();
    set_all(&mut rig, [400, -200]);
    rig.cycles(100);
    let now = rig.now();
    rig.master.stop(now, GROUP);
    let mut cycles = 0;
    while rig.axis(0).state == AxisState::RampingDown {
        rig.cycle();
        let [left, right] = [0, 1].map(|axis| rig.axis(axis).sent);
        assert!((left + 2 * right).abs() <= 2, "{left} and {right}");
        cycles += 1;
    }
    assert!((40..=42).contains(&cycles), "{cycles} cycles of 10 r/min");
    rig.cycles(50);
    assert!(rig.drive(0).is_enabled(), "a stopped wheel holds");
    let now = rig.now();
    rig.master.resume(now, GROUP).unwrap();
    set_all(&mut rig, [50, 50]);
    rig.cycles(50);
    assert_eq!(rig.axis(0).sent, 50);
}

#[test]
fn a_fault_of_one_drive_stops_both_in_the_same_cycle() {
    let mut rig = two_wheels();
    rig.stream();
    set_all(&mut rig, [300, 300]);
    rig.cycles(60);
    rig.drive_mut(0).faults_mut().trip(0x0004);
    rig.cycle();
    assert_eq!(last_control_word(&rig, 2), 0x0002, "quick stop, at once");
    assert_eq!(rig.axis(1).fault, Some(WheelFault::Group));
    assert!(matches!(
        rig.axis(0).fault,
        Some(WheelFault::Emergency(_) | WheelFault::Drive(_))
    ));
    rig.cycles(100);
    let [_, right] = speeds_rpm(&rig);
    assert!(right.abs() < 1.0, "the other wheel stands: {right}");
    assert!(is_energised(&rig, 1));
    let now = rig.now();
    assert!(matches!(
        rig.master.resume(now, GROUP),
        Err(CommandError::Faulted { .. })
    ));
    assert!(rig.master.set_target(1, 10).is_err());
}

#[test]
fn a_cleared_fault_is_reset_once_its_cause_is_gone() {
    let mut rig = two_wheels();
    rig.stream();
    rig.drive_mut(0).faults_mut().trip(0x0008);
    rig.cycles(5);
    let now = rig.now();
    rig.master.clear(now, GROUP).unwrap();
    rig.cycles(150);
    assert_eq!(
        rig.axis(0).fault,
        Some(WheelFault::Drive(FaultCode::new(8))),
        "the cause is still there"
    );
    rig.drive_mut(0).faults_mut().remove_cause();
    let now = rig.now();
    rig.master.clear(now, GROUP).unwrap();
    rig.cycles(150);
    assert_eq!(rig.axis(0).state, AxisState::Ready);
    assert_eq!(rig.axis(1).state, AxisState::Holding);
    let now = rig.now();
    rig.master.disable(now, GROUP);
    rig.run_until(AxisState::Ready);
    rig.stream();
}

#[test]
fn a_silent_drive_is_lost_and_its_group_stops() {
    let mut rig = two_wheels();
    rig.stream();
    set_all(&mut rig, [300, 300]);
    rig.cycles(60);
    rig.drive_mut(0).faults_mut().leave_bus();
    rig.cycles(12);
    assert_eq!(rig.axis(0).fault, Some(WheelFault::Lost));
    assert_eq!(rig.axis(1).fault, Some(WheelFault::Group));
    // The lost drive hears nothing: its own supervision (2000h) must stop it.
    rig.cycles(100);
    let [left, right] = speeds_rpm(&rig);
    assert!(left.abs() < 1.0 && right.abs() < 1.0, "{left} {right}");
}

#[test]
fn a_drive_that_restarts_is_noticed_and_set_up_anew() {
    let mut rig = two_wheels();
    rig.stream();
    rig.drive_mut(0).faults_mut().power_cycle(1_000_000);
    rig.cycles(20);
    assert!(saw_fault(&rig, |fault| matches!(
        fault,
        WheelFault::Reboot | WheelFault::Lost
    )));
    let now = rig.now();
    rig.master.clear(now, GROUP).unwrap();
    rig.cycles(200);
    assert_eq!(rig.axis(0).state, AxisState::Ready);
    assert!(rig.drive(0).is_operational() && !rig.drive(0).is_enabled());
}

#[test]
fn an_emergency_stop_input_is_a_fault() {
    let mut rig = two_wheels();
    rig.stream();
    set_all(&mut rig, [100, 100]);
    rig.cycles(30);
    rig.drive_mut(1).faults_mut().emergency_input(true);
    rig.cycles(5);
    assert!(saw_fault(&rig, |fault| *fault == WheelFault::EmergencyInput));
    rig.cycles(50);
    let [left, right] = speeds_rpm(&rig);
    assert!(left.abs() < 1.0 && right.abs() < 1.0, "{left} {right}");
}

#[test]
fn halt_brakes_and_resume_starts_from_standstill() {
    let mut rig = two_wheels();
    rig.stream();
    set_all(&mut rig, [300, 300]);
    rig.cycles(60);
    let now = rig.now();
    rig.master.halt(now, GROUP);
    rig.cycles(50);
    assert!(speeds_rpm(&rig)[0].abs() < 1.0);
    assert_eq!(rig.axis(0).state, AxisState::Holding);
    let now = rig.now();
    rig.master.resume(now, GROUP).unwrap();
    set_all(&mut rig, [100, 100]);
    rig.cycles(100);
    assert_eq!(rig.axis(0).fault, None);
    assert!((speeds_rpm(&rig)[0] - 100.0).abs() < 1.0);
}

#[test]
fn a_reaction_can_be_a_ramp_or_no_power() {
    for (reaction, energised) in [(Reaction::RampDown, true), (Reaction::Disable, false)] {
        let mut wheel = host_tests::rig::wheel_config(node(1));
        wheel.reactions.drive = reaction;
        let mut rig = rig(WheelMasterConfig::DEFAULT, wheel, 2);
        rig.stream();
        set_all(&mut rig, [200, 200]);
        rig.cycles(60);
        rig.drive_mut(0).faults_mut().trip(0x0004);
        rig.cycles(5);
        let coasts = speeds_rpm(&rig)[1];
        assert!(coasts > 50.0, "{reaction:?}: {coasts}");
        rig.cycles(200);
        assert!(speeds_rpm(&rig)[1].abs() < 1.0, "{reaction:?}");
        assert_eq!(is_energised(&rig, 1), energised, "{reaction:?}");
    }
}

fn positions(max_step: u32) -> WheelLimits {
    WheelLimits::position(-0x3FFF_FFFF, 0x3FFF_FFFF, max_step, 20)
}

#[test]
fn positions_are_followed_with_sync_and_end_where_they_should() {
    let config = WheelMasterConfig {
        feedback: FeedbackTiming::Sync,
        ..WheelMasterConfig::DEFAULT
    };
    let wheel = WheelConfig {
        mode: WheelMode::Position {
            profile_speed_rpm: 300,
        },
        limits: positions(100),
        ..host_tests::rig::wheel_config(node(1))
    };
    let mut rig = rig(config, wheel, 2);
    rig.stream();
    let start = rig.axis(0).sent;
    set_all(&mut rig, [start + 20_000, start - 10_000]);
    rig.cycles(300);
    for (axis, distance) in [(0, 20_000), (1, -10_000)] {
        let travel = rig.drive(axis).travel_counts(rig.bench.now_ns());
        assert!((travel - distance).abs() <= 4, "axis {axis}: {travel}");
        assert_eq!(rig.axis(axis).fault, None);
    }
}

/// One wheel in position mode whose drive makes its own moves.
fn moving_wheel(arrival: WheelArrival) -> WheelRig {
    let most = 0x3FFF_FFFF;
    let wheel = WheelConfig {
        mode: WheelMode::Position {
            profile_speed_rpm: 60,
        },
        limits: WheelLimits {
            following_error: u32::MAX,
            ..WheelLimits::position(-most, most, 1_000_000, 1_000_000)
        },
        arrival,
        ..host_tests::rig::wheel_config(node(1))
    };
    rig(WheelMasterConfig::DEFAULT, wheel, 1)
}

fn arrivals(rig: &WheelRig) -> Vec<WheelEventKind> {
    let is_one = |kind: &WheelEventKind| {
        matches!(
            kind,
            WheelEventKind::Arrived { .. } | WheelEventKind::NotArrived { .. }
        )
    };
    let events = rig.events.iter().map(|event| event.kind);
    events.filter(is_one).collect()
}

#[test]
fn a_wheel_says_once_that_it_has_arrived_at_each_target() {
    let mut rig = moving_wheel(WheelArrival {
        limit_us: Some(5_000_000),
        ..WheelArrival::DEFAULT
    });
    rig.stream();
    // Half a turn at 60 r/min.
    rig.master.set_target(0, 2_048).unwrap();
    rig.cycles(40);
    assert_eq!(arrivals(&rig), []);
    rig.cycles(200);
    // The drive counts whole numbers, and says so before the last of them.
    let [WheelEventKind::Arrived { counts }] = arrivals(&rig)[..] else {
        panic!("{:?}", arrivals(&rig));
    };
    assert!((2_007..=2_089).contains(&counts), "{counts}");
    // The same target again is no new way; another one is, and a relative one is the sum of the application.
    rig.master.set_target(0, 2_048).unwrap();
    rig.cycles(50);
    assert_eq!(arrivals(&rig).len(), 1);
    let from = rig.axis(0).sent;
    rig.master.set_target(0, from - 1_000).unwrap();
    rig.cycles(200);
    assert_eq!(arrivals(&rig).len(), 2);
    let travel = rig.drive(0).travel_counts(rig.bench.now_ns());
    assert!((travel - 1_048).abs() <= 1, "{travel}");
}

#[test]
fn a_wheel_that_does_not_arrive_in_time_is_said_once_and_may_arrive_later() {
    let mut rig = moving_wheel(WheelArrival {
        limit_us: Some(500_000),
        ..WheelArrival::DEFAULT
    });
    rig.stream();
    rig.master.set_target(0, 4_096).unwrap();
    rig.cycles(60);
    let [WheelEventKind::NotArrived { off_counts }] = arrivals(&rig)[..] else {
        panic!("{:?}", arrivals(&rig));
    };
    assert!((-4_096..-1_000).contains(&off_counts), "{off_counts}");
    rig.cycles(200);
    assert!(matches!(
        arrivals(&rig)[..],
        [
            WheelEventKind::NotArrived { .. },
            WheelEventKind::Arrived { .. }
        ]
    ));
}

#[test]
fn a_move_that_was_stopped_does_not_arrive() {
    let mut rig = moving_wheel(WheelArrival {
        limit_us: Some(1_000_000),
        ..WheelArrival::DEFAULT
    });
    rig.stream();
    rig.master.set_target(0, 40_960).unwrap();
    rig.cycles(50);
    let now = rig.now();
    rig.master.stop(now, GROUP);
    rig.cycles(300);
    assert_eq!(arrivals(&rig), []);
}

#[test]
fn a_blocked_position_is_a_following_error() {
    let wheel = WheelConfig {
        mode: WheelMode::Position {
            // Slower than the targets move.
            profile_speed_rpm: 1,
        },
        limits: positions(400),
        ..host_tests::rig::wheel_config(node(1))
    };
    let mut rig = rig(WheelMasterConfig::DEFAULT, wheel, 2);
    rig.stream();
    set_all(&mut rig, [100_000, 0]);
    rig.cycles(50);
    assert!(saw_fault(&rig, |fault| matches!(
        fault,
        WheelFault::FollowingError { .. }
    )));
}

#[test]
fn a_wrong_speed_resolution_never_moves() {
    let wheel = WheelConfig {
        speed_resolution: 10,
        ..host_tests::rig::wheel_config(node(1))
    };
    let mut rig = rig(WheelMasterConfig::DEFAULT, wheel, 1);
    rig.cycles(200);
    assert_eq!(
        rig.axis(0).fault,
        Some(WheelFault::SpeedResolution {
            expected: 10,
            actual: 1
        })
    );
    assert_eq!(
        rig.master.set_target(0, 1),
        Err(TargetError::NotStreaming {
            state: AxisState::Faulted
        })
    );
}

#[test]
fn transfers_run_beside_the_cycle_and_the_masters_objects_are_its_own() {
    let mut rig = two_wheels();
    let start = |rig: &mut WheelRig, request, confirmation| {
        let now = rig.now();
        rig.master.start(now, 0, request, confirmation)
    };
    assert!(matches!(
        start(&mut rig, objects::BUS_VOLTAGE.read(), Confirmation::None),
        Err(TransferError::State { .. })
    ));
    rig.stream();
    start(
        &mut rig,
        objects::MOTOR_TEMPERATURE.read(),
        Confirmation::None,
    )
    .unwrap();
    rig.cycles(3);
    assert!(rig.saw(|event| matches!(
        event,
        WheelEventKind::Transfer(event) if matches!(event.end, SdoEnd::Value(_))
    )));
    for request in [
        objects::CONTROL_WORD.write(0x0F),
        objects::TARGET_SPEED.write(100),
        SdoRequest::Write(objects::EEPROM_UPDATE.address(), zlac_word(0)),
    ] {
        assert!(matches!(
            start(&mut rig, request, Confirmation::Given),
            Err(TransferError::Owned { .. })
        ));
    }
    let store = objects::STORE.write(objects::STORE_SAVE_ALL);
    assert_eq!(
        start(&mut rig, store, Confirmation::None),
        Err(TransferError::Unconfirmed)
    );
    assert_eq!(
        start(&mut rig, store, Confirmation::Given),
        Err(TransferError::State {
            actual: AxisState::Streaming
        })
    );
    assert_eq!(rig.master.cycle_counters().late, 0);
}

fn zlac_word(value: u16) -> zlac8030l::ObjectData {
    zlac8030l::ObjectData::from_bytes(&value.to_le_bytes()).unwrap()
}
