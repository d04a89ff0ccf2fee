//! Objects that change what the drive does, and objects that show what it measures.

use super::*;

const MODE_TORQUE: [u8; 8] = [0x2F, 0x60, 0x60, 0, 4, 0, 0, 0];
const NEVER_OFFLINE: [u8; 8] = [0x2B, 0x00, 0x20, 0, 0, 0, 0, 0];
const OFF: [u8; 8] = [0x2B, 0x40, 0x60, 0, 0, 0, 0, 0];

/// A write of two bytes.
fn write(index: u16, sub: u8, value: u16) -> [u8; 8] {
    let ([low, high], [a, b]) = (index.to_le_bytes(), value.to_le_bytes());
    [0x2B, low, high, sub, a, b, 0, 0]
}

impl Rig {
    /// The value of an object, asked on the bus.
    fn value(&mut self, index: u16, sub: u8) -> u32 {
        let [low, high] = index.to_le_bytes();
        let reply = self.ask([0x40, low, high, sub, 0, 0, 0, 0]);
        let data = reply.split_once('#').expect("a frame").1;
        let raw = u32::from_str_radix(&data[8..], 16).expect("hex");
        u32::from_be_bytes(raw.to_le_bytes())
    }

    fn signed(&mut self, index: u16, sub: u8) -> i16 {
        self.value(index, sub) as i16
    }

    fn rpm(&self) -> f64 {
        self.drive().speed_rpm(self.now_ns())
    }

    fn turning_at_100(before: &[[u8; 8]]) -> Self {
        let mut rig = Self::booted();
        rig.tell(&[NEVER_OFFLINE]);
        rig.tell(before);
        rig.tell(&[VELOCITY_MODE]);
        rig.tell(&ENABLE);
        rig.tell(&[SPEED_100]);
        rig.pass(300);
        rig
    }
}

#[test]
fn the_sense_of_rotation_turns_the_shaft_the_other_way_round_and_not_the_counts() {
    let mut rig = Rig::turning_at_100(&[write(0x2001, 0, 1)]);
    assert!((rig.rpm() + 100.0).abs() < 1e-9, "{}", rig.rpm());
    assert_eq!(rig.value(0x606C, 0), 1_000);
    let now_ns = rig.now_ns();
    let (counts, travel) = (
        rig.drive().position_counts(now_ns),
        rig.drive().travel_counts(now_ns),
    );
    assert!(counts > 0 && travel == -counts, "{counts} {travel}");
    // It waits until nothing is energised: the wheel goes on as it turns.
    rig.tell(&[write(0x2001, 0, 0)]);
    rig.pass(10);
    assert!((rig.rpm() + 100.0).abs() < 1e-9, "{}", rig.rpm());
    rig.tell(&[OFF]);
    rig.pass(1);
    assert!(rig.rpm() < -99.0, "it coasts on: {}", rig.rpm());
    assert!(rig.signed(0x606C, 0) < -980, "and is counted anew");
}

#[test]
fn the_current_of_torque_mode_follows_its_slope() {
    let mut rig = Rig::booted();
    // 300 mA a second, as from the factory, to 600 mA.
    rig.tell(&[NEVER_OFFLINE, MODE_TORQUE]);
    rig.tell(&ENABLE);
    rig.tell(&[write(0x6071, 0, 600)]);
    rig.pass(1_000);
    // 6077h counts 0.1 A, 6074h counts mA.
    assert_eq!((rig.signed(0x6077, 0), rig.signed(0x6074, 0)), (3, 600));
    assert_eq!(rig.value(0x6041, 0) & 0x0400, 0, "not reached yet");
    rig.pass(1_100);
    assert_eq!(rig.signed(0x6077, 0), 6);
    assert_eq!(rig.value(0x6041, 0) & 0x0400, 0x0400);
    let by_range = ZlacDriveConfig {
        quirks: ZlacQuirks {
            torque_units_by_range: true,
            ..ZlacQuirks::default()
        },
        ..config()
    };
    let mut rig = Rig::new(by_range);
    rig.pass(101);
    // A slope of 0 is a step.
    rig.tell(&[
        NEVER_OFFLINE,
        MODE_TORQUE,
        [0x23, 0x87, 0x60, 0, 0, 0, 0, 0],
    ]);
    rig.tell(&ENABLE);
    rig.tell(&[write(0x6071, 0, 600)]);
    assert_eq!((rig.signed(0x6077, 0), rig.signed(0x6074, 0)), (600, 6));
}

#[test]
fn a_wheel_that_accelerates_takes_current_and_one_that_stands_takes_none() {
    let mut rig = Rig::booted();
    rig.tell(&[NEVER_OFFLINE, VELOCITY_MODE]);
    rig.tell(&ENABLE);
    assert_eq!(rig.signed(0x6077, 0), 0);
    rig.tell(&[SPEED_100]);
    rig.pass(20);
    // 1000 r/min in 500 ms: 2000 r/min a second, and 200 of friction; 400 of them are 1 A.
    assert_eq!(rig.signed(0x6077, 0), 55);
    rig.pass(300);
    assert_eq!(rig.signed(0x6077, 0), 5);
}

#[test]
fn parking_limits_the_current_in_every_mode() {
    let mut rig = Rig::booted();
    rig.tell(&[
        NEVER_OFFLINE,
        write(0x202F, 4, 1),
        [0x23, 0x87, 0x60, 0, 0, 0, 0, 0],
        MODE_TORQUE,
    ]);
    rig.tell(&ENABLE);
    rig.tell(&[write(0x6071, 0, 10_000)]);
    assert_eq!(rig.signed(0x6077, 0), 30);
    let mut rig = Rig::booted();
    rig.tell(&[NEVER_OFFLINE, write(0x202F, 4, 1), VELOCITY_MODE]);
    rig.tell(&ENABLE);
    rig.tell(&[SPEED_100]);
    rig.pass(20);
    assert_eq!(rig.signed(0x6077, 0), 30);
}

#[test]
fn a_closed_brake_holds_the_wheel_against_the_motor() {
    let mut rig = Rig::turning_at_100(&[]);
    rig.tell(&[write(0x2030, 0x0E, 1)]);
    rig.pass(100);
    assert_eq!(rig.rpm(), 0.0);
    // B0 in bit 2 of the outputs.
    assert_eq!(rig.value(0x2004, 0), 0b100);
    rig.tell(&[write(0x2030, 0x0E, 0)]);
    rig.pass(300);
    assert!((rig.rpm() - 100.0).abs() < 1e-9);
}

#[test]
fn shorted_phases_brake_a_wheel_after_an_alarm() {
    for (is_on, expected_rpm) in [(0, 80.0), (1, 0.0)] {
        let mut rig = Rig::turning_at_100(&[write(0x202F, 1, is_on)]);
        let drive = rig.drive;
        rig.bench.device_mut(drive).faults_mut().trip(0x0004);
        rig.pass(100);
        // 200 r/min a second of friction, or 1000 of the shorted phases.
        assert!((rig.rpm() - expected_rpm).abs() < 0.1, "{}", rig.rpm());
        // Y0 shows alarms.
        assert_eq!(rig.value(0x2004, 0), 1);
    }
}

#[test]
fn an_emergency_input_holds_the_shaft_or_releases_it() {
    for (releases, expected_rpm) in [(0, 0.0), (1, 80.0)] {
        let mut rig = Rig::turning_at_100(&[write(0x202F, 3, releases)]);
        let drive = rig.drive;
        rig.bench
            .device_mut(drive)
            .faults_mut()
            .emergency_input(true);
        rig.pass(100);
        assert!((rig.rpm() - expected_rpm).abs() < 0.1, "{}", rig.rpm());
        // X0 has the function of an emergency stop from the factory on.
        assert_eq!(rig.value(0x2003, 0), 1);
        assert_eq!(rig.value(0x6041, 0) & 0x8000, 0x8000);
    }
}

#[test]
fn node_and_bit_rate_count_from_the_next_start() {
    let mut rig = Rig::new(ZlacDriveConfig {
        bus_bit_rate: Some(BitRate::Kbit500),
        ..config()
    });
    rig.pass(101);
    rig.tell(&[write(0x200D, 0, 9)]);
    assert_eq!(rig.value(0x200D, 0), 9, "it still answers as node 4");
    rig.send(0x000, &[0x81, 4]);
    assert_eq!(rig.pass(150), ["709#00"]);
    rig.send(0x609, &[0x40, 0x0D, 0x20, 0, 0, 0, 0, 0]);
    assert_eq!(rig.pass(1), ["589#4B0D200009000000"]);
    // Factory settings: node 4 and 500 kbit/s at the next start.
    rig.send(0x609, &write(0x2009, 0, 1));
    assert_eq!(rig.pass(1), ["589#6009200000000000"]);
    rig.send(0x000, &[0x81, 9]);
    assert_eq!(rig.pass(150), ["704#00"]);
    // 250 kbit/s: the drive is gone from this bus.
    rig.tell(&[write(0x200E, 0, 2)]);
    rig.send(0x000, &[0x81, 4]);
    assert!(rig.pass(150).is_empty());
    rig.send(0x604, &[0x40, 0x0D, 0x20, 0, 0, 0, 0, 0]);
    assert!(rig.pass(10).is_empty());
}

#[test]
fn a_dip_switch_is_stronger_than_200dh() {
    let mut rig = Rig::new(ZlacDriveConfig::new(NodeId::new(3).unwrap()));
    assert_eq!(rig.pass(101), ["703#00"]);
    rig.send(0x603, &write(0x200D, 0, 9));
    rig.pass(1);
    rig.send(0x000, &[0x81, 0]);
    assert_eq!(rig.pass(150), ["703#00"]);
}

#[test]
fn temperatures_and_voltage_are_measured_and_heat_trips() {
    let mut rig = Rig::booted();
    assert_eq!(
        (
            rig.value(0x2026, 1),
            rig.value(0x2026, 2),
            rig.value(0x2029, 0)
        ),
        (250, 300, 4_800)
    );
    let surroundings = |motor_decidegrees| ZlacSurroundings {
        motor_decidegrees,
        bus_centivolts: 3_605,
        ..ZlacSurroundings::DEFAULT
    };
    let drive = rig.drive;
    let change = |rig: &mut Rig, degrees| {
        let faults = rig.bench.device_mut(drive).faults_mut();
        faults.surroundings(surroundings(degrees));
        rig.pass(1);
    };
    // Below zero it takes the signed reading (Z7).
    change(&mut rig, -125);
    assert_eq!((rig.signed(0x2026, 1), rig.value(0x2029, 0)), (-125, 3_605));
    change(&mut rig, 799);
    assert_eq!(rig.value(0x603F, 0), 0);
    change(&mut rig, 800);
    assert_eq!(rig.value(0x603F, 0), 0x0400);
    rig.tell(&[write(0x6040, 0, 0x80), OFF]);
    assert_eq!(rig.value(0x603F, 0), 0x0400, "still hot");
    change(&mut rig, 700);
    rig.send(0x604, &write(0x6040, 0, 0x80));
    rig.pass(1);
    assert_eq!(rig.value(0x603F, 0), 0);
}

#[test]
fn hall_sensors_step_through_six_sectors_and_their_fault_shows() {
    let mut rig = Rig::turning_at_100(&[]);
    let mut seen = std::collections::BTreeSet::new();
    for _ in 0..60 {
        seen.insert(rig.value(0x2028, 0));
        rig.pass(3);
    }
    assert!(seen.iter().eq([1, 2, 3, 4, 5, 6].iter()), "{seen:?}");
    let drive = rig.drive;
    rig.bench.device_mut(drive).faults_mut().trip(0x0200);
    rig.pass(1);
    assert_eq!(rig.value(0x2028, 0), 7);
}

#[test]
fn the_largest_speed_of_the_motor_limits_targets() {
    // The ramps lead to it in their time.
    let mut rig = Rig::turning_at_100(&[write(0x200A, 0, 60)]);
    rig.pass(300);
    assert!((rig.rpm() - 60.0).abs() < 1e-9, "{}", rig.rpm());
}

#[test]
fn a_move_begins_with_the_start_speed_and_still_ends_where_it_says() {
    let mut rig = Rig::booted();
    let start_30 = [0x23, 0x82, 0x60, 0, 30, 0, 0, 0];
    rig.tell(&[NEVER_OFFLINE, POSITION_MODE, start_30]);
    rig.tell(&ENABLE);
    rig.tell(&[
        [0x23, 0x7A, 0x60, 0, 0, 0x10, 0, 0],
        write(0x6040, 0, 0x4F),
        write(0x6040, 0, 0x5F),
    ]);
    rig.pass(1);
    assert!(rig.rpm() >= 30.0, "{}", rig.rpm());
    rig.pass(3_000);
    let now_ns = rig.now_ns();
    assert_eq!(rig.drive().position_counts(now_ns), 4_096);
    assert_eq!(rig.rpm(), 0.0);
}

#[test]
fn a_drive_can_be_told_to_fall_silent_after_some_writes() {
    let mut rig = Rig::booted();
    let drive = rig.drive;
    rig.bench
        .device_mut(drive)
        .faults_mut()
        .fall_silent_after_writes(1);
    rig.tell(&[write(0x2018, 0, 5)]);
    rig.send(0x604, &write(0x2018, 0, 6));
    assert!(rig.pass(5).is_empty());
    let smoothing = ObjectAddress::new(0x2018, 0);
    let now_ns = rig.now_ns();
    assert_eq!(rig.drive().object(now_ns, smoothing), 5);
}
