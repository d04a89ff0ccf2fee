//! Every byte of a line of DYN drives is in exactly one event, and a packet that is found is a packet.
#![no_main]

use dyn_serial::{Decoder, Dialect, Event, Packet, Reply, Request};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut decoder = Decoder::new();
    let mut found = Vec::new();
    for &byte in bytes {
        found.extend(decoder.push(byte));
    }
    found.extend(decoder.silence());
    for event in &found {
        if let Event::Packet(packet) = event {
            assert_eq!(Packet::parse(packet.as_bytes()).as_ref(), Ok(packet));
            let _ = Reply::decode(packet);
            let _ = Request::decode(packet, &Dialect::MANUAL);
        }
    }
    assert!(decoder.unfinished().is_empty());
});
