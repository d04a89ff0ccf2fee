use super::*;
use proptest::prelude::*;

const REPLY_US: u64 = 50_000;

fn client() -> SdoClient {
    SdoClient::new(NodeId::FACTORY, SdoTimeouts::DEFAULT)
}

fn frame(id: u16, data: &[u8]) -> DataFrame {
    DataFrame::new(id, data).unwrap()
}

/// A client that has asked for the speed at 0 us.
fn reading_speed() -> SdoClient {
    let mut client = client();
    let sent = client.start(0, objects::ACTUAL_SPEED.read());
    assert_eq!(sent, Ok(frame(0x604, &[0x40, 0x6C, 0x60, 0, 0, 0, 0, 0])));
    client
}

/// A client that has asked for 100 r/min at 0 us.
fn writing_speed() -> SdoClient {
    let mut client = client();
    client.start(0, objects::TARGET_SPEED.write(100)).unwrap();
    client
}

fn ignored(heard: SdoHeard) -> SdoIgnored {
    match heard {
        SdoHeard::Ignored(reason) => reason,
        SdoHeard::Ended(event) => panic!("believed: {event:?}"),
    }
}

fn ended(heard: SdoHeard) -> SdoEnd {
    match heard {
        SdoHeard::Ended(event) => event.end,
        SdoHeard::Ignored(reason) => panic!("ignored: {reason:?}"),
    }
}

#[test]
fn a_read_ends_with_its_value() {
    let reply = frame(0x584, &[0x43, 0x6C, 0x60, 0, 0xED, 0x03, 0, 0]);
    let end = ended(reading_speed().on_frame(500, &reply));
    assert_eq!(end, SdoEnd::Value(ObjectData::from_raw(1005, 4)));
}

#[test]
fn a_refusal_ends_the_transfer_with_its_code() {
    let reply = frame(0x584, &[0x80, 0xFF, 0x60, 0, 0x30, 0, 9, 6]);
    let end = ended(writing_speed().on_frame(500, &reply));
    assert_eq!(end, SdoEnd::Aborted(AbortCode::VALUE_RANGE));
}

#[test]
fn replies_of_another_object_drive_or_direction_are_not_believed() {
    let mut client = writing_speed();
    let expected = objects::TARGET_SPEED.address();
    let other_index = frame(0x584, &[0x60, 0x81, 0x60, 0, 0, 0, 0, 0]);
    let actual = ObjectAddress::new(0x6081, 0);
    assert_eq!(
        ignored(client.on_frame(1, &other_index)),
        SdoIgnored::Address { expected, actual }
    );
    let other_sub = frame(0x584, &[0x60, 0xFF, 0x60, 1, 0, 0, 0, 0]);
    let actual = ObjectAddress::new(0x60FF, 1);
    assert_eq!(
        ignored(client.on_frame(2, &other_sub)),
        SdoIgnored::Address { expected, actual }
    );
    let other_drive = frame(0x585, &[0x60, 0xFF, 0x60, 0, 0, 0, 0, 0]);
    assert_eq!(
        ignored(client.on_frame(3, &other_drive)),
        SdoIgnored::Foreign
    );
    let value = frame(0x584, &[0x43, 0xFF, 0x60, 0, 0, 0, 0, 0]);
    assert_eq!(ignored(client.on_frame(4, &value)), SdoIgnored::Direction);
    let short = frame(0x584, &[0x60, 0xFF, 0x60, 0]);
    assert!(matches!(
        ignored(client.on_frame(5, &short)),
        SdoIgnored::Malformed(DecodeError::Length { actual: 4, .. })
    ));
    let right = frame(0x584, &[0x60, 0xFF, 0x60, 0, 0, 0, 0, 0]);
    assert_eq!(ended(client.on_frame(6, &right)), SdoEnd::Written);
}

#[test]
fn a_second_transfer_is_refused_while_one_runs() {
    let mut client = writing_speed();
    let address = objects::TARGET_SPEED.address();
    let second = client.start(1, objects::MODE.write(3));
    assert_eq!(second, Err(SdoBusy::Running { address }));
    let right = frame(0x584, &[0x60, 0xFF, 0x60, 0, 0, 0, 0, 0]);
    assert_eq!(ended(client.on_frame(6, &right)), SdoEnd::Written);
    assert!(client.start(6, objects::MODE.write(3)).is_ok());
}

#[test]
fn a_timeout_sends_an_abort_and_is_followed_by_silence() {
    let mut client = writing_speed();
    assert_eq!(client.poll_at_us(), Some(REPLY_US));
    assert_eq!(client.poll(REPLY_US - 1), None);
    let event = client.poll(REPLY_US).unwrap();
    assert_eq!(event.end, SdoEnd::TimedOut);
    let abort = frame(0x604, &[0x80, 0xFF, 0x60, 0, 0, 0, 4, 5]);
    let sent = event.abort().map(|abort| abort.encode(NodeId::FACTORY));
    assert_eq!(sent, Some(abort));
    let until_us = 2 * REPLY_US;
    assert_eq!(
        client.start(REPLY_US, objects::TARGET_SPEED.write(0)),
        Err(SdoBusy::Quarantined { until_us })
    );
    // The trap: the late confirmation of 100 r/min must not confirm the stop that never arrived.
    let late = frame(0x584, &[0x60, 0xFF, 0x60, 0, 0, 0, 0, 0]);
    let address = objects::TARGET_SPEED.address();
    assert_eq!(
        ignored(client.on_frame(REPLY_US + 10, &late)),
        SdoIgnored::Unawaited { address }
    );
    assert!(
        client
            .start(until_us, objects::TARGET_SPEED.write(0))
            .is_ok()
    );
}

#[test]
fn a_repeated_reply_does_not_answer_the_next_request() {
    let mut client = reading_speed();
    let reply = frame(0x584, &[0x43, 0x6C, 0x60, 0, 1, 0, 0, 0]);
    assert!(matches!(client.on_frame(100, &reply), SdoHeard::Ended(_)));
    let until_us = 1_100;
    assert_eq!(
        client.start(101, objects::ACTUAL_SPEED.read()),
        Err(SdoBusy::Settling { until_us })
    );
    assert!(matches!(
        ignored(client.on_frame(400, &reply)),
        SdoIgnored::Unawaited { .. }
    ));
    assert!(client.start(until_us, objects::ACTUAL_SPEED.read()).is_ok());
}

#[test]
fn a_segmented_reply_is_given_up_with_an_abort() {
    let mut client = reading_speed();
    let segmented = frame(0x584, &[0x41, 0x6C, 0x60, 0, 9, 0, 0, 0]);
    let SdoHeard::Ended(event) = client.on_frame(10, &segmented) else {
        panic!("ignored");
    };
    assert_eq!(event.end, SdoEnd::Specifier { actual: 0x41 });
    let abort = frame(0x604, &[0x80, 0x6C, 0x60, 0, 1, 0, 4, 5]);
    let sent = event.abort().map(|abort| abort.encode(NodeId::FACTORY));
    assert_eq!(sent, Some(abort));
    assert!(matches!(
        client.ready(11, objects::MODE.address()),
        Err(SdoBusy::Quarantined { .. })
    ));
}

#[test]
fn segments_with_either_toggle_bit_are_ignored() {
    for specifier in [0x00, 0x10, 0x20, 0x30, 0x0D] {
        let mut client = reading_speed();
        let segment = frame(0x584, &[specifier, 1, 2, 3, 4, 5, 6, 7]);
        assert!(matches!(
            ignored(client.on_frame(10, &segment)),
            SdoIgnored::Malformed(DecodeError::Specifier { .. })
        ));
    }
}

#[test]
fn the_printed_wrong_confirmation_needs_its_quirk() {
    let as_printed = frame(0x584, &[0x60, 0x81, 0x60, 1, 0, 0, 0, 0]);
    let quirks = SdoQuirks {
        profile_speed_confirmed_as_sub_1: true,
    };
    let mut strict = client();
    let mut tolerant = client().with_quirks(quirks);
    for client in [&mut strict, &mut tolerant] {
        client.start(0, objects::PROFILE_SPEED.write(60)).unwrap();
    }
    assert!(matches!(
        ignored(strict.on_frame(1, &as_printed)),
        SdoIgnored::Address { .. }
    ));
    assert_eq!(ended(tolerant.on_frame(1, &as_printed)), SdoEnd::Written);
    // For no other object, and not for a read.
    tolerant.start(2, objects::TARGET_SPEED.write(1)).unwrap();
    let other = frame(0x584, &[0x60, 0xFF, 0x60, 1, 0, 0, 0, 0]);
    assert!(matches!(
        ignored(tolerant.on_frame(3, &other)),
        SdoIgnored::Address { .. }
    ));
}

#[test]
fn a_request_that_came_back_unsent_leaves_the_client_free() {
    let mut client = reading_speed();
    client.withdraw();
    assert_eq!(client.poll_at_us(), None);
    assert!(client.start(10, objects::ACTUAL_SPEED.read()).is_ok());
    // A late reply is still awaited although nothing more is sent.
    client.abandon(20);
    let until = client.poll_at_us();
    client.withdraw();
    assert_eq!(client.poll_at_us(), until);
}

#[test]
fn refusals_and_ends_say_what_happened() {
    let address = objects::ACTUAL_SPEED.address();
    let busy = [
        SdoBusy::Running { address },
        SdoBusy::Quarantined { until_us: 7 },
        SdoBusy::Settling { until_us: 8 },
        SdoBusy::NoTransfer,
    ];
    let texts = [
        "the transfer of 606Ch:00 has not ended",
        "a late reply may come until 7 us",
        "what was just answered can be asked again at 8 us",
        "an abort starts no transfer",
    ];
    assert_eq!(busy.map(|busy| std::format!("{busy}")), texts);
    let code = AbortCode::VALUE_RANGE;
    let ends = [
        SdoEnd::Value(ObjectData::from_raw(0x3ED, 4)),
        SdoEnd::Written,
        SdoEnd::Aborted(code),
        SdoEnd::TimedOut,
        SdoEnd::Specifier { actual: 0x41 },
    ];
    let texts = [
        "the drive answered 0x3ED".into(),
        "the drive took the value".into(),
        std::format!("the drive refused: {code}"),
        "the drive did not answer in time".into(),
        "the drive answered with the specifier 0x41, which is not that of an expedited transfer"
            .into(),
    ];
    assert_eq!(ends.map(|end| std::format!("{end}")), texts);
}

#[test]
fn an_abandoned_transfer_is_quarantined_too() {
    let mut client = writing_speed();
    client.abandon(10);
    let address = objects::TARGET_SPEED.address();
    assert!(client.ready(REPLY_US, address).is_err());
    assert!(client.ready(REPLY_US + 10, address).is_ok());
}

proptest! {
    /// Whatever comes in: only the right reply ends the transfer well, and the client comes back by itself.
    #[test]
    fn nothing_but_the_right_reply_confirms(
        frames in proptest::collection::vec((0x580_u16..0x588, proptest::collection::vec(any::<u8>(), 0..=8)), 0..50)
    ) {
        let mut client = writing_speed();
        let right = [0x60, 0xFF, 0x60, 0];
        for (id, data) in frames {
            let heard = client.on_frame(1, &frame(id, &data));
            if let SdoHeard::Ended(SdoEvent { end: SdoEnd::Written, .. }) = heard {
                prop_assert!(id == 0x584 && data.len() == 8 && data.starts_with(&right));
            }
        }
        let _ = client.poll(REPLY_US);
        let _ = client.poll(2 * REPLY_US);
        prop_assert_eq!(client.poll_at_us(), None);
    }
}

/// A client whose write of the speed was confirmed at 100 us, and that asks for the mode at 200 us.
fn asking_behind_a_write() -> SdoClient {
    let mut client = writing_speed();
    let right = frame(0x584, &[0x60, 0xFF, 0x60, 0, 0, 0, 0, 0]);
    assert_eq!(ended(client.on_frame(100, &right)), SdoEnd::Written);
    client.start(200, objects::MODE.read()).unwrap();
    client
}

#[test]
fn an_object_settles_while_another_one_is_asked() {
    let mut client = asking_behind_a_write();
    let mode = frame(0x584, &[0x4F, 0x60, 0x60, 0, 3, 0, 0, 0]);
    assert!(matches!(
        ended(client.on_frame(300, &mode)),
        SdoEnd::Value(_)
    ));
    let until_us = 1_300;
    let settling = Err(SdoBusy::Settling { until_us });
    let mut other = client;
    // The repeated confirmation would answer this write.
    assert_eq!(client.start(400, objects::TARGET_SPEED.write(0)), settling);
    assert_eq!(client.start(400, objects::MODE.read()), settling);
    // It could not be told which of three settles.
    assert_eq!(client.start(400, objects::STATUS_WORD.read()), settling);
    assert!(
        client
            .start(until_us, objects::TARGET_SPEED.write(0))
            .is_ok()
    );
    other.poll(until_us);
    other.start(until_us, objects::STATUS_WORD.read()).unwrap();
    let status = frame(0x584, &[0x4B, 0x41, 0x60, 0, 0, 0, 0, 0]);
    let _ = ended(other.on_frame(1_400, &status));
    assert!(other.start(1_500, objects::MODE.read()).is_ok());
}

#[test]
fn an_object_settles_also_when_the_next_request_is_withdrawn() {
    let mut client = asking_behind_a_write();
    client.withdraw();
    let until_us = 1_200;
    assert_eq!(
        client.start(300, objects::TARGET_SPEED.write(0)),
        Err(SdoBusy::Settling { until_us })
    );
    assert!(client.start(300, objects::MODE.read()).is_ok());
}
