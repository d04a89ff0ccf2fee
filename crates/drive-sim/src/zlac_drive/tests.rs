mod mechanics;
mod settings;

use super::*;
use crate::node::NodeId as BusNode;
use embedded_can::{StandardId, nb::Can};
use zlac8030l::{NodeId, ObjectAddress};

/// One drive, node 4, and a master that is driven by hand.
struct Rig {
    bench: Bench<ZlacDrive>,
    master: BusNode,
    drive: DeviceId,
}

impl Rig {
    fn new(config: ZlacDriveConfig) -> Self {
        let (mut bench, drives) = Bench::with_zlac_drives(BitRate::Kbit500, [config]);
        let master = bench.add_master(ControllerConfig::device());
        Self {
            bench,
            master,
            drive: drives[0],
        }
    }

    /// A factory drive that has booted.
    fn booted() -> Self {
        let mut rig = Self::new(config());
        assert_eq!(rig.pass(101), ["704#00"]);
        rig
    }

    fn now_ns(&self) -> u64 {
        self.bench.now_ns()
    }

    /// Lets milliseconds pass; what the drive sent.
    fn pass(&mut self, ms: u64) -> Vec<String> {
        let until_ns = self.now_ns() + ms * MS;
        let mut heard = Vec::new();
        loop {
            let more = self.bench.advance_until_received(self.master, until_ns);
            while let Ok(frame) = self.bench.port(self.master).receive() {
                heard.push(frame.to_string());
            }
            if !more {
                return heard;
            }
        }
    }

    fn send(&mut self, id: u16, data: &[u8]) {
        let frame = Frame::new(StandardId::new(id).unwrap(), data).unwrap();
        self.bench.port(self.master).transmit(&frame).unwrap();
    }

    /// An SDO request as printed, with its reply.
    fn ask(&mut self, data: [u8; 8]) -> String {
        self.send(0x604, &data);
        let heard = self.pass(1);
        assert_eq!(heard.len(), 1, "{heard:?}");
        heard[0].clone()
    }

    /// Requests of which each is confirmed.
    fn tell(&mut self, requests: &[[u8; 8]]) {
        for request in requests {
            let [_, low, high, sub, ..] = request;
            let confirmation = format!("584#60{low:02X}{high:02X}{sub:02X}00000000");
            assert_eq!(self.ask(*request), confirmation);
        }
    }

    fn drive(&self) -> &ZlacDrive {
        self.bench.device(self.drive)
    }
}

fn config() -> ZlacDriveConfig {
    ZlacDriveConfig::new(NodeId::FACTORY)
}

const ENABLE: [[u8; 8]; 3] = [
    [0x2B, 0x40, 0x60, 0, 0x06, 0, 0, 0],
    [0x2B, 0x40, 0x60, 0, 0x07, 0, 0, 0],
    [0x2B, 0x40, 0x60, 0, 0x0F, 0, 0, 0],
];
const VELOCITY_MODE: [u8; 8] = [0x2F, 0x60, 0x60, 0, 3, 0, 0, 0];
const POSITION_MODE: [u8; 8] = [0x2F, 0x60, 0x60, 0, 1, 0, 0, 0];
const SPEED_100: [u8; 8] = [0x23, 0xFF, 0x60, 0, 0x64, 0, 0, 0];

#[test]
fn the_printed_velocity_example_turns_the_wheel() {
    let mut rig = Rig::booted();
    rig.tell(&[VELOCITY_MODE]);
    rig.tell(&ENABLE);
    rig.tell(&[SPEED_100]);
    rig.pass(300);
    let now_ns = rig.now_ns();
    assert!((rig.drive().speed_rpm(now_ns) - 100.0).abs() < 1e-9);
    // 606Ch counts 0.1 r/min.
    assert_eq!(
        rig.ask([0x40, 0x6C, 0x60, 0, 0, 0, 0, 0]),
        "584#436C6000E8030000"
    );
    // Enabled, not stopped, speed reached, running.
    assert_eq!(
        rig.ask([0x40, 0x41, 0x60, 0, 0, 0, 0, 0]),
        "584#4B41600027440000"
    );
}

#[test]
fn the_printed_position_examples_end_where_they_say() {
    let mut rig = Rig::booted();
    let max_speed = [0x23, 0x81, 0x60, 0, 0x3C, 0, 0, 0];
    // The moves take longer than the offline time.
    let never_offline = [0x2B, 0x00, 0x20, 0, 0, 0, 0, 0];
    rig.tell(&[never_offline, POSITION_MODE, max_speed]);
    rig.tell(&ENABLE);
    let start = |first: u8, second: u8| {
        [
            [0x2B, 0x40, 0x60, 0, first, 0, 0, 0],
            [0x2B, 0x40, 0x60, 0, second, 0, 0, 0],
        ]
    };
    let (there, back) = (
        [0x23, 0x7A, 0x60, 0, 0, 0x7D, 0, 0],
        [0x23, 0x7A, 0x60, 0, 0, 0x83, 0xFF, 0xFF],
    );
    rig.tell(&[there]);
    rig.tell(&start(0x4F, 0x5F));
    rig.pass(10_000);
    assert_eq!(rig.drive().position_counts(rig.now_ns()), 32_000);
    rig.tell(&[back]);
    rig.tell(&start(0x4F, 0x5F));
    rig.pass(10_000);
    assert_eq!(rig.drive().position_counts(rig.now_ns()), 0);
    rig.tell(&[back]);
    rig.tell(&start(0x0F, 0x1F));
    rig.pass(10_000);
    assert_eq!(rig.drive().position_counts(rig.now_ns()), -32_000);
    // Target reached and acknowledged, standing.
    assert_eq!(rig.drive().status_word(rig.now_ns()), 0x1427);
}

#[test]
fn the_printed_mappings_move_process_data() {
    let mut rig = Rig::booted();
    // Speed of the wheel by timer, 1000 units of 0.5 ms; target speed by RPDO 1.
    rig.tell(&[
        [0x2F, 0x00, 0x1A, 0, 0, 0, 0, 0],
        [0x23, 0x00, 0x1A, 1, 0x20, 0, 0x6C, 0x60],
        [0x2F, 0x00, 0x18, 2, 0xFF, 0, 0, 0],
        [0x2B, 0x00, 0x18, 5, 0xE8, 3, 0, 0],
        [0x2F, 0x00, 0x1A, 0, 1, 0, 0, 0],
        [0x2F, 0x01, 0x16, 0, 0, 0, 0, 0],
        [0x23, 0x01, 0x16, 1, 0x20, 0, 0xFF, 0x60],
        [0x2F, 0x01, 0x16, 0, 1, 0, 0, 0],
        VELOCITY_MODE,
    ]);
    rig.tell(&ENABLE);
    rig.send(0x304, &[0x64, 0, 0, 0]);
    assert_eq!(rig.pass(600), Vec::<String>::new(), "not operational");
    assert_eq!(rig.drive().speed_rpm(rig.now_ns()), 0.0);
    rig.send(0x000, &[0x01, 0x04]);
    rig.send(0x304, &[0x64, 0, 0, 0]);
    let heard = rig.pass(1_100);
    assert_eq!(heard, ["184#E8030000", "184#E8030000"]);
    rig.send(0x000, &[0x80, 0x00]);
    assert_eq!(rig.pass(1_100), Vec::<String>::new());
}

#[test]
fn a_mapping_cannot_change_while_it_is_in_force() {
    let mut rig = Rig::booted();
    // RPDO 0 holds the control word from the start.
    let entry = [0x23, 0x00, 0x16, 1, 0x20, 0, 0xFF, 0x60];
    assert_eq!(rig.ask(entry), "584#8000160100000106");
    // The state of the node comes before that.
    rig.send(0x000, &[0x01, 0x00]);
    let count = [0x2F, 0x00, 0x16, 0, 0, 0, 0, 0];
    assert_eq!(rig.ask(count), "584#8000160022000008");
}

#[test]
fn sync_and_change_send_process_data_too() {
    let mut rig = Rig::booted();
    rig.tell(&[
        [0x23, 0x00, 0x1A, 1, 0x10, 0, 0x41, 0x60],
        [0x2F, 0x00, 0x18, 2, 2, 0, 0, 0],
        [0x2F, 0x00, 0x1A, 0, 1, 0, 0, 0],
        [0x23, 0x01, 0x1A, 1, 0x10, 0, 0x41, 0x60],
        [0x2F, 0x01, 0x18, 2, 0xFE, 0, 0, 0],
        [0x2F, 0x01, 0x1A, 0, 1, 0, 0, 0],
    ]);
    rig.send(0x000, &[0x01, 0x04]);
    assert_eq!(rig.pass(20), ["284#6000"]);
    for expected in [vec![], vec!["184#6000"], vec![], vec!["184#6000"]] {
        rig.send(0x080, &[]);
        assert_eq!(rig.pass(5), expected);
    }
    rig.send(0x204, &[0x06, 0x00]);
    assert_eq!(rig.pass(20), ["284#2100"]);
}

#[test]
fn what_a_master_may_not_do_is_refused_with_its_reason() {
    let mut rig = Rig::booted();
    let refusals = [
        ([0x2B, 0x41, 0x60, 0, 0, 0, 0, 0], "584#8041600002000106"),
        ([0x23, 0xFF, 0x60, 0, 0xE9, 3, 0, 0], "584#80FF600030000906"),
        ([0x2B, 0xFF, 0x60, 0, 1, 0, 0, 0], "584#80FF600010000706"),
        ([0x40, 0xFF, 0x60, 1, 0, 0, 0, 0], "584#80FF600111000906"),
        ([0x40, 0x00, 0x70, 0, 0, 0, 0, 0], "584#8000700000000206"),
        ([0x21, 0xFF, 0x60, 0, 9, 0, 0, 0], "584#80FF600001000405"),
    ];
    for (request, expected) in refusals {
        assert_eq!(rig.ask(request), expected);
    }
    rig.send(0x604, &[0x40, 0x41, 0x60]);
    assert_eq!(rig.pass(5), Vec::<String>::new(), "a short request");
    assert_eq!(rig.drive().books().sdo_aborted, 6);
}

#[test]
fn stored_objects_wear_the_eeprom_unless_2010h_is_1() {
    let mut rig = Rig::booted();
    let heartbeat = |ms: u8| [0x2B, 0x17, 0x10, 0, ms, 0, 0, 0];
    let wear = |rig: &Rig| {
        (
            rig.drive().eeprom_wear().single_writes,
            rig.drive().eeprom_wear().saves,
        )
    };
    rig.tell(&[heartbeat(0)]);
    assert_eq!(wear(&rig), (1, 0));
    rig.tell(&[
        [0x2B, 0x10, 0x20, 0, 1, 0, 0, 0],
        [0x2B, 0x14, 0x20, 0, 100, 0, 0, 0],
    ]);
    assert_eq!(wear(&rig), (1, 0));
    rig.bench.device_mut(rig.drive).faults_mut().power_cycle(0);
    assert_eq!(rig.pass(101), ["704#00"]);
    let rated_current = ObjectAddress::new(0x2014, 0);
    assert_eq!(
        rig.drive().object(rig.now_ns(), rated_current),
        150,
        "not saved"
    );
    rig.tell(&[
        [0x2B, 0x10, 0x20, 0, 1, 0, 0, 0],
        [0x2B, 0x14, 0x20, 0, 100, 0, 0, 0],
        [0x2B, 0x09, 0x20, 0, 2, 0, 0, 0],
    ]);
    rig.bench.device_mut(rig.drive).faults_mut().power_cycle(0);
    rig.pass(101);
    assert_eq!(rig.drive().object(rig.now_ns(), rated_current), 100);
    assert_eq!(wear(&rig), (1, 1));
}

#[test]
fn a_fault_is_told_and_waits_for_its_reset() {
    let mut rig = Rig::booted();
    rig.tell(&[VELOCITY_MODE]);
    rig.tell(&ENABLE);
    rig.bench.device_mut(rig.drive).faults_mut().trip(0x0204);
    assert_eq!(rig.pass(1), ["084#0010010402000000"]);
    assert!(!rig.drive().is_enabled());
    assert_eq!(rig.drive().status_word(rig.now_ns()) & 0x4F, 0x08);
    let fault = rig.ask([0x40, 0x3F, 0x60, 0, 0, 0, 0, 0]);
    assert_eq!(fault, "584#4B3F600004020000");
    rig.bench.device_mut(rig.drive).faults_mut().remove_cause();
    rig.send(0x604, &[0x2B, 0x40, 0x60, 0, 0x80, 0, 0, 0]);
    assert_eq!(
        rig.pass(1),
        ["084#0000000000000000", "584#6040600000000000"]
    );
    assert_eq!(rig.drive().status_word(rig.now_ns()) & 0x4F, 0x40);
}

#[test]
fn the_heartbeat_comes_with_its_period_and_tells_the_state() {
    let mut rig = Rig::booted();
    rig.tell(&[[0x2B, 0x17, 0x10, 0, 100, 0, 0, 0]]);
    assert_eq!(rig.pass(210), ["704#7F", "704#7F"]);
    rig.send(0x000, &[0x01, 0x00]);
    assert_eq!(rig.pass(100), ["704#05"]);
}

#[test]
fn a_master_that_falls_silent_stops_the_wheel() {
    let mut rig = Rig::booted();
    rig.tell(&[VELOCITY_MODE]);
    rig.tell(&ENABLE);
    rig.tell(&[SPEED_100]);
    rig.pass(900);
    assert!(rig.drive().speed_rpm(rig.now_ns()) > 99.0);
    rig.pass(200);
    assert_eq!(rig.drive().speed_rpm(rig.now_ns()), 0.0);
    // Quick stop: energised, bit 5 is 0.
    assert_eq!(rig.drive().status_word(rig.now_ns()) & 0x2F, 0x07);
}

#[test]
fn an_emergency_input_stops_and_shows() {
    let mut rig = Rig::booted();
    rig.tell(&[VELOCITY_MODE]);
    rig.tell(&ENABLE);
    rig.tell(&[SPEED_100]);
    rig.pass(300);
    rig.bench
        .device_mut(rig.drive)
        .faults_mut()
        .emergency_input(true);
    rig.pass(300);
    assert_eq!(rig.drive().speed_rpm(rig.now_ns()), 0.0);
    assert_eq!(rig.drive().status_word(rig.now_ns()) & 0x8007, 0x8007);
}

#[test]
fn quirks_of_the_guide_can_be_switched_on() {
    let mut config = config();
    config.quirks.profile_speed_confirmed_as_sub_1 = true;
    config.quirks.status_word_without_cia402_bits = true;
    config.quirks.torque_mode_is_6 = true;
    let mut rig = Rig::new(config);
    rig.pass(101);
    let max_speed = [0x23, 0x81, 0x60, 0, 0x3C, 0, 0, 0];
    assert_eq!(rig.ask(max_speed), "584#6081600100000000");
    assert_eq!(rig.drive().status_word(rig.now_ns()), 0x0020);
    rig.tell(&[[0x2F, 0x60, 0x60, 0, 4, 0, 0, 0]]);
    let mode = [0x40, 0x61, 0x60, 0, 0, 0, 0, 0];
    assert_eq!(rig.ask(mode), "584#4F61600000000000");
    rig.tell(&[[0x2F, 0x60, 0x60, 0, 6, 0, 0, 0]]);
    assert_eq!(rig.ask(mode), "584#4F61600006000000");
}

/// Milliseconds from a control word to standstill, from 100 r/min, and the lower bits of the status word before and after.
///
/// 6084h makes it 100 ms, 6085h 20 ms, the motor 5 ms, friction 500 ms.
fn stop(config: ZlacDriveConfig, option: (u16, i16), control_word: u16) -> (u64, u16, u16) {
    let mut rig = Rig::new(ZlacDriveConfig {
        motor_acceleration_rpm_s: 20_000.0,
        coast_deceleration_rpm_s: 200.0,
        ..config
    });
    rig.pass(101);
    let (index, value) = option;
    let [low, high] = index.to_le_bytes();
    let [a, b] = value.to_le_bytes();
    rig.tell(&[
        [0x2B, 0x00, 0x20, 0, 0, 0, 0, 0],
        [0x23, 0x84, 0x60, 0, 0xE8, 0x03, 0, 0],
        [0x23, 0x85, 0x60, 0, 0xC8, 0x00, 0, 0],
        [0x2B, low, high, 0, a, b, 0, 0],
        VELOCITY_MODE,
    ]);
    rig.tell(&ENABLE);
    rig.tell(&[SPEED_100]);
    rig.pass(200);
    let [low, high] = control_word.to_le_bytes();
    let start_ns = rig.now_ns();
    rig.tell(&[[0x2B, 0x40, 0x60, 0, low, high, 0, 0]]);
    let state = |rig: &mut Rig| {
        let reply = rig.ask([0x40, 0x41, 0x60, 0, 0, 0, 0, 0]);
        u16::from_str_radix(&reply[12..14], 16).unwrap() & 0x27
    };
    let while_braking = state(&mut rig);
    let mut ms = 0;
    while rig.drive().speed_rpm(start_ns + ms * MS) > 0.0 {
        ms += 1;
        assert!(ms < 1_000, "it never stands");
    }
    rig.pass(600);
    (ms, while_braking, state(&mut rig))
}

#[test]
fn each_stop_brakes_as_its_option_says() {
    // On, stopped by quick stop, ready, switched on, off; bit 5 is 1 unless quick stop is in force.
    const ON: u16 = 0x27;
    const QUICK: u16 = 0x07;
    let near = |expected: u64, actual: u64| actual.abs_diff(expected) <= 2;
    let cases = [
        ((0x605A, 5), 0x0002, 100, QUICK, QUICK),
        ((0x605A, 6), 0x0002, 20, QUICK, QUICK),
        ((0x605A, 7), 0x0002, 5, QUICK, QUICK),
        ((0x605D, 0), 0x010F, 100, ON, ON),
        ((0x605D, 1), 0x010F, 100, ON, ON),
        ((0x605D, 2), 0x010F, 20, ON, ON),
        ((0x605D, 3), 0x010F, 5, ON, ON),
        ((0x605B, 0), 0x0006, 500, 0x21, 0x21),
        ((0x605B, 1), 0x0006, 100, ON, 0x21),
        ((0x605C, 0), 0x0007, 500, 0x23, 0x23),
        ((0x605C, 1), 0x0007, 100, ON, 0x23),
    ];
    for (option, word, expected_ms, braking, end) in cases {
        let (ms, while_braking, after) = stop(config(), option, word);
        assert!(near(expected_ms, ms), "{option:X?}: {ms} ms");
        assert_eq!((while_braking, after), (braking, end), "{option:X?}");
    }
}

#[test]
fn word_0_frees_the_shaft_at_once_or_brakes_first() {
    let near = |expected: u64, actual: u64| actual.abs_diff(expected) <= 2;
    let brakes = ZlacDriveConfig {
        brakes_before_power_off: true,
        ..config()
    };
    let (ms, while_braking, after) = stop(config(), (0x605C, 1), 0x0000);
    assert!(near(500, ms), "{ms} ms");
    assert_eq!((while_braking, after), (0x20, 0x20));
    let (ms, while_braking, after) = stop(brakes.clone(), (0x605C, 1), 0x0000);
    assert!(near(100, ms), "{ms} ms");
    assert_eq!((while_braking, after), (0x27, 0x20));
    assert!(near(500, stop(brakes, (0x605C, 0), 0x0000).0));
}

#[test]
fn replies_may_leave_their_size_open() {
    let mut rig = Rig::new(ZlacDriveConfig {
        quirks: ZlacQuirks {
            replies_without_size: true,
            ..ZlacQuirks::default()
        },
        ..config()
    });
    rig.pass(101);
    // 200Dh is 4, in 16 bits; 1000h is 40192h.
    assert_eq!(
        rig.ask([0x40, 0x0D, 0x20, 0, 0, 0, 0, 0]),
        "584#420D200004000000"
    );
    assert_eq!(
        rig.ask([0x40, 0x00, 0x10, 0, 0, 0, 0, 0]),
        "584#4200100092010400"
    );
}
