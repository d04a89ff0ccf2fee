//! Any conversation has words.
#![no_main]

use can_decode::{Decoder, Frame};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|heard: Vec<(u32, u32, [u8; 8], u8)>| {
    let mut decoders = [Decoder::default(), Decoder::canopen()];
    let mut at_ns = 0;
    for (pause_ns, id, data, length) in heard {
        at_ns += u64::from(pause_ns);
        let data = &data[..usize::from(length % 9)];
        let Some(frame) = Frame::new(id & 0x7FF, false, data) else {
            continue;
        };
        for decoder in &mut decoders {
            let _ = decoder.hear(Some(at_ns), &frame).to_string();
        }
    }
});
