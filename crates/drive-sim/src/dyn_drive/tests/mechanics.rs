//! End stops and a switch.

use dyn_can::Revision;

use super::*;

/// Drive 1 whose shaft goes from -500 to 1000 counts, with a switch that is operated from 700 upward.
fn between_stops(revision: Revision) -> Probe {
    Probe::new(DynDriveConfig {
        mechanics: Mechanics {
            stops: Some(EndStops {
                low_counts: -500,
                high_counts: 1_000,
            }),
            switch: Some(Switch {
                at_counts: 700,
                side: SwitchSide::Above,
            }),
        },
        ..drive_1().with_revision(revision)
    })
}

/// A step of 1091 or -591 counts in one frame leads 91 counts beyond the stop: a fifth of the 455 counts of the full torque.
#[test]
fn a_shaft_stops_at_its_stop_and_the_motor_pushes_there() {
    for (revision, step, position, torque) in [
        (Revision::V1_6A, &[0x04, 0x43], 1_000, "02E#00C4"),
        (Revision::V1_6A, &[0xFD, 0xB1], -500, "02E#FF3C"),
        (Revision::V1_2A, &[0x04, 0x43], 1_000, "02E#FF74"),
        (Revision::V1_2A, &[0xFD, 0xB1], -500, "02E#008C"),
    ] {
        let mut probe = between_stops(revision);
        probe.hear(0x03C, step);
        probe.wait(300 * MS);
        assert_eq!(probe.position(), position);
        assert_eq!(probe.ask(0x02E, &[0x1E]), [torque], "{revision:?}");
        assert!(!probe.drive.status(probe.now_ns).on_position());
        // Back where the stop is, nothing pushes.
        let back: i16 = if position > 0 { -91 } else { 91 };
        probe.hear(0x03C, &back.to_be_bytes());
        probe.wait(300 * MS);
        assert_eq!(probe.position(), position);
        assert_eq!(probe.ask(0x02E, &[0x1E]), ["02E#00"]);
    }
}

#[test]
fn a_shaft_that_coasts_stops_at_its_stop_too() {
    let mut probe = between_stops(Revision::V1_6A);
    // 200 rpm, then free.
    probe.hear(0x02A, &[0x00, 0xC8]);
    probe.wait(10 * MS);
    assert!(probe.drive.speed_rpm(probe.now_ns) > 50.0);
    probe.hear(0x039, &[0xFF]);
    probe.wait(2_000 * MS);
    assert!(probe.position() <= 1_000, "{}", probe.position());
    assert_eq!(probe.ask(0x02E, &[0x1E]), ["02E#00"]);
}

#[test]
fn a_switch_follows_the_shaft_whatever_the_drive_calls_its_position() {
    let mut probe = between_stops(Revision::V1_6A);
    let is_operated = |probe: &Probe| probe.drive.switch_is_operated(probe.now_ns);
    assert!(!is_operated(&probe));
    probe.hear(0x03C, &[0x02, 0xBC]);
    probe.wait(300 * MS);
    assert!(is_operated(&probe));
    probe.hear(0x020, &[0xAB]);
    assert_eq!(probe.position(), 0);
    assert!(is_operated(&probe));
    probe.hear(0x03C, &[0xFF]);
    probe.wait(300 * MS);
    assert_eq!((probe.position(), is_operated(&probe)), (-1, false));
}
