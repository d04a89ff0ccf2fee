//! What ends the motion: the stop circuit, a drive in alarm, a drive that is lost.

use drive_sim::DeviceId;
use dyn_can::Alarm;
use firmware_tests::rig::MS;
use firmware_tests::{Contact, Rig, rig};

const AXES: i32 = 8;
/// A set-point may be on the wire and three may wait in the mailboxes when the order to stop comes.
const ON_THEIR_WAY: usize = 4;

fn moving() -> Rig {
    let mut rig = Rig::with_numbered_drives(rig::image("axes-8"), AXES);
    rig.bring_up();
    rig
}

fn devices(rig: &Rig) -> Vec<DeviceId> {
    rig.drives().to_vec()
}

/// Enable alone brings nothing back; released and made active again it does.
fn comes_back_on_command(rig: &mut Rig) {
    let from_ns = rig.board().soc().now_ns();
    rig.run_ms(1_000);
    assert_eq!(rig.set_points_since(from_ns).count(), 0, "moved by itself");
    for contact in [Contact::Run, Contact::Enable] {
        rig.open(contact);
    }
    rig.run_ms(500);
    rig.enable();
    let from_ns = rig.board().soc().now_ns();
    rig.run_ms(10);
    assert!(rig.set_points_since(from_ns).count() >= 9 * AXES as usize);
}

#[test]
fn the_stop_circuit_ends_all_set_points_in_the_same_cycle_and_disables_later() {
    let mut rig = moving();
    rig.open(Contact::Stop);
    let opened_ns = rig.board().soc().now_ns();
    rig.run_ms(2);
    // The pin is looked at once a cycle: the one under way is the last.
    assert_eq!(rig.set_points_since(opened_ns + MS).count(), 0);
    assert!(
        rig.wire().devices().all(|drive| drive.is_enabled()),
        "the drives must hold to stop the motors"
    );
    rig.run_ms(600);
    assert!(rig.wire().devices().all(|drive| !drive.is_enabled()));
    rig.close(Contact::Stop);
    comes_back_on_command(&mut rig);
}

#[test]
fn an_alarm_ends_the_set_points_of_all_axes_in_the_same_cycle() {
    let mut rig = moving();
    let drive = devices(&rig)[3];
    let raised_ns = rig.board().soc().now_ns();
    rig.wire_mut()
        .device_mut(drive)
        .faults_mut()
        .raise_alarm(Alarm::OverCurrent);
    rig.run_ms(3);
    let alarm_ns = rig
        .wire()
        .bus()
        .log()
        .iter()
        .find(|record| record.start_ns >= raised_ns && record.frame.to_string().starts_with("09D#"))
        .map(|record| record.end_ns)
        .expect("the alarm frame of drive 4 is on the wire");
    assert!(rig.set_points_since(alarm_ns).count() <= ON_THEIR_WAY);
    assert_eq!(rig.set_points_since(alarm_ns + MS).count(), 0);
    assert!(rig.run_until_logged("AlarmFrame", 20) || rig.has_logged("AlarmFrame"));
    let from_ns = rig.board().soc().now_ns();
    rig.run_ms(1_000);
    assert_eq!(rig.set_points_since(from_ns).count(), 0);
}

#[test]
fn a_lost_drive_ramps_the_others_down_in_step() {
    let mut rig = moving();
    let drive = devices(&rig)[7];
    rig.run_ms(50);
    rig.wire_mut().device_mut(drive).faults_mut().leave_bus();
    rig.run_ms(500);
    assert!(rig.has_logged("Fault(Lost)"));
    assert!(rig.has_logged("RampingDown"));
    let from_ns = rig.board().soc().now_ns();
    rig.run_ms(100);
    assert_eq!(rig.set_points_since(from_ns).count(), 0);
    let counts = rig.commanded_counts();
    assert!(
        counts[..7].windows(2).all(|pair| pair[0] == pair[1]),
        "{counts:?}"
    );
    rig.wire_mut().device_mut(drive).faults_mut().wake();
    comes_back_on_command(&mut rig);
}
