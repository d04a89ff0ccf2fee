//! Any frame of this protocol in words: what a bus monitor shows.

use core::fmt;

use can_frame::DataFrame;

use crate::emcy::{Emcy, Sync};
use crate::error::DecodeError;
use crate::nmt::{Heartbeat, NmtRequest};
use crate::node::{NodeId, PdoNumber, Service};
use crate::sdo::{SdoReply, SdoRequest};

/// A message, whoever sent it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Message {
    /// Network management.
    Nmt(NmtRequest),
    /// SYNC.
    Sync,
    /// An emergency message; without node when it came on 080h (Z21).
    Emcy(Option<NodeId>, Emcy),
    /// Process data from a drive. Its meaning is in the mapping and not in the frame.
    Tpdo(NodeId, PdoNumber, DataFrame),
    /// Process data to a drive.
    Rpdo(NodeId, PdoNumber, DataFrame),
    /// An SDO request.
    SdoRequest(NodeId, SdoRequest),
    /// An SDO reply.
    SdoReply(NodeId, SdoReply),
    /// Boot-up or heartbeat.
    Heartbeat(Heartbeat),
}

impl Message {
    /// Reads a frame by its identifier.
    ///
    /// # Errors
    /// [`DecodeError`] with what is wrong.
    pub fn decode(frame: &DataFrame) -> Result<Self, DecodeError> {
        Ok(match Service::of(frame.id())? {
            Service::Nmt => Self::Nmt(NmtRequest::decode(frame)?),
            Service::Sync if frame.len() == 8 => emcy(frame)?,
            Service::Sync => Sync::decode(frame).map(|_| Self::Sync)?,
            Service::Emcy(_) => emcy(frame)?,
            Service::Tpdo(number, node) => Self::Tpdo(node, number, *frame),
            Service::Rpdo(number, node) => Self::Rpdo(node, number, *frame),
            Service::SdoRequest(_) => {
                SdoRequest::decode(frame).map(|(node, request)| Self::SdoRequest(node, request))?
            }
            Service::SdoReply(_) => {
                SdoReply::decode(frame).map(|(node, reply)| Self::SdoReply(node, reply))?
            }
            Service::Heartbeat(_) => Self::Heartbeat(Heartbeat::decode(frame)?),
        })
    }
}

fn emcy(frame: &DataFrame) -> Result<Message, DecodeError> {
    Emcy::decode(frame).map(|(node, emcy)| Message::Emcy(node, emcy))
}

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nmt(NmtRequest {
                command,
                node: Some(node),
            }) => write!(f, "NMT: node {node} {command}"),
            Self::Nmt(NmtRequest {
                command,
                node: None,
            }) => write!(f, "NMT: all nodes {command}"),
            Self::Sync => f.write_str("SYNC"),
            Self::Emcy(Some(node), emcy) => write!(f, "node {node} {emcy}"),
            Self::Emcy(None, emcy) => write!(f, "unknown node {emcy}"),
            Self::Tpdo(node, number, frame) => {
                write!(f, "node {node} TPDO{number} {:02X?}", frame.data())
            }
            Self::Rpdo(node, number, frame) => {
                write!(f, "node {node} RPDO{number} {:02X?}", frame.data())
            }
            Self::SdoRequest(node, request) => write!(f, "node {node} SDO: {request}"),
            Self::SdoReply(node, reply) => write!(f, "node {node} SDO: {reply}"),
            Self::Heartbeat(Heartbeat { node, state }) => write!(f, "node {node} is {state}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn an_emergency_message_on_the_sync_identifier_is_not_a_sync() {
        let frame = DataFrame::new(0x080, &[0; 8]).unwrap();
        assert!(matches!(
            Message::decode(&frame),
            Ok(Message::Emcy(None, _))
        ));
        assert!(Message::decode(&DataFrame::new(0x080, &[1, 2]).unwrap()).is_err());
    }

    #[test]
    fn a_sync_is_read_as_one() {
        let sync = DataFrame::new(0x080, &[]).unwrap();
        assert_eq!(Message::decode(&sync), Ok(Message::Sync));
    }

    proptest! {
        /// What decodes encodes to the same frame, but for unused bytes, which are sent as 0.
        #[test]
        fn any_frame_decodes_or_is_refused(id in 0_u16..=0x7FF, data in proptest::collection::vec(any::<u8>(), 0..=8)) {
            let frame = DataFrame::new(id, &data).unwrap();
            let Ok(message) = Message::decode(&frame) else { return Ok(()) };
            prop_assert_ne!(std::format!("{message}").len(), 0);
            let again = match message {
                Message::Nmt(request) => request.encode(),
                Message::Sync => Sync.encode(),
                Message::Emcy(Some(node), emcy) => emcy.encode(node),
                Message::Emcy(None, _) | Message::Tpdo(..) | Message::Rpdo(..) => frame,
                Message::SdoRequest(node, request) => request.encode(node),
                Message::SdoReply(node, reply) => reply.encode(node),
                Message::Heartbeat(heartbeat) => heartbeat.encode(),
            };
            prop_assert_eq!(Message::decode(&again), Ok(message));
            prop_assert_eq!(again.id(), frame.id());
        }
    }
}
