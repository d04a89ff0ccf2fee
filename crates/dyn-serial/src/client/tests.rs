use core::num::NonZeroU8;
use std::vec::Vec;

use dyn_values::{Counts28, SpeedRpm};

use super::*;
use crate::DriveId;
use crate::{Quantity, RangeError};

const START_US: u64 = 1_000_000;

fn drive(id: i32) -> DriveId {
    DriveId::new(id).unwrap()
}

/// A client that has sent a read of drive 1's main gain at [`START_US`].
fn waiting() -> Client {
    let mut client = Client::new(Dialect::MANUAL, Timing::ONE_DRIVE);
    client
        .begin(START_US, drive(1).into(), &Request::ReadMainGain)
        .unwrap();
    assert_eq!(sent(client.poll(START_US)), [0x01, 0x98, 0x80, 0x99]);
    client
}

fn sent(poll: Poll) -> Vec<u8> {
    let Poll::Transmit(packet) = poll else {
        panic!("{poll:?}");
    };
    packet.as_bytes().to_vec()
}

fn hear(client: &mut Client, now_us: u64, bytes: &[u8]) {
    for byte in bytes {
        let _ = client.receive(now_us, *byte);
    }
}

fn main_gain(value: i32) -> Reply {
    Reply::MainGain(crate::MainGain::new(value).unwrap())
}

#[test]
fn reply_of_the_right_drive_and_function_ends_the_request() {
    let mut client = waiting();
    // Another function, another drive, then the reply, with noise around each.
    hear(
        &mut client,
        START_US + 3_000,
        &[0xFF, 0x01, 0x99, 0x80, 0x9A],
    );
    hear(
        &mut client,
        START_US + 3_000,
        &[0x02, 0x90, 0xE4, 0xF6, 0x80],
    );
    assert_eq!(
        client.poll(START_US + 3_000),
        Poll::Wait {
            until_us: START_US + 50_000
        }
    );
    hear(&mut client, START_US + 4_000, &[0x01, 0x90, 0xE4, 0xF5]);
    let reply = Answer::Reply {
        from: drive(1),
        reply: main_gain(100),
    };
    assert_eq!(client.poll(START_US + 4_000), Poll::Done(Ok(reply)));
    assert_eq!(client.poll(START_US + 4_000), Poll::Idle);
    assert_eq!(
        (client.traffic().unexpected, client.traffic().replies),
        (2, 1)
    );
    assert_eq!((client.line().packets, client.line().stray_bytes), (3, 2));
}

#[test]
fn one_request_at_a_time() {
    let mut client = waiting();
    let second = client.begin(START_US, drive(2).into(), &Request::ReadDriveId);
    assert_eq!(second, Err(Busy::Outstanding));
}

#[test]
fn a_read_is_repeated_and_then_given_up() {
    let mut client = waiting();
    for attempt in 1..3 {
        let now_us = START_US + attempt * 50_000;
        assert_eq!(sent(client.poll(now_us)), [0x01, 0x98, 0x80, 0x99]);
    }
    let end_us = START_US + 150_000;
    let Poll::Wait { until_us } = client.poll(end_us - 1) else {
        panic!("given up too early");
    };
    assert_eq!(until_us, end_us);
    assert_eq!(
        client.poll(end_us),
        Poll::Done(Err(Failure::NoReply { attempts: 3 }))
    );
    assert_eq!(client.traffic().retries, 2);
}

#[test]
fn a_command_is_never_repeated() {
    let mut client = Client::new(Dialect::MANUAL, Timing::ONE_DRIVE);
    let step = Request::GoRelativePos(Counts28::new(120).unwrap());
    client.begin(START_US, drive(3).into(), &step).unwrap();
    assert_eq!(sent(client.poll(START_US)), [0x03, 0xA3, 0x80, 0xF8, 0x9E]);
    assert_eq!(client.poll(START_US), Poll::Done(Ok(Answer::Sent)));
    assert_eq!(client.poll(START_US + 10_000_000), Poll::Idle);
}

#[test]
fn what_is_sent_next_waits_until_the_line_is_free_and_quiet() {
    let mut client = Client::new(Dialect::MANUAL, Timing::ONE_DRIVE);
    let stop = Request::TurnConstSpeed(SpeedRpm::ZERO);
    client.begin(START_US, drive(1).into(), &stop).unwrap();
    let _ = sent(client.poll(START_US));
    let _ = client.poll(START_US);
    client.begin(START_US, drive(1).into(), &stop).unwrap();
    // Four bytes of the first command, then 2 ms.
    let free_us = START_US + 4 * 261 + 2_000;
    assert_eq!(client.poll(START_US), Poll::Wait { until_us: free_us });
    assert_eq!(sent(client.poll(free_us)), [0x01, 0x8A, 0x80, 0x8B]);
}

#[test]
fn a_late_reply_is_heard_before_the_next_request_and_not_taken_for_its_reply() {
    let mut client = waiting();
    let end_us = START_US + 150_000;
    for attempt in 1..=3 {
        let _ = client.poll(START_US + attempt * 50_000);
    }
    client
        .begin(end_us, drive(1).into(), &Request::ReadMainGain)
        .unwrap();
    hear(&mut client, end_us, &[0x01, 0x90, 0xE4, 0xF5]);
    assert_eq!(
        client.poll(end_us),
        Poll::Wait {
            until_us: end_us + 2_000
        }
    );
    assert_eq!(client.traffic().unexpected, 1);
}

#[test]
fn a_line_that_is_never_quiet_is_a_failure_and_nothing_is_sent() {
    let mut client = Client::new(Dialect::MANUAL, Timing::ONE_DRIVE);
    hear(&mut client, START_US, &[0xFF]);
    client
        .begin(START_US, drive(1).into(), &Request::ReadDriveId)
        .unwrap();
    for now_us in (START_US..START_US + 100_000).step_by(1_000) {
        hear(&mut client, now_us, &[0xFF]);
        assert!(matches!(client.poll(now_us), Poll::Wait { .. }));
    }
    hear(&mut client, START_US + 100_000, &[0xFF]);
    assert_eq!(
        client.poll(START_US + 100_000),
        Poll::Done(Err(Failure::NotQuiet { waited_us: 100_000 }))
    );
}

#[test]
fn an_echo_is_no_reply() {
    let mut client = waiting();
    hear(&mut client, START_US + 1_100, &[0x01, 0x98, 0x80, 0x99]);
    assert_eq!(
        (client.traffic().echoes, client.traffic().unexpected),
        (1, 0)
    );
    assert!(matches!(client.poll(START_US + 1_100), Poll::Wait { .. }));
}

#[test]
fn a_bad_reply_is_named_when_no_good_one_follows() {
    let mut client = waiting();
    hear(&mut client, START_US, &[0x01, 0x90, 0x80, 0x91]);
    hear(&mut client, START_US, &[0x01, 0xB0, 0x80, 0xE4, 0x95]);
    assert_eq!(
        (client.traffic().out_of_range, client.traffic().wrong_length),
        (1, 1)
    );
    hear(&mut client, START_US, &[0x01, 0x90, 0x80, 0x91]);
    for attempt in 1..3 {
        let _ = client.poll(START_US + attempt * 50_000);
    }
    let error = DecodeError::Range(RangeError {
        quantity: Quantity::MainGain,
        actual: 0,
    });
    assert_eq!(
        client.poll(START_US + 150_000),
        Poll::Done(Err(Failure::BadReply { attempts: 3, error }))
    );
}

#[test]
fn half_a_reply_does_not_spoil_the_reply_of_the_next_attempt() {
    let mut client = waiting();
    hear(&mut client, START_US, &[0x01, 0x90]);
    let _ = client.poll(START_US + 50_000);
    assert_eq!(client.line().truncated, 1);
    hear(&mut client, START_US + 53_000, &[0x01, 0x90, 0xE4, 0xF5]);
    assert!(matches!(client.poll(START_US + 53_000), Poll::Done(Ok(_))));
}

#[test]
fn a_lone_drive_of_unknown_id_answers_the_general_id() {
    let dialect = Dialect {
        general_id: crate::GeneralId::LoneDrive,
        ..Dialect::MANUAL
    };
    let mut client = Client::new(dialect, Timing::ONE_DRIVE);
    client
        .begin(START_US, Address::All, &Request::ReadDriveId)
        .unwrap();
    assert_eq!(sent(client.poll(START_US)), [0x7F, 0x86, 0x80, 0x85]);
    hear(&mut client, START_US, &[0x05, 0x96, 0x85, 0xA0]);
    let reply = Answer::Reply {
        from: drive(5),
        reply: Reply::DriveId(drive(5)),
    };
    assert_eq!(client.poll(START_US), Poll::Done(Ok(reply)));
}

#[test]
fn a_chain_waits_for_every_relay_both_ways() {
    let one = Timing::chain(NonZeroU8::MIN);
    assert_eq!(one, Timing::ONE_DRIVE);
    let sixty_four = Timing::chain(NonZeroU8::new(64).unwrap());
    assert_eq!(
        sixty_four.reply_timeout_us - one.reply_timeout_us,
        2 * 63 * 7 * 261
    );
}

#[test]
fn a_reserved_id_is_never_taken_for_the_drive() {
    // The decoder reports the packet, because its form is right; the client does not believe it.
    let mut client = waiting();
    hear(&mut client, START_US, &[0x41, 0x90, 0xE4, 0xB5]);
    assert_eq!((client.line().packets, client.traffic().unexpected), (1, 1));
}
