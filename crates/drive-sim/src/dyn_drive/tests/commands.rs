//! Built-in motion, servo switch, origin, parameters and configuration.

use super::*;

#[test]
fn move_is_busy_until_its_profile_ends() {
    let mut probe = Probe::v1_6a();
    // MaxSpd 48, MaxAcl 30 and 140000 counts: 0.362 s (DYN2 manual A1.8 section 7).
    probe.hear(0x031, &[48, 30]);
    probe.hear(0x021, &[0x02, 0x22, 0xE0]);
    probe.wait(350 * MS);
    assert_eq!(probe.status(), 0x21);
    assert_eq!(probe.ask(0x029, &[]), ["029#21"]);
    probe.wait(100 * MS);
    assert_eq!((probe.status(), probe.position()), (0x00, 140_000));
    probe.hear(0x023, &[0xFF, 0x38]);
    probe.wait(200 * MS);
    assert_eq!(probe.position(), 139_800);
    let books = probe.drive.books();
    assert_eq!((books.moves, books.relative_move_counts), (2, -200));
    assert_eq!(books.last_move_target_counts, Some(139_800));
    assert_eq!(books.commanded_counts, 0);
}

#[test]
fn loaded_moves_start_together_on_a_broadcast_trigger() {
    let mut probes = [1, 2].map(|id| Probe::new(DynDriveConfig::numbered(id).unwrap()));
    for (probe, id) in probes.iter_mut().zip([0x036, 0x056]) {
        probe.hear(id, &[0x03, 0xE8]);
        probe.hear(id + 1, &[0x64]);
        probe.wait(50 * MS);
        assert_eq!(probe.position(), 0);
        probe.hear(0x018, &[0xFF]);
        assert_eq!(probe.status() & 0x20, 0x20);
        probe.wait(500 * MS);
        assert_eq!(probe.position(), 1_000);
        probe.hear(0x018, &[0xEE]);
        probe.wait(500 * MS);
        assert_eq!(probe.position(), 1_100);
        // Both were used up.
        probe.hear(0x018, &[0xFF]);
        probe.hear(0x018, &[0xEE]);
        probe.wait(500 * MS);
        assert_eq!(probe.position(), 1_100);
        assert_eq!(probe.drive.books().moves_ignored, 2);
    }
}

#[test]
fn constant_speed_switches_1_6a_to_speed_mode_until_power_or_a_write() {
    let mut probe = Probe::v1_6a();
    probe.hear(0x02A, &[0x32]);
    probe.wait(100 * MS);
    assert_eq!(probe.drive.speed_rpm(probe.now_ns), 50.0);
    assert_eq!(probe.ask(0x028, &[]), ["028#08"]);
    probe.hear(0x02A, &[0x00]);
    probe.stream(&[0x64], 3);
    assert_eq!(probe.drive.books().pd_frames_ignored, 3);
    assert_eq!(probe.drive.eeprom_writes().config, 0);
    probe.hear(0x027, &[0x00]);
    probe.stream(&[0x64], 3);
    assert_eq!(probe.drive.commanded_counts(), 300);
    assert_eq!(probe.drive.eeprom_writes().config, 1);
    // Back in position mode, after a turn at constant speed.
    let anchor = probe.drive.target_counts(probe.now_ns) - 300;
    probe.wait(200 * MS);
    assert_eq!(probe.position(), anchor + 300);
}

#[test]
fn constant_speed_leaves_the_mode_of_1_2a_alone() {
    let mut probe = Probe::v1_2a();
    probe.hear(0x02A, &[0x32]);
    probe.wait(100 * MS);
    assert_eq!(probe.drive.speed_rpm(probe.now_ns), 50.0);
    assert_eq!(probe.ask(0x028, &[]), ["028#00"]);
    probe.hear(0x03C, &[0x64]);
    probe.wait(200 * MS);
    assert_eq!(probe.drive.commanded_counts(), 100);
    assert_eq!(probe.drive.speed_rpm(probe.now_ns), 0.0);
}

#[test]
fn a_speed_is_reached_and_left_by_the_soft_start_of_the_acceleration_parameter() {
    // DYN2 manual A1.8 section 4.2: the whole time is 1.2 * 59.98 / 10^2 = 0.720 s, from 10 to 90 % it is 0.600 s.
    let mut probe = Probe::v1_6a();
    probe.hear(0x031, &[0, 10]);
    let speed = |probe: &Probe| probe.drive.speed_rpm(probe.now_ns);
    let mut last = 0.0;
    for target in [1_000.0, -1_000.0, 0.0] {
        let [high, low] = (target as i16).to_be_bytes();
        probe.hear(0x02A, &[high, low]);
        let share = |probe: &Probe, ms: u64| {
            let mut ahead = Probe {
                drive: probe.drive.clone(),
                now_ns: probe.now_ns,
                sent: Vec::new(),
            };
            ahead.wait(ms * MS);
            (speed(&ahead) - last) / (target - last)
        };
        assert!(share(&probe, 55) < 0.1, "{}", share(&probe, 55));
        assert!((share(&probe, 360) - 0.5).abs() < 0.02);
        assert!(share(&probe, 665) > 0.9, "{}", share(&probe, 665));
        assert!(share(&probe, 700) < 0.999);
        probe.wait(721 * MS);
        assert!((speed(&probe) - target).abs() < 1e-9);
        last = target;
    }
}

#[test]
fn wave_needs_amplitude_and_frequency() {
    let mut probe = Probe::v1_6a();
    probe.hear(0x02C, &[0x01, 0xF4]);
    probe.wait(100 * MS);
    assert_eq!(probe.position(), 0);
    probe.hear(0x02D, &[5]);
    probe.wait(50 * MS);
    assert!(
        (300..=520).contains(&probe.position()),
        "{}",
        probe.position()
    );
    probe.wait(100 * MS);
    assert!(
        (-520..=-300).contains(&probe.position()),
        "{}",
        probe.position()
    );
    probe.hear(0x02D, &[0]);
    probe.wait(200 * MS);
    assert_eq!(probe.position(), 0);
}

#[test]
fn disabled_servo_ignores_steps_and_holds_where_it_is_enabled() {
    let mut probe = Probe::v1_6a();
    probe.stream(&[0x64], 20);
    probe.hear(0x039, &[0xFF]);
    assert_eq!(probe.status(), 0x02);
    let speed = probe.drive.speed_rpm(probe.now_ns);
    assert!(speed > 200.0);
    probe.stream(&[0x64], 5);
    let coasting = probe.drive.speed_rpm(probe.now_ns);
    // 3000 rpm/s for 5 ms.
    assert!((speed - coasting - 15.0).abs() < 1.0, "{speed} {coasting}");
    probe.wait(500 * MS);
    assert_eq!(probe.drive.speed_rpm(probe.now_ns), 0.0);
    let rest = probe.position();
    assert_ne!(rest, 2_000);
    probe.hear(0x039, &[0x00]);
    probe.wait(100 * MS);
    assert_eq!((probe.status(), probe.position()), (0x00, rest));
    probe.stream(&[0x0A], 1);
    probe.wait(100 * MS);
    assert_eq!(probe.position(), rest + 10);
    let books = probe.drive.books();
    assert_eq!(
        (
            books.commanded_counts,
            books.pd_frames,
            books.pd_frames_ignored
        ),
        (2_010, 21, 5)
    );
}

#[test]
fn enabling_an_enabled_servo_loses_no_count() {
    let mut probe = Probe::v1_6a();
    probe.hear(0x03C, &[0x03, 0xE8]);
    probe.wait(MS);
    probe.hear(0x039, &[0x00]);
    probe.wait(100 * MS);
    assert_eq!(probe.position(), 1_000);
}

#[test]
fn origin_takes_the_magic_byte_of_the_revision() {
    for (mut probe, magic, other) in [(Probe::v1_2a(), 0xFF, 0xAB), (Probe::v1_6a(), 0xAB, 0xFF)] {
        probe.stream(&[0x7F], 4);
        probe.wait(100 * MS);
        probe.hear(0x020, &[other]);
        assert_eq!(probe.position(), 508);
        probe.hear(0x020, &[magic]);
        assert_eq!(probe.position(), 0);
        assert_eq!(probe.drive.travel_counts(probe.now_ns), 508);
        assert_eq!(probe.drive.eeprom_writes().origin, 1);
        assert_eq!(probe.drive.commanded_counts(), 508);
        probe.hear(0x021, &[0x0A]);
        probe.wait(200 * MS);
        assert_eq!(probe.drive.travel_counts(probe.now_ns), 518);
    }
}

#[test]
fn parameters_are_stored_read_and_worn() {
    let mut probe = Probe::v1_6a();
    probe.hear(0x030, &[1, 0, 3, 0]);
    assert_eq!(probe.ask(0x033, &[]), ["033#0114037F"]);
    probe.hear(0x032, &[0, 0x08, 0x00, 0x01, 0xF4]);
    assert_eq!(probe.ask(0x035, &[]), ["035#14000008F401"]);
    for speed in 1..=12 {
        probe.hear(0x031, &[speed, 0]);
    }
    assert_eq!(probe.ask(0x034, &[]), ["034#0C3C"]);
    probe.hear(0x030, &[0; 4]);
    let writes = *probe.drive.eeprom_writes();
    assert_eq!((writes.group1, writes.group2, writes.group3), (1, 10, 1));
    assert_eq!(writes.total(), 12);
    probe.drive.faults_mut().reboot();
    probe.wait(MS);
    assert_eq!(probe.ask(0x034, &[]), ["034#0A3C"]);
}

#[test]
fn other_modes_ignore_motion() {
    for config in [0x01, 0x02, 0x03, 0x08, 0x10, 0x18] {
        let mut probe = Probe::new(DynDriveConfig {
            config_byte: ConfigByte::from_byte(config),
            ..drive_1()
        });
        probe.stream(&[0x64], 2);
        probe.hear(0x021, &[0x64]);
        probe.wait(100 * MS);
        let books = probe.drive.books();
        assert_eq!(
            (
                books.pd_frames_ignored,
                books.moves_ignored,
                books.commanded_counts
            ),
            (2, 1, 0),
            "{config:02X}"
        );
        assert_eq!(probe.drive.travel_counts(probe.now_ns), 0);
    }
}

#[test]
fn configuration_bit_5_switches_the_servo() {
    let mut probe = Probe::v1_6a();
    probe.hear(0x027, &[0x20]);
    assert!(!probe.drive.is_enabled());
    probe.hear(0x027, &[0x00]);
    assert!(probe.drive.is_enabled());
    assert_eq!(probe.drive.eeprom_writes().config, 2);
}

#[test]
fn new_id_counts_after_10_ms_in_1_2a_and_after_power_in_1_6a() {
    let mut probe = Probe::v1_2a();
    probe.hear(0x025, &[5]);
    probe.wait(9 * MS);
    assert_eq!(probe.ask(0x026, &[]), ["026#01"]);
    assert_eq!(probe.ask(0x0A6, &[]), ["0A6#05"]);
    assert_eq!(probe.ask(0x026, &[]), [""; 0]);

    let mut probe = Probe::v1_6a();
    probe.hear(0x025, &[5]);
    probe.wait(1_000 * MS);
    assert_eq!(probe.ask(0x026, &[]), ["026#01"]);
    probe.drive.faults_mut().reboot();
    probe.wait(MS);
    assert_eq!(probe.ask(0x0A6, &[]), ["0A6#05"]);
    assert_eq!(probe.drive.eeprom_writes().drive_id, 1);
}

#[test]
fn fresh_drive_answers_on_identifier_0() {
    let mut probe = Probe::new(DynDriveConfig::fresh());
    assert_eq!(probe.ask(0x006, &[]), ["006#00"]);
    assert_eq!(probe.ask(0x026, &[]), [""; 0]);
    assert_eq!(probe.ask(0x00D, &[51]), ["01D#FF"]);
    assert_eq!(Probe::v1_6a().ask(0x006, &[]), ["026#01"]);
}
