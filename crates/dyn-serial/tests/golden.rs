//! Every message with literal bytes, both ways: DYN2 manual A1.8, sections 7.2 and 7.3, to and from drive 5.

use dyn_serial::{
    Address, Amplitude, ConfigByte, Counts28, DecodeError, Dialect, DriveId, DriveStatus,
    FrequencyHz, GearNumber, IntegrationGain, MainGain, MaxAcceleration, MaxSpeed, OnPosRange,
    Packet, RangeError, ReadSelector, Reply, ReplyFunction as R, Request, RequestFunction,
    SpeedGain, SpeedRpm, TorqueFilter,
};

/// A number that is in its range.
fn of<T>(value: Result<T, RangeError>) -> T {
    value.unwrap_or_else(|error| panic!("{error}"))
}

fn counts(counts: i32) -> Counts28 {
    of(Counts28::new(counts))
}

fn id(id: i32) -> DriveId {
    of(DriveId::new(id))
}

fn config(byte: i32) -> ConfigByte {
    of(ConfigByte::new(byte))
}

/// Request, packet, and the function of what the drive answers.
fn requests() -> Vec<(Request, &'static [u8], Option<R>)> {
    vec![
        (Request::SetOrigin, &[0x05, 0x80, 0x80, 0x85], None),
        (
            Request::GoAbsolutePos(counts(-134_217_728)),
            &[0x05, 0xE1, 0xC0, 0x80, 0x80, 0x80, 0xA6],
            None,
        ),
        (
            Request::MakeLinearLine(counts(100)),
            &[0x05, 0xA2, 0x80, 0xE4, 0x8B],
            None,
        ),
        (
            Request::GoRelativePos(counts(-120)),
            &[0x05, 0xA3, 0xFF, 0x88, 0xAF],
            None,
        ),
        (
            Request::MakeCircularArc(counts(-8_193)),
            &[0x05, 0xC4, 0xFF, 0xBF, 0xFF, 0x86],
            None,
        ),
        (
            Request::AssignDriveId(id(63)),
            &[0x05, 0x85, 0xBF, 0xC9],
            None,
        ),
        (
            Request::ReadDriveId,
            &[0x05, 0x86, 0x80, 0x8B],
            Some(R::IsDriveId),
        ),
        (
            Request::SetDriveConfig(config(0x36)),
            &[0x05, 0x87, 0xB6, 0xC2],
            None,
        ),
        (
            Request::ReadDriveConfig,
            &[0x05, 0x88, 0x80, 0x8D],
            Some(R::IsConfig),
        ),
        (
            Request::ReadDriveStatus,
            &[0x05, 0x89, 0x80, 0x8E],
            Some(R::IsStatus),
        ),
        (
            Request::TurnConstSpeed(of(SpeedRpm::new(-20_000))),
            &[0x05, 0xCA, 0xFE, 0xE3, 0xE0, 0x90],
            None,
        ),
        (
            Request::SquareWave(of(Amplitude::new(64))),
            &[0x05, 0xAB, 0x80, 0xC0, 0xF0],
            None,
        ),
        (
            Request::SinWave(of(Amplitude::new(4_096))),
            &[0x05, 0xAC, 0xA0, 0x80, 0xD1],
            None,
        ),
        (
            Request::SsFrequency(of(FrequencyHz::new(50))),
            &[0x05, 0x8D, 0xB2, 0xC4],
            None,
        ),
        (
            Request::GeneralRead(ReadSelector::Position),
            &[0x05, 0x8E, 0x9B, 0xAE],
            Some(R::IsAbsPos32),
        ),
        (
            Request::GeneralRead(ReadSelector::Torque),
            &[0x05, 0x8E, 0x9E, 0xB1],
            Some(R::IsTrqCurrent),
        ),
        (
            Request::SetMainGain(of(MainGain::new(63))),
            &[0x05, 0x90, 0xBF, 0xD4],
            None,
        ),
        (
            Request::SetSpeedGain(of(SpeedGain::new(127))),
            &[0x05, 0x91, 0xFF, 0x95],
            None,
        ),
        (
            Request::SetIntGain(of(IntegrationGain::new(2))),
            &[0x05, 0x92, 0x82, 0x99],
            None,
        ),
        (
            Request::SetTrqCons(of(TorqueFilter::new(100))),
            &[0x05, 0x93, 0xE4, 0xFC],
            None,
        ),
        (
            Request::SetHighSpeed(of(MaxSpeed::new(127))),
            &[0x05, 0x94, 0xFF, 0x98],
            None,
        ),
        (
            Request::SetHighAccel(of(MaxAcceleration::new(64))),
            &[0x05, 0x95, 0xC0, 0xDA],
            None,
        ),
        (
            Request::SetPosOnRange(of(OnPosRange::new(1))),
            &[0x05, 0x96, 0x81, 0x9C],
            None,
        ),
        (
            Request::SetGearNumber(of(GearNumber::new(500))),
            &[0x05, 0xB7, 0x83, 0xF4, 0xB3],
            None,
        ),
        (
            Request::ReadMainGain,
            &[0x05, 0x98, 0x80, 0x9D],
            Some(R::IsMainGain),
        ),
        (
            Request::ReadSpeedGain,
            &[0x05, 0x99, 0x80, 0x9E],
            Some(R::IsSpeedGain),
        ),
        (
            Request::ReadIntGain,
            &[0x05, 0x9A, 0x80, 0x9F],
            Some(R::IsIntGain),
        ),
        (
            Request::ReadTrqCons,
            &[0x05, 0x9B, 0x80, 0xA0],
            Some(R::IsTrqCons),
        ),
        (
            Request::ReadHighSpeed,
            &[0x05, 0x9C, 0x80, 0xA1],
            Some(R::IsHighSpeed),
        ),
        (
            Request::ReadHighAccel,
            &[0x05, 0x9D, 0x80, 0xA2],
            Some(R::IsHighAccel),
        ),
        (
            Request::ReadPosOnRange,
            &[0x05, 0x9E, 0x80, 0xA3],
            Some(R::IsPosOnRange),
        ),
        (
            Request::ReadGearNumber,
            &[0x05, 0x9F, 0x80, 0xA4],
            Some(R::IsGearNumber),
        ),
    ]
}

#[test]
fn every_request_is_its_bytes() {
    let to = Address::Drive(id(5));
    for (request, bytes, reply) in requests() {
        let packet = of_bytes(bytes);
        assert_eq!(request.encode(to, &Dialect::MANUAL), Ok(packet));
        assert_eq!(
            Request::decode(&packet, &Dialect::MANUAL),
            Ok((to, request))
        );
        assert_eq!(request.reply_function(), reply, "{request:?}");
        assert_eq!(request.function().code(), packet.code());
    }
}

fn of_bytes(bytes: &[u8]) -> Packet {
    Packet::parse(bytes).unwrap_or_else(|error| panic!("{bytes:02X?}: {error}"))
}

#[test]
fn every_reply_is_its_bytes() {
    let replies: &[(Reply, &[u8])] = &[
        (
            Reply::MainGain(of(MainGain::new(127))),
            &[0x05, 0x90, 0xFF, 0x94],
        ),
        (
            Reply::SpeedGain(of(SpeedGain::new(1))),
            &[0x05, 0x91, 0x81, 0x97],
        ),
        (
            Reply::IntegrationGain(of(IntegrationGain::new(63))),
            &[0x05, 0x92, 0xBF, 0xD6],
        ),
        (
            Reply::TorqueFilter(of(TorqueFilter::new(64))),
            &[0x05, 0x93, 0xC0, 0xD8],
        ),
        (
            Reply::MaxSpeed(of(MaxSpeed::new(2))),
            &[0x05, 0x94, 0x82, 0x9B],
        ),
        (
            Reply::MaxAcceleration(of(MaxAcceleration::new(127))),
            &[0x05, 0x95, 0xFF, 0x99],
        ),
        (Reply::DriveId(id(5)), &[0x05, 0x96, 0x85, 0xA0]),
        (
            Reply::OnPosRange(of(OnPosRange::new(64))),
            &[0x05, 0x97, 0xC0, 0xDC],
        ),
        (
            Reply::GearNumber(of(GearNumber::new(500))),
            &[0x05, 0xB8, 0x83, 0xF4, 0xB4],
        ),
        (
            Reply::Status(DriveStatus::from_byte(0x21)),
            &[0x05, 0x99, 0xA1, 0xBF],
        ),
        (Reply::Config(config(0x36)), &[0x05, 0x9A, 0xB6, 0xD5]),
        (
            Reply::Position(counts(-134_217_727)),
            &[0x05, 0xFB, 0xC0, 0x80, 0x80, 0x81, 0xC1],
        ),
        (Reply::Torque(-8_193), &[0x05, 0xDE, 0xFF, 0xBF, 0xFF, 0xA0]),
    ];
    for &(reply, bytes) in replies {
        let packet = of_bytes(bytes);
        assert_eq!(reply.encode(id(5)), packet, "{reply:?}");
        assert_eq!(Reply::decode(&packet), Ok((id(5), reply)));
    }
}

/// The packet of drive 5 with so many data bytes.
fn with_len(code: u8, len: usize) -> Packet {
    let mut bytes = vec![5, 0x80 | (len as u8 - 1) << 5 | code];
    bytes.resize(2 + len, 0x81);
    let sum: u32 = bytes.iter().map(|byte| u32::from(*byte)).sum();
    bytes.push(0x80 | sum as u8 & 0x7F);
    of_bytes(&bytes)
}

#[test]
fn every_request_has_a_number_of_bytes_and_no_other() {
    // Function, the fewest and the most data bytes.
    let lengths = [
        (0x00, 1, 1),
        (0x05, 1, 1),
        (0x06, 1, 1),
        (0x07, 1, 1),
        (0x0a, 1, 3),
        (0x0b, 1, 3),
        (0x0c, 1, 3),
        (0x0d, 1, 3),
        (0x0e, 1, 1),
        (0x10, 1, 1),
        (0x11, 1, 1),
        (0x17, 2, 2),
        (0x18, 1, 1),
        (0x1f, 1, 1),
    ];
    for (code, min, max) in lengths {
        for actual in 1..=4 {
            let packet = with_len(code, usize::from(actual));
            let refused = DecodeError::Length {
                function: RequestFunction::from_code(code).expect("a function").into(),
                min,
                max,
                actual,
            };
            let is_refused = Request::decode(&packet, &Dialect::MANUAL) == Err(refused);
            assert_eq!(is_refused, !(min..=max).contains(&actual), "{packet}");
        }
    }
}

#[test]
fn every_reply_has_a_number_of_bytes_and_no_other() {
    let lengths = [
        (0x10, 1, 1),
        (0x16, 1, 1),
        (0x18, 2, 3),
        (0x19, 1, 1),
        (0x1b, 1, 4),
        (0x1e, 1, 4),
    ];
    for (code, min, max) in lengths {
        for actual in 1..=4 {
            let packet = with_len(code, usize::from(actual));
            let refused = DecodeError::Length {
                function: R::from_code(code).expect("a function").into(),
                min,
                max,
                actual,
            };
            let is_refused = Reply::decode(&packet) == Err(refused);
            assert_eq!(is_refused, !(min..=max).contains(&actual), "{packet}");
        }
    }
}

#[test]
fn only_position_and_torque_are_selected() {
    for code in 0..=u8::MAX {
        let expected = match code {
            0x1B => Some(ReadSelector::Position),
            0x1E => Some(ReadSelector::Torque),
            _ => None,
        };
        assert_eq!(ReadSelector::from_code(code), expected);
    }
    let unknown = of_bytes(&[0x05, 0x8E, 0x9C, 0xAF]);
    let refused = DecodeError::Selector { actual: 0x1C };
    assert_eq!(Request::decode(&unknown, &Dialect::MANUAL), Err(refused));
}

#[test]
fn the_general_id_is_refused_for_what_only_one_drive_may_be_told() {
    let origin = of_bytes(&[0x7F, 0x80, 0x80, 0xFF]);
    let refused = DecodeError::Broadcast {
        function: RequestFunction::SetOrigin,
    };
    assert_eq!(Request::decode(&origin, &Dialect::MANUAL), Err(refused));
    let line = of_bytes(&[0x7F, 0xA2, 0x80, 0xE4, 0x85]);
    let request = Request::MakeLinearLine(counts(100));
    assert_eq!(
        Request::decode(&line, &Dialect::MANUAL),
        Ok((Address::All, request))
    );
}

#[test]
fn a_packet_prints_as_its_bytes() {
    let packet = of_bytes(&[0x08, 0x8A, 0xB2, 0xC4]);
    assert_eq!(
        format!("{packet} {packet:?}"),
        "08 8A B2 C4 Packet(08 8A B2 C4)"
    );
}
