//! The serial codec: every request and reply in both directions, the stream decoder and the client.

use core::fmt;

use dyn_serial::{
    Address, CircularMove, Client, ConfigByte, Counts28, Decoder, Dialect, DriveId, DriveStatus,
    Dummy, Event, FeedRate, GeneralId, LinearMove, Packet, ParameterForm, Reply, Request,
    RequestFunction, SpeedRpm, Timing, Turn, service,
};
use embedded_io::{ErrorKind, ErrorType, Read, ReadReady, Write};

use crate::opaque::{self, consume, hide, number, reach, reach_mut};

/// Calls everything once.
pub fn exercise() {
    messages();
    numbers();
    moves();
    stream();
    client();
}

/// What a program needs that sends requests and hears packets: its size has a limit.
pub fn encode_and_decode_stream() {
    let dialect = Dialect::MANUAL;
    let request = hide(Request::SetOrigin);
    consume(request.encode(hide(Address::All), reach(&dialect)));
    let mut decoder = Decoder::new();
    consume(reach_mut(&mut decoder).push(opaque::byte()));
}

/// Any bytes that are a packet.
pub fn packet() -> Option<Packet> {
    let bytes = opaque::bytes::<9>();
    Packet::parse(bytes.get(..opaque::word() as usize)?).ok()
}

/// Any reading of the manual.
pub fn dialect() -> Dialect {
    Dialect {
        parameter_form: opaque::pick([ParameterForm::Table, ParameterForm::ShortestSigned]),
        dummy: Dummy::new(number()).unwrap_or(Dummy::MIN),
        general_id: opaque::pick([
            GeneralId::CoordinatedMoves,
            GeneralId::Stop,
            GeneralId::LoneDrive,
        ]),
    }
}

fn messages() {
    consume(Packet::parse(&opaque::bytes::<9>()));
    let Some(packet) = packet() else { return };
    packet.as_bytes().iter().copied().for_each(consume);
    packet.data().iter().copied().for_each(consume);
    consume((packet.start_byte(), packet.code(), packet.data_len()));
    consume((packet.signed(), packet.unsigned()));
    if let Ok((to, request)) = Request::decode(&packet, &dialect()) {
        consume((to, request.function(), request.reply_function()));
        consume(request.encode(to, &dialect()));
    }
    if let Ok((from, reply)) = Reply::decode(&packet) {
        consume((reply.function(), reply.encode(from)));
    }
}

fn numbers() {
    consume(Address::from_start_byte(opaque::byte()));
    DriveId::all().for_each(consume);
    consume(SpeedRpm::new(number()));
    consume(ConfigByte::new(number()).map(ConfigByte::config));
    let status = DriveStatus::from_byte(opaque::byte());
    consume((status.alarm(), status.on_position(), status.is_disabled()));
    consume(RequestFunction::from_code(opaque::byte()).map(RequestFunction::name));
}

fn moves() {
    let counts = || Counts28::new(number()).unwrap_or(Counts28::MIN);
    let feed_rate = FeedRate::new(number()).unwrap_or(FeedRate::MIN);
    let line = LinearMove {
        distances: [counts(), counts(), counts()],
        feed_rate,
    };
    line.packets().into_iter().for_each(consume);
    let arc = CircularMove {
        start: [counts(), counts()],
        end: [counts(), counts()],
        plane: opaque::byte(),
        turn: opaque::pick([Turn::Clockwise, Turn::CounterClockwise]),
        feed_rate,
    };
    arc.packets().into_iter().for_each(consume);
}

fn stream() {
    let mut decoder = hide(Decoder::new());
    let event = decoder.push(opaque::byte());
    if let Some(Event::Truncated(fragment)) = event {
        fragment.as_bytes().iter().copied().for_each(consume);
    }
    consume(event);
    decoder.unfinished().iter().copied().for_each(consume);
    consume((decoder.silence(), *decoder.counters()));
}

fn client() {
    let mut client = hide(Client::new(dialect(), hide(Timing::ONE_DRIVE)));
    let (now_us, request) = (opaque::bits(), hide(Request::SetOrigin));
    consume(client.begin(now_us, hide(Address::All), &request));
    consume(client.receive(opaque::bits(), opaque::byte()));
    consume(client.poll(opaque::bits()));
    consume((*client.line(), *client.traffic()));
    consume(service(&mut client, &mut AnyPort, opaque::bits()).is_ok());
    client.abandon();
    consume(Timing::chain(hide(Timing::ONE_DRIVE.attempts)));
}

/// A port that may do anything, broken contracts included.
struct AnyPort;

#[derive(Debug)]
struct PortError;

impl fmt::Display for PortError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("port error")
    }
}

impl core::error::Error for PortError {}

impl embedded_io::Error for PortError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

impl ErrorType for AnyPort {
    type Error = PortError;
}

impl Read for AnyPort {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, PortError> {
        buffer.iter_mut().for_each(|byte| *byte = opaque::byte());
        any_result(opaque::word() as usize)
    }
}

impl ReadReady for AnyPort {
    fn read_ready(&mut self) -> Result<bool, PortError> {
        any_result(opaque::flag())
    }
}

impl Write for AnyPort {
    fn write(&mut self, buffer: &[u8]) -> Result<usize, PortError> {
        buffer.iter().copied().for_each(consume);
        any_result(opaque::word() as usize)
    }

    fn flush(&mut self) -> Result<(), PortError> {
        any_result(())
    }
}

fn any_result<T>(value: T) -> Result<T, PortError> {
    if opaque::flag() {
        Ok(value)
    } else {
        Err(PortError)
    }
}
