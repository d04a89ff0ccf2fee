//! A loop whose answer depends on the gains.

use super::*;

/// Farthest position and time to within 2 %, in ms, of a step of 1000 counts with these gains, written over the bus.
fn answer(gains: [u8; 4]) -> (i64, u64) {
    let mut probe = Probe::new(DynDriveConfig {
        servo_loop: ServoLoop::WithGains,
        ..drive_1()
    });
    probe.hear(0x030, &gains);
    probe.hear(0x03C, &[0x03, 0xE8]);
    let (mut farthest, mut settled_ms) = (0, 0);
    for ms in 0..2_000 {
        probe.wait(MS);
        farthest = farthest.max(probe.position());
        if (probe.position() - 1_000).abs() > 20 {
            settled_ms = ms;
        }
    }
    (farthest, settled_ms)
}

#[test]
fn the_gains_of_the_factory_answer_fast_with_little_overshoot() {
    let (farthest, settled_ms) = answer([20, 20, 10, 127]);
    assert!((1_000..1_150).contains(&farthest), "{farthest}");
    assert!(settled_ms < 300, "{settled_ms}");
}

#[test]
fn less_speed_gain_overshoots_more_and_more_main_gain_answers_faster() {
    let factory = answer([20, 20, 10, 127]);
    assert!(answer([20, 5, 10, 127]).0 > factory.0 + 200);
    let stiff = answer([60, 60, 10, 127]);
    assert!(stiff.1 < factory.1, "{stiff:?} {factory:?}");
}

/// With the default loop the gains change nothing.
#[test]
fn the_default_loop_does_not_know_the_gains() {
    let position_after = |gains: [u8; 4]| {
        let mut probe = Probe::v1_6a();
        probe.hear(0x030, &gains);
        probe.hear(0x03C, &[0x03, 0xE8]);
        probe.wait(20 * MS);
        probe.position()
    };
    assert_eq!(position_after([20, 20, 10, 127]), position_after([127; 4]));
}
