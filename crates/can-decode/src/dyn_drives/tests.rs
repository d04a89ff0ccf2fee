//! Bytes are written by hand from the documents.

use super::*;
use crate::decoder::Decoder;

/// Hears frames at times in microseconds and tells their words.
fn words(settings: Settings, frames: &[(u64, u32, &[u8])]) -> Vec<String> {
    let mut decoder = Decoder::new(settings);
    let hear = |&(at_us, id, data): &(u64, u32, &[u8])| {
        let frame = Frame::new(id, false, data).expect("a frame");
        decoder.hear(at_us * 1_000, &frame).to_string()
    };
    frames.iter().map(hear).collect()
}

fn last(frames: &[(u64, u32, &[u8])]) -> String {
    words(Settings::DEFAULT, frames).pop().unwrap_or_default()
}

const POSITION: &[u8] = &[0x1B];
const TORQUE: &[u8] = &[0x1E];

#[test]
fn the_meaning_of_a_reading_comes_from_its_request() {
    // 1.6A section 6, #14: FF63 is -157.
    let reading = |selector| last(&[(0, 0x0AE, selector), (500, 0x0AE, &[0xFF, 0x63])]);
    assert_eq!(
        reading(POSITION),
        "from drive 5  General_Read: position -157 counts (0.500 ms after the request)"
    );
    assert_eq!(
        reading(TORQUE),
        "from drive 5  General_Read: torque -157 of 981, 16.0 % of the peak current counter-clockwise (0.500 ms after the request)"
    );
    assert_eq!(
        last(&[(0, 0x0AE, &[0xFF, 0x63])]),
        "from drive 5  General_Read: position or torque -157, its request was not seen \
         [nobody asked: it came twice, or its request was not seen]"
    );
}

#[test]
fn a_position_that_looks_like_a_request_is_a_position_while_one_is_awaited() {
    let asked: (u64, u32, &[u8]) = (0, 0x02E, POSITION);
    assert!(last(&[asked, (500, 0x02E, TORQUE)]).contains("position 30 counts"));
    // After the window nobody waits any more, so it is a new request.
    assert_eq!(
        last(&[asked, (20_000, 0x02E, TORQUE)]),
        "to drive 1    General_Read: read the torque [asked 20.000 ms before without a reply]"
    );
}

#[test]
fn an_echo_alternates() {
    let bytes: &[u8] = &[1, 2, 3, 0xFE];
    let texts = words(
        Settings::DEFAULT,
        &[
            (0, 0x03E, bytes),
            (700, 0x03E, bytes),
            (5_000, 0x03E, bytes),
        ],
    );
    assert_eq!(
        texts,
        [
            "to drive 1    Echo_Function: send back 01 02 03 FE",
            "from drive 1  Echo_Function: sent back 01 02 03 FE (0.700 ms after the request)",
            "to drive 1    Echo_Function: send back 01 02 03 FE",
        ]
    );
}

#[test]
fn replies_that_are_late_doubled_or_unasked_say_so() {
    let request: (u64, u32, &[u8]) = (0, 0x029, &[]);
    assert_eq!(
        last(&[request, (15_000, 0x029, &[0x0A])]),
        "from drive 1  Read_Drive_Status: on position, disabled, over-current [late: 15.000 ms after the request]"
    );
    assert!(
        last(&[request, (500, 0x029, &[0]), (590, 0x029, &[0])])
            .ends_with("[the same frame as 0.090 ms before: repeated by CAN, or sent twice]")
    );
    assert!(last(&[(0, 0x029, &[0])]).contains("nobody asked"));
    assert!(
        last(&[request, (9_000, 0x029, &[])]).ends_with("[asked 9.000 ms before without a reply]")
    );
}

#[test]
fn a_repeated_set_point_is_named_and_the_next_one_is_not() {
    let step: &[u8] = &[0x88];
    let texts = words(
        Settings::DEFAULT,
        &[(0, 0x03C, step), (93, 0x03C, step), (1_000, 0x03C, step)],
    );
    assert_eq!(
        texts[0],
        "to drive 1    Go_Relative_Pos_PD: step by -120 counts"
    );
    assert_eq!(
        texts[1],
        "to drive 1    Go_Relative_Pos_PD: step by -120 counts \
         [the same frame as 0.093 ms before: repeated by CAN, or sent twice]"
    );
    assert_eq!(texts[2], texts[0]);
}

#[test]
fn the_revision_shows_in_the_length_of_group_3() {
    // 1.2A: 20, 4096, 2500 in five bytes MSB first; 1.6A: in six bytes LSB first (D20).
    let group3 = ": on-position range 20 (0.44 degrees), gear number 4096 (16384 counts a turn), line number 2500";
    let v1_2a: &[u8] = &[0x14, 0x10, 0x00, 0x09, 0xC4];
    let v1_6a: &[u8] = &[0x14, 0x00, 0x00, 0x10, 0xC4, 0x09];
    for reply in [v1_2a, v1_6a] {
        assert!(last(&[(0, 0x035, &[]), (500, 0x035, reply)]).contains(group3));
    }
    let torque = last(&[
        (0, 0x035, &[]),
        (500, 0x035, v1_2a),
        (2_000, 0x02E, TORQUE),
        (2_500, 0x02E, &[70]),
    ]);
    assert!(
        torque.contains("torque 70 of 700, 10.0 % of the peak current counter-clockwise"),
        "{torque}"
    );
}

#[test]
fn drives_speak_unasked_and_all_drives_can_be_addressed() {
    assert_eq!(
        last(&[(0, 0x03D, &[0xEE])]),
        "from drive 1  Drive_Error: ALARM: the drive stopped, read its status"
    );
    assert_eq!(
        last(&[(0, 0x018, &[0xEE])]),
        "to all drives Sync_Trigger: start the loaded relative moves"
    );
}

#[test]
fn what_does_not_decode_says_why() {
    assert_eq!(
        last(&[(0, 0x03C, &[1, 2, 3])]),
        "to drive 1    Go_Relative_Pos_PD: does not decode: Go_Relative_Pos_PD (0x1C) needs 1..=2 data bytes, got 3"
    );
    assert!(last(&[(0, 0x02F, &[0])]).contains("reserved for the factory"));
    assert!(last(&[(0, 0x039, &[0x11])]).contains("knows data 0x00 and 0xFF, got 0x11"));
}

#[test]
fn every_identifier_and_length_has_words() {
    let mut decoder = Decoder::default();
    for id in 0..=0x7FF {
        for len in 0..=8 {
            let frame = Frame::new(id, false, &[0x1B; 8][..len]).expect("a frame");
            let text = decoder.hear(0, &frame).to_string();
            assert!(
                text.len() > 20 && !text.contains("unknown"),
                "{id:03X} {len}: {text}"
            );
        }
    }
}

#[test]
fn trouble_is_remarkable_and_the_rest_is_not() {
    let remarkable = |frames: &[(u64, u32, &[u8])]| {
        let mut decoder = Decoder::default();
        let mut last = false;
        for (at_us, id, data) in frames {
            let frame = Frame::new(*id, false, data).expect("a frame");
            last = decoder.hear(at_us * 1_000, &frame).is_remarkable();
        }
        last
    };
    let asked: (u64, u32, &[u8]) = (0, 0x029, &[]);
    assert!(!remarkable(&[asked]));
    assert!(!remarkable(&[asked, (500, 0x029, &[0])]));
    assert!(remarkable(&[asked, (15_000, 0x029, &[0])]), "late");
    assert!(remarkable(&[asked, (9_000, 0x029, &[])]), "not answered");
    assert!(remarkable(&[(0, 0x03D, &[0xEE])]), "an alarm");
    assert!(remarkable(&[(0, 0x03C, &[1, 2, 3])]), "does not decode");
}

#[test]
fn values_have_units_in_their_names() {
    let mut decoder = Decoder::default();
    let mut json = |at_us: u64, id, data: &[u8]| {
        let frame = Frame::new(id, false, data).expect("a frame");
        serde_json::to_value(decoder.hear(at_us * 1_000, &frame)).expect("JSON")
    };
    assert_eq!(
        json(0, 0x03C, &[0x88]),
        serde_json::json!({
            "protocol": "dyn", "drive": 1, "direction": "to_drive", "function": "Go_Relative_Pos_PD", "step_counts": -120
        })
    );
    json(1_000, 0x02E, POSITION);
    assert_eq!(
        json(1_500, 0x02E, &[0xFF, 0x63]),
        serde_json::json!({
            "protocol": "dyn", "drive": 1, "direction": "from_drive", "function": "General_Read",
            "position_counts": -157, "response_us": 500.0
        })
    );
}
