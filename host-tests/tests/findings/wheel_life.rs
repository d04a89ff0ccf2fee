//! Wheels that were moved, left to turn or kept waiting where nobody meant it, and of which nothing was said.

use can_motion::facts::Power;
use can_motion::wheel::{TransferError, WheelEventKind, WheelFault};
use can_motion::{AxisState, Confirmation};
use drive_sim::{OfflineReaction, ReplyDamage, ResponseDelay};
use embedded_can::Frame as _;
use zlac8030l::{FaultCode, SdoRequest, SetUpError, objects};

use crate::support::wheels::{Command, Hub, Wheels, hub, hubs};
use crate::support::{Call, id_of};

/// Bit 4 of the control word, whose edge makes a drive in position mode take its target.
const EDGE: u16 = 0x0010;
/// Start of a read of 603Fh.
const READ_FAULT_CODE: [u8; 4] = [0x40, 0x3F, 0x60, 0x00];
/// Start of a write of 2030h:0E.
const WRITE_BRAKE: [u8; 4] = [0x2B, 0x30, 0x20, 0x0E];

/// A wheel whose drive does not stop by itself when its master is silent.
fn careless(node: i32) -> Hub {
    hub(node).drive(|drive| drive.offline_reaction = OfflineReaction::Nothing)
}

fn start(machine: &mut Wheels, request: SdoRequest) -> Result<(), TransferError> {
    let now = machine.0.now();
    machine.0.master.start(now, 0, request, Confirmation::None)
}

/// Somebody else sends a frame, and two cycles pass.
fn stranger_sends(machine: &mut Wheels, stranger: drive_sim::NodeId, id: u16, data: &[u8]) {
    machine.stranger_sends(stranger, id, data);
    machine.run(2);
}

/// A wheel in position mode that holds somewhere is adopted by a program that starts anew: nothing moves it to the zero of its counts.
#[test]
fn a_wheel_that_is_adopted_away_from_its_zero_stays_where_it_is() {
    let wheels = [hub(1).position(300)];
    let mut machine = Wheels::streaming(&wheels);
    machine.drive_at(&[6_000], 400);
    assert_eq!(machine.travel(0), 6_000);
    machine.start_anew(&wheels);
    machine.run(300);
    assert_eq!(machine.0.state(0), AxisState::FoundOn);
    let mark = machine.mark();
    machine.call(Call::Adopt).unwrap();
    machine.run(300);
    assert_eq!(machine.0.state(0), AxisState::Holding);
    assert_eq!(machine.travel(0), 6_000, "adopt moves nothing");
    let commands = machine.commands_since(mark, 0);
    let elsewhere = |command: &&Command| command.word & EDGE != 0 && command.target != 6_000;
    assert_eq!(commands.iter().find(elsewhere), None);
    machine.call(Call::Resume).unwrap();
    machine.drive_at(&[6_500], 200);
    assert_eq!(machine.travel(0), 6_500);
}

/// The check of one wheel wants to write, which must wait while its drive is on; the brake of a wheel of another group closes all the
/// same, and its power goes off.
#[test]
fn a_write_that_has_to_wait_keeps_no_other_wheel_waiting() {
    let wheels = [hub(1), hub(2).in_group(1).load_can_fall()];
    let mut machine = Wheels::new(&wheels);
    machine.become_ready();
    let other = can_motion::GroupId(1);
    machine.call(Call::Enable).unwrap();
    machine.run(200);
    assert_eq!(machine.0.state(0), AxisState::Streaming);
    // The program starts anew with another ramp, and finds the first wheel on.
    let changed = [hub(1).ramp_ms(300), wheels[1].clone()];
    machine.start_anew(&changed);
    machine.run(400);
    assert_eq!(machine.0.axis(0).facts.power, Power::FoundOn);
    machine.call_group(Call::Enable, other).unwrap();
    machine.run(300);
    assert_eq!(machine.0.state(1), AxisState::Streaming);
    machine.call_group(Call::Disable, other).unwrap();
    machine.run(300);
    assert!(!machine.energised(1), "disabled 3 s ago");
    assert_eq!(machine.0.state(1), AxisState::Ready);
}

/// A program starts anew while its wheel turns, with other settings; somebody has mapped speed and position to the PDO of the status,
/// which read as a status say that the power is off.
#[test]
fn what_another_program_has_mapped_is_not_taken_for_a_status() {
    for is_slow in [false, true] {
        let mut machine = Wheels::streaming(&[careless(1)]);
        let stranger = machine.add_stranger();
        machine.drive_at(&[100], 60);
        stranger_sends(&mut machine, stranger, 0, &[0x80, 1]);
        let mapping: [[u8; 8]; 4] = [
            [0x2F, 0x00, 0x1A, 0, 0, 0, 0, 0],
            [0x23, 0x00, 0x1A, 1, 0x20, 0, 0x6C, 0x60],
            [0x23, 0x00, 0x1A, 2, 0x20, 0, 0x64, 0x60],
            [0x2F, 0x00, 0x1A, 0, 2, 0, 0, 0],
        ];
        machine.start_anew(&[careless(1).ramp_ms(300)]);
        if is_slow {
            machine.hang(20);
        }
        for data in mapping {
            stranger_sends(&mut machine, stranger, 0x601, &data);
        }
        stranger_sends(&mut machine, stranger, 0, &[0x01, 1]);
        assert!(machine.energised(0));
        let mark = machine.mark();
        machine.run(200);
        let told = machine.frames_since(mark).filter(|record| {
            let first = record.frame.data().first().copied();
            id_of(record) == 0 || (id_of(record) == 0x601 && first.is_some_and(|b| b >> 5 == 1))
        });
        assert_eq!(told.count(), 0, "it is on, and not of this master");
        assert!(machine.energised(0));
        assert_eq!(machine.0.axis(0).facts.power, Power::FoundOn);
    }
}

/// Somebody stops a node by network management while it turns: its drive takes no targets any more, and is stopped by a transfer.
#[test]
fn a_wheel_that_left_operational_is_stopped() {
    for state in [0x80, 0x02] {
        let mut machine = Wheels::streaming(&[careless(1), careless(2)]);
        let stranger = machine.add_stranger();
        machine.drive_at(&[100, 100], 60);
        stranger_sends(&mut machine, stranger, 0, &[state, 1]);
        machine.run(100);
        assert!(
            matches!(machine.fault(0), Some(WheelFault::NotOperational(_))),
            "{state:02X}"
        );
        for axis in [0, 1] {
            let speed_rpm = machine.speed_rpm(axis);
            assert_eq!(speed_rpm, 0.0, "{state:02X}: wheel {axis}");
            assert!(machine.energised(axis), "it holds");
        }
        let mark = machine.mark();
        machine.run(100);
        assert_eq!(
            machine.transfers_since(mark, 0),
            Vec::<Vec<u8>>::new(),
            "what was done is not repeated"
        );
        machine.call(Call::Disable).unwrap();
        machine.run(100);
        assert!(!machine.energised(0), "{state:02X}");
        machine.call(Call::Clear).unwrap();
        machine.run(300);
        assert_eq!(machine.0.state(0), AxisState::Ready, "{state:02X}");
    }
}

/// The same under `disable` and without a word in between.
#[test]
fn a_stopped_node_is_switched_off() {
    let mut machine = Wheels::streaming(&[careless(1), careless(2)]);
    let stranger = machine.add_stranger();
    machine.drive_at(&[100, 100], 60);
    machine.stranger_sends(stranger, 0, &[0x02, 1]);
    machine.call(Call::Disable).unwrap();
    machine.run(300);
    assert!(!machine.energised(0));
    assert_eq!(machine.0.axis(0).facts.power, Power::Off);
}

/// A reading that was started under a fault does not keep the checks behind `clear` waiting.
#[test]
fn a_reading_under_a_fault_ends_with_clear() {
    let mut machine = Wheels::streaming(&hubs(1));
    machine.faults_mut(0).power_cycle(50_000_000);
    machine.run(300);
    assert!(machine.fault(0).is_some());
    start(&mut machine, objects::FAULT_CODE.read()).unwrap();
    machine.call(Call::Clear).unwrap();
    machine.run(500);
    assert_eq!(machine.0.state(0), AxisState::Ready);
    assert!(
        machine
            .0
            .saw(|kind| *kind == WheelEventKind::ProcedureAborted)
    );
}

/// Somebody changes a setting between the check and `enable`, which cannot write it back.
#[test]
fn a_setting_that_differs_when_it_is_enabled_is_a_fault() {
    let mut machine = Wheels::new(&hubs(2));
    let stranger = machine.add_stranger();
    machine.become_ready();
    let address = objects::ACCELERATION_TIME_MS.address();
    let data = [0x23, 0x83, 0x60, 0x00, 0x09, 0x03, 0x00, 0x00];
    stranger_sends(&mut machine, stranger, 0x601, &data);
    machine.call(Call::Enable).unwrap();
    machine.run(300);
    let fault = machine.fault(0);
    let is_right = matches!(fault, Some(WheelFault::SetUp(SetUpError::Differs { address: is, actual: 777, .. })) if is == address);
    assert!(is_right, "{fault:?}");
    machine.call(Call::Disable).unwrap();
    machine.run(100);
    machine.call(Call::Clear).unwrap();
    machine.run(300);
    machine.call(Call::Enable).unwrap();
    machine.run(300);
    assert!(machine.all_stream());
}

/// A drive that keeps its power under a fault is not reset by `clear`, which switches nothing: the fault is there again.
#[test]
fn a_fault_of_a_drive_that_holds_is_told_again_after_clear() {
    let slow = hub(1).drive(|drive| drive.response_delay = ResponseDelay::fixed(15_000_000));
    let mut machine = Wheels::streaming(&[slow]);
    let reports = |machine: &mut Wheels, cycles| {
        for _ in 0..cycles {
            let is_asked = machine
                .transfers_since(0, 0)
                .last()
                .is_some_and(|request| request.starts_with(&READ_FAULT_CODE));
            machine.0.cycle_with(|rig| {
                Wheels::comes_in(rig, 0x181, &[0x37, 0x04, 0x04, 0, 0, 0, 0, 0]);
                if is_asked {
                    let reply = [0x4B, 0x3F, 0x60, 0, 0x04, 0, 0, 0];
                    Wheels::comes_in(rig, 0x581, &reply);
                }
            });
        }
    };
    reports(&mut machine, 30);
    assert_eq!(machine.fault(0), Some(WheelFault::Drive(FaultCode::new(4))));
    assert_eq!(machine.0.axis(0).facts.power, Power::On);
    machine.call(Call::Clear).unwrap();
    reports(&mut machine, 500);
    assert_eq!(machine.fault(0), Some(WheelFault::Drive(FaultCode::new(4))));
}

/// The drive refuses to close its brake: its power stays on, and that is said.
#[test]
fn a_brake_that_is_refused_is_a_fault_and_said_again() {
    let mut machine = Wheels::streaming(&[hub(1).load_can_fall()]);
    let mark = machine.mark();
    machine.call(Call::Disable).unwrap();
    let mut answered = 0;
    machine.faults_mut(0).damage_next_reply(ReplyDamage::Drop);
    for _ in 0..300 {
        let asked = machine.transfers_since(mark, 0);
        if asked.len() > answered {
            answered = asked.len();
            assert_eq!(asked[answered - 1][..4], WRITE_BRAKE);
            machine.faults_mut(0).damage_next_reply(ReplyDamage::Drop);
            let reply = [0x80, 0x30, 0x20, 0x0E, 0, 0, 2, 6];
            machine
                .0
                .cycle_with(|rig| Wheels::comes_in(rig, 0x581, &reply));
        } else {
            machine.run(1);
        }
    }
    let fault = machine.fault(0);
    assert!(matches!(fault, Some(WheelFault::Transfer(_))), "{fault:?}");
    assert_eq!(machine.0.axis(0).facts.power, Power::OffWanted);
    let said = |wanted: u32| {
        machine.0.saw(|kind| {
            matches!(kind, WheelEventKind::DisableUnconfirmed { repeated } if *repeated == wanted)
        })
    };
    assert_eq!([1, 2, 4, 8].map(said), [true, true, true, false]);
}

/// A fault ends a reading that is under way; its reply does not end the next one.
#[test]
fn the_reply_to_an_aborted_reading_does_not_end_the_next_one() {
    let slow = hub(1).drive(|drive| drive.response_delay = ResponseDelay::fixed(35_000_000));
    let mut machine = Wheels::streaming(&[slow]);
    start(&mut machine, objects::BUS_VOLTAGE.read()).unwrap();
    machine.run(1);
    machine.faults_mut(0).trip(0x0400);
    machine.run(1);
    while machine.fault(0).is_none() {
        machine.run(1);
    }
    let from = machine.events();
    start(&mut machine, objects::MOTOR_TEMPERATURE.read()).unwrap();
    machine.run(100);
    let ended: Vec<_> = machine.0.events[from..]
        .iter()
        .filter_map(|event| match event.kind {
            WheelEventKind::Transfer(event) => Some(event.request.address()),
            _ => None,
        })
        .collect();
    assert_eq!(ended, [objects::MOTOR_TEMPERATURE.address()]);
}

/// What the set-up writes is not written by a procedure too: the next check would undo it.
#[test]
fn what_the_set_up_writes_is_refused() {
    let mut machine = Wheels::new(&hubs(1));
    machine.become_ready();
    for request in [
        objects::ACCELERATION_TIME_MS.write(777),
        objects::DECELERATION_TIME_MS.write(777),
        objects::PROFILE_SPEED.write(77),
        objects::TORQUE_SLOPE.write(777),
    ] {
        let refused = start(&mut machine, request);
        assert!(
            matches!(refused, Err(TransferError::Owned { .. })),
            "{request:?}: {refused:?}"
        );
    }
}

/// A wheel that does not follow has a fault, and then its cable breaks.
#[test]
fn a_wheel_that_falls_silent_under_a_fault_is_lost() {
    let weak = hub(1).drive(|drive| drive.motor_acceleration_rpm_s = 1.0);
    let mut machine = Wheels::streaming(&[weak, hub(2)]);
    machine.drive_at(&[100, 100], 300);
    let fault = machine.fault(0);
    assert!(
        matches!(fault, Some(WheelFault::FollowingSpeed { .. })),
        "{fault:?}"
    );
    let from = machine.events();
    machine.faults_mut(0).leave_bus();
    machine.run(500);
    let lost = machine.0.events[from..]
        .iter()
        .filter(|event| event.kind == WheelEventKind::Fault(WheelFault::Lost));
    assert_eq!(lost.count(), 1);
    assert!(!machine.believed_on(0));
}
