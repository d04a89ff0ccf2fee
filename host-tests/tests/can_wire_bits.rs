//! Golden vectors of `can_wire_bits.json`.

use can_motion::plan::wire as plan;
use drive_sim::wire;
use drive_sim::{Frame, WireLength};
use embedded_can::{Frame as _, StandardId};
use host_tests::vectors_dir;
use host_tests::wire_bits::{self, WireBits};

fn simulated_bus(can_id: u16, data: &[u8]) -> WireBits {
    let id = StandardId::new(can_id).expect("the vectors have 11-bit identifiers");
    let frame = Frame::new(id, data).expect("the vectors have at most 8 bytes");
    let length = WireLength::of(&frame);
    WireBits {
        crc15: Some(length.crc15),
        stuff_bits: Some(length.stuff_bits),
        bits_exact_with_ifs: Some(length.bits_with_ifs),
        bits_exact_without_ifs: Some(length.bits_without_ifs),
        bits_unstuffed_with_ifs: Some(wire::unstuffed_bits_with_ifs(&frame)),
        bits_worst_with_ifs: Some(wire::worst_bits_with_ifs(&frame)),
        sof_to_crc_stuffed: Some(wire::sof_to_crc_stuffed(&frame).to_string()),
    }
}

fn bus_plan(can_id: u16, data: &[u8]) -> WireBits {
    WireBits {
        bits_exact_with_ifs: Some(u32::from(plan::exact_bits(can_id, data))),
        bits_worst_with_ifs: Some(u32::from(plan::bound_bits(data.len() as u8))),
        ..WireBits::default()
    }
}

#[test]
fn the_bus_plan_counts_the_same_bits() {
    wire_bits::check(&vectors_dir(), bus_plan).assert_passed();
}

#[test]
fn the_simulated_bus_counts_every_bit() {
    wire_bits::check(&vectors_dir(), simulated_bus).assert_passed();
}
