//! The codec: every request and reply in both directions, every validated number, every unit.

use dyn_can::{
    Address, Alarm, Amplitude, ByteOrder, CommandMode, ConfigByte, Counts28, DataFrame,
    DecodeError, Dialect, DriveConfig, DriveError, DriveId, DriveStatus, DynFrame, EncodeError,
    FrequencyHz, FunctionCode, GearNumber, Group3ReplyOrder, IntegrationGain, LineNumber, MainGain,
    MaxAcceleration, MaxSpeed, OnPosRange, PdStep, Quantity, Reply, ReplyKind, Request, Revision,
    Rotation, ServoMode, SetOriginData, SpeedGain, SpeedRpm, StepLimit, StoredDriveId, Torque,
    TorqueFilter, TorqueFullScale, ZeroAddress, go_relative_pos_pd, units,
};

use crate::opaque::{self, consume, number};

/// Calls everything once.
pub fn exercise() {
    frames();
    requests();
    replies();
    identifiers();
    numbers();
    bytes();
    conversions();
    moves();
}

/// Calls what turns requests and replies into frames and back, each once, and nothing else.
pub fn messages() {
    let inputs = Inputs::any();
    consume(Request::decode(&inputs.frame, &inputs.dialect));
    consume(Reply::decode(&inputs.frame, inputs.kind, &inputs.dialect));
    consume(inputs.request.encode(inputs.address, &inputs.dialect));
    consume(inputs.reply.encode(inputs.address, &inputs.dialect));
}

/// Takes the inputs of [`messages`] and uses values of the types of its results, and calls none of the codec: what that image has
/// beside it.
pub fn messages_without_codec() {
    let inputs = Inputs::any();
    let request: Result<_, DecodeError> = Ok((inputs.address, inputs.request));
    let reply: Result<_, DecodeError> = Ok((inputs.address, inputs.reply));
    let encoded: Result<_, EncodeError> = Ok(inputs.frame);
    consume(opaque::hide(request));
    consume(opaque::hide(reply));
    consume(opaque::hide(encoded));
    consume(inputs.frame);
    consume((inputs.kind, inputs.dialect));
}

/// What the messages are made of.
struct Inputs {
    frame: DataFrame,
    kind: Option<ReplyKind>,
    dialect: Dialect,
    address: Address,
    request: Request,
    reply: Reply,
}

impl Inputs {
    /// Any, without a call of the codec.
    fn any() -> Self {
        Self {
            frame: any_frame(),
            kind: opaque::hide(Some(ReplyKind::Position)),
            dialect: opaque::hide(Dialect::V1_6A),
            address: opaque::hide(Address::Broadcast),
            request: opaque::hide(Request::SetOrigin),
            reply: opaque::hide(Reply::Position(0)),
        }
    }
}

/// Any frame, without a call of the codec.
fn any_frame() -> DataFrame {
    opaque::hide(DataFrame::from_fields(0, 0, [0; 8]))
}

/// Calls what a cycle needs most: encodes a streamed set-point and decodes a position reply.
pub fn set_point_and_position() {
    let (drive, step) = (opaque::hide(DriveId::MIN), opaque::hide(PdStep::ZERO));
    consume(go_relative_pos_pd(drive, step, ByteOrder::MsbFirst));
    let kind = Some(ReplyKind::Position);
    consume(Reply::decode(&any_frame(), kind, &Dialect::V1_6A));
}

/// The same without the codec: what that image has beside it.
pub fn set_point_and_position_without_codec() {
    consume((opaque::hide(DriveId::MIN), opaque::hide(PdStep::ZERO)));
    consume(any_frame());
    let reply: Result<_, DecodeError> = Ok((Address::Broadcast, Reply::Position(0)));
    consume(opaque::hide(reply));
}

/// Any frame.
pub fn frame() -> Option<DataFrame> {
    let (id, data) = (opaque::bits() as u16, opaque::bytes::<9>());
    let data = data.get(..opaque::word() as usize)?;
    DataFrame::new(id, data).ok()
}

/// Any drive.
pub fn drive() -> DriveId {
    DriveId::new(number()).unwrap_or(DriveId::MIN)
}

/// Any address.
pub fn address() -> Address {
    Address::from_can_id(opaque::bits() as u16)
}

fn rotation() -> Rotation {
    opaque::pick([Rotation::Clockwise, Rotation::CounterClockwise])
}

/// Any reading of the documents.
pub fn dialect() -> Dialect {
    let order = || opaque::pick([ByteOrder::MsbFirst, ByteOrder::LsbFirst]);
    let group3_order = || {
        opaque::pick([
            Group3ReplyOrder::Recognise,
            Group3ReplyOrder::Fixed(order()),
        ])
    };
    Dialect {
        revision: opaque::pick([Revision::V1_2A, Revision::V1_6A]),
        number_order: order(),
        group3_request_order: order(),
        group3_reply_order_1_2a: group3_order(),
        group3_reply_order_1_6a: group3_order(),
        set_origin: opaque::pick([SetOriginData::Empty, SetOriginData::Magic(opaque::byte())]),
        torque_full_scale: full_scale(),
        positive_torque: rotation(),
        read_dummy: opaque::maybe(opaque::byte()),
        accept_beyond_28_bit: opaque::flag(),
        strict_minimal: opaque::flag(),
        zero_address: opaque::pick([
            ZeroAddress::SyncTrigger,
            ZeroAddress::Disable,
            ZeroAddress::DisableAndSpeedZero,
            ZeroAddress::LoneFreshDrive,
        ]),
        allow_assign_zero: opaque::flag(),
    }
}

/// Any request: whatever a frame can hold.
pub fn request() -> Option<Request> {
    let (_, request) = Request::decode(&frame()?, &dialect()).ok()?;
    Some(request)
}

fn full_scale() -> TorqueFullScale {
    opaque::pick([TorqueFullScale::Raw700, TorqueFullScale::Raw981])
}

fn kind() -> ReplyKind {
    opaque::pick([
        ReplyKind::DriveId,
        ReplyKind::DriveConfig,
        ReplyKind::DriveStatus,
        ReplyKind::Position,
        ReplyKind::Torque,
        ReplyKind::ParamGroup1,
        ReplyKind::ParamGroup2,
        ReplyKind::ParamGroup3,
        ReplyKind::MotorSpeed,
        ReplyKind::DriveReset,
        ReplyKind::Echo,
        ReplyKind::DiagnosticCounter,
    ])
}

fn frames() {
    let Some(frame) = frame() else { return };
    consume((frame.id(), frame.len(), frame.address(), frame.function()));
    frame.data().iter().copied().for_each(consume);
    let length = opaque::word() as usize;
    consume(DataFrame::from_parts(
        opaque::word(),
        opaque::flag(),
        opaque::flag(),
        opaque::bytes::<64>().get(..length).unwrap_or(&[]),
    ));
}

fn requests() {
    if let Some(frame) = frame() {
        consume(Request::decode(&frame, &dialect()));
    }
    let Some(request) = request() else { return };
    consume((request.function(), request.reply_kind()));
    consume(request.encode(address(), &dialect()));
    consume(go_relative_pos_pd(
        drive(),
        PdStep::new(number()).unwrap_or(PdStep::ZERO),
        dialect().number_order,
    ));
}

fn replies() {
    let Some(frame) = frame() else { return };
    let Ok((_, reply)) = Reply::decode(&frame, opaque::maybe(kind()), &dialect()) else {
        return;
    };
    consume(reply);
    consume((reply.function(), kind().function()));
    consume(reply.encode(address(), &dialect()));
}

fn identifiers() {
    let function = FunctionCode::from_can_id(opaque::bits() as u16);
    consume(function.name());
    consume(function.admit_request(dialect().revision));
    consume(function.admit_reply(dialect().revision));
    consume((drive().can_id(function), address().can_id(function)));
    consume(address().drive());
    DriveId::all().for_each(consume);
}

fn numbers() {
    consume(DriveId::new(number()));
    consume(StoredDriveId::new(number()).map(StoredDriveId::drive_id));
    consume(Counts28::new(number()));
    consume(SpeedRpm::new(number()));
    consume(Amplitude::new(number()));
    consume(FrequencyHz::new(number()));
    consume(MainGain::new(number()));
    consume(SpeedGain::new(number()));
    consume(IntegrationGain::new(number()));
    consume(LineNumber::new(number()));
    consume(CommandMode::new(number()));
    consume(ServoMode::new(number()));
    if let Ok(limit) = StepLimit::new(number()) {
        consume(PdStep::toward(number(), limit));
    }
    let quantity = opaque::pick([Quantity::PdStep, Quantity::ConfigByte, Quantity::StepLimit]);
    consume((quantity.limits(), quantity.check(number())));
}

fn bytes() {
    let byte = opaque::byte();
    consume(DriveConfig::from_byte(byte).map(DriveConfig::to_byte));
    let config = ConfigByte::from_byte(byte);
    consume((config.config(), config.command_mode(), config.servo_free()));
    consume((config.absolute_mode(), config.servo_mode_code()));
    let status = DriveStatus::from_byte(byte);
    consume((status.alarm(), status.on_position(), status.is_disabled()));
    consume((status.motion_busy(), status.alarm().is_alarm()));
    let alarm = Alarm::from_code(byte);
    consume(DriveStatus::new(opaque::flag(), opaque::flag(), alarm, opaque::flag()).to_byte());
    consume(DriveError::from_byte(byte).to_byte());
    consume(Revision::from_group3_reply_len(opaque::word() as usize));
}

fn conversions() {
    let (gear, x) = (gear(), opaque::float());
    consume((units::gear_ratio(gear), units::gear_number(x)));
    consume(units::command_counts_per_turn(gear));
    consume(units::motor_counts(number(), gear));
    consume(units::command_counts(x, gear));
    consume(units::max_speed_parameter(x, gear));
    consume(units::max_acceleration_parameter(x, gear));
    consume(units::on_position_range(x));
    if let Ok(range) = OnPosRange::new(number()) {
        consume((
            units::on_position_degrees(range),
            range.enables_brake_output(),
        ));
    }
    if let Ok(filter) = TorqueFilter::new(number()) {
        consume(units::torque_filter_rad_s(filter));
    }
    if let Some(torque) = Torque::from_share(x, full_scale(), rotation()) {
        consume((torque.of_peak(), torque.current_a(x)));
    }
}

fn moves() {
    let (Ok(speed), Ok(acceleration)) = (MaxSpeed::new(number()), MaxAcceleration::new(number()))
    else {
        return;
    };
    let gear = gear();
    consume(units::max_speed_rpm(speed, gear));
    consume(units::max_acceleration_rpm_s(acceleration, gear));
    consume(units::soft_start_s(acceleration));
    consume(units::SCurve::new(number(), speed, acceleration, gear));
}

fn gear() -> GearNumber {
    GearNumber::new(number()).unwrap_or(GearNumber::MAX)
}
