//! Every request and every reply under every reading of the documents: what may be encoded comes back, what may not is refused for the
//! reason that the dialect gives.

use std::collections::HashSet;

use dyn_can::{
    Address, Alarm, Amplitude, ByteOrder, CommandMode, ConfigByte, Counts28, DecodeError, Dialect,
    DriveConfig, DriveError, DriveId, DriveStatus, DynFrame, EncodeError, FrequencyHz,
    FunctionCode, GearNumber, Group3ReplyOrder, LineNumber, OnPosRange, ParamGroup1, ParamGroup2,
    ParamGroup3, PdStep, RangeError, ReadSelector, Reply, ReplyKind, Request, Revision, Rotation,
    ServoMode, ServoSwitch, SetOriginData, SetParamGroup1, SetParamGroup2, SetParamGroup3,
    SpeedRpm, StoredDriveId, SyncKind, Torque, TorqueFullScale, ZeroAddress, go_relative_pos_pd,
};
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;
use proptest::sample::select;
use proptest::strategy::{Union, ValueTree};
use proptest::test_runner::TestRunner;

/// Any value of a ranged type, its limits more often than chance would give them.
fn number<T>(min: i32, max: i32) -> BoxedStrategy<T>
where
    T: TryFrom<i32, Error = RangeError> + std::fmt::Debug + 'static,
{
    let value = prop_oneof![8 => min..=max, 1 => Just(min), 1 => Just(max)];
    value
        .prop_map(|value| T::try_from(value).expect("the strategy knows the limits"))
        .boxed()
}

/// A parameter 1 ..= 127.
fn parameter<T>() -> BoxedStrategy<T>
where
    T: TryFrom<i32, Error = RangeError> + std::fmt::Debug + 'static,
{
    number(1, 127)
}

/// Lengths 1 to 4 with equal weight: a uniform 28-bit number hardly ever fits fewer than 4 bytes.
fn counts_28() -> BoxedStrategy<Counts28> {
    prop_oneof![
        number(-128, 127),
        number(-32_768, 32_767),
        number(-8_388_608, 8_388_607),
        number(-134_217_728, 134_217_727),
    ]
    .boxed()
}

fn stored_drive_id() -> impl Strategy<Value = StoredDriveId> {
    (0..=63).prop_map(|id| StoredDriveId::new(id).expect("the strategy knows the limits"))
}

fn gear() -> BoxedStrategy<GearNumber> {
    number(500, 16_384)
}

fn line() -> BoxedStrategy<LineNumber> {
    number(500, 4_095)
}

fn drive() -> BoxedStrategy<DriveId> {
    number(1, 63)
}

fn address() -> impl Strategy<Value = Address> {
    prop_oneof![4 => drive().prop_map(Address::Drive), 1 => Just(Address::Broadcast)]
}

fn byte_order() -> impl Strategy<Value = ByteOrder> {
    select(vec![ByteOrder::MsbFirst, ByteOrder::LsbFirst])
}

fn dialect() -> impl Strategy<Value = Dialect> {
    let orders = (
        byte_order(),
        byte_order(),
        option::of(byte_order()),
        option::of(byte_order()),
    );
    let positive_torque = select(vec![Rotation::Clockwise, Rotation::CounterClockwise]);
    let data = (option::of(any::<u8>()), option::of(any::<u8>()));
    let full_scale = select(vec![TorqueFullScale::Raw700, TorqueFullScale::Raw981]);
    let permissions = select(vec![
        ZeroAddress::SyncTrigger,
        ZeroAddress::Disable,
        ZeroAddress::DisableAndSpeedZero,
        ZeroAddress::LoneFreshDrive,
    ]);
    let revision = select(vec![Revision::V1_2A, Revision::V1_6A]);
    (
        revision,
        orders,
        data,
        (full_scale, positive_torque),
        permissions,
        any::<[bool; 3]>(),
    )
        .prop_map(
            |(
                revision,
                orders,
                (magic, read_dummy),
                (torque_full_scale, positive_torque),
                zero_address,
                [wide, strict, assign],
            )| Dialect {
                revision,
                number_order: orders.0,
                group3_request_order: orders.1,
                group3_reply_order_1_2a: orders
                    .2
                    .map_or(Group3ReplyOrder::Recognise, Group3ReplyOrder::Fixed),
                group3_reply_order_1_6a: orders
                    .3
                    .map_or(Group3ReplyOrder::Recognise, Group3ReplyOrder::Fixed),
                set_origin: magic.map_or(SetOriginData::Empty, SetOriginData::Magic),
                torque_full_scale,
                positive_torque,
                read_dummy,
                accept_beyond_28_bit: wide,
                strict_minimal: strict,
                zero_address,
                allow_assign_zero: assign,
            },
        )
}

fn drive_config() -> impl Strategy<Value = DriveConfig> {
    let command_mode = vec![
        CommandMode::Rs232,
        CommandMode::CwCcw,
        CommandMode::PulseDirection,
        CommandMode::Analog,
    ];
    let servo_mode = vec![ServoMode::Position, ServoMode::Speed, ServoMode::Torque];
    (
        select(command_mode),
        any::<bool>(),
        select(servo_mode),
        any::<bool>(),
    )
        .prop_map(
            |(command_mode, absolute_mode, servo_mode, servo_free)| DriveConfig {
                command_mode,
                absolute_mode,
                servo_mode,
                servo_free,
            },
        )
}

fn set_group_1() -> impl Strategy<Value = SetParamGroup1> {
    (
        option::of(parameter()),
        option::of(parameter()),
        option::of(parameter()),
        option::of(parameter()),
    )
        .prop_map(
            |(main_gain, speed_gain, integration_gain, torque_filter)| SetParamGroup1 {
                main_gain,
                speed_gain,
                integration_gain,
                torque_filter,
            },
        )
}

fn set_group_2() -> impl Strategy<Value = SetParamGroup2> {
    (option::of(parameter()), option::of(parameter())).prop_map(|(max_speed, max_acceleration)| {
        SetParamGroup2 {
            max_speed,
            max_acceleration,
        }
    })
}

fn set_group_3() -> impl Strategy<Value = SetParamGroup3> {
    (
        option::of(parameter::<OnPosRange>()),
        option::of(gear()),
        option::of(line()),
    )
        .prop_map(|(on_pos_range, gear_number, line_number)| SetParamGroup3 {
            on_pos_range,
            gear_number,
            line_number,
        })
}

fn request() -> impl Strategy<Value = Request> {
    let plain = vec![
        Request::SetOrigin,
        Request::ReadDriveId,
        Request::ReadDriveConfig,
        Request::ReadDriveStatus,
        Request::ReadParamGroup1,
        Request::ReadParamGroup2,
        Request::ReadParamGroup3,
        Request::ReadMotorSpeed,
        Request::DriveReset,
        Request::DiagnosticCounter,
    ];
    let amplitude = || number::<Amplitude>(0, 4_096);
    Union::new([
        select(plain).boxed(),
        counts_28().prop_map(Request::GoAbsolutePosPtp).boxed(),
        counts_28().prop_map(Request::MakeLinearLine).boxed(),
        counts_28().prop_map(Request::GoRelativePosPtp).boxed(),
        counts_28().prop_map(Request::MakeCircularArc).boxed(),
        stored_drive_id().prop_map(Request::AssignDriveId).boxed(),
        drive_config().prop_map(Request::SetDriveConfig).boxed(),
        number::<SpeedRpm>(-20_000, 20_000)
            .prop_map(Request::TurnConstSpeed)
            .boxed(),
        Just(Request::TurnConstSpeed(SpeedRpm::ZERO)).boxed(),
        amplitude().prop_map(Request::SquareWave).boxed(),
        amplitude().prop_map(Request::SinWave).boxed(),
        number::<FrequencyHz>(0, 50)
            .prop_map(Request::SsFrequency)
            .boxed(),
        select(vec![ReadSelector::Position, ReadSelector::Torque])
            .prop_map(Request::GeneralRead)
            .boxed(),
        set_group_1().prop_map(Request::SetParamGroup1).boxed(),
        set_group_2().prop_map(Request::SetParamGroup2).boxed(),
        set_group_3().prop_map(Request::SetParamGroup3).boxed(),
        counts_28().prop_map(Request::GoAbsolutePosSync).boxed(),
        counts_28().prop_map(Request::GoRelativePosSync).boxed(),
        select(vec![SyncKind::Absolute, SyncKind::Relative])
            .prop_map(Request::SyncTrigger)
            .boxed(),
        select(vec![ServoSwitch::Enable, ServoSwitch::Disable])
            .prop_map(Request::ServoDisable)
            .boxed(),
        number::<PdStep>(-16_384, 16_384)
            .prop_map(Request::GoRelativePosPd)
            .boxed(),
        any::<[u8; 4]>().prop_map(Request::EchoFunction).boxed(),
    ])
}

fn status() -> impl Strategy<Value = DriveStatus> {
    let parts = (any::<[bool; 3]>(), 0..8_u8).prop_map(|([on_position, disabled, busy], alarm)| {
        DriveStatus::new(on_position, disabled, Alarm::from_code(alarm), busy)
    });
    prop_oneof![parts, any::<u8>().prop_map(DriveStatus::from_byte)]
}

fn position(dialect: &Dialect) -> BoxedStrategy<i32> {
    let legal = counts_28().prop_map(Counts28::get);
    if dialect.accept_beyond_28_bit {
        prop_oneof![legal, any::<i32>()].boxed()
    } else {
        legal.boxed()
    }
}

fn group_1() -> impl Strategy<Value = ParamGroup1> {
    (parameter(), parameter(), parameter(), parameter()).prop_map(
        |(main_gain, speed_gain, integration_gain, torque_filter)| ParamGroup1 {
            main_gain,
            speed_gain,
            integration_gain,
            torque_filter,
        },
    )
}

fn group_3() -> impl Strategy<Value = ParamGroup3> {
    (parameter(), gear(), option::of(line())).prop_map(
        |(on_pos_range, gear_number, line_number)| ParamGroup3 {
            on_pos_range,
            gear_number,
            line_number,
        },
    )
}

/// Also beyond its scale.
fn torque(full_scale: TorqueFullScale, positive: Rotation) -> impl Strategy<Value = Torque> {
    any::<i16>().prop_map(move |raw| Torque {
        raw,
        full_scale,
        positive,
    })
}

/// A reply that a drive of this dialect may send, with the kind that its request awaits.
fn reply(dialect: &Dialect) -> impl Strategy<Value = (Option<ReplyKind>, Reply)> + use<> {
    let of = |kind: ReplyKind, replies: BoxedStrategy<Reply>| {
        replies.prop_map(move |reply| (Some(kind), reply)).boxed()
    };
    let group_2 =
        (parameter(), parameter()).prop_map(|(max_speed, max_acceleration)| ParamGroup2 {
            max_speed,
            max_acceleration,
        });
    let error = any::<u8>().prop_map(|byte| Reply::DriveError(DriveError::from_byte(byte)));
    Union::new([
        of(
            ReplyKind::DriveId,
            stored_drive_id().prop_map(Reply::DriveId).boxed(),
        ),
        of(
            ReplyKind::DriveConfig,
            any::<u8>()
                .prop_map(|byte| Reply::DriveConfig(ConfigByte::from_byte(byte)))
                .boxed(),
        ),
        of(
            ReplyKind::DriveStatus,
            status().prop_map(Reply::DriveStatus).boxed(),
        ),
        of(
            ReplyKind::Position,
            position(dialect).prop_map(Reply::Position).boxed(),
        ),
        of(
            ReplyKind::Torque,
            torque(dialect.torque_full_scale, dialect.positive_torque)
                .prop_map(Reply::Torque)
                .boxed(),
        ),
        of(
            ReplyKind::ParamGroup1,
            group_1().prop_map(Reply::ParamGroup1).boxed(),
        ),
        of(
            ReplyKind::ParamGroup2,
            group_2.prop_map(Reply::ParamGroup2).boxed(),
        ),
        of(
            ReplyKind::ParamGroup3,
            group_3().prop_map(Reply::ParamGroup3).boxed(),
        ),
        of(
            ReplyKind::MotorSpeed,
            any::<i16>().prop_map(Reply::MotorSpeed).boxed(),
        ),
        of(
            ReplyKind::DriveReset,
            any::<u8>().prop_map(Reply::DriveReset).boxed(),
        ),
        of(
            ReplyKind::Echo,
            any::<[u8; 4]>().prop_map(Reply::Echo).boxed(),
        ),
        of(
            ReplyKind::DiagnosticCounter,
            any::<u8>().prop_map(Reply::DiagnosticCounter).boxed(),
        ),
        error.prop_map(|reply| (None, reply)).boxed(),
    ])
}

/// A group 3 of 1.2A whose two numbers are others in the other byte order, and within their ranges too (D21).
fn fits_both_orders(reply: &Reply, dialect: &Dialect) -> bool {
    let recognises = dialect.revision == Revision::V1_2A
        && dialect.group3_reply_order_1_2a == Group3ReplyOrder::Recognise;
    let Reply::ParamGroup3(group) = reply else {
        return false;
    };
    let gear = group.gear_number.get();
    let line = group.line_number.map_or(0, LineNumber::get);
    let (other_gear, other_line) = (gear.swap_bytes(), line.swap_bytes());
    recognises
        && (gear, line) != (other_gear, other_line)
        && (500..=16_384).contains(&other_gear)
        && (other_line == 0 || (500..=4_095).contains(&other_line))
}

fn dialect_and_reply() -> impl Strategy<Value = (Dialect, Option<ReplyKind>, Reply)> {
    dialect().prop_flat_map(|dialect| {
        reply(&dialect).prop_map(move |(kind, reply)| (dialect, kind, reply))
    })
}

/// The refusal that the readings of the documents ask for, written down independently of the codec.
fn expected_refusal(request: &Request, to: Address, dialect: &Dialect) -> Option<&'static str> {
    let missing = match dialect.revision {
        Revision::V1_2A => matches!(request, Request::DriveReset),
        Revision::V1_6A => matches!(
            request,
            Request::MakeLinearLine(_) | Request::MakeCircularArc(_)
        ),
    };
    let disables = *request == Request::ServoDisable(ServoSwitch::Disable);
    let brakes = matches!(request, Request::TurnConstSpeed(speed) if speed.get() == 0);
    let triggers = matches!(request, Request::SyncTrigger(_));
    let broadcast_allowed = match dialect.zero_address {
        ZeroAddress::SyncTrigger => triggers,
        ZeroAddress::Disable => disables || triggers,
        ZeroAddress::DisableAndSpeedZero => disables || brakes || triggers,
        ZeroAddress::LoneFreshDrive => true,
    };
    if missing {
        Some("revision")
    } else if to == Address::Broadcast && !broadcast_allowed {
        Some("broadcast")
    } else if *request == Request::AssignDriveId(StoredDriveId::NONE) && !dialect.allow_assign_zero
    {
        Some("range")
    } else {
        None
    }
}

fn refusal(error: EncodeError) -> &'static str {
    match error {
        EncodeError::Refused(_) => "revision",
        EncodeError::Broadcast { .. } => "broadcast",
        EncodeError::Range(_) => "range",
        _ => "unknown",
    }
}

proptest! {
    // A failing input is printed; there is no source file beside which it could be stored.
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_request_comes_back_or_is_refused(request in request(), to in address(), dialect in dialect()) {
        match request.encode(to, &dialect) {
            Ok(frame) => {
                prop_assert_eq!(expected_refusal(&request, to, &dialect), None);
                prop_assert_eq!(frame.address(), to);
                prop_assert_eq!(frame.function(), request.function());
                prop_assert_eq!(Request::decode(&frame, &dialect), Ok((to, request)));
            }
            Err(error) => prop_assert_eq!(expected_refusal(&request, to, &dialect), Some(refusal(error))),
        }
    }

    #[test]
    fn a_reply_comes_back((dialect, kind, reply) in dialect_and_reply(), from in address()) {
        let frame = reply.encode(from, &dialect);
        let decoded = Reply::decode(&frame, kind, &dialect);
        if matches!(reply, Reply::DriveReset(_)) && dialect.revision == Revision::V1_2A {
            prop_assert!(matches!(decoded, Err(DecodeError::Refused(_))));
        } else if fits_both_orders(&reply, &dialect) {
            prop_assert!(matches!(decoded, Err(DecodeError::OrderUnknown { .. })), "{:?}", decoded);
        } else {
            prop_assert_eq!(decoded, Ok((from, reply)));
        }
    }

    #[test]
    fn the_hot_path_makes_the_same_frame(drive in drive(), step in number::<PdStep>(-16_384, 16_384), dialect in dialect()) {
        let frame = Request::GoRelativePosPd(step).encode(Address::Drive(drive), &dialect);
        prop_assert_eq!(frame, Ok(go_relative_pos_pd(drive, step, dialect.number_order)));
    }

    #[test]
    fn any_frame_decodes_without_panic_and_stays_what_it_was(
        id in 0..0x800_u16, data in vec(any::<u8>(), 0..=8), dialect in dialect(),
    ) {
        let frame = dyn_can::DataFrame::new(id, &data).expect("11-bit identifier, at most 8 bytes");
        if let Ok((to, request)) = Request::decode(&frame, &dialect) {
            let encoded = request.encode(to, &dialect).expect("what decodes may be sent");
            prop_assert!(encoded.len() <= frame.len() || dialect.read_dummy.is_some());
            prop_assert_eq!(Request::decode(&encoded, &dialect), Ok((to, request)));
        }
        if let Ok((from, reply)) = Reply::decode(&frame, None, &dialect) {
            let encoded = reply.encode(from, &dialect);
            prop_assert!(encoded.len() <= frame.len());
            prop_assert_eq!(Reply::decode(&encoded, None, &dialect), Ok((from, reply)));
        }
    }
}

/// The function codes that a strategy reaches in enough samples to reach all.
fn functions<S: Strategy>(
    strategy: S,
    function: impl Fn(S::Value) -> FunctionCode,
) -> HashSet<FunctionCode> {
    let mut runner = TestRunner::deterministic();
    (0..5_000)
        .map(|_| {
            function(
                strategy
                    .new_tree(&mut runner)
                    .expect("nothing is filtered")
                    .current(),
            )
        })
        .collect()
}

#[test]
fn the_strategies_leave_no_message_out() {
    let requests = functions(request(), |request| request.function());
    let replies = functions(dialect_and_reply(), |(_, _, reply)| reply.function());
    for function in FunctionCode::ALL {
        let admitted = |admit: fn(FunctionCode, Revision) -> bool| {
            admit(function, Revision::V1_2A) || admit(function, Revision::V1_6A)
        };
        let is_request = admitted(|function, revision| function.admit_request(revision).is_ok());
        let is_reply = admitted(|function, revision| function.admit_reply(revision).is_ok());
        assert_eq!(
            requests.contains(&function),
            is_request,
            "request {function}"
        );
        assert_eq!(replies.contains(&function), is_reply, "reply {function}");
    }
}
