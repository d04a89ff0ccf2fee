//! Every error, state and fault as the text that a person reads.

use core::fmt::{self, Display, Write};

use can_motion::{Confirmation, EventKind, Limits, MotorLimits, PollKind, ServoMaster, Travel};
use dyn_can::{
    DataFrame, DriveError, DriveId, DriveStatus, FunctionCode, Quantity, Reply, Request,
};
use trajectory::curve::KeyframeMotion;

use crate::codec::{address, dialect, drive, frame, request};
use crate::master::{AXES, axis, config, drive_move, gear, group, keyframes, now, procedure, run};
use crate::opaque::{self, consume, number, word};

/// Says everything once.
pub fn exercise() {
    codec();
    serial();
    configuration();
    run(tell);
}

/// Takes text byte by byte.
struct Sink;

impl Write for Sink {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().for_each(consume);
        Ok(())
    }
}

fn say(text: impl Display) {
    consume(write!(Sink, "{text}"));
}

fn say_error<T>(result: Result<T, impl Display>) {
    if let Err(error) = result {
        say(error);
    }
}

fn codec() {
    say_error(DriveId::new(number()));
    say_error(DataFrame::from_parts(
        word(),
        opaque::flag(),
        opaque::flag(),
        &[0; 9],
    ));
    if let Some(frame) = frame() {
        say(frame);
        say_error(Request::decode(&frame, &dialect()));
        say_error(Reply::decode(&frame, None, &dialect()));
    }
    if let Some(request) = request() {
        say_error(request.encode(address(), &dialect()));
    }
    say(address());
    say(drive());
    say(dialect().revision);
    say(FunctionCode::from_can_id(opaque::bits() as u16));
    say(DriveError::from_byte(opaque::byte()));
    say(DriveStatus::from_byte(opaque::byte()).alarm());
    say(opaque::pick([Quantity::PdStep, Quantity::StepLimit]));
}

fn serial() {
    use crate::serial::{dialect, packet};
    say(opaque::hide(dyn_serial::Failure::NoReply { attempts: 1 }));
    say(opaque::hide(dyn_serial::Busy::Outstanding));
    say(opaque::hide(dyn_serial::Address::All));
    say_error(dyn_serial::Packet::parse(&opaque::bytes::<9>()));
    say_error(dyn_serial::SpeedRpm::new(number()));
    let Some(packet) = packet() else { return };
    say(packet);
    say_error(dyn_serial::Request::decode(&packet, &dialect()));
    say_error(dyn_serial::Reply::decode(&packet));
    if let Ok((to, request)) = dyn_serial::Request::decode(&packet, &dialect()) {
        say(request.function());
        say_error(request.encode(to, &dialect()));
    }
    let status = dyn_serial::DriveStatus::from_byte(opaque::byte());
    say(status.alarm());
}

fn configuration() {
    let axes = [(); AXES].map(|()| axis());
    say_error(ServoMaster::<AXES>::new(config(), &axes));
    let motor = MotorLimits {
        speed_rpm: word(),
        acceleration_rpm_per_s: word(),
    };
    say_error(Limits::of_motor(motor, Travel::WHOLE, gear(), word()));
    say_error(KeyframeMotion::new(&keyframes()));
    say(opaque::pick(PollKind::ALL));
    say(now());
}

fn tell(master: &mut ServoMaster<AXES>) {
    if let Some(snapshot) = master.snapshot(word() as usize) {
        say(snapshot.state);
        snapshot.fault.into_iter().for_each(say);
    }
    say_error(master.set_target(word() as usize, number()));
    say_error(master.start_move(now(), word() as usize, drive_move()));
    say_error(master.start_moves(now(), &[(word() as usize, drive_move())]));
    say_error(master.enable(now(), group()));
    say_error(master.adopt(now(), group()));
    say_error(master.clear(now(), group()));
    if let Some(procedure) = procedure() {
        say_error(master.start(now(), word() as usize, procedure, Confirmation::None));
    }
    match master.next_event().map(|event| event.kind) {
        Some(EventKind::Fault(fault)) => say(fault),
        Some(EventKind::BadReply(error)) => say(error),
        Some(EventKind::NotOurs(error)) => say(error),
        _ => {}
    }
}
