//! Lines that bring back what is sent.

use std::vec;
use std::vec::Vec;

use proptest::prelude::*;

use super::*;
use crate::{ConfigByte, DriveId, DriveStatus, GearNumber, MainGain, OnPosRange};

const START_US: u64 = 1_000_000;
/// Is_MainGain 20 of drive 1, and the same 33, which has the bytes of Set_MainGain 33.
const IS_20: [u8; 4] = [0x01, 0x90, 0x94, 0xA5];
const IS_33: [u8; 4] = [0x01, 0x90, 0xA1, 0xB2];
const READ: [u8; 4] = [0x01, 0x98, 0x80, 0x99];

fn drive(id: i32) -> DriveId {
    DriveId::new(id).unwrap()
}

fn gain(value: i32) -> MainGain {
    MainGain::new(value).unwrap()
}

fn hear(client: &mut Client, now_us: u64, bytes: &[u8]) {
    for byte in bytes {
        let _ = client.receive(now_us, *byte);
    }
}

/// Sends a request as soon as the client does; returns when that was.
fn send(client: &mut Client, mut now_us: u64, request: &Request) -> u64 {
    client.begin(now_us, drive(1).into(), request).unwrap();
    loop {
        match client.poll(now_us) {
            Poll::Transmit(_) => return now_us,
            Poll::Wait { until_us } => now_us = until_us,
            other => panic!("{other:?}"),
        }
    }
}

/// A client that has set main gain 33 and then asked for it; with the time of that.
fn asked_after_set() -> (Client, u64) {
    let mut client = Client::new(Dialect::MANUAL, Timing::ONE_DRIVE);
    let set_us = send(&mut client, START_US, &Request::SetMainGain(gain(33)));
    assert_eq!(client.poll(set_us), Poll::Done(Ok(Answer::Sent)));
    let read_us = send(&mut client, set_us + 1_000, &Request::ReadMainGain);
    // Four bytes on their way, and then the time in which an echo may come.
    assert_eq!(read_us, set_us + 4 * 261 + 2_000);
    (client, read_us)
}

fn is(value: i32) -> Poll {
    let from = drive(1);
    let reply = Reply::MainGain(gain(value));
    Poll::Done(Ok(Answer::Reply { from, reply }))
}

/// How the request ends when nothing more comes.
fn end_of(client: &mut Client, mut now_us: u64) -> Poll {
    loop {
        match client.poll(now_us) {
            Poll::Wait { until_us } => now_us = until_us,
            Poll::Transmit(_) => {}
            end => return end,
        }
    }
}

#[test]
fn a_command_that_has_come_back_is_not_waited_for_any_longer() {
    let slow = Timing {
        echo_us: 20_000,
        ..Timing::ONE_DRIVE
    };
    let start = || {
        let mut client = Client::new(Dialect::MANUAL, slow);
        let at_us = send(&mut client, START_US, &Request::SetMainGain(gain(33)));
        assert_eq!(client.poll(at_us), Poll::Done(Ok(Answer::Sent)));
        (client, at_us)
    };
    let sent_us = 4 * 261;
    let (mut client, at_us) = start();
    hear(&mut client, at_us + 1_100, &IS_33);
    let next_us = send(&mut client, at_us + 1_100, &Request::ReadMainGain);
    assert_eq!(next_us, at_us + 1_100 + 2_000);
    // What somebody else said is not what was sent.
    let (mut client, at_us) = start();
    hear(&mut client, at_us + 1_100, &IS_20);
    let next_us = send(&mut client, at_us + 1_100, &Request::ReadMainGain);
    assert_eq!(next_us, at_us + sent_us + 20_000);
}

#[test]
fn a_setting_that_comes_back_late_is_not_its_read_back() {
    let (mut client, at_us) = asked_after_set();
    hear(&mut client, at_us + 500, &IS_33);
    assert!(matches!(client.poll(at_us + 500), Poll::Wait { .. }));
    hear(&mut client, at_us + 1_100, &READ);
    assert!(matches!(client.poll(at_us + 1_100), Poll::Wait { .. }));
    // The drive has not taken it.
    hear(&mut client, at_us + 4_000, &IS_20);
    assert_eq!(client.poll(at_us + 4_000), is(20));
    let traffic = client.traffic();
    assert_eq!((traffic.doubtful, traffic.echoes), (1, 1));
}

#[test]
fn a_setting_that_comes_back_and_no_reply_is_no_reply() {
    let (mut client, at_us) = asked_after_set();
    hear(&mut client, at_us + 500, &IS_33);
    hear(&mut client, at_us + 1_100, &READ);
    assert_eq!(
        end_of(&mut client, at_us + 1_100),
        Poll::Done(Err(Failure::NoReply { attempts: 3 }))
    );
}

#[test]
fn a_reply_that_is_no_echo_is_believed_beside_one() {
    let (mut client, at_us) = asked_after_set();
    hear(&mut client, at_us + 500, &IS_33);
    hear(&mut client, at_us + 4_000, &IS_20);
    assert_eq!(client.poll(at_us + 4_000), is(20));
}

#[test]
fn a_read_back_equal_to_the_setting_counts_when_the_line_brings_nothing_back() {
    let (mut client, at_us) = asked_after_set();
    hear(&mut client, at_us + 4_000, &IS_33);
    let until_us = at_us + 50_000;
    assert_eq!(client.poll(at_us + 4_000), Poll::Wait { until_us });
    assert_eq!(client.poll(until_us), is(33));
    // From then on it is known.
    let at_us = send(&mut client, until_us, &Request::ReadMainGain);
    hear(&mut client, at_us + 4_000, &IS_33);
    assert_eq!(client.poll(at_us + 4_000), is(33));
}

#[test]
fn a_read_back_equal_to_the_setting_counts_at_once_after_both_echoes() {
    let mut client = Client::new(Dialect::MANUAL, Timing::ONE_DRIVE);
    let at_us = send(&mut client, START_US, &Request::SetMainGain(gain(33)));
    assert_eq!(client.poll(at_us), Poll::Done(Ok(Answer::Sent)));
    hear(&mut client, at_us + 1_100, &IS_33);
    let at_us = send(&mut client, at_us + 1_100, &Request::ReadMainGain);
    hear(&mut client, at_us + 1_100, &READ);
    hear(&mut client, at_us + 4_000, &IS_33);
    assert_eq!(client.poll(at_us + 4_000), is(33));
    assert_eq!((client.traffic().doubtful, client.traffic().echoes), (0, 2));
}

#[test]
fn on_a_disturbed_line_the_doubt_is_an_error() {
    let (mut client, mut now_us) = asked_after_set();
    // The echo of the request is damaged each time.
    let damaged = [0x01, 0x98, 0x80, 0x98];
    for attempt in 1..=3 {
        if attempt > 1 {
            assert!(
                matches!(client.poll(now_us), Poll::Transmit(_)),
                "{attempt}"
            );
        }
        hear(&mut client, now_us + 500, &IS_33);
        hear(&mut client, now_us + 1_100, &damaged);
        now_us += 50_000;
    }
    assert_eq!(
        client.poll(now_us),
        Poll::Done(Err(Failure::Doubtful { attempts: 3 }))
    );
}

#[test]
fn where_another_request_came_back_the_doubt_is_an_error() {
    let mut client = Client::new(Dialect::MANUAL, Timing::ONE_DRIVE);
    let now_us = send(&mut client, START_US, &Request::ReadMainGain);
    hear(&mut client, now_us + 4_000, &IS_20);
    assert_eq!(client.poll(now_us + 4_000), is(20));
    let set = Request::SetMainGain(gain(33));
    let now_us = send(&mut client, now_us + 4_000, &set);
    assert_eq!(client.poll(now_us), Poll::Done(Ok(Answer::Sent)));
    let now_us = send(&mut client, now_us, &Request::ReadMainGain);
    // The echoes of the first read and of the setting; that of the second read is lost, and the drive is silent.
    hear(&mut client, now_us + 500, &READ);
    hear(&mut client, now_us + 1_600, &IS_33);
    assert_eq!(
        end_of(&mut client, now_us + 1_600),
        Poll::Done(Err(Failure::Doubtful { attempts: 3 }))
    );
}

#[test]
fn what_is_on_the_line_at_the_start_is_listened_for() {
    let mut client = Client::new(Dialect::MANUAL, Timing::ONE_DRIVE);
    client
        .begin(0, drive(1).into(), &Request::ReadMainGain)
        .unwrap();
    assert_eq!(client.poll(0), Poll::Wait { until_us: 2_000 });
    hear(&mut client, 1_000, &IS_33);
    assert_eq!(client.poll(2_000), Poll::Wait { until_us: 3_000 });
    assert!(matches!(client.poll(3_000), Poll::Transmit(_)));
    assert_eq!(client.traffic().unexpected, 1);
}

/// Requests whose packets read as replies, and some that do not.
fn earlier() -> impl Strategy<Value = Request> {
    let gains = (1..=127_i32).prop_flat_map(|value| {
        prop_oneof![
            Just(Request::SetMainGain(gain(value))),
            Just(Request::SetSpeedGain(value.try_into().unwrap())),
            Just(Request::SetIntGain(value.try_into().unwrap())),
            Just(Request::SetTrqCons(value.try_into().unwrap())),
            Just(Request::SetHighSpeed(value.try_into().unwrap())),
            Just(Request::SetHighAccel(value.try_into().unwrap())),
            Just(Request::SetPosOnRange(value.try_into().unwrap())),
            Just(Request::SetDriveConfig(ConfigByte::new(value).unwrap())),
        ]
    });
    let gears =
        (500..=16_383_i32).prop_map(|gear| Request::SetGearNumber(gear.try_into().unwrap()));
    prop_oneof![gains, gears, read().prop_map(|(request, _)| request)]
}

/// Reads with a reply of the drive.
fn read() -> impl Strategy<Value = (Request, Reply)> {
    (1..=63_i32).prop_flat_map(|value| {
        prop::sample::select(vec![
            (Request::ReadMainGain, Reply::MainGain(gain(value))),
            (
                Request::ReadSpeedGain,
                Reply::SpeedGain(value.try_into().unwrap()),
            ),
            (
                Request::ReadIntGain,
                Reply::IntegrationGain(value.try_into().unwrap()),
            ),
            (
                Request::ReadTrqCons,
                Reply::TorqueFilter(value.try_into().unwrap()),
            ),
            (
                Request::ReadHighSpeed,
                Reply::MaxSpeed(value.try_into().unwrap()),
            ),
            (
                Request::ReadHighAccel,
                Reply::MaxAcceleration(value.try_into().unwrap()),
            ),
            (Request::ReadDriveId, Reply::DriveId(drive(1))),
            (
                Request::ReadPosOnRange,
                Reply::OnPosRange(OnPosRange::new(value).unwrap()),
            ),
            (
                Request::ReadGearNumber,
                Reply::GearNumber(GearNumber::new(value + 500).unwrap()),
            ),
            (
                Request::ReadDriveStatus,
                Reply::Status(DriveStatus::from_byte(value as u8)),
            ),
            (
                Request::ReadDriveConfig,
                Reply::Config(ConfigByte::new(value).unwrap()),
            ),
        ])
    })
}

proptest! {
    /// Whatever was sent before a read, with every echo in its order, those of the last ones late: the value is that of the reply, or
    /// there is none.
    #[test]
    fn no_echo_is_a_value(
        before in proptest::collection::vec(earlier(), 1..6), on_time in 0..6_usize, (request, reply) in read(),
        replies: bool, echoes: bool, late_us in 0..2_000_u64
    ) {
        let packet = |request: &Request| request.encode(drive(1).into(), &Dialect::MANUAL).unwrap();
        let mut client = Client::new(Dialect::MANUAL, Timing::ONE_DRIVE);
        let mut now_us = START_US;
        let mut late = Vec::new();
        for (number, request) in before.iter().enumerate() {
            now_us = send(&mut client, now_us, request);
            // A read is given up.
            client.abandon();
            if echoes && number < on_time {
                hear(&mut client, now_us + 1_000, packet(request).as_bytes());
            } else if echoes {
                late.push(packet(request));
            }
        }
        now_us = send(&mut client, now_us, &request) + late_us;
        // In each attempt the echo of the request, in the first one behind those that are late, and then the reply.
        let end = loop {
            for echo in late.drain(..) {
                hear(&mut client, now_us, echo.as_bytes());
            }
            if echoes {
                hear(&mut client, now_us + 1_000, packet(&request).as_bytes());
            }
            if replies {
                hear(&mut client, now_us + 2_000, reply.encode(drive(1)).as_bytes());
            }
            let mut polls = (2..52).map(|ms| client.poll(now_us + ms * 1_000));
            let end = polls.find(|poll| !matches!(poll, Poll::Wait { .. }));
            now_us += 52_000;
            match end {
                Some(Poll::Transmit(_)) | None => {}
                Some(end) => break end,
            }
        };
        if replies {
            prop_assert_eq!(end, Poll::Done(Ok(Answer::Reply { from: drive(1), reply })));
        } else {
            prop_assert_eq!(end, Poll::Done(Err(Failure::NoReply { attempts: 3 })));
        }
    }
}
