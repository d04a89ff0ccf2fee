//! Alarms and commanded faults.

use core::num::NonZeroU64;

use super::*;

#[test]
fn alarm_is_latched_frees_the_motor_and_is_told_at_once() {
    let mut probe = Probe::v1_6a();
    probe.stream(&[0x64], 10);
    probe.hear(0x029, &[]);
    probe.drive.faults_mut().raise_alarm(Alarm::OverCurrent);
    let before_ns = probe.now_ns;
    probe.wait(MS);
    assert_eq!(
        probe.sent,
        [
            (before_ns, "03D#EE".into()),
            (before_ns + DELAY_NS, "029#01".into())
        ]
    );
    probe.sent.clear();
    probe.stream(&[0x64], 3);
    probe.hear(0x021, &[0x64]);
    probe.hear(0x039, &[0x00]);
    assert_eq!(probe.ask(0x029, &[]), ["029#0A"]);
    assert_eq!(probe.drive.commanded_counts(), 1_000);
    assert_eq!(probe.drive.books().pd_frames_ignored, 3);
    assert!(!probe.drive.is_enabled());
}

#[test]
fn drive_reset_clears_an_alarm_in_1_6a_only() {
    for (mut probe, reply, status) in [
        (Probe::v1_6a(), vec!["03B#00"], 0x00),
        (Probe::v1_2a(), vec![], 0x0E),
    ] {
        probe.stream(&[0x64], 10);
        probe.wait(100 * MS);
        probe
            .drive
            .faults_mut()
            .raise_alarm(Alarm::OverheatOrOverpower);
        probe.wait(MS);
        assert_eq!(probe.take_sent(), ["03D#EE"]);
        assert_eq!(probe.ask(0x03B, &[0xFE]), reply);
        assert_eq!(probe.status(), status);
        let is_reset = status == 0;
        assert_eq!(probe.position(), if is_reset { 0 } else { 1_000 });
        assert_eq!(probe.drive.is_enabled(), is_reset);
    }
}

#[test]
fn steps_too_fast_for_the_motor_end_in_lost_phase() {
    let mut probe = Probe::v1_6a();
    let mut frames = 0;
    while probe.drive.alarm() == Alarm::None {
        // 4096 counts a millisecond are 15000 rpm.
        probe.stream(&[0x10, 0x00], 1);
        frames += 1;
        assert!(frames < 10);
    }
    assert_eq!(probe.take_sent(), ["03D#EE"]);
    assert_eq!(probe.status(), 0x06);
    assert_eq!(probe.drive.commanded_counts(), 4_096 * i64::from(frames));
}

/// The alarm comes when the error is there, not when somebody asks.
#[test]
fn lost_phase_is_told_without_a_request() {
    let mut probe = Probe::v1_6a();
    // Up to 792 counts a millisecond, which are 2900 rpm; stopping dead then overshoots by more than 8192 counts some milliseconds later.
    for step in (8..=792_u16).step_by(8) {
        probe.stream(&step.to_be_bytes(), 1);
    }
    assert_eq!(probe.take_sent(), [""; 0]);
    let end_ns = probe.now_ns;
    probe.wait(1_000 * MS);
    let (at_ns, text) = probe.sent.remove(0);
    assert_eq!(text, "03D#EE");
    assert!(
        at_ns > end_ns + 5 * MS && at_ns < end_ns + 50 * MS,
        "{at_ns}"
    );
    assert_eq!(at_ns % TICK_NS, 0);
}

#[test]
fn lost_phase_can_be_switched_off() {
    let mut probe = Probe::new(DynDriveConfig {
        lost_phase_steps: None,
        ..drive_1()
    });
    probe.stream(&[0x40, 0x00], 10);
    probe.wait(3_000 * MS);
    assert_eq!((probe.status(), probe.position()), (0x00, 163_840));
}

#[test]
fn alarm_frames_repeat_as_often_as_told() {
    let mut probe = Probe::v1_6a();
    probe.drive.faults_mut().raise_alarm(Alarm::LostPhase);
    probe
        .drive
        .faults_mut()
        .repeat_alarm_frames(NonZeroU64::new(500_000));
    probe.wait(2 * MS);
    let times: Vec<u64> = probe.sent.iter().map(|(at_ns, _)| *at_ns).collect();
    assert_eq!(times, [0, 500_000, 1_000_000, 1_500_000, 2_000_000]);
    probe.drive.faults_mut().repeat_alarm_frames(None);
    probe.take_sent();
    probe.wait(10 * MS);
    assert_eq!(probe.take_sent(), [""; 0]);
    assert_eq!(probe.drive.books().alarm_frames, 5);
}

#[test]
fn reply_faults_concern_the_next_replies_in_order() {
    let mut probe = Probe::v1_6a();
    probe.drive.faults_mut().drop_next_replies(2);
    probe.drive.faults_mut().duplicate_next_reply();
    for expected in [vec![], vec![], vec!["03F#02"; 2], vec!["03F#03"]] {
        assert_eq!(probe.ask(0x03F, &[]), expected);
    }
    probe.drive.faults_mut().truncate_next_reply();
    assert_eq!(probe.ask(0x03A, &[]), ["03A#00"]);
    probe.drive.faults_mut().lengthen_next_reply();
    assert_eq!(probe.ask(0x03A, &[]), ["03A#000000"]);
    assert_eq!(probe.ask(0x03A, &[]), ["03A#0000"]);
    probe.drive.faults_mut().delay_next_reply(3 * MS);
    probe.hear(0x026, &[]);
    probe.hear(0x028, &[]);
    let late_ns = probe.now_ns + 3 * MS + DELAY_NS;
    probe.wait(10 * MS);
    assert_eq!(
        probe.sent,
        [(late_ns, "026#01".into()), (late_ns, "028#00".into())]
    );
    assert_eq!(probe.drive.books().unsent_frames, 2);
}

#[test]
fn silent_drive_obeys_and_gone_drive_does_not() {
    let mut probe = Probe::v1_6a();
    probe.drive.faults_mut().fall_silent();
    probe.stream(&[0x01], 5);
    probe.drive.faults_mut().raise_alarm(Alarm::OverCurrent);
    assert_eq!(probe.ask(0x029, &[]), [""; 0]);
    assert_eq!(probe.drive.commanded_counts(), 5);
    assert_eq!(probe.drive.books().unsent_frames, 2);
    probe.drive.faults_mut().leave_bus();
    assert_eq!(probe.ask(0x03F, &[]), [""; 0]);
    probe.drive.faults_mut().wake();
    assert_eq!(probe.ask(0x03F, &[]), ["03F#00"]);
}

#[test]
fn drive_can_disable_and_misconfigure_itself() {
    let mut probe = Probe::v1_6a();
    probe.drive.faults_mut().disable_itself();
    assert_eq!(probe.ask(0x029, &[]), ["029#02"]);
    probe.hear(0x039, &[0x00]);
    probe
        .drive
        .faults_mut()
        .misconfigure(ConfigByte::from_byte(0x02));
    assert_eq!(probe.ask(0x028, &[]), ["028#02"]);
    probe.stream(&[0x01], 5);
    assert_eq!(probe.drive.books().pd_frames_ignored, 5);
    assert_eq!(probe.drive.eeprom_writes().total(), 0);
    probe.drive.faults_mut().reboot();
    assert_eq!(probe.ask(0x028, &[]), ["028#00"]);
}

#[test]
fn settings_are_ignored_after_as_many_as_were_allowed() {
    let mut probe = Probe::v1_6a();
    probe.drive.faults_mut().ignore_settings_after(1);
    // Main gain 33, then speed gain 44; the others are kept.
    probe.hear(0x030, &[0x21, 0, 0, 0]);
    probe.hear(0x030, &[0, 0x2C, 0, 0]);
    assert_eq!(probe.ask(0x033, &[]), ["033#21140A7F"]);
    probe.hear(0x025, &[0x09]);
    probe.hear(0x020, &[0xAB]);
    assert_eq!(probe.drive.eeprom_writes().total(), 1);
    // What stores nothing is obeyed.
    probe.hear(0x039, &[0xFF]);
    assert!(!probe.drive.is_enabled());
}
