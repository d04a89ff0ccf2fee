//! One CANopen message in its conversation.

use core::fmt::{self, Display as _};

use serde::ser::{Serialize, SerializeStruct, Serializer};
use zlac8030l::{
    CanopenFrame, DataFrame, DecodeError, FaultCode, Heartbeat, MAX_ENTRIES, MappingEntry,
    NmtState, NodeId, ObjectAddress, ObjectData, PdoMapping, SdoReply, SdoRequest, Service,
    StatusWord, dictionary, objects,
};

use crate::conversation::Direction;

/// Nanoseconds of a millisecond.
const MS: f64 = 1e6;

/// A frame in its conversation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Message {
    /// What it says; an error when it is no message.
    content: Result<zlac8030l::Message, DecodeError>,
    /// The service of its identifier.
    service: Option<Service>,
    /// The objects of a PDO with their values, where its mapping was heard.
    objects: [Option<(MappingEntry, ObjectData)>; MAX_ENTRIES],
    /// Time from the SDO request to this reply.
    pub(super) response_ns: Option<u64>,
    /// What is remarkable about it.
    pub(super) note: Option<Note>,
}

/// What is remarkable about a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Note {
    /// The drive refuses.
    Refused,
    /// The master gave the transfer up.
    GivenUp,
    /// An SDO reply that nobody asked for: late, or repeated.
    Unasked,
    /// An SDO reply about another object than the one that was asked for.
    AnotherObject,
    /// The request before this one had no reply.
    NoReply {
        /// Time since then in nanoseconds, when it is known.
        after_ns: Option<u64>,
    },
    /// The PDO is not as long as its mapping.
    Length,
}

impl Message {
    pub(super) fn new(content: zlac8030l::Message) -> Self {
        Self {
            content: Ok(content),
            service: service_of(&content),
            objects: [None; MAX_ENTRIES],
            response_ns: None,
            note: None,
        }
    }

    pub(super) fn undecodable(frame: &DataFrame, error: DecodeError) -> Self {
        Self {
            content: Err(error),
            service: frame.service().ok(),
            objects: [None; MAX_ENTRIES],
            response_ns: None,
            note: None,
        }
    }

    /// Takes the values of a PDO apart, when its mapping is known.
    pub(super) fn carry(&mut self, mapping: Option<PdoMapping>, frame: &DataFrame) {
        let Some(mapping) = mapping else { return };
        let Ok(values) = mapping.values(frame) else {
            self.note = Some(Note::Length);
            return;
        };
        for (place, (entry, value)) in self.objects.iter_mut().zip(mapping.entries().zip(values)) {
            *place = value.map(|value| (entry, value));
        }
    }

    /// Whether the frame could not be read as a message.
    #[must_use]
    pub fn is_undecodable(&self) -> bool {
        self.content.is_err()
    }

    /// Whether someone who looks for trouble wants to see it.
    #[must_use]
    pub fn is_remarkable(&self) -> bool {
        self.note.is_some()
            || match self.content {
                Err(_) => true,
                Ok(zlac8030l::Message::Emcy(_, emergency)) => emergency.error_code != 0,
                Ok(zlac8030l::Message::Heartbeat(heartbeat)) => heartbeat.state == NmtState::BootUp,
                Ok(_) => self.tells_a_fault(),
            }
    }

    fn tells_a_fault(&self) -> bool {
        let fault = objects::FAULT_CODE.address();
        self.values()
            .any(|(address, data)| address == fault && data.raw() != 0)
    }

    /// The node that sent or gets it; `None` for a message to all.
    #[must_use]
    pub fn node(&self) -> Option<u8> {
        match self.content {
            Ok(zlac8030l::Message::Nmt(request)) => request.node.map(NodeId::get),
            _ => match self.service? {
                Service::Nmt | Service::Sync => None,
                Service::Emcy(node)
                | Service::Tpdo(_, node)
                | Service::Rpdo(_, node)
                | Service::SdoReply(node)
                | Service::SdoRequest(node)
                | Service::Heartbeat(node) => Some(node.get()),
            },
        }
    }

    /// The service by its usual name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self.service {
            None => "",
            Some(Service::Nmt) => "NMT",
            Some(Service::Sync) => "SYNC",
            Some(Service::Emcy(_)) => "EMCY",
            Some(Service::Tpdo(..)) => "TPDO",
            Some(Service::Rpdo(..)) => "RPDO",
            Some(Service::SdoReply(_)) => "SDO reply",
            Some(Service::SdoRequest(_)) => "SDO request",
            Some(Service::Heartbeat(_)) => "heartbeat",
        }
    }

    /// Which side sent it.
    #[must_use]
    pub fn direction(&self) -> Option<Direction> {
        Some(match self.service? {
            Service::Nmt | Service::Sync | Service::Rpdo(..) | Service::SdoRequest(_) => {
                Direction::ToDrive
            }
            Service::Emcy(_) | Service::Tpdo(..) | Service::SdoReply(_) | Service::Heartbeat(_) => {
                Direction::FromDrive
            }
        })
    }

    /// Time from the SDO request to this reply in nanoseconds.
    #[must_use]
    pub fn response_ns(&self) -> Option<u64> {
        self.response_ns
    }

    /// The objects whose values it tells.
    fn values(&self) -> impl Iterator<Item = (ObjectAddress, ObjectData)> {
        let single = match self.content {
            Ok(zlac8030l::Message::SdoRequest(_, SdoRequest::Write(address, data)))
            | Ok(zlac8030l::Message::SdoReply(_, SdoReply::Value(address, data))) => {
                Some((address, data))
            }
            _ => None,
        };
        let mapped = self.objects.iter().flatten();
        single
            .into_iter()
            .chain(mapped.map(|(entry, data)| (entry.address, *data)))
    }
}

/// The service that a message belongs to.
fn service_of(message: &zlac8030l::Message) -> Option<Service> {
    use zlac8030l::Message as M;
    Some(match *message {
        M::Nmt(_) => Service::Nmt,
        M::Sync => Service::Sync,
        M::Emcy(node, _) => Service::Emcy(node?),
        M::Tpdo(node, number, _) => Service::Tpdo(number, node),
        M::Rpdo(node, number, _) => Service::Rpdo(number, node),
        M::SdoRequest(node, _) => Service::SdoRequest(node),
        M::SdoReply(node, _) => Service::SdoReply(node),
        M::Heartbeat(Heartbeat { node, .. }) => Service::Heartbeat(node),
    })
}

/// An object by its name, with its value in its unit.
struct Value(ObjectAddress, ObjectData);

impl Value {
    /// The number in the sign of its type.
    fn number(&self) -> i64 {
        dictionary::find(self.0)
            .and_then(|entry| entry.data_type.value(self.1).ok())
            .unwrap_or(i64::from(self.1.raw()))
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (address, raw) = (self.0, self.1.raw());
        match dictionary::find(address) {
            _ if address == objects::STATUS_WORD.address() => {
                write!(f, "status {}", StatusWord::new(raw as u16))
            }
            _ if address == objects::FAULT_CODE.address() => {
                write!(f, "fault {}", FaultCode::new(raw as u16))
            }
            _ if address == objects::CONTROL_WORD.address() => write!(f, "control word {raw:04X}h"),
            // What it counts is in the drive (Z34).
            _ if address == objects::TARGET_SPEED.address() => {
                write!(f, "target speed = {} x 1/n r/min", self.number())
            }
            Some(entry) if entry.unit.is_empty() => write!(f, "{} = {}", entry.name, self.number()),
            Some(entry) => write!(f, "{} = {} x {}", entry.name, self.number(), entry.unit),
            None => write!(f, "{address} = 0x{raw:X}"),
        }
    }
}

/// An object by its address and name.
struct Named(ObjectAddress);

impl fmt::Display for Named {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match dictionary::find(self.0) {
            Some(entry) => write!(f, "{} {}", self.0, entry.name),
            None => self.0.fmt(f),
        }
    }
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fmt_sides(f)?;
        self.fmt_content(f)?;
        if let Some(response_ns) = self.response_ns {
            write!(f, " ({:.3} ms after the request)", response_ns as f64 / MS)?;
        }
        match self.note {
            None | Some(Note::Refused | Note::GivenUp) => Ok(()),
            Some(Note::Unasked) => f.write_str(" - nobody asked: late, or repeated"),
            Some(Note::AnotherObject) => f.write_str(" - another object was asked for"),
            Some(Note::Length) => f.write_str(" - not as long as its mapping"),
            Some(Note::NoReply { after_ns: None }) => {
                f.write_str(" - the request before had no reply")
            }
            Some(Note::NoReply {
                after_ns: Some(after_ns),
            }) => write!(
                f,
                " - the request {:.3} ms before had no reply",
                after_ns as f64 / MS
            ),
        }
    }
}

impl Message {
    fn fmt_sides(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.direction(), self.node()) {
            (Some(side), Some(node)) => {
                write!(f, "{side:4} node {node:<3} {}", self.name())?;
                match self.service {
                    Some(Service::Tpdo(number, _) | Service::Rpdo(number, _)) => {
                        write!(f, " {number}: ")
                    }
                    _ => f.write_str(": "),
                }
            }
            (Some(side), None) => write!(f, "{side:4} all      {}: ", self.name()),
            (None, _) => Ok(()),
        }
    }

    fn fmt_content(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use zlac8030l::Message as M;
        match &self.content {
            Err(error) => error.fmt(f),
            Ok(M::Nmt(request)) => request.command.fmt(f),
            Ok(M::Sync) => f.write_str("now"),
            Ok(M::Emcy(_, emergency)) => emergency.fmt(f),
            Ok(M::Heartbeat(heartbeat)) => heartbeat.state.fmt(f),
            Ok(M::SdoRequest(_, SdoRequest::Read(address))) => {
                write!(f, "read {}", Named(*address))
            }
            Ok(M::SdoRequest(_, SdoRequest::Write(address, data))) => {
                write!(f, "write {address} {}", Value(*address, *data))
            }
            Ok(M::SdoReply(_, SdoReply::Value(address, data))) => {
                write!(f, "{address} {}", Value(*address, *data))
            }
            Ok(M::SdoReply(_, SdoReply::Written(address))) => {
                write!(f, "{} written", Named(*address))
            }
            Ok(
                M::SdoReply(_, SdoReply::Abort(address, code))
                | M::SdoRequest(_, SdoRequest::Abort(address, code)),
            ) => write!(f, "{} aborted: {code}", Named(*address)),
            Ok(M::Tpdo(_, _, frame) | M::Rpdo(_, _, frame)) => self.fmt_values(f, frame),
        }
    }

    fn fmt_values(&self, f: &mut fmt::Formatter<'_>, frame: &DataFrame) -> fmt::Result {
        if self.objects.iter().all(Option::is_none) {
            return write!(f, "{:02X?}, its mapping was not heard", frame.data());
        }
        for (place, (address, data)) in self.values().enumerate() {
            f.write_str(if place == 0 { "" } else { ", " })?;
            Value(address, data).fmt(f)?;
        }
        Ok(())
    }
}

impl Serialize for Message {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Message", 6)?;
        fields.serialize_field("node", &self.node())?;
        fields.serialize_field("direction", &self.direction())?;
        fields.serialize_field("service", self.name())?;
        let objects: Vec<(String, i64)> = self
            .values()
            .map(|(address, data)| (address.to_string(), Value(address, data).number()))
            .collect();
        fields.serialize_field("objects", &objects)?;
        fields.serialize_field("response_ns", &self.response_ns)?;
        fields.serialize_field("remarkable", &self.is_remarkable())?;
        fields.end()
    }
}
