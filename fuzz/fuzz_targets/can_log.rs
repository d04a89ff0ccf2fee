//! Any text is a log of one of the formats, or has a place and a reason; what is read has words.
#![no_main]

use can_decode::Decoder;
use can_decode::log::{Event, LogReader};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let mut reader = LogReader::new();
    let mut decoders = [Decoder::default(), Decoder::canopen()];
    for line in text.lines() {
        let Ok(Some(entry)) = reader.line(line) else {
            continue;
        };
        if let Event::Frame(frame) = entry.event {
            for decoder in &mut decoders {
                let _ = decoder.hear(entry.at_ns, &frame).to_string();
            }
        }
    }
});
