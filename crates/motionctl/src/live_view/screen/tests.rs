//! The picture on screens of several sizes.

use super::*;
use crate::recording::{About, AxisAbout, Item, Origin, Sample};
use can_motion::AxisState;
use dyn_can::DriveId;
use ratatui::Terminal;
use ratatui::backend::TestBackend;

const KEYS: &str = "up/down select  s stop  q stop and leave";

fn recording(axes: usize) -> Recording {
    let drives = DriveId::all().take(axes);
    let about = drives.map(|drive| AxisAbout {
        name: format!("axis_{drive}"),
        ..AxisAbout::of_drive(drive)
    });
    let mut recording = Recording::new(About::now(Origin::Bus, about.collect(), 1_000, 1_000));
    let axis = |number: usize| AxisSample {
        target: 123_456 + number as i32,
        sent: 123_446,
        position: Some(123_431),
        backlog: 10,
        status_age_us: Some(12_300),
        position_age_us: None,
        state: Some(AxisState::Streaming),
    };
    recording.add(&Item::Cycle(Sample {
        at_us: 1_500_000,
        number: 1_500,
        load: 0.375,
        is_late: true,
        axes: (0..axes).map(axis).collect(),
        wheels: Vec::new(),
    }));
    recording.add(&Item::Event(Happening {
        at_us: 1_400_000,
        axis: Some(1),
        kind: Kind::Fault,
        text: "the drive does not answer".to_owned(),
        times: 1,
    }));
    recording
}

fn drawn(axes: usize, selected: usize, verdict: Option<(&str, bool)>, size: (u16, u16)) -> String {
    let recording = recording(axes);
    let screen = Screen {
        recording: &recording,
        selected,
        off_the_bus: &[false, true],
        head: "motion 6.0 s",
        status: "",
        keys: KEYS,
        events_title: " events ",
        messages: &["a message of the tool".to_owned()],
        verdict,
    };
    let mut terminal = Terminal::new(TestBackend::new(size.0, size.1)).unwrap();
    terminal.draw(|frame| screen.draw(frame)).unwrap();
    terminal.backend().to_string()
}

#[test]
fn axes_load_events_and_keys_are_there() {
    let text = drawn(2, 1, None, (110, 24));
    for wanted in [
        "1.500 s   motion 6.0 s",
        "123456",
        "off the bus, streaming",
        "12.3",
        "counts",
        "bus load 38 %",
        "1 late cycles",
        "1.400 s  drive 2  the drive does not answer",
        "a message of the tool",
        "q stop and leave",
    ] {
        assert!(text.contains(wanted), "{wanted} in\n{text}");
    }
}

#[test]
fn every_axis_and_key_is_visible_in_80_columns_and_24_lines_up_to_14_axes() {
    for axes in 1..=14 {
        for verdict in [None, Some(("Every promise kept", true))] {
            let text = drawn(axes, 0, verdict, (80, 24));
            for axis in 0..axes {
                let row = format!("axis_{:<5} {:5} ", axis + 1, axis + 1);
                assert!(text.contains(&row), "{row:?} of {axes} in\n{text}");
                let target = (123_456 + axis).to_string();
                assert!(text.contains(&target), "{target} of {axes} in\n{text}");
            }
            for wanted in ["backlog", "position", "bus load 38 %", "q stop and leave"] {
                assert!(text.contains(wanted), "{wanted} of {axes} in\n{text}");
            }
            assert!(text.contains("a message of the tool"), "{text}");
        }
    }
}

#[test]
fn names_have_what_room_there_is_and_a_longer_one_says_so() {
    assert_eq!(
        [60, 80, 85, 99, 100, 110, 200].map(name_width),
        [10, 10, 15, 18, 16, 18, 18]
    );
    assert_eq!(cut("right_rpm", 10), "right_rpm");
    assert_eq!(cut("right_rpm", 9), "right_rpm");
    assert_eq!(cut("right_rpm", 8), "right_r…");
    assert_eq!(cut("größer", 6), "größer");
}

#[test]
fn more_axes_than_lines_are_shown_around_the_selected_one() {
    let text = drawn(40, 30, None, (80, 24));
    assert!(text.contains("axis_31 "), "{text}");
    assert!(text.contains(" of 40"), "{text}");
    assert!(drawn(40, 39, None, (80, 24)).contains("axis_40 "));
    // However small the terminal is, nothing panics.
    for height in 0..12 {
        drawn(40, 39, Some(("done", false)), (30, height));
    }
}

#[test]
fn keys_take_as_many_lines_as_they_need() {
    let lines = |width| {
        let lines = key_lines(KEYS, width);
        lines.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    assert_eq!(lines(80), [" up/down select  s stop  q stop and leave"]);
    assert_eq!(lines(30), [" up/down select  s stop", " q stop and leave"]);
}
