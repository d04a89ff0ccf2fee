//! Power-on delay and power cycles.

use super::*;

#[test]
fn nothing_is_heard_before_the_power_on_delay() {
    let mut probe = Probe::v1_6a();
    probe.drive = DynDrive::new(drive_1());
    probe.wait(150 * MS - 1);
    assert!(!probe.drive.is_ready() && !probe.drive.is_enabled());
    probe.hear(0x03C, &[0x64]);
    assert_eq!(probe.ask(0x029, &[]), [""; 0]);
    assert_eq!(probe.drive.commanded_counts(), 0);
    assert!(probe.drive.is_ready() && probe.drive.is_enabled());
    assert_eq!(probe.ask(0x029, &[]), ["029#00"]);
}

#[test]
fn power_cycle_restarts_the_counter_and_loses_replies_and_position() {
    for (position_after_power, position) in [
        (PositionAfterPower::Zero, 0),
        (PositionAfterPower::Kept, 1_042),
    ] {
        let mut probe = Probe::v1_6a();
        probe.drive = DynDrive::new(DynDriveConfig {
            position_after_power,
            start_position_counts: 42,
            ..drive_1()
        });
        probe.wait(150 * MS);
        probe.stream(&[0x64], 10);
        probe.wait(100 * MS);
        assert_eq!(probe.ask(0x03F, &[]), ["03F#00"]);
        assert_eq!(probe.ask(0x03F, &[]), ["03F#01"]);
        probe.hear(0x029, &[]);
        probe.drive.faults_mut().power_cycle(20 * MS);
        probe.wait(170 * MS - 1);
        assert!(!probe.drive.is_ready());
        probe.wait(1);
        assert!(probe.drive.is_ready());
        assert_eq!(probe.take_sent(), [""; 0]);
        assert_eq!(probe.position(), position);
        assert_eq!(probe.ask(0x03F, &[]), ["03F#00"]);
        assert_eq!(probe.drive.travel_counts(probe.now_ns), 1_000);
        assert_eq!(probe.drive.commanded_counts(), 1_000);
    }
}

#[test]
fn power_cycle_clears_alarm_loaded_moves_and_waves() {
    let mut probe = Probe::v1_2a();
    probe.hear(0x036, &[0x64]);
    probe.hear(0x02D, &[5]);
    probe.drive.faults_mut().raise_alarm(Alarm::OverCurrent);
    probe.wait(MS);
    probe.drive.faults_mut().reboot();
    probe.wait(MS);
    assert_eq!(probe.status(), 0x00);
    probe.hear(0x018, &[0xFF]);
    probe.hear(0x02C, &[0x64]);
    probe.wait(200 * MS);
    assert_eq!(probe.position(), 0);
}

#[test]
fn absolute_mode_moves_to_zero_after_power_on() {
    let mut probe = Probe::new(DynDriveConfig {
        config_byte: ConfigByte::from_byte(0x04),
        start_position_counts: 5_000,
        ..drive_1()
    });
    assert_eq!((probe.position(), probe.status() & 0x20), (5_000, 0x20));
    probe.wait(300 * MS);
    assert_eq!((probe.position(), probe.status()), (0, 0x00));
    assert_eq!(probe.drive.travel_counts(probe.now_ns), -5_000);
}

#[test]
fn servo_free_configuration_starts_free() {
    let free = Probe::new(DynDriveConfig {
        config_byte: ConfigByte::from_byte(0x20),
        ..drive_1()
    });
    assert_eq!(free.status(), 0x02);
    let free = Probe::new(DynDriveConfig {
        enabled_after_power_on: false,
        ..drive_1()
    });
    assert_eq!(free.status(), 0x02);
}

#[test]
fn power_that_never_comes_back_is_no_event() {
    let mut probe = Probe::v1_6a();
    probe.drive.faults_mut().power_cycle(u64::MAX);
    probe.wait(MS);
    assert_eq!(probe.drive.next_event_ns(), Some(u64::MAX));
    assert_eq!(probe.ask(0x029, &[]), [""; 0]);
}
