//! Any frame is a message of CANopen or is refused.
#![no_main]

use can_frame::DataFrame;
use libfuzzer_sys::fuzz_target;
use zlac8030l::Message;

fuzz_target!(|heard: (u16, [u8; 8], u8)| {
    let (id, data, length) = heard;
    let data = &data[..usize::from(length % 9)];
    if let Ok(frame) = DataFrame::new(id & 0x7FF, data) {
        let _ = Message::decode(&frame);
    }
});
