//! Every 11-bit identifier with every payload of 0, 1 and 2 bytes: 2048 * 65793 = 134,744,064 frames, in both directions and both
//! revisions.
//!
//! Nothing may panic, and what decodes must encode back to the same bytes or, where a number came in more bytes than it needs, to its
//! shortest form. Which forms are longer than needed is decided here, from the bytes alone. So are the numbers of frames that decode.

use std::num::NonZero;
use std::thread;

use dyn_can::{DataFrame, Dialect, DynFrame, FunctionCode, Reply, ReplyKind, Request};

const IDS: u16 = 0x800;

/// Payloads of 0, 1 and 2 bytes.
const PAYLOADS: u64 = 1 + 256 + 65_536;

/// Addresses with one drive behind them.
const DRIVES: u64 = 63;

/// Numbers in 1 or 2 bytes of any value.
const ANY_NUMBER: u64 = 256 + 65_536;

fn every_payload(id: u16) -> impl Iterator<Item = DataFrame> {
    let frame = move |data: &[u8]| DataFrame::new(id, data).expect("11-bit identifier, short data");
    let empty = std::iter::once(frame(&[]));
    let one = (0..=u8::MAX).map(move |byte| frame(&[byte]));
    let two = (0..=u16::MAX).map(move |word| frame(&word.to_be_bytes()));
    empty.chain(one).chain(two)
}

/// Frames seen and frames decoded.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
struct Count {
    seen: u64,
    decoded: u64,
}

/// Runs `decodings`, which says in how many ways a frame decodes, on every frame, on all processors.
fn on_every_frame(decodings: impl Fn(&DataFrame) -> u64 + Sync) -> Count {
    let workers = thread::available_parallelism().map_or(1, NonZero::get);
    let decodings = &decodings;
    thread::scope(|scope| {
        let threads: Vec<_> = (0..workers)
            .map(|worker| {
                scope.spawn(move || {
                    let mut count = Count::default();
                    // Neighbouring identifiers go to different workers: functions differ in their work.
                    for id in (0..IDS).skip(worker).step_by(workers) {
                        for frame in every_payload(id) {
                            count.seen += 1;
                            count.decoded += decodings(&frame);
                        }
                    }
                    count
                })
            })
            .collect();
        threads.into_iter().fold(Count::default(), |sum, thread| {
            let count = thread.join().expect("no frame makes the codec panic");
            Count {
                seen: sum.seen + count.seen,
                decoded: sum.decoded + count.decoded,
            }
        })
    })
}

/// The same frame, or the shorter form of the same number: the first of two bytes only repeats the sign of the second.
fn expect_same_or_shortest(received: &DataFrame, encoded: &DataFrame) {
    if encoded == received {
        return;
    }
    assert_eq!(encoded.id(), received.id());
    let [high, low] = *received.data() else {
        panic!("{received} came back as {encoded}")
    };
    let sign = if low < 0x80 { 0x00 } else { 0xFF };
    assert!(
        high == sign && encoded.data() == [low],
        "{received} came back as {encoded}"
    );
}

fn request_decodings(frame: &DataFrame, dialect: &Dialect) -> u64 {
    let Ok((to, request)) = Request::decode(frame, dialect) else {
        return 0;
    };
    let encoded = request
        .encode(to, dialect)
        .expect("what decodes may be sent");
    expect_same_or_shortest(frame, &encoded);
    if encoded != *frame {
        assert_eq!(Request::decode(&encoded, dialect), Ok((to, request)));
    }
    1
}

fn reply_decodings(frame: &DataFrame, outstanding: Option<ReplyKind>, dialect: &Dialect) -> u64 {
    let Ok((from, reply)) = Reply::decode(frame, outstanding, dialect) else {
        return 0;
    };
    let encoded = reply.encode(from, dialect);
    expect_same_or_shortest(frame, &encoded);
    if encoded != *frame {
        assert_eq!(
            Reply::decode(&encoded, outstanding, dialect),
            Ok((from, reply))
        );
    }
    1
}

/// Without an outstanding request, and for General_Read with either selector.
fn all_reply_decodings(frame: &DataFrame, dialect: &Dialect) -> u64 {
    let mut decoded = reply_decodings(frame, None, dialect);
    if frame.function() == FunctionCode::GeneralRead {
        assert_eq!(decoded, 0, "{frame}: position and torque look alike");
        decoded += reply_decodings(frame, Some(ReplyKind::Position), dialect);
        decoded += reply_decodings(frame, Some(ReplyKind::Torque), dialect);
    }
    decoded
}

/// Requests to one drive with at most 2 data bytes that both revisions know, counted from the printed ranges.
fn requests_of_one_drive() -> u64 {
    let set_origin = 1;
    let moves_of_any_size = 4 * ANY_NUMBER; // 01, 03, 16, 17
    let assign_drive_id = 63;
    let set_drive_config = 4 * 2 * 3 * 2; // command mode, absolute, servo mode, free
    let reads = 8; // 06, 08, 09, 13, 14, 15, 1A, 1F without data
    let speed = 256 + 40_001;
    let waves = 2 * (128 + 4_097);
    let frequency = 51;
    let general_read = 2;
    let group_2 = 128 * 128;
    let sync_trigger = 2;
    let servo_disable = 2;
    let pd_step = 256 + 32_769;
    set_origin
        + moves_of_any_size
        + assign_drive_id
        + set_drive_config
        + reads
        + speed
        + waves
        + frequency
        + general_read
        + group_2
        + sync_trigger
        + servo_disable
        + pd_step
}

/// Sync_Trigger with its two arguments.
const BROADCASTS: u64 = 2;

fn check_requests(dialect: &Dialect, only_in_this_revision: u64) {
    let count = on_every_frame(|frame| request_decodings(frame, dialect));
    let decoded = DRIVES * (requests_of_one_drive() + only_in_this_revision) + BROADCASTS;
    assert_eq!(
        count,
        Count {
            seen: u64::from(IDS) * PAYLOADS,
            decoded
        }
    );
}

fn check_replies(dialect: &Dialect, only_in_this_revision: u64) {
    let count = on_every_frame(|frame| all_reply_decodings(frame, dialect));
    let drive_id = 64;
    let any_byte = 4 * 256; // 08, 09, 1D, 1F
    let group_2 = 127 * 127;
    let motor_speed = 65_536;
    let position = ANY_NUMBER;
    let torque = 256 + 65_536;
    let of_one_drive =
        drive_id + any_byte + group_2 + motor_speed + position + torque + only_in_this_revision;
    // A drive without an id answers on the broadcast identifiers.
    assert_eq!(
        count,
        Count {
            seen: u64::from(IDS) * PAYLOADS,
            decoded: (DRIVES + 1) * of_one_drive
        }
    );
}

#[test]
fn every_short_request_of_1_2a() {
    // 02 and 04.
    check_requests(&Dialect::V1_2A, 2 * ANY_NUMBER);
}

#[test]
fn every_short_request_of_1_6a() {
    // Drive_Reset with FE.
    check_requests(&Dialect::V1_6A, 1);
}

#[test]
fn every_short_reply_of_1_2a() {
    check_replies(&Dialect::V1_2A, 0);
}

#[test]
fn every_short_reply_of_1_6a() {
    // Drive_Reset with any byte.
    check_replies(&Dialect::V1_6A, 256);
}
