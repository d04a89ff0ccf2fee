//! What stands beside the shaft, and the loops.

use super::*;

const POSITION_MODE: [u8; 8] = [0x2F, 0x60, 0x60, 0, 1, 0, 0, 0];
const NEVER_OFFLINE: [u8; 8] = [0x2B, 0x00, 0x20, 0, 0, 0, 0, 0];

fn rig(mechanics: ZlacMechanics) -> Rig {
    let config = ZlacDriveConfig {
        mechanics,
        ..config()
    };
    let mut rig = Rig::new(config);
    rig.pass(101);
    rig.tell(&[NEVER_OFFLINE]);
    rig
}

fn write_u16(index: u16, value: u16) -> [u8; 8] {
    let ([low, high], [a, b]) = (index.to_le_bytes(), value.to_le_bytes());
    [0x2B, low, high, 0, a, b, 0, 0]
}

fn write_u32(index: u16, value: i32) -> [u8; 8] {
    let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), value.to_le_bytes());
    [0x23, low, high, 0, a, b, c, d]
}

impl Rig {
    fn go_to(&mut self, counts: i32) {
        self.tell(&[
            write_u32(0x607A, counts),
            write_u16(0x6040, 0x000F),
            write_u16(0x6040, 0x001F),
        ]);
    }

    fn torque(&self) -> i16 {
        self.drive()
            .object(self.now_ns(), ObjectAddress::new(0x6077, 0)) as i16
    }

    fn counts(&self) -> i64 {
        self.drive().position_counts(self.now_ns())
    }
}

#[test]
fn a_wheel_stays_at_its_stop_and_pushes_up_to_the_largest_current() {
    let mut rig = rig(ZlacMechanics {
        stops_turns: Some((-0.25, 0.5)),
        ..ZlacMechanics::FREE
    });
    rig.tell(&[POSITION_MODE]);
    rig.tell(&ENABLE);
    rig.go_to(-1_124);
    rig.pass(3_000);
    // 100 counts behind the stop at -1024: 8.8 degrees of 0.6 A each, in 0.1 A.
    assert_eq!((rig.counts(), rig.torque()), (-1_024, -53));
    // 2 A at most.
    rig.tell(&[write_u16(0x2015, 20)]);
    rig.go_to(-4_000);
    rig.pass(3_000);
    assert_eq!((rig.counts(), rig.torque()), (-1_024, -20));
    rig.go_to(-1_000);
    rig.pass(3_000);
    assert_eq!((rig.counts(), rig.torque()), (-1_000, 0));
}

#[test]
fn a_speed_loop_that_is_held_pushes_more_and_more() {
    let mut rig = rig(ZlacMechanics {
        stops_turns: Some((-0.25, 0.5)),
        ..ZlacMechanics::FREE
    });
    rig.tell(&[VELOCITY_MODE]);
    rig.tell(&ENABLE);
    rig.tell(&[write_u32(0x60FF, 60)]);
    rig.pass(4_000);
    assert_eq!((rig.counts(), rig.torque()), (2_048, 300));
    rig.tell(&[write_u32(0x60FF, 0)]);
    rig.pass(10);
    assert_eq!(rig.torque(), 0);
}

#[test]
fn the_switch_is_operated_from_its_place_on() {
    let mut rig = rig(ZlacMechanics {
        switch_turns: Some(-0.1),
        ..ZlacMechanics::FREE
    });
    rig.tell(&[POSITION_MODE]);
    rig.tell(&ENABLE);
    for (counts, is_operated) in [(0, false), (-409, false), (-410, true), (-900, true)] {
        rig.go_to(counts);
        rig.pass(3_000);
        let seen = rig.drive().switch_is_operated(rig.now_ns());
        assert_eq!(seen, is_operated, "{counts}");
    }
}

/// Speeds once a millisecond after a step to 60 r/min, with this 201Eh.
fn step_response(speed_ki: u16) -> Vec<f64> {
    let mut rig = rig(ZlacMechanics {
        control: ZlacLoop::WithGains,
        ..ZlacMechanics::FREE
    });
    rig.tell(&[
        write_u16(0x201E, speed_ki),
        write_u32(0x6083, 0),
        write_u32(0x6084, 0),
        VELOCITY_MODE,
    ]);
    rig.tell(&ENABLE);
    rig.tell(&[write_u32(0x60FF, 60)]);
    (0..1_000)
        .map(|_| {
            rig.pass(1);
            rig.drive().speed_rpm(rig.now_ns())
        })
        .collect()
}

#[test]
fn the_gains_change_the_answer_and_not_its_end() {
    let peak = |speeds: &[f64]| speeds.iter().copied().fold(0.0, f64::max);
    let (factory, stiff) = (step_response(100), step_response(2_000));
    assert!((60.0..66.0).contains(&peak(&factory)), "{}", peak(&factory));
    assert!(peak(&stiff) > 68.0, "{}", peak(&stiff));
    for speeds in [&factory, &stiff] {
        let end = speeds.last().copied().unwrap_or_default();
        assert!((end - 60.0).abs() < 1.0, "{end}");
    }
}

#[test]
fn a_position_loop_with_gains_arrives() {
    let mut rig = rig(ZlacMechanics {
        control: ZlacLoop::WithGains,
        ..ZlacMechanics::FREE
    });
    rig.tell(&[POSITION_MODE]);
    rig.tell(&ENABLE);
    rig.go_to(4_096);
    rig.pass(8_000);
    assert_eq!(rig.counts(), 4_096);
    assert!(rig.drive().speed_rpm(rig.now_ns()) == 0.0);
}
