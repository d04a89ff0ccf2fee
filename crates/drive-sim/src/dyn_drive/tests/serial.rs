//! The serial port: literal packets in, literal packets out, and the same drive behind the other door.

use super::*;
use crate::serial_line::{BYTE_NS, SerialDevice};

impl Probe {
    /// Bytes come in at the present instant.
    fn serial(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.drive.on_serial_byte(self.now_ns, *byte);
        }
    }

    /// What the drive sends over its serial port within 10 ms of some bytes.
    fn serial_ask(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.serial(bytes);
        self.wait(10 * MS);
        let now_ns = self.now_ns;
        std::iter::from_fn(|| self.drive.pop_serial(now_ns))
            .map(|(_, byte)| byte)
            .collect()
    }
}

#[test]
fn parameter_written_over_serial_is_read_back_over_can() {
    let mut probe = Probe::v1_6a();
    // Main gain 100 and integration gain 7 over serial; the other two keep 20 and 127.
    assert_eq!(probe.serial_ask(&[0x01, 0x90, 0xE4, 0xF5]), []);
    assert_eq!(probe.serial_ask(&[0x01, 0x92, 0x87, 0x9A]), []);
    assert_eq!(probe.ask(0x033, &[]), ["033#6414077F"]);
    assert_eq!(probe.drive.eeprom_writes().group1, 2);
}

#[test]
fn parameter_written_over_can_is_read_back_over_serial() {
    let mut probe = Probe::v1_6a();
    probe.hear(0x030, &[0x65, 0x00, 0x00, 0x00]);
    // Read_MainGain: Is_MainGain 101.
    assert_eq!(
        probe.serial_ask(&[0x01, 0x98, 0x80, 0x99]),
        [0x01, 0x90, 0xE5, 0xF6]
    );
}

#[test]
fn move_over_serial_is_seen_over_can() {
    let mut probe = Probe::v1_6a();
    // Relative move by 120 counts.
    probe.serial(&[0x01, 0xA3, 0x80, 0xF8, 0x9C]);
    probe.wait(500 * MS);
    assert_eq!(probe.position(), 120);
    assert_eq!(probe.ask(0x02E, &[0x1B]), ["02E#78"]);
    // And position over serial: Is_AbsPos32 120.
    assert_eq!(
        probe.serial_ask(&[0x01, 0x8E, 0x9B, 0xAA]),
        [0x01, 0xBB, 0x80, 0xF8, 0xB4]
    );
}

#[test]
fn every_read_has_its_reply() {
    let mut probe = Probe::v1_6a();
    let first_data_byte = |probe: &mut Probe, second: u8, data: u8| {
        let sum = 0x80 | (0x01_u8.wrapping_add(second).wrapping_add(data));
        let reply = probe.serial_ask(&[0x01, second, data, sum]);
        assert_eq!(reply[0], 0x01, "{reply:02X?}");
        (reply[1], reply[2])
    };
    for (second, data, reply) in [
        (0x86, 0x80, (0x96, 0x81)), // id 1
        (0x88, 0x80, (0x9A, 0x80)), // configuration 0
        (0x89, 0x80, (0x99, 0x80)), // status 0
        (0x8E, 0x9E, (0x9E, 0x80)), // torque 0
        (0x98, 0x80, (0x90, 0x94)), // main gain 20
        (0x99, 0x80, (0x91, 0x94)), // speed gain 20
        (0x9A, 0x80, (0x92, 0x8A)), // integration gain 10
        (0x9B, 0x80, (0x93, 0xFF)), // torque filter 127
        (0x9C, 0x80, (0x94, 0xBC)), // max speed 60
        (0x9D, 0x80, (0x95, 0xBC)), // max acceleration 60
        (0x9E, 0x80, (0x97, 0x94)), // on-position range 20
        (0x9F, 0x80, (0xB8, 0xA0)), // gear 4096 in two bytes
    ] {
        assert_eq!(first_data_byte(&mut probe, second, data), reply);
    }
    assert_eq!(probe.drive.books().serial_replies, 12);
}

#[test]
fn every_parameter_is_set_alone() {
    let mut probe = Probe::v1_6a();
    let parameters = |probe: &Probe| {
        let (group1, group2, group3) = (
            probe.drive.group1(),
            probe.drive.group2(),
            probe.drive.group3(),
        );
        [
            u16::from(group1.main_gain.get()),
            u16::from(group1.speed_gain.get()),
            u16::from(group1.integration_gain.get()),
            u16::from(group1.torque_filter.get()),
            u16::from(group2.max_speed.get()),
            u16::from(group2.max_acceleration.get()),
            u16::from(group3.on_pos_range.get()),
        ]
    };
    let mut expected = parameters(&probe);
    for (place, second) in (0x90_u8..=0x96).enumerate() {
        let value = 0x81 + place as u8;
        let sum = 0x80 | second.wrapping_add(value).wrapping_add(1);
        probe.serial(&[0x01, second, value, sum]);
        expected[place] = u16::from(value & 0x7F);
        assert_eq!(parameters(&probe), expected);
    }
    // Gear 500.
    probe.serial(&[0x01, 0xB7, 0x83, 0xF4, 0xAF]);
    assert_eq!(probe.drive.group3().gear_number.get(), 500);
    assert_eq!(parameters(&probe), expected);
}

#[test]
fn codes_from_0x10_on_are_not_those_of_can() {
    let mut probe = Probe::v1_6a();
    // On CAN 0x16 loads an absolute move; here it sets the on-position range to 5.
    probe.serial(&[0x01, 0x96, 0x85, 0x9C]);
    probe.wait(100 * MS);
    assert_eq!(probe.drive.group3().on_pos_range.get(), 5);
    assert_eq!(probe.position(), 0);
}

#[test]
fn only_sound_packets_for_this_drive_are_obeyed() {
    let mut probe = Probe::v1_6a();
    // Another drive, a wrong checksum, a reserved id, half a packet.
    probe.serial(&[0x02, 0xA3, 0x80, 0xF8, 0x9D]);
    probe.serial(&[0x01, 0xA3, 0x80, 0xF8, 0x9D]);
    probe.serial(&[0x41, 0xA3, 0x80, 0xF8, 0xDC]);
    probe.serial(&[0x01, 0xA3, 0x80]);
    probe.wait(200 * MS);
    assert_eq!(
        (probe.position(), probe.drive.books().serial_requests),
        (0, 0)
    );
    // The factory's code, and a configuration with the undefined servo mode 3.
    probe.serial(&[0x01, 0x8F, 0x80, 0x90]);
    probe.serial(&[0x01, 0x87, 0x98, 0xA0]);
    assert_eq!(probe.drive.books().undecodable_packets, 2);
    // The general id reaches it.
    probe.serial(&[0x7F, 0xA3, 0x80, 0xF8, 0x9A]);
    probe.wait(500 * MS);
    assert_eq!(probe.position(), 120);
}

#[test]
fn fresh_drive_answers_as_drive_0() {
    let mut probe = Probe::new(DynDriveConfig::fresh());
    assert_eq!(
        probe.serial_ask(&[0x00, 0x86, 0x80, 0x86]),
        [0x00, 0x96, 0x80, 0x96]
    );
}

#[test]
fn reply_takes_its_delay_and_a_byte_time_for_each_byte() {
    let mut probe = Probe::v1_6a();
    probe.serial(&[0x01, 0x89, 0x80, 0x8A]);
    let due: Vec<u64> = std::iter::from_fn(|| probe.drive.pop_serial(u64::MAX))
        .map(|(at_ns, _)| at_ns)
        .collect();
    let expected = [1, 2, 3, 4].map(|byte| DELAY_NS + byte * BYTE_NS);
    assert_eq!(due, expected);
}

#[test]
fn port_is_dead_without_power() {
    let mut probe = Probe::v1_6a();
    probe.serial(&[0x01, 0x89]);
    probe.drive.faults_mut().power_cycle(MS);
    probe.wait(100_000);
    probe.serial(&[0x80, 0x8A]);
    probe.wait(200 * MS);
    assert_eq!(probe.serial_ask(&[0x80, 0x8A]), []);
    assert_eq!(probe.drive.books().serial_requests, 0);
}

#[test]
fn faults_of_replies_reach_this_port() {
    let mut probe = Probe::v1_6a();
    let read_status = [0x01, 0x89, 0x80, 0x8A];
    probe.drive.faults_mut().drop_next_replies(1);
    assert_eq!(probe.serial_ask(&read_status), []);
    probe.drive.faults_mut().truncate_next_reply();
    assert_eq!(probe.serial_ask(&read_status), [0x01, 0x99, 0x80]);
    assert_eq!(probe.serial_ask(&read_status), [0x01, 0x99, 0x80, 0x9A]);
}
