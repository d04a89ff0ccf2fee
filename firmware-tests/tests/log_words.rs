//! The log is for people: drives by their ids, faults with what to do, no text for debugging.

use dyn_can::Alarm;
use firmware_tests::{Rig, rig};

/// What a derived text of a value looks like, and no sentence does.
const DEBUG_TEXT: [&str; 7] = [
    "Event {", "kind:", "Some(", "None", "Fault(", "Instant(", "State {",
];

fn assert_in_words(rig: &Rig) {
    let log = rig.board().log();
    assert!(log.len() > 3, "{log:#?}");
    for line in log {
        for leftover in DEBUG_TEXT {
            assert!(!line.contains(leftover), "{leftover} in {line}");
        }
    }
}

#[test]
fn from_power_on_to_an_alarm_every_line_is_in_words() {
    let mut rig = Rig::with_numbered_drives(rig::image("axes-8"), 8);
    rig.bring_up();
    let drive = rig.drives()[3];
    rig.servo_mut(drive)
        .faults_mut()
        .raise_alarm(Alarm::OverCurrent);
    rig.run_ms(100);
    assert!(
        rig.has_logged("drive 4: alarm, its shaft is free"),
        "{:#?}",
        rig.board().log()
    );
    assert!(rig.has_logged("drive 1: stopped with the others"));
    assert_in_words(&rig);
}

#[test]
fn a_drive_that_is_not_there_is_named_by_its_id() {
    let mut rig = Rig::with_numbered_drives(rig::image("axes-8"), 7);
    rig.make_ready();
    rig.run_ms(500);
    assert!(
        rig.has_logged("drive 8: no answer: check power"),
        "{:#?}",
        rig.board().log()
    );
    assert_in_words(&rig);
}
