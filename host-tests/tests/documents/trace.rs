//! The bytes that were on the wire.

use can_motion::family::Family;
use drive_sim::{Device, Outcome};
use host_tests::rig::Rig;

/// A frame that arrived.
#[derive(Debug, Clone)]
pub(crate) struct Wire {
    pub(crate) end_ns: u64,
    pub(crate) from_master: bool,
    pub(crate) id: u16,
    pub(crate) data: Vec<u8>,
}

/// Every frame that arrived so far, in order.
pub(crate) fn wire<D: Device, F: Family>(rig: &Rig<D, F>) -> Vec<Wire> {
    let delivered = rig
        .traffic
        .iter()
        .filter(|record| record.outcome == Outcome::Delivered);
    delivered
        .map(|record| {
            let text = record.frame.to_string();
            let (id, data) = text.split_once('#').expect("a data frame in text");
            Wire {
                end_ns: record.end_ns,
                from_master: record.node == rig.node,
                id: u16::from_str_radix(id, 16).expect("an identifier"),
                data: data
                    .as_bytes()
                    .chunks(2)
                    .map(|digits| {
                        let digits = std::str::from_utf8(digits).expect("digits");
                        u8::from_str_radix(digits, 16).expect("a byte")
                    })
                    .collect(),
            }
        })
        .collect()
}

/// A number, most significant byte first, with its sign.
pub(crate) fn big_endian(data: &[u8]) -> i32 {
    data.iter()
        .fold(if data[0] > 0x7F { -1 } else { 0 }, |number, byte| {
            number << 8 | i32::from(*byte)
        })
}

/// Replies to requests with one data byte, as those of General_Read: the reply is the next frame of the drive on the identifier.
pub(crate) fn replies_to(frames: &[Wire], id: u16, selector: u8) -> Vec<(u64, Vec<u8>)> {
    let mut asked = false;
    let mut replies = Vec::new();
    for frame in frames.iter().filter(|frame| frame.id == id) {
        if frame.from_master {
            asked = frame.data == [selector];
        } else if std::mem::take(&mut asked) {
            replies.push((frame.end_ns, frame.data.clone()));
        }
    }
    replies
}
