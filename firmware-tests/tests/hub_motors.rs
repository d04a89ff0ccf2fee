//! The board with two hub motors: bring-up, speeds, the two ways to stop, and each failure by its cause alone.

use drive_sim::{DeviceId, EepromWear, Record, ZlacDrive, ZlacDriveConfig};
use embedded_can::{Frame as _, Id};
use firmware_tests::rig::MS;
use firmware_tests::soc::ResetCause;
use firmware_tests::{Contact, Rig, rig};
use zlac8030l::NodeId;

const NODES: [i32; 2] = [1, 2];
/// Identifier of RPDO1, with control word and target, without the node (the guide's PDOs begin at 0).
const COMMAND: u16 = 0x300;
/// Milliseconds from the supply until both drives are set up: boot-up after 100 ms, and one SDO request a cycle.
const READY_MS: u64 = 3_000;
/// Milliseconds from enable until both are enabled: standstill for 100 ms, three steps of the state machine.
const ENABLE_MS: u64 = 1_000;

fn ready_with(image: &str) -> Rig {
    let config = |node| ZlacDriveConfig::new(NodeId::new(node).unwrap());
    let mut rig = Rig::with_hub_motors(rig::image(image), NODES.map(config));
    rig.close(Contact::Stop);
    rig.run_ms(READY_MS);
    assert_eq!(enabled(&rig), [false, false], "{:#?}", rig.board().log());
    rig
}

fn moving_with(image: &str) -> Rig {
    let mut rig = ready_with(image);
    rig.close(Contact::Enable);
    rig.run_ms(ENABLE_MS);
    assert_eq!(enabled(&rig), [true, true], "{:#?}", rig.board().log());
    rig.close(Contact::Run);
    assert!(rig.run_until_logged("the motion starts", 100));
    // The speed at the second keyframe.
    rig.run_ms(1_000);
    let speeds = speeds_rpm(&rig);
    assert!(
        speeds.iter().all(|speed| (speed.abs() - 30.0).abs() < 2.0),
        "{speeds:?} {:#?}",
        rig.board().log()
    );
    rig
}

fn moving() -> Rig {
    moving_with("hub-motors")
}

fn enabled(rig: &Rig) -> [bool; 2] {
    let mut drives = rig.hub_motors().map(ZlacDrive::is_enabled);
    std::array::from_fn(|_| drives.next().expect("two drives"))
}

fn speeds_rpm(rig: &Rig) -> [f64; 2] {
    let now_ns = rig.board().soc().now_ns();
    let mut speeds = rig.hub_motors().map(|drive| drive.speed_rpm(now_ns));
    std::array::from_fn(|_| speeds.next().expect("two drives"))
}

fn devices(rig: &Rig) -> Vec<DeviceId> {
    rig.drives().to_vec()
}

/// The commands to a node that the board put on the wire since then: control word and target.
fn commands(rig: &Rig, node: u16, from_ns: u64) -> Vec<(u16, i32)> {
    let since = |record: &&Record| record.start_ns >= from_ns && record.outcome.is_received();
    let to_it = |record: &&Record| match record.frame.id() {
        Id::Standard(id) => id.as_raw() == COMMAND + node,
        Id::Extended(_) => false,
    };
    let frames = rig.from_board().filter(since).filter(to_it);
    frames
        .map(|record| {
            let data = record.frame.data();
            let target = [data[2], data[3], data[4], data[5]];
            (
                u16::from_le_bytes([data[0], data[1]]),
                i32::from_le_bytes(target),
            )
        })
        .collect()
}

/// After at most two seconds no wheel turns and no drive has power.
fn is_at_rest_and_off(rig: &mut Rig, what: &str) {
    rig.run_ms(2_000);
    assert_eq!(
        enabled(rig),
        [false, false],
        "{what}: {:#?}",
        rig.board().log()
    );
    // A wheel that coasts takes its time.
    rig.run_ms(1_000);
    let speeds = speeds_rpm(rig);
    assert!(
        speeds.iter().all(|speed| speed.abs() < 0.5),
        "{what}: {speeds:?}"
    );
}

#[test]
fn power_on_moves_nothing_and_wears_nothing() {
    let mut rig = ready_with("hub-motors");
    rig.close(Contact::Run);
    rig.run_ms(1_000);
    assert_eq!(enabled(&rig), [false, false]);
    assert_eq!(speeds_rpm(&rig), [0.0, 0.0]);
    assert!(rig.hub_motors().all(ZlacDrive::is_operational));
    for drive in rig.hub_motors() {
        assert_eq!(drive.eeprom_wear(), EepromWear::default());
        assert_eq!(drive.books().sdo_aborted, 0);
    }
}

#[test]
fn the_wheels_follow_their_speeds_and_no_cycle_is_late() {
    let mut rig = moving();
    let from_ns = rig.board().soc().now_ns();
    rig.run_ms(2_000);
    for node in [1, 2] {
        let commands = commands(&rig, node, from_ns);
        // 100 Hz; the ends of the window may lie within a cycle.
        assert!(commands.len().abs_diff(200) <= 1, "{}", commands.len());
        // From 30 by way of 0 to -30 r/min, by at most 1 r/min a cycle.
        let targets: Vec<i32> = commands.iter().map(|&(_, target)| target).collect();
        assert!(
            targets
                .windows(2)
                .all(|pair| pair[0].abs_diff(pair[1]) <= 1),
            "{targets:?}"
        );
        assert!(targets.iter().all(|target| target.abs() <= 30));
        assert!(targets.contains(&0) && targets.iter().min() <= Some(&-29));
    }
    rig.run_ms(1_000);
    assert_eq!(
        (rig.statistic("late"), rig.statistic("missed")),
        (Some(0), Some(0))
    );
    assert_eq!(
        (rig.statistic("events dropped"), rig.statistic("bus errors")),
        (Some(0), Some(0))
    );
}

#[test]
fn the_run_input_ends_the_motion_with_speed_0_and_the_drives_stay_enabled() {
    let mut rig = moving();
    rig.open(Contact::Run);
    assert!(rig.run_until_logged("the motion has ended", 6_000));
    rig.run_ms(500);
    assert_eq!(enabled(&rig), [true, true]);
    assert!(speeds_rpm(&rig).iter().all(|speed| speed.abs() < 0.5));
    assert_eq!(rig.logged_counts("the motion has ended"), Some(vec![0, 0]));
}

#[test]
fn released_enable_slows_the_wheels_down_and_takes_the_power() {
    let mut rig = moving();
    let from_ns = rig.board().soc().now_ns();
    rig.open(Contact::Enable);
    is_at_rest_and_off(&mut rig, "enable released");
    let targets = commands(&rig, 1, from_ns);
    let last = targets.last().expect("commands go on");
    assert_eq!(last.1, 0, "{targets:?}");
    // And it comes back on command.
    rig.open(Contact::Run);
    rig.run_ms(100);
    rig.close(Contact::Enable);
    rig.run_ms(ENABLE_MS);
    assert_eq!(enabled(&rig), [true, true], "{:#?}", rig.board().log());
}

#[test]
fn an_open_stop_circuit_is_a_quick_stop_and_then_power_off() {
    let mut rig = moving();
    let from_ns = rig.board().soc().now_ns();
    rig.open(Contact::Stop);
    rig.run_ms(50);
    // The debouncing and a cycle: then nothing but the quick stop, control word 2.
    let words = commands(&rig, 1, from_ns + 30 * MS);
    assert!(!words.is_empty());
    assert!(words.iter().all(|&(word, _)| word == 2), "{words:?}");
    is_at_rest_and_off(&mut rig, "stop circuit open");
    // As long as it is open nothing is enabled.
    rig.open(Contact::Enable);
    rig.run_ms(100);
    rig.close(Contact::Enable);
    rig.run_ms(ENABLE_MS);
    assert_eq!(enabled(&rig), [false, false]);
}

/// Something happens to the second drive in motion; the first one must stop with it.
fn stops_with_it(happens: impl FnOnce(&mut Rig, DeviceId), line: &str) -> Rig {
    let mut rig = moving();
    let second = devices(&rig)[1];
    happens(&mut rig, second);
    assert!(
        rig.run_until_logged(line, 1_000),
        "{line}: {:#?}",
        rig.board().log()
    );
    rig.run_ms(1_500);
    let speed = speeds_rpm(&rig)[0];
    assert!(speed.abs() < 0.5, "{line}: {speed}");
    let from_ns = rig.board().soc().now_ns();
    rig.run_ms(1_000);
    // The run input is still active: nothing moves again by itself.
    let targets = commands(&rig, 1, from_ns);
    assert!(
        !targets.is_empty() && targets.iter().all(|&(_, target)| target == 0),
        "{line}: {targets:?}"
    );
    rig
}

#[test]
fn a_lost_drive_stops_the_other() {
    let rig = stops_with_it(
        |rig, drive| rig.hub_motor_mut(drive).faults_mut().leave_bus(),
        "no answer: check power",
    );
    // By itself: it has heard nothing of its master any more (2000h).
    assert!(speeds_rpm(&rig)[1].abs() < 0.5);
}

#[test]
fn a_fault_of_a_drive_stops_the_other_and_leaves_on_command() {
    const OVER_CURRENT: u16 = 0x0004;
    let mut rig = stops_with_it(
        |rig, drive| rig.hub_motor_mut(drive).faults_mut().trip(OVER_CURRENT),
        "drive 2: ",
    );
    let second = devices(&rig)[1];
    rig.hub_motor_mut(second).faults_mut().remove_cause();
    rig.open(Contact::Run);
    rig.open(Contact::Enable);
    rig.run_ms(1_000);
    assert_eq!(enabled(&rig), [false, false]);
    rig.close(Contact::Enable);
    rig.run_ms(ENABLE_MS + 2_000);
    assert_eq!(enabled(&rig), [true, true], "{:#?}", rig.board().log());
}

#[test]
fn an_emergency_stop_input_of_a_drive_stops_the_other() {
    stops_with_it(
        |rig, drive| {
            rig.hub_motor_mut(drive).faults_mut().emergency_input(true);
        },
        "emergency stop input",
    );
}

#[test]
fn a_drive_that_starts_again_stops_the_other() {
    stops_with_it(
        |rig, drive| {
            let off_ns = 50 * MS;
            rig.hub_motor_mut(drive).faults_mut().power_cycle(off_ns);
        },
        "drive 2: ",
    );
}

#[test]
fn a_panic_takes_the_power_from_the_wheels_and_nothing_moves_afterwards() {
    const PANIC: u8 = 2;
    let mut rig = moving_with("hub-motors-misbehaving");
    rig.board_mut().poke("MISBEHAVE", PANIC);
    rig.run_ms(2_000);
    assert_eq!(rig.board().resets().len(), 1);
    assert_eq!(rig.board().resets()[0].cause, ResetCause::Software);
    assert_eq!(enabled(&rig), [false, false], "{:#?}", rig.board().log());
    rig.run_ms(1_000);
    assert!(speeds_rpm(&rig).iter().all(|speed| speed.abs() < 0.5));
    for contact in [Contact::Run, Contact::Enable, Contact::Stop] {
        rig.open(contact);
    }
    rig.run_ms(200);
    for contact in [Contact::Stop, Contact::Enable, Contact::Run] {
        rig.close(contact);
        rig.run_ms(1_000);
    }
    assert_eq!(enabled(&rig), [false, false]);
}
