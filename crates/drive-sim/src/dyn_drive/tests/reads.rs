//! Requests that are answered, and data errors.

use super::*;

#[test]
fn every_read_is_answered_with_the_bytes_of_its_revision() {
    let mut probe = Probe::v1_6a();
    let golden: [(u16, &[u8], &str); 11] = [
        (0x026, &[], "026#01"),
        (0x028, &[], "028#00"),
        (0x029, &[], "029#00"),
        (0x02E, &[0x1B], "02E#00"),
        (0x02E, &[0x1E], "02E#00"),
        (0x033, &[], "033#14140A7F"),
        (0x034, &[], "034#3C3C"),
        (0x035, &[], "035#140000100000"),
        (0x03A, &[], "03A#0000"),
        (0x03E, &[1, 2, 0xFE, 0xFF], "03E#0102FEFF"),
        (0x03F, &[], "03F#00"),
    ];
    for (id, data, reply) in golden {
        assert_eq!(probe.ask(id, data), [reply]);
    }
    assert_eq!(probe.ask(0x03F, &[]), ["03F#01"]);
    assert_eq!(Probe::v1_2a().ask(0x035, &[]), ["035#1410000000"]);
}

#[test]
fn reply_is_ready_after_the_delay_counted_from_the_request() {
    let mut probe = Probe::v1_6a();
    probe.wait(5 * MS);
    probe.hear(0x029, &[]);
    assert_eq!(probe.drive.next_event_ns(), Some(5 * MS + DELAY_NS));
    probe.wait(MS);
    assert_eq!(probe.sent, [(5 * MS + DELAY_NS, "029#00".into())]);
    assert_eq!(probe.drive.next_event_ns(), None);
}

#[test]
fn requests_for_others_and_what_is_no_request_are_not_answered() {
    let mut probe = Probe::v1_6a();
    for (id, data) in [
        (0x049, &[][..]),
        (0x02F, &[1]),
        (0x03D, &[0xEE]),
        (0x020, &[0xFF]),
    ] {
        assert_eq!(probe.ask(id, data), [""; 0], "{id:03X}");
    }
    let remote = crate::frame::tests::remote(0x029, 0);
    let extended = crate::frame::tests::extended(0x029, &[]);
    for frame in [remote, extended] {
        probe.drive.on_frame(probe.now_ns, &frame);
    }
    probe.wait(10 * MS);
    assert_eq!(probe.take_sent(), [""; 0]);
    let books = probe.drive.books();
    assert_eq!((books.factory_frames, books.undecodable_frames), (1, 3));
}

#[test]
fn read_back_has_the_unit_and_the_gear_of_the_drive() {
    // -1000 command counts at gear number 4096, and at 2048 after a write.
    for (unit, at_4096, at_2048) in [
        (ReadBackUnit::CommandCounts, "02E#FC18", "02E#FC18"),
        (ReadBackUnit::MovementPositions, "02E#F060", "02E#E0C0"),
        (ReadBackUnit::MotorSteps, "02E#FC18", "02E#F830"),
    ] {
        let mut probe = Probe::new(DynDriveConfig {
            read_back: unit,
            start_position_counts: -1_000,
            ..drive_1()
        });
        assert_eq!(probe.ask(0x02E, &[0x1B]), [at_4096]);
        probe.hear(0x032, &[0, 0x08, 0x00, 0, 0]);
        assert_eq!(probe.ask(0x02E, &[0x1B]), [at_2048]);
    }
}

#[test]
fn torque_has_the_scale_and_the_sign_of_the_revision() {
    // A step clockwise needs a clockwise torque: positive in 1.6A, negative in 1.2A.
    for (mut probe, full_scale) in [(Probe::v1_6a(), 981.0), (Probe::v1_2a(), -700.0)] {
        probe.hear(0x03C, &[0x1F, 0x40]);
        probe.wait(MS);
        let torque = probe.drive.motion.at(probe.now_ns).torque_share(8_192.0);
        assert!(torque > 0.75, "{torque}");
        let reply = probe.ask(0x02E, &[0x1E]).remove(0);
        let raw = i16::from_str_radix(&reply[4..], 16);
        let raw = raw.unwrap_or_else(|_| u16::from_str_radix(&reply[4..], 16).unwrap() as i16);
        assert_eq!(raw, (torque * full_scale).round() as i16);
    }
}

#[test]
fn a_drive_without_a_line_number_reports_0_whatever_is_written_beside_it() {
    for (mut probe, before, after) in [
        (Probe::v1_6a(), "035#140000100000", "035#140000080000"),
        (Probe::v1_2a(), "035#1410000000", "035#1408000000"),
    ] {
        assert_eq!(probe.ask(0x035, &[]), [before]);
        probe.hear(0x032, &[0, 0x08, 0x00, 0, 0]);
        assert_eq!(probe.ask(0x035, &[]), [after]);
    }
}

#[test]
fn speed_is_signed_and_two_bytes_long() {
    let mut probe = Probe::v1_6a();
    probe.hear(0x02A, &[0xF8, 0x30]);
    probe.wait(500 * MS);
    assert_eq!(probe.ask(0x03A, &[]), ["03A#F830"]);
}

#[test]
fn data_error_comes_where_it_is_promised() {
    let out_of_range: [(u16, &[u8]); 11] = [
        (0x021, &[0x08, 0, 0, 0]),
        (0x023, &[0xF7, 0xFF, 0xFF, 0xFF]),
        (0x02A, &[0x4E, 0x21]),
        (0x02B, &[0x10, 0x01]),
        (0x02C, &[0x80]),
        (0x02D, &[51]),
        (0x030, &[0, 128, 0, 0]),
        (0x031, &[0, 128]),
        (0x032, &[0, 0x01, 0xF3, 0, 0]),
        (0x036, &[0x08, 0, 0, 0]),
        (0x037, &[0x08, 0, 0, 0]),
    ];
    for mut probe in [Probe::v1_2a(), Probe::v1_6a()] {
        for (id, data) in out_of_range {
            assert_eq!(probe.ask(id, data), ["03D#FF"], "{id:03X}");
        }
        assert_eq!(probe.drive.books().data_errors, 11);
        assert_eq!(probe.drive.eeprom_writes().total(), 0);
    }
}

#[test]
fn what_no_document_promises_is_silence_unless_configured() {
    let unspecified: [(u16, &[u8]); 9] = [
        (0x020, &[0x00]),
        (0x02E, &[0x1C]),
        (0x038, &[0x00]),
        (0x039, &[0x01]),
        (0x03B, &[0xFF]),
        (0x03C, &[]),
        (0x029, &[0x00]),
        (0x03E, &[1, 2, 3]),
        (0x022, &[0x00]),
    ];
    let mut quiet = Probe::v1_6a();
    let mut loud = Probe::new(DynDriveConfig {
        unspecified: Reaction::DataError,
        ..drive_1()
    });
    for (id, data) in unspecified {
        assert_eq!(quiet.ask(id, data), [""; 0], "{id:03X}");
        assert_eq!(loud.ask(id, data), ["03D#FF"], "{id:03X}");
    }
}

#[test]
fn a_value_out_of_range_is_an_error_by_the_chapter_on_errors_or_by_that_of_its_function() {
    // Servo mode 3, an id of 64, and a step beyond 16384: only the chapter on errors speaks of them in 1.6A.
    let doubtful: [(u16, &[u8]); 4] = [
        (0x027, &[0x40]),
        (0x027, &[0x18]),
        (0x025, &[0x40]),
        (0x03C, &[0x40, 0x01]),
    ];
    let narrow = DynDriveConfig {
        range_errors: RangeErrors::WhereRepeated,
        ..drive_1()
    };
    for (id, data) in doubtful {
        assert_eq!(Probe::v1_6a().ask(id, data), ["03D#FF"], "{id:03X}");
        let mut probe = Probe::new(narrow.clone());
        assert_eq!(probe.ask(id, data), [""; 0], "{id:03X}");
        assert_eq!(probe.drive.eeprom_writes().total(), 0);
    }
    // 1.2A repeats it for Assign_Drive_ID.
    let mut older = Probe::new(narrow.with_revision(Revision::V1_2A));
    assert_eq!(older.ask(0x025, &[0x40]), ["03D#FF"]);
    assert_eq!(older.ask(0x027, &[0x40]), [""; 0]);
}
