use super::*;

fn frame(id: u32, data: &[u8]) -> Frame {
    Frame::new(id, false, data).unwrap()
}

/// What is made of frames that end a millisecond apart.
fn words(frames: &[(u32, &[u8])]) -> Vec<String> {
    let mut canopen = Canopen::default();
    (0_u64..)
        .zip(frames)
        .filter_map(|(ms, (id, data))| canopen.hear(Some(ms * 1_000_000), &frame(*id, data)))
        .map(|message| message.to_string())
        .collect()
}

#[test]
fn a_read_and_its_reply_are_one_conversation() {
    let said = words(&[
        (0x604, &[0x40, 0x6C, 0x60, 0, 0, 0, 0, 0]),
        (0x584, &[0x43, 0x6C, 0x60, 0, 0x18, 0xFC, 0xFF, 0xFF]),
        (0x584, &[0x43, 0x6C, 0x60, 0, 0x18, 0xFC, 0xFF, 0xFF]),
    ]);
    assert_eq!(
        said,
        [
            "to   node 4   SDO request: read 606Ch:00 actual speed",
            "from node 4   SDO reply: 606Ch:00 actual speed = -1000 x 0.1 r/min (1.000 ms after the request)",
            "from node 4   SDO reply: 606Ch:00 actual speed = -1000 x 0.1 r/min - nobody asked: late, or repeated",
        ]
    );
}

#[test]
fn a_pdo_is_read_by_the_mapping_that_was_heard() {
    let pdo: (u32, &[u8]) = (0x304, &[0x0F, 0, 0x9C, 0xFF, 0xFF, 0xFF]);
    let said = words(&[
        pdo,
        (0x604, &[0x2F, 0x01, 0x16, 0, 0, 0, 0, 0]),
        (0x604, &[0x23, 0x01, 0x16, 1, 0x10, 0, 0x40, 0x60]),
        (0x604, &[0x23, 0x01, 0x16, 2, 0x20, 0, 0xFF, 0x60]),
        (0x604, &[0x2F, 0x01, 0x16, 0, 2, 0, 0, 0]),
        pdo,
        (0x304, &[0x0F, 0]),
    ]);
    let (first, last) = (&said[0], &said[5..]);
    assert_eq!(
        first,
        "to   node 4   RPDO 1: [0F, 00, 9C, FF, FF, FF], its mapping was not heard"
    );
    assert_eq!(
        last,
        [
            "to   node 4   RPDO 1: control word 000Fh, target speed = -100 x 1/n r/min",
            "to   node 4   RPDO 1: [0F, 00], its mapping was not heard - not as long as its mapping",
        ]
    );
}

#[test]
fn trouble_is_remarkable() {
    let mut canopen = Canopen::default();
    let mut hear = |id, data: &[u8]| {
        let message = canopen.hear(Some(0), &frame(id, data)).unwrap();
        (message.is_remarkable(), message.to_string())
    };
    let (remarkable, text) = hear(0x704, &[0x00]);
    assert!(remarkable && text.ends_with("heartbeat: boot-up"), "{text}");
    assert!(!hear(0x704, &[0x05]).0);
    let (remarkable, text) = hear(0x584, &[0x80, 0xFF, 0x60, 0, 0x30, 0, 9, 6]);
    assert!(
        remarkable && text.contains("value range exceeded"),
        "{text}"
    );
    let (remarkable, text) = hear(0x084, &[0x10, 0x32, 1, 0, 0, 0, 0, 0]);
    assert!(remarkable && text.contains("emergency 3210h"), "{text}");
    let (remarkable, text) = hear(0x584, &[0x43, 0x64]);
    assert!(
        remarkable && text.contains("needs 8 data bytes, got 2"),
        "{text}"
    );
    assert!(!hear(0x080, &[]).0);
}

#[test]
fn only_data_frames_of_11_bits_are_canopen() {
    let mut canopen = Canopen::default();
    assert_eq!(
        canopen.hear(Some(0), &Frame::new(0x604, true, &[]).unwrap()),
        None
    );
    assert_eq!(
        canopen.hear(Some(0), &Frame::remote(0x704, false, 1).unwrap()),
        None
    );
}
