//! Every message with literal bytes, both ways: 1.6A and 1.2A, sections 4 to 6; those without an example in the documents by hand.

use dyn_can::{
    Address, Amplitude, ByteOrder, CommandMode, ConfigByte, Counts28, DataFrame, DecodeError,
    Dialect, DriveConfig, DriveError, DriveId, DriveStatus, FrequencyHz, FunctionCode, GearNumber,
    IntegrationGain, LineNumber, MainGain, MaxAcceleration, MaxSpeed, OnPosRange, ParamGroup1,
    ParamGroup2, ParamGroup3, PdStep, ReadSelector, Reply, ReplyKind, Request, Revision, Rotation,
    ServoMode, ServoSwitch, SetOriginData, SetParamGroup1, SetParamGroup2, SetParamGroup3,
    SpeedGain, SpeedRpm, StoredDriveId, SyncKind, Torque, TorqueFilter, TorqueFullScale,
};

const DRIVE_1: Address = Address::Drive(DriveId::MIN);

const CONFIG: DriveConfig = DriveConfig {
    command_mode: CommandMode::PulseDirection,
    absolute_mode: true,
    servo_mode: ServoMode::Torque,
    servo_free: true,
};

fn counts(counts: i32) -> Counts28 {
    Counts28::new(counts).expect("28 bits")
}

fn amplitude(counts: i32) -> Amplitude {
    Amplitude::new(counts).expect("an amplitude")
}

/// Request, identifier to drive 1, data, and what the drive answers.
type Row = (Request, u16, &'static [u8], Option<ReplyKind>);

/// What both revisions have.
fn requests() -> Vec<Row> {
    let group_1 = SetParamGroup1 {
        main_gain: MainGain::new(45).ok(),
        speed_gain: None,
        integration_gain: IntegrationGain::new(3).ok(),
        torque_filter: TorqueFilter::new(127).ok(),
    };
    let group_2 = SetParamGroup2 {
        max_speed: None,
        max_acceleration: MaxAcceleration::new(1).ok(),
    };
    let group_3 = SetParamGroup3 {
        on_pos_range: OnPosRange::new(20).ok(),
        gear_number: GearNumber::new(4_096).ok(),
        line_number: LineNumber::new(2_500).ok(),
    };
    let speed = |rpm| SpeedRpm::new(rpm).expect("a speed");
    let step = |counts| PdStep::new(counts).expect("a step");
    let assigned = StoredDriveId::new(63).expect("an id");
    let frequency = FrequencyHz::new(50).expect("a frequency");
    let relative = SyncKind::Relative;
    vec![
        (
            Request::GoAbsolutePosPtp(counts(-134_217_727)),
            0x21,
            &[0xF8, 0, 0, 1],
            None,
        ),
        (
            Request::GoRelativePosPtp(counts(32_768)),
            0x23,
            &[0x00, 0x80, 0x00],
            None,
        ),
        (Request::AssignDriveId(assigned), 0x25, &[63], None),
        (Request::ReadDriveId, 0x26, &[], Some(ReplyKind::DriveId)),
        (Request::SetDriveConfig(CONFIG), 0x27, &[0x36], None),
        (
            Request::ReadDriveConfig,
            0x28,
            &[],
            Some(ReplyKind::DriveConfig),
        ),
        (
            Request::ReadDriveStatus,
            0x29,
            &[],
            Some(ReplyKind::DriveStatus),
        ),
        (
            Request::TurnConstSpeed(speed(-2_000)),
            0x2A,
            &[0xF8, 0x30],
            None,
        ),
        (
            Request::SquareWave(amplitude(1_024)),
            0x2B,
            &[0x04, 0x00],
            None,
        ),
        (Request::SinWave(amplitude(5)), 0x2C, &[5], None),
        (Request::SsFrequency(frequency), 0x2D, &[50], None),
        (
            Request::GeneralRead(ReadSelector::Position),
            0x2E,
            &[0x1B],
            Some(ReplyKind::Position),
        ),
        (
            Request::GeneralRead(ReadSelector::Torque),
            0x2E,
            &[0x1E],
            Some(ReplyKind::Torque),
        ),
        (
            Request::SetParamGroup1(group_1),
            0x30,
            &[45, 0, 3, 127],
            None,
        ),
        (Request::SetParamGroup2(group_2), 0x31, &[0, 1], None),
        (
            Request::SetParamGroup3(group_3),
            0x32,
            &[0x14, 0x10, 0x00, 0x09, 0xC4],
            None,
        ),
        (
            Request::ReadParamGroup1,
            0x33,
            &[],
            Some(ReplyKind::ParamGroup1),
        ),
        (
            Request::ReadParamGroup2,
            0x34,
            &[],
            Some(ReplyKind::ParamGroup2),
        ),
        (
            Request::ReadParamGroup3,
            0x35,
            &[],
            Some(ReplyKind::ParamGroup3),
        ),
        (
            Request::GoAbsolutePosSync(counts(-129)),
            0x36,
            &[0xFF, 0x7F],
            None,
        ),
        (
            Request::GoRelativePosSync(counts(-8_388_609)),
            0x37,
            &[0xFF, 0x7F, 0xFF, 0xFF],
            None,
        ),
        (
            Request::SyncTrigger(SyncKind::Absolute),
            0x38,
            &[0xFF],
            None,
        ),
        (Request::SyncTrigger(relative), 0x38, &[0xEE], None),
        (
            Request::ServoDisable(ServoSwitch::Enable),
            0x39,
            &[0x00],
            None,
        ),
        (
            Request::ServoDisable(ServoSwitch::Disable),
            0x39,
            &[0xFF],
            None,
        ),
        (
            Request::ReadMotorSpeed,
            0x3A,
            &[],
            Some(ReplyKind::MotorSpeed),
        ),
        (
            Request::GoRelativePosPd(step(-16_383)),
            0x3C,
            &[0xC0, 0x01],
            None,
        ),
        (
            Request::EchoFunction([1, 2, 3, 0xFF]),
            0x3E,
            &[1, 2, 3, 0xFF],
            Some(ReplyKind::Echo),
        ),
        (
            Request::DiagnosticCounter,
            0x3F,
            &[],
            Some(ReplyKind::DiagnosticCounter),
        ),
    ]
}

fn check(dialect: &Dialect, rows: &[Row]) {
    for &(request, id, data, reply) in rows {
        let frame = DataFrame::new(id, data).expect("a frame");
        assert_eq!(request.encode(DRIVE_1, dialect), Ok(frame), "{request:?}");
        assert_eq!(Request::decode(&frame, dialect), Ok((DRIVE_1, request)));
        assert_eq!(request.reply_kind(), reply, "{request:?}");
        let function = FunctionCode::from_can_id(id);
        assert_eq!(reply.map(ReplyKind::function), reply.map(|_| function));
    }
}

#[test]
fn every_request_is_its_bytes() {
    for dialect in [&Dialect::V1_6A, &Dialect::V1_2A] {
        check(dialect, &requests());
    }
    let reset: Row = (
        Request::DriveReset,
        0x3B,
        &[0xFE],
        Some(ReplyKind::DriveReset),
    );
    check(
        &Dialect::V1_6A,
        &[(Request::SetOrigin, 0x20, &[0xAB], None), reset],
    );
    let word = counts(-134_217_728);
    let only_1_2a: [Row; 3] = [
        (Request::SetOrigin, 0x20, &[0xFF], None),
        (Request::MakeLinearLine(word), 0x22, &[0xF8, 0, 0, 0], None),
        (Request::MakeCircularArc(counts(1)), 0x24, &[1], None),
    ];
    check(&Dialect::V1_2A, &only_1_2a);
}

#[test]
fn every_request_has_a_number_of_bytes_and_no_other() {
    // Function, the fewest and the most bytes.
    let lengths = [
        (0x00, 1, 1),
        (0x01, 1, 4),
        (0x03, 1, 4),
        (0x05, 1, 1),
        (0x06, 0, 0),
        (0x07, 1, 1),
        (0x0A, 1, 2),
        (0x0B, 1, 3),
        (0x0C, 1, 3),
        (0x0D, 1, 1),
        (0x0E, 1, 1),
        (0x10, 4, 4),
        (0x11, 2, 2),
        (0x12, 5, 5),
        (0x13, 0, 0),
        (0x16, 1, 4),
        (0x17, 1, 4),
        (0x18, 1, 1),
        (0x19, 1, 1),
        (0x1A, 0, 0),
        (0x1B, 1, 1),
        (0x1C, 1, 2),
        (0x1E, 4, 4),
        (0x1F, 0, 0),
    ];
    for (function, min, max) in lengths {
        for len in 0..=8 {
            let frame = DataFrame::new(0x20 | function, &[0; 8][..len]).expect("a frame");
            let refused = DecodeError::Length {
                function: FunctionCode::from_can_id(function),
                min: min as u8,
                max: max as u8,
                actual: len as u8,
            };
            let is_refused = Request::decode(&frame, &Dialect::V1_6A) == Err(refused);
            assert_eq!(is_refused, !(min..=max).contains(&len), "{frame}");
        }
    }
}

#[test]
fn a_byte_that_means_nothing_is_named_with_those_that_do() {
    for (id, expected) in [
        (0x20, [0xAB, 0xAB]),
        (0x2E, [0x1B, 0x1E]),
        (0x38, [0xFF, 0xEE]),
        (0x39, [0x00, 0xFF]),
        (0x3B, [0xFE, 0xFE]),
    ] {
        let frame = DataFrame::new(id, &[0x55]).expect("a frame");
        let magic = DecodeError::Magic {
            function: FunctionCode::from_can_id(id),
            expected,
            actual: 0x55,
        };
        assert_eq!(Request::decode(&frame, &Dialect::V1_6A), Err(magic));
    }
}

#[test]
fn a_number_in_more_bytes_than_it_needs_is_refused_only_where_asked() {
    let strict = Dialect {
        strict_minimal: true,
        ..Dialect::V1_6A
    };
    let request = Request::GoRelativePosPtp(counts(5));
    for (data, is_shortest) in [(&[5][..], true), (&[0, 5], false), (&[0, 0, 0, 5], false)] {
        let frame = DataFrame::new(0x23, data).expect("a frame");
        assert_eq!(
            Request::decode(&frame, &Dialect::V1_6A),
            Ok((DRIVE_1, request))
        );
        let too_long = DecodeError::NotShortest {
            function: FunctionCode::GoRelativePosPtp,
            expected: 1,
            actual: data.len() as u8,
        };
        let expected = if is_shortest {
            Ok((DRIVE_1, request))
        } else {
            Err(too_long)
        };
        assert_eq!(Request::decode(&frame, &strict), expected);
    }
}

fn replies() -> Vec<(Reply, u16, &'static [u8], Option<ReplyKind>)> {
    let group_1 = ParamGroup1 {
        main_gain: MainGain::new(45).expect("a gain"),
        speed_gain: SpeedGain::new(1).expect("a gain"),
        integration_gain: IntegrationGain::new(3).expect("a gain"),
        torque_filter: TorqueFilter::new(127).expect("a filter"),
    };
    let group_2 = ParamGroup2 {
        max_speed: MaxSpeed::new(48).expect("a speed"),
        max_acceleration: MaxAcceleration::new(30).expect("an acceleration"),
    };
    let group_3 = ParamGroup3 {
        on_pos_range: OnPosRange::new(93).expect("a range"),
        gear_number: GearNumber::new(5_043).expect("a gear"),
        line_number: LineNumber::new(3_083).ok(),
    };
    let torque = Torque {
        raw: -157,
        full_scale: TorqueFullScale::Raw981,
        positive: Rotation::Clockwise,
    };
    let id = StoredDriveId::new(1).expect("an id");
    let status = DriveStatus::from_byte(0x21);
    vec![
        (Reply::DriveId(id), 0x26, &[1], Some(ReplyKind::DriveId)),
        (
            Reply::DriveConfig(ConfigByte::from_byte(0x2D)),
            0x28,
            &[0x2D],
            Some(ReplyKind::DriveConfig),
        ),
        (
            Reply::DriveStatus(status),
            0x29,
            &[0x21],
            Some(ReplyKind::DriveStatus),
        ),
        (
            Reply::Position(-8_388_609),
            0x2E,
            &[0xFF, 0x7F, 0xFF, 0xFF],
            Some(ReplyKind::Position),
        ),
        (
            Reply::Torque(torque),
            0x2E,
            &[0xFF, 0x63],
            Some(ReplyKind::Torque),
        ),
        (
            Reply::ParamGroup1(group_1),
            0x33,
            &[45, 1, 3, 127],
            Some(ReplyKind::ParamGroup1),
        ),
        (
            Reply::ParamGroup2(group_2),
            0x34,
            &[48, 30],
            Some(ReplyKind::ParamGroup2),
        ),
        (
            Reply::ParamGroup3(group_3),
            0x35,
            &[0x5D, 0x00, 0xB3, 0x13, 0x0B, 0x0C],
            Some(ReplyKind::ParamGroup3),
        ),
        (
            Reply::MotorSpeed(-2),
            0x3A,
            &[0xFF, 0xFE],
            Some(ReplyKind::MotorSpeed),
        ),
        (
            Reply::DriveReset(0xFE),
            0x3B,
            &[0xFE],
            Some(ReplyKind::DriveReset),
        ),
        (
            Reply::Echo([1, 2, 3, 0xFF]),
            0x3E,
            &[1, 2, 3, 0xFF],
            Some(ReplyKind::Echo),
        ),
        (
            Reply::DiagnosticCounter(127),
            0x3F,
            &[127],
            Some(ReplyKind::DiagnosticCounter),
        ),
        (Reply::DriveError(DriveError::Alarm), 0x3D, &[0xEE], None),
    ]
}

#[test]
fn every_reply_is_its_bytes() {
    let dialect = &Dialect::V1_6A;
    for (reply, id, data, kind) in replies() {
        let frame = DataFrame::new(id, data).expect("a frame");
        assert_eq!(reply.encode(DRIVE_1, dialect), frame, "{reply:?}");
        assert_eq!(Reply::decode(&frame, kind, dialect), Ok((DRIVE_1, reply)));
        // Who missed the request can read it all the same, but for the two that look alike.
        let alone = Reply::decode(&frame, None, dialect);
        let expected = match reply {
            Reply::Position(_) | Reply::Torque(_) => Err(DecodeError::SelectorUnknown),
            _ => Ok((DRIVE_1, reply)),
        };
        assert_eq!(alone, expected);
    }
}

#[test]
fn every_reply_has_a_number_of_bytes_and_no_other() {
    for (reply, id, data, kind) in replies() {
        let most = match reply {
            Reply::Position(_) => 4,
            Reply::Torque(_) => 2,
            _ => data.len(),
        };
        let least = if matches!(reply, Reply::Position(_) | Reply::Torque(_)) {
            1
        } else {
            most
        };
        for len in 0..=8 {
            let mut bytes = data.to_vec();
            bytes.resize(len, 1);
            let frame = DataFrame::new(id, &bytes).expect("a frame");
            let decoded = Reply::decode(&frame, kind, &Dialect::V1_6A);
            let is_length = matches!(decoded, Err(DecodeError::Length { .. }));
            assert_eq!(is_length, !(least..=most).contains(&len), "{reply:?} {len}");
        }
    }
}

#[test]
fn a_reply_to_something_else_is_not_taken() {
    let frame = DataFrame::new(0x29, &[0x21]).expect("a frame");
    for kind in [ReplyKind::DriveConfig, ReplyKind::Position] {
        let unexpected = DecodeError::Unexpected {
            expected: kind.function(),
            actual: FunctionCode::ReadDriveStatus,
        };
        let decoded = Reply::decode(&frame, Some(kind), &Dialect::V1_6A);
        assert_eq!(decoded, Err(unexpected));
    }
}

#[test]
fn the_length_of_a_reply_tells_the_revision() {
    let revisions = [4, 5, 6, 7].map(Revision::from_group3_reply_len);
    let (old, new) = (Some(Revision::V1_2A), Some(Revision::V1_6A));
    assert_eq!(revisions, [None, old, new, None]);
    assert_eq!(
        format!("{} {}", Revision::V1_2A, Revision::V1_6A),
        "1.2A 1.6A"
    );
}

#[test]
fn an_id_as_stored_is_that_of_a_drive_unless_it_is_0() {
    let stored = StoredDriveId::new(63).expect("an id");
    assert_eq!((stored.get(), stored.drive_id()), (63, Some(DriveId::MAX)));
    assert_eq!(StoredDriveId::NONE.drive_id(), None);
    assert_eq!(format!("{stored} {}", StoredDriveId::NONE), "63 0");
}

#[test]
fn errors_of_a_drive_are_named() {
    let text = |byte| format!("{}", DriveError::from_byte(byte));
    assert_eq!(text(0xFF), "data error");
    assert_eq!(text(0xEE), "alarm");
    assert_eq!(text(0x12), "undocumented error 0x12");
}

#[test]
fn a_drive_with_an_empty_origin_command_takes_no_byte() {
    let empty = Dialect {
        set_origin: SetOriginData::Empty,
        ..Dialect::V1_6A
    };
    let (none, one) = (&[][..], &[0xAB][..]);
    let decode = |data| Request::decode(&DataFrame::new(0x20, data).expect("a frame"), &empty);
    assert_eq!(decode(none), Ok((DRIVE_1, Request::SetOrigin)));
    assert!(matches!(
        decode(one),
        Err(DecodeError::Length { max: 0, .. })
    ));
}

#[test]
fn what_every_drive_would_hear_is_refused_unless_it_may_be_broadcast() {
    let trigger = DataFrame::new(0x18, &[0xEE]).expect("a frame");
    let request = Request::SyncTrigger(SyncKind::Relative);
    let decoded = Request::decode(&trigger, &Dialect::V1_6A);
    assert_eq!(decoded, Ok((Address::Broadcast, request)));
    let disable = DataFrame::new(0x19, &[0xFF]).expect("a frame");
    let refused = DecodeError::Broadcast {
        function: FunctionCode::ServoDisable,
    };
    let decoded = Request::decode(&disable, &Dialect::V1_6A);
    assert_eq!(decoded, Err(refused));
}

#[test]
fn a_position_has_its_function_and_length_whatever_the_dialect_says_of_numbers() {
    let strict = Dialect {
        strict_minimal: true,
        ..Dialect::V1_6A
    };
    let lsb_first = Dialect {
        number_order: ByteOrder::LsbFirst,
        ..Dialect::V1_6A
    };
    for dialect in [Dialect::V1_6A, strict, lsb_first] {
        for (id, len) in [
            (0x2E, 0),
            (0x2E, 5),
            (0x2E, 8),
            (0x2F, 1),
            (0x2F, 5),
            (0x29, 1),
        ] {
            let frame = DataFrame::new(id, &[1; 8][..len]).expect("a frame");
            let decoded = Reply::decode(&frame, Some(ReplyKind::Position), &dialect);
            assert!(decoded.is_err(), "{frame}: {decoded:?}");
        }
        let frame = DataFrame::new(0x2E, &[5]).expect("a frame");
        let decoded = Reply::decode(&frame, Some(ReplyKind::Position), &dialect);
        assert_eq!(decoded, Ok((DRIVE_1, Reply::Position(5))));
    }
}
