//! Short logs, frame by frame.

use super::*;
use can_decode::Decoder;

/// Frames of a log: time in microseconds, identifier, data.
fn motion(frames: &[(u64, u32, &[u8])]) -> (Recording, Outcome) {
    let mut motion = LogMotion::new("can0", 1_000);
    let mut decoder = Decoder::default();
    for &(at_us, id, data) in frames {
        let frame = Frame::new(id, false, data).unwrap();
        let at_ns = 1_700_000_000_000_000_000 + at_us * 1_000;
        let meaning = decoder.hear(at_ns, &frame);
        motion.frame(at_ns, &frame, &meaning);
    }
    motion.finish().unwrap()
}

fn sent(recording: &Recording, axis: usize) -> Vec<i32> {
    let samples = recording.samples.iter();
    samples.map(|sample| sample.axes[axis].sent).collect()
}

#[test]
fn steps_are_summed_from_where_the_drive_stood() {
    // Drive 1 is asked for its position, 100, and then told +2, +3, -1; drive 2 comes later, in front of it in the row.
    let (recording, outcome) = motion(&[
        (0, 0x02E, &[0x1B]),
        (500, 0x02E, &[0x00, 0x64]),
        (1_000, 0x03C, &[0x02]),
        (2_000, 0x03C, &[0x03]),
        (3_000, 0x05C, &[0x05]),
        (3_100, 0x03C, &[0xFF]),
        (3_500, 0x02E, &[0x1B]),
        (3_900, 0x02E, &[0x00, 0x66]),
    ]);
    let names: Vec<_> = recording.about.axes.iter().map(|axis| axis.drive).collect();
    assert_eq!(names, [1, 2]);
    assert_eq!(sent(&recording, 0), [102, 105, 104]);
    assert_eq!(
        sent(&recording, 1),
        [5, 5, 5],
        "it stood there before, as far as is known"
    );
    let last = recording.samples.last().unwrap();
    assert_eq!(last.axes[0].position, Some(102));
    assert_eq!(last.at_us, 3_900);
    assert_eq!(recording.about.cycle_us, 1_000);
    assert_eq!(outcome.axes[0].set_points, Some(3));
    let text = outcome.facts.join(" ");
    assert!(text.contains("Drive 2: the log has no position"), "{text}");
    assert!(!text.contains("Drive 1:"), "{text}");
}

#[test]
fn a_set_point_that_came_twice_counts_twice_and_is_named() {
    let (recording, outcome) = motion(&[
        (1_000, 0x03C, &[0x02]),
        (1_080, 0x03C, &[0x02]),
        (2_000, 0x03C, &[0x02]),
    ]);
    assert_eq!(sent(&recording, 0), [2, 4, 6]);
    assert!(outcome.facts.join(" ").contains("1 set-point came twice"));
}

#[test]
fn a_drive_that_shows_late_where_it_stands_is_moved_there() {
    let (recording, _) = motion(&[
        (1_000, 0x03C, &[0x02]),
        (2_000, 0x03C, &[0x02]),
        (2_300, 0x02E, &[0x1B]),
        (2_600, 0x02E, &[0x00, 0x64]),
        (3_000, 0x03C, &[0x02]),
    ]);
    assert_eq!(sent(&recording, 0), [98, 100, 102]);
}

#[test]
fn alarms_are_faults_and_what_looks_like_trouble_is_a_notice() {
    // Status with alarm 2 (over-current), then a set-point, then a status twice without an answer.
    let (recording, outcome) = motion(&[
        (0, 0x029, &[]),
        (500, 0x029, &[0x08]),
        (1_000, 0x03C, &[0x02]),
        (2_000, 0x029, &[]),
        (3_000, 0x029, &[]),
    ]);
    let kinds: Vec<Kind> = recording.happenings.iter().map(|it| it.kind).collect();
    assert_eq!(kinds, [Kind::Fault, Kind::Phase, Kind::Notice]);
    assert!(!outcome.is_good);
    let text = recording.happenings[0].text.as_str();
    assert!(text.contains("alarm"), "{text}");
}
