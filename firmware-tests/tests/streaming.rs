//! Ten seconds of motion with eight axes and polls.

use drive_sim::{DynDrive, Record};
use firmware_tests::load::Masked;
use firmware_tests::scenario::is_set_point;
use firmware_tests::{Contact, Rig, rig};

const AXES: usize = 8;

fn streaming() -> (Rig, u64) {
    let mut rig = Rig::with_numbered_drives(rig::image("axes-8"), AXES as i32);
    rig.bring_up();
    let from_ns = rig.board().soc().now_ns();
    (rig, from_ns)
}

#[test]
fn what_the_firmware_sent_is_what_the_drives_got_and_no_cycle_is_late() {
    let (mut rig, from_ns) = streaming();
    rig.run_ms(10_000);
    let sent = rig.set_points_since(from_ns).count();
    // The ends of the window may lie within a cycle.
    assert!(sent.abs_diff(10_000 * AXES) < AXES, "{sent}");
    assert_eq!(
        (rig.statistic("late"), rig.statistic("missed")),
        (Some(0), Some(0))
    );
    assert_eq!(
        (rig.statistic("events dropped"), rig.statistic("bus errors")),
        (Some(0), Some(0))
    );
    rig.open(Contact::Run);
    assert!(rig.run_until_logged("the motion has ended", 2_000));
    rig.run_ms(5);
    // The counts that the firmware believes to have sent, against the books of the drives.
    let ended = rig.logged_counts("the motion has ended").unwrap();
    let started = rig.logged_counts("the motion starts").unwrap();
    let moved: Vec<i64> = ended
        .iter()
        .zip(&started)
        .map(|(end, start)| end - start)
        .collect();
    assert_eq!(rig.commanded_counts(), moved);
    for drive in rig.servos() {
        let books = drive.books();
        assert_eq!((books.pd_frames_ignored, books.undecodable_frames), (0, 0));
        assert!(books.replies > 900, "polls ran beside the set-points");
    }
}

#[test]
fn interrupted_in_the_middle_the_sums_are_still_equal() {
    let (mut rig, _) = streaming();
    rig.run_ms(250);
    rig.open(Contact::Enable);
    assert!(rig.run_until_logged("the motion has ended", 50));
    rig.run_ms(500);
    assert!(rig.servos().all(|drive| !drive.is_enabled()));
    let commanded = rig.commanded_counts();
    assert!(
        commanded.windows(2).all(|pair| pair[0] == pair[1]),
        "not in step: {commanded:?}"
    );
    // Anchored anew at what the drives read back, which is where the motors stopped.
    rig.open(Contact::Run);
    rig.run_ms(100);
    rig.enable();
    rig.close(Contact::Run);
    let now_ns = rig.board().soc().now_ns();
    let stands: Vec<i64> = rig
        .servos()
        .map(|drive| drive.position_counts(now_ns))
        .collect();
    assert!(rig.run_until_logged("the motion starts", 100));
    assert_eq!(rig.logged_counts("the motion starts"), Some(stands));
}

#[test]
fn the_wire_never_waits_for_the_next_set_point_of_a_cycle() {
    let (mut rig, from_ns) = streaming();
    rig.run_ms(1_000);
    let records: Vec<&Record> = rig
        .wire()
        .bus()
        .log()
        .iter()
        .filter(|record| record.start_ns >= from_ns)
        .collect();
    let mut pairs = 0;
    for pair in records.windows(2) {
        let [before, after] = pair else { continue };
        // In a cycle they go out in ascending order of drives.
        let same_cycle = before.frame.arbitration_field() < after.frame.arbitration_field();
        if is_set_point(before) && is_set_point(after) && same_cycle {
            pairs += 1;
            assert_eq!(
                after.start_ns, before.free_ns,
                "an idle gap before {}",
                after.frame
            );
        }
    }
    assert!(pairs > 6_000, "only {pairs} pairs of neighbours were seen");
}

#[test]
fn polls_keep_status_and_position_fresh() {
    let (mut rig, _) = streaming();
    rig.run_ms(2_000);
    let age = |unit: &str| {
        let line = rig
            .board()
            .log()
            .iter()
            .rev()
            .find(|line| line.contains("oldest status"))
            .unwrap();
        let behind = line.split_once(unit).unwrap().1;
        behind
            .trim()
            .split(' ')
            .next()
            .unwrap()
            .parse::<u64>()
            .unwrap()
    };
    // 50 Hz, and a request waits for its turn.
    assert!(age("oldest status") <= 40, "{}", age("oldest status"));
    assert!(age(", position") <= 40);
    assert!(rig.servos().all(DynDrive::is_enabled));
}

#[test]
fn interrupts_are_never_masked_for_long() {
    let mut rig = Rig::with_numbered_drives(rig::image("axes-8"), AXES as i32);
    // The start masks them while the clocks are set up.
    rig.run_ms(20);
    rig.board_mut().soc_mut().masked = Masked::default();
    rig.bring_up();
    rig.run_ms(2_000);
    // Many lines of the log: every drive is lost, and none confirms that it is off.
    let drives = rig.drives().to_vec();
    for drive in drives {
        rig.servo_mut(drive).faults_mut().leave_bus();
    }
    rig.run_ms(2_000);
    let masked = rig.board().soc().masked;
    assert!(
        masked.longest <= 350,
        "{} instructions from {:#x} on",
        masked.longest,
        masked.begins_at
    );
}
