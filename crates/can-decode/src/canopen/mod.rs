//! CANopen of ZLAC8030L hub-motor drives: who says what, with the objects in PDOs as far as the mapping was heard.
//!
//! Requests and replies have identifiers of their own here, so a frame alone tells its side. What needs the conversation is the time from an
//! SDO request to its reply, a reply that nobody asked for, and the content of a PDO: its mapping is in the SDO traffic of the set-up,
//! written or read back.

mod message;
#[cfg(test)]
mod tests;

use std::collections::HashMap;

use zlac8030l::{
    DataFrame, MAX_ENTRIES, MappingEntry, NodeId, PdoDirection, PdoMapping, PdoNumber, PdoObjects,
    SdoReply, SdoRequest,
};

use crate::conversation::{Conversation, since};
use crate::frame::Frame;
pub use message::{Message, Note};

/// The mapping of one PDO as it was heard: number of objects, and their words.
#[derive(Debug, Clone, Copy, Default)]
struct Heard {
    count: Option<u8>,
    words: [Option<u32>; MAX_ENTRIES],
}

impl Heard {
    /// The mapping, once all of it was heard.
    fn mapping(&self) -> Option<PdoMapping> {
        let words = self.words.get(..usize::from(self.count?))?;
        let entries: Option<Vec<MappingEntry>> = words
            .iter()
            .map(|word| word.map(MappingEntry::from_word))
            .collect();
        PdoMapping::new(&entries?)
            .ok()
            .filter(|mapping| !mapping.is_empty())
    }
}

/// The conversation with all CANopen drives on a bus.
#[derive(Debug, Clone, Default)]
pub struct Canopen {
    /// The SDO request that waits for its reply, and when it ended, by node.
    open: HashMap<NodeId, (SdoRequest, Option<u64>)>,
    /// By node and index of the mapping object.
    mappings: HashMap<(NodeId, u16), Heard>,
}

impl Canopen {
    /// Notes what a transfer tells of a mapping.
    fn note_mapping(&mut self, node: NodeId, index: u16, sub: u8, raw: u32) {
        if !matches!(index, 0x1600..=0x1603 | 0x1A00..=0x1A03) {
            return;
        }
        let heard = self.mappings.entry((node, index)).or_default();
        match usize::from(sub).checked_sub(1) {
            None => heard.count = Some(raw as u8),
            Some(place) => {
                if let Some(word) = heard.words.get_mut(place) {
                    *word = Some(raw);
                }
            }
        }
    }

    fn mapping(
        &self,
        node: NodeId,
        direction: PdoDirection,
        number: PdoNumber,
    ) -> Option<PdoMapping> {
        let index = PdoObjects::new(direction, number).count().address().index;
        self.mappings.get(&(node, index))?.mapping()
    }

    fn hear_request(
        &mut self,
        at_ns: Option<u64>,
        node: NodeId,
        request: SdoRequest,
    ) -> Option<Note> {
        if let SdoRequest::Write(address, data) = request {
            self.note_mapping(node, address.index, address.sub, data.raw());
        }
        let before = match request {
            SdoRequest::Abort(..) => {
                self.open.remove(&node);
                return Some(Note::GivenUp);
            }
            SdoRequest::Read(_) | SdoRequest::Write(..) => self.open.insert(node, (request, at_ns)),
        };
        before.map(|(_, asked_ns)| Note::NoReply {
            after_ns: since(at_ns, asked_ns),
        })
    }

    fn hear_reply(
        &mut self,
        at_ns: Option<u64>,
        node: NodeId,
        reply: SdoReply,
    ) -> (Option<u64>, Option<Note>) {
        if let SdoReply::Value(address, data) = reply {
            self.note_mapping(node, address.index, address.sub, data.raw());
        }
        let refused = matches!(reply, SdoReply::Abort(..)).then_some(Note::Refused);
        match self.open.get(&node) {
            Some((request, asked_ns)) if request.address() == reply.address() => {
                let response_ns = since(at_ns, *asked_ns);
                self.open.remove(&node);
                (response_ns, refused)
            }
            Some(_) => (None, Some(Note::AnotherObject)),
            None => (None, Some(Note::Unasked)),
        }
    }
}

impl Conversation for Canopen {
    type Message = Message;

    fn hear(&mut self, at_ns: Option<u64>, frame: &Frame) -> Option<Message> {
        let parts = DataFrame::from_parts(
            frame.id(),
            frame.is_extended(),
            frame.is_remote(),
            frame.data(),
        );
        let frame = parts.ok()?;
        let content = match zlac8030l::Message::decode(&frame) {
            Ok(content) => content,
            Err(error) => return Some(Message::undecodable(&frame, error)),
        };
        let mut message = Message::new(content);
        match content {
            zlac8030l::Message::SdoRequest(node, request) => {
                message.note = self.hear_request(at_ns, node, request);
            }
            zlac8030l::Message::SdoReply(node, reply) => {
                (message.response_ns, message.note) = self.hear_reply(at_ns, node, reply);
            }
            zlac8030l::Message::Tpdo(node, number, _) => {
                message.carry(self.mapping(node, PdoDirection::Transmit, number), &frame);
            }
            zlac8030l::Message::Rpdo(node, number, _) => {
                message.carry(self.mapping(node, PdoDirection::Receive, number), &frame);
            }
            _ => {}
        }
        Some(message)
    }
}
