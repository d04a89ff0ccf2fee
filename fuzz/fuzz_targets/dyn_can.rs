//! Any frame is a request or a reply of the DYN drives or is refused, and what decodes is encoded to the same bytes again.
#![no_main]

use arbitrary::Arbitrary;
use can_frame::DataFrame;
use dyn_can::{Dialect, Reply, Request, Revision};
use libfuzzer_sys::fuzz_target;

#[derive(Debug, Arbitrary)]
struct Heard {
    id: u16,
    data: [u8; 8],
    length: u8,
    is_newer: bool,
    is_strict: bool,
    asked: Option<Asked>,
}

#[derive(Debug, Arbitrary)]
struct Asked {
    id: u16,
    data: [u8; 8],
    length: u8,
}

fn frame(id: u16, data: &[u8; 8], length: u8) -> Option<DataFrame> {
    DataFrame::new(id & 0x7FF, &data[..usize::from(length % 9)]).ok()
}

fuzz_target!(|heard: Heard| {
    let revision = if heard.is_newer {
        Revision::V1_6A
    } else {
        Revision::V1_2A
    };
    let dialect = Dialect {
        strict_minimal: heard.is_strict,
        ..Dialect::of(revision)
    };
    let Some(frame) = frame(heard.id, &heard.data, heard.length) else {
        return;
    };
    if let Ok((to, request)) = Request::decode(&frame, &dialect)
        && let Ok(again) = request.encode(to, &dialect)
    {
        assert_eq!(Request::decode(&again, &dialect), Ok((to, request)));
    }
    let outstanding = heard
        .asked
        .and_then(|asked| self::frame(asked.id, &asked.data, asked.length))
        .and_then(|frame| Request::decode(&frame, &dialect).ok())
        .and_then(|(_, request)| request.reply_kind());
    if let Ok((from, reply)) = Reply::decode(&frame, outstanding, &dialect) {
        let again = reply.encode(from, &dialect);
        assert_eq!(
            Reply::decode(&again, outstanding, &dialect),
            Ok((from, reply))
        );
    }
});
