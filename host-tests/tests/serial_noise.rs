//! Random bytes against the serial decoder, and broken decoders against the check.
//!
//! The long run is `cargo run --release -p host-tests --bin serial-fuzz`.

use std::cell::RefCell;

use drive_sim::SplitMix64;
use dyn_serial::{Decoder, Event};
use host_tests::serial_noise::{Fault, Tally, check, run, stream};

#[test]
fn every_packet_in_a_million_bytes_of_noise_is_found_and_no_byte_is_lost() {
    let mut total = Tally::default();
    for seed in 0..100 {
        total.add(run(seed, 10_000).unwrap_or_else(|fault| panic!("stream {seed}: {fault}")));
    }
    // The noise must be full of packets, or the test would show nothing.
    assert!(total.bytes >= 1_000_000, "{total:?}");
    assert!(total.planted > 40_000, "{total:?}");
    assert!(total.found > total.planted, "{total:?}");
}

/// The decoder with something around it that spoils it.
fn spoiled(spoil: impl Fn(&mut Decoder, u8) -> Option<Event>) -> Result<Tally, Fault> {
    let (stream, _) = stream(&mut SplitMix64::new(7), 10_000);
    let decoder = RefCell::new(Decoder::new());
    check(
        &stream,
        |byte| spoil(&mut decoder.borrow_mut(), byte),
        || decoder.borrow().unfinished().to_vec(),
    )
}

#[test]
fn the_sound_decoder_passes_in_the_same_harness() {
    assert!(spoiled(Decoder::push).is_ok());
}

#[test]
fn a_decoder_that_swallows_the_start_byte_that_cuts_a_packet_is_caught() {
    let caught = spoiled(|decoder, byte| {
        if byte < 0x80 && !decoder.unfinished().is_empty() {
            decoder.silence()
        } else {
            decoder.push(byte)
        }
    });
    assert!(matches!(caught, Err(Fault::Packets { .. })), "{caught:?}");
}

#[test]
fn a_decoder_that_reports_only_packets_is_caught() {
    let caught = spoiled(|decoder, byte| {
        let event = decoder.push(byte)?;
        matches!(event, Event::Packet(_)).then_some(event)
    });
    assert!(caught.is_err(), "{caught:?}");
}

#[test]
fn a_decoder_that_hides_a_stray_byte_is_caught() {
    let caught = spoiled(|decoder, byte| {
        let event = decoder.push(byte)?;
        (event != Event::Stray(0xFF)).then_some(event)
    });
    assert!(caught.is_err(), "{caught:?}");
}
