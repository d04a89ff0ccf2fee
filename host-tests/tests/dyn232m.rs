//! Golden vectors of `dyn232m.json`.

use drive_sim::SplitMix64;
use dyn_serial::{Decoder, Event, Packet};
use host_tests::{dyn_serial as vectors, vectors_dir};

#[test]
fn every_packet_refusal_and_stream_is_as_the_vectors_say() {
    vectors::check(&vectors_dir()).assert_passed();
}

#[test]
fn every_packet_is_found_behind_noise_of_any_kind() {
    let packets = vectors::packets(&vectors_dir()).expect("the vector file is readable");
    assert!(packets.len() > 100, "{} packets", packets.len());
    let mut random = SplitMix64::new(1);
    let mut decoder = Decoder::new();
    let mut found = Vec::new();
    for packet in &packets {
        // Up to 20 bytes, also none: then two packets are glued together.
        let noise = (0..random.up_to(20)).map(|_| random.next_u64() as u8);
        let noise: Vec<u8> = noise.collect();
        for byte in noise.iter().chain(packet) {
            if let Some(Event::Packet(packet)) = decoder.push(*byte) {
                found.push(packet);
            }
        }
        let last = found.last().map(Packet::as_bytes);
        assert_eq!(last, Some(packet.as_slice()), "behind {noise:02X?}");
    }
}
