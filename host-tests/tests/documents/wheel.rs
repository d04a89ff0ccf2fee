//! CANopen of the hub motor: CiA 301, guide sections 3 and 9.

use can_motion::wheel::WheelMasterConfig;
use drive_sim::{BitRate, ZlacDriveConfig, ZlacQuirks};
use host_tests::rig::{WheelRig, wheel_config};
use zlac8030l::{NodeId, ObjectAddress, WriteError, dictionary};

use crate::trace::wire;

#[test]
fn a_drive_that_leaves_the_size_of_its_replies_open_is_set_up_and_driven() {
    let drive = ZlacDriveConfig {
        quirks: ZlacQuirks {
            replies_without_size: true,
            ..ZlacQuirks::default()
        },
        ..ZlacDriveConfig::new(NodeId::MIN)
    };
    let wheel = wheel_config(NodeId::MIN);
    let mut rig = WheelRig::wheels(WheelMasterConfig::DEFAULT, &[wheel], vec![drive]);
    rig.stream();
    rig.master.set_target(0, 100).expect("a streaming wheel");
    rig.cycles(100);
    let frames = wire(&rig);
    // Every value that was read came with 42h, and nothing was given up.
    let replies = |specifier: u8| {
        frames
            .iter()
            .filter(move |frame| frame.id == 0x581 && frame.data[0] == specifier)
            .count()
    };
    assert!(replies(0x42) > 10);
    for sized in [0x43, 0x47, 0x4B, 0x4F, 0x80] {
        assert_eq!(replies(sized), 0, "{sized:02X}");
    }
    let aborts = frames
        .iter()
        .filter(|frame| frame.id == 0x601 && frame.data[0] == 0x80);
    assert_eq!(aborts.count(), 0);
    // TPDO0 ends with 1000, in 0.1 r/min.
    let speed = frames.iter().rfind(|frame| frame.id == 0x181);
    assert_eq!(speed.expect("feedback").data[4..], [0xE8, 0x03, 0, 0]);
}

#[test]
fn a_mapping_has_at_most_four_entries() {
    for index in [
        0x1600, 0x1601, 0x1602, 0x1603, 0x1A00, 0x1A01, 0x1A02, 0x1A03,
    ] {
        let count = ObjectAddress::new(index, 0);
        for entries in 0..=4 {
            assert!(dictionary::write(count, entries).is_ok(), "{count}");
        }
        for entries in [5, 8, 64, 255] {
            assert!(
                matches!(
                    dictionary::write(count, entries),
                    Err(WriteError::Range { max: 4, .. })
                ),
                "{count} = {entries}"
            );
        }
        // There is no fifth entry.
        let fifth = ObjectAddress::new(index, 5);
        assert!(matches!(
            dictionary::write(fifth, 0),
            Err(WriteError::NoSuchObject { .. })
        ));
    }
}

#[test]
fn what_the_master_maps_has_at_most_four_entries_and_eight_bytes() {
    let wheel = wheel_config(NodeId::MIN);
    let drive = ZlacDriveConfig::new(NodeId::MIN);
    let mut rig = WheelRig::wheels(WheelMasterConfig::DEFAULT, &[wheel], vec![drive]);
    rig.ready();
    let mut counts = 0;
    for frame in wire(&rig).iter().filter(|frame| frame.id == 0x601) {
        let index = u16::from_le_bytes([frame.data[1], frame.data[2]]);
        let is_mapping = matches!(index, 0x1600..=0x1603 | 0x1A00..=0x1A03);
        if frame.data[0] == 0x2F && is_mapping && frame.data[3] == 0 {
            counts += 1;
            assert!(frame.data[4] <= 4, "{:02X?}", frame.data);
        }
    }
    assert!(counts > 0);
}

#[test]
fn a_wheel_runs_at_every_bit_rate_of_its_drive_and_at_no_other() {
    use can_motion::Master;
    use can_motion::wheel::{WheelConfigError, Zlac};

    // 200Eh: 0 is 1000 kbit/s, 1 500, 2 250, 3 125, 4 100.
    for bit_rate in [
        BitRate::Kbit1000,
        BitRate::Kbit500,
        BitRate::Kbit250,
        BitRate::Kbit125,
        BitRate::Kbit100,
    ] {
        let config = WheelMasterConfig {
            bit_rate,
            cycle_us: 20_000,
            ..WheelMasterConfig::DEFAULT
        };
        let wheel = wheel_config(NodeId::MIN);
        let drive = ZlacDriveConfig::new(NodeId::MIN);
        let mut rig = WheelRig::wheels(config, &[wheel], vec![drive]);
        rig.stream();
        rig.master.set_target(0, 50).expect("a streaming wheel");
        rig.cycles(60);
        assert_eq!(rig.axis(0).fault, None, "{} kbit/s", bit_rate.kbit_per_s());
        // A frame of RPDO1, 6 bytes: at least 95 bits on the wire.
        let record = rig
            .traffic
            .iter()
            .rfind(|record| record.frame.to_string().starts_with("301#"))
            .expect("a command");
        let bits_us =
            (record.end_ns - record.start_ns) * u64::from(bit_rate.kbit_per_s()) / 1_000_000;
        assert!((90..=120).contains(&bits_us), "{bits_us} bits");
    }
    for bit_rate in [BitRate::Kbit10, BitRate::Kbit50, BitRate::Kbit800] {
        let config = WheelMasterConfig {
            bit_rate,
            ..WheelMasterConfig::DEFAULT
        };
        let refused = Master::<4, Zlac>::new(config, &[wheel_config(NodeId::MIN)]);
        assert!(matches!(
            refused.err(),
            Some(WheelConfigError::BitRate { actual }) if actual == bit_rate
        ));
    }
}
