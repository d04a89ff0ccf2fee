//! The image that takes orders follows a motion file that a host sends.

mod orders;

use board_link::WhenDry;
use board_link::host::StreamEnd;
use board_link::segment::StreamPhase;
use orders::{board, counts_told, pick_and_place, targets};

#[test]
fn four_axes_follow_a_file_of_a_host_that_is_up_to_50_ms_late() {
    let (mut rig, mut host) = board();
    host.bring_up(&mut rig);
    host.pause_up_to(50);
    let file = pick_and_place();
    let rows = file.rows();
    let from_ns = rig.board().soc().now_ns();
    let stand = targets(&host);
    host.stream(&mut rig, 1, file.segments(&stand), WhenDry::End);
    let is_complete = host.run_until(&mut rig, 9_000, |host, _| {
        host.phases(1).contains(&StreamPhase::Complete)
    });
    assert!(is_complete, "{:?} {:#?}", host.told, rig.board().log());
    let end = host.stream_end();
    assert_eq!(end, Some(StreamEnd::Sent { segments: 600 }));
    host.run_ms(&mut rig, 1_100);
    assert_eq!(
        (rig.statistic("late"), rig.statistic("missed")),
        (Some(0), Some(0))
    );
    let told = counts_told(&rig, from_ns);
    for (axis, told) in told.iter().enumerate() {
        let expected: Vec<i32> = rows.iter().map(|row| row[axis]).collect();
        let begins = |counts: &[i32]| counts.iter().position(|counts| *counts != 0).unwrap();
        // Both stand at first; from there on it is the same table, cycle by cycle.
        let (begun, planned) = (begins(told), begins(&expected));
        let told = &told[begun - planned..][..expected.len()];
        assert_eq!(told, expected, "axis {axis}");
    }
    // The books of the drives: what the board believes to have sent, and what they got.
    let sums: Vec<i64> = told
        .iter()
        .map(|told| i64::from(told[told.len() - 1]))
        .collect();
    let ends: Vec<i64> = targets(&host)
        .iter()
        .zip(&stand)
        .map(|(end, from)| i64::from(end - from))
        .collect();
    assert_eq!(sums, ends);
}
