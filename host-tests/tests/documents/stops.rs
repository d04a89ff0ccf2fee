//! Stops of a hub motor (guide section 9, 605Ah to 605Dh; Z43, Z44), judged by the speeds that it tells.

use can_motion::wheel::WheelMasterConfig;
use drive_sim::{Bench, BitRate, ControllerConfig, NodeId, ZlacDrive, ZlacDriveConfig};
use embedded_can::{Frame as _, StandardId, nb::Can};
use host_tests::rig::{GROUP, WheelRig, wheel_config};
use zlac8030l::NodeId as Node;

use crate::trace::wire;

/// A drive whose motor brakes with 20 000 r/min a second and whose friction with 500.
fn drive() -> ZlacDriveConfig {
    ZlacDriveConfig {
        motor_acceleration_rpm_s: 20_000.0,
        coast_deceleration_rpm_s: 500.0,
        ..ZlacDriveConfig::new(Node::MIN)
    }
}

#[test]
fn the_quick_stop_of_the_master_brakes_as_the_option_that_it_wrote() {
    // From 1000 r/min: 6084h makes it 500 ms, 6085h 200 ms, the motor 50 ms.
    for (option, expected_ms) in [(5, 500), (6, 200), (7, 50)] {
        let mut wheel = wheel_config(Node::MIN);
        wheel.ramp_ms = 500;
        wheel.stops.quick_stop = option;
        wheel.stops.emergency_ms = 200;
        let mut rig = WheelRig::wheels(WheelMasterConfig::DEFAULT, &[wheel], vec![drive()]);
        rig.stream();
        rig.master.set_target(0, 1_000).expect("a streaming wheel");
        rig.cycles(250);
        let now = rig.now();
        rig.master.halt(now, GROUP);
        rig.cycles(150);
        let frames = wire(&rig);
        // 605Ah was written, or was there already: 2B 5A 60 00.
        let written = frames
            .iter()
            .filter(|frame| frame.id == 0x601 && frame.data.starts_with(&[0x2B, 0x5A, 0x60, 0]))
            .map(|frame| i16::from(frame.data[4]))
            .next_back();
        assert_eq!(written.unwrap_or(5), option);
        // RPDO1 begins with the control word: bit 1 set and bit 2 clear is quick stop. TPDO0 ends with the speed in 0.1 r/min.
        let stop_ns = frames
            .iter()
            .find(|frame| frame.id == 0x301 && frame.data[0] & 0b0110 == 0b0010)
            .expect("a quick stop")
            .end_ns;
        let stands_ns = frames
            .iter()
            .find(|frame| {
                frame.id == 0x181 && frame.end_ns > stop_ns && frame.data[4..] == [0, 0, 0, 0]
            })
            .expect("it stands")
            .end_ns;
        let ms = (stands_ns - stop_ns) / 1_000_000;
        // Feedback comes every 10 ms.
        assert!(
            (expected_ms..=expected_ms + 12).contains(&ms),
            "605Ah = {option}: {ms} ms for {expected_ms} ms"
        );
    }
}

/// A drive and a controller that is driven by hand.
struct Lone {
    bench: Bench<ZlacDrive>,
    node: NodeId,
}

impl Lone {
    fn new() -> Self {
        let (mut bench, _) = Bench::with_zlac_drives(BitRate::Kbit500, [drive()]);
        let node = bench.add_master(ControllerConfig::device());
        bench.advance_to(150_000_000);
        Self { bench, node }
    }

    /// An SDO request; the bytes of its reply.
    fn ask(&mut self, request: [u8; 8]) -> Vec<u8> {
        let id = StandardId::new(0x601).expect("11 bits");
        let frame = drive_sim::Frame::new(id, &request).expect("8 bytes");
        self.bench
            .port(self.node)
            .transmit(&frame)
            .expect("there is room");
        self.bench.advance_to(self.bench.now_ns() + 1_000_000);
        let replies = std::iter::from_fn(|| self.bench.port(self.node).receive().ok());
        let reply = replies
            .map(|frame| frame.to_string())
            .find(|text| text.starts_with("581#"))
            .expect("a reply");
        reply.as_bytes()[4..]
            .chunks(2)
            .map(|digits| {
                u8::from_str_radix(std::str::from_utf8(digits).expect("digits"), 16)
                    .expect("a byte")
            })
            .collect()
    }

    fn write(&mut self, request: [u8; 8]) {
        assert_eq!(self.ask(request)[0], 0x60, "{request:02X?}");
    }

    /// 606Ch in 0.1 r/min.
    fn speed(&mut self) -> i32 {
        let reply = self.ask([0x40, 0x6C, 0x60, 0, 0, 0, 0, 0]);
        i32::from_le_bytes([reply[4], reply[5], reply[6], reply[7]])
    }

    /// Bits 0 to 3 and 5 of 6041h.
    fn state(&mut self) -> u8 {
        self.ask([0x40, 0x41, 0x60, 0, 0, 0, 0, 0])[4] & 0x2F
    }
}

#[test]
fn shut_down_disable_and_halt_brake_as_their_options_say() {
    // 605Bh and 605Ch: 0 does not brake, so friction does (1000 ms); 1 is the normal stop of 6084h (250 ms) before power goes.
    // 605Dh: 0 and 1 normal, 2 sudden by 6085h (100 ms), 3 emergency, what the motor can (25 ms); energised in all four.
    let cases: [(u16, u8, u16, i64, u8, u8); 8] = [
        (0x605B, 0, 0x0006, 1_000, 0x21, 0x21),
        (0x605B, 1, 0x0006, 250, 0x27, 0x21),
        (0x605C, 0, 0x0007, 1_000, 0x23, 0x23),
        (0x605C, 1, 0x0007, 250, 0x27, 0x23),
        (0x605D, 0, 0x010F, 250, 0x27, 0x27),
        (0x605D, 1, 0x010F, 250, 0x27, 0x27),
        (0x605D, 2, 0x010F, 100, 0x27, 0x27),
        (0x605D, 3, 0x010F, 25, 0x27, 0x27),
    ];
    for (index, option, word, expected_ms, while_braking, after) in cases {
        let named = format!("{index:04X}h = {option}");
        let mut lone = Lone::new();
        let [low, high] = index.to_le_bytes();
        lone.write([0x2B, low, high, 0, option, 0, 0, 0]);
        // 6084h = 500 ms, 6085h = 200 ms, both for 1000 r/min; velocity mode; enable; 500 r/min.
        lone.write([0x23, 0x84, 0x60, 0, 0xF4, 0x01, 0, 0]);
        lone.write([0x23, 0x85, 0x60, 0, 0xC8, 0x00, 0, 0]);
        lone.write([0x2F, 0x60, 0x60, 0, 3, 0, 0, 0]);
        for word in [6, 7, 15] {
            lone.write([0x2B, 0x40, 0x60, 0, word, 0, 0, 0]);
        }
        lone.write([0x23, 0xFF, 0x60, 0, 0xF4, 0x01, 0, 0]);
        for _ in 0..400 {
            lone.speed();
        }
        assert_eq!(lone.speed(), 5_000, "{named}");
        let [low, high] = word.to_le_bytes();
        lone.write([0x2B, 0x40, 0x60, 0, low, high, 0, 0]);
        let start_ns = lone.bench.now_ns();
        assert_eq!(lone.state(), while_braking, "{named}");
        while lone.speed() != 0 {}
        let ms = i64::try_from((lone.bench.now_ns() - start_ns) / 1_000_000).expect("small");
        assert!((ms - expected_ms).abs() <= 4, "{named}: {ms} ms");
        lone.speed();
        assert_eq!(lone.state(), after, "{named}");
    }
}
