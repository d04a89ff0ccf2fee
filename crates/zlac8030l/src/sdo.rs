//! Expedited SDO, both directions: read and write of one object of at most 4 bytes (guide section 3.3; CiA 301).
//!
//! Eight bytes always: command specifier, index, sub-index, four data bytes. Every other specifier belongs to segmented or block
//! transfer, which no object of this drive needs, and is refused.

use core::fmt;

use can_frame::DataFrame;

use crate::abort::AbortCode;
use crate::error::DecodeError;
use crate::frame::{self, exactly, node_of};
use crate::node::{NodeId, SDO_REPLY, SDO_REQUEST, Service};
use crate::object::{ObjectAddress, ObjectData};

/// Read an object; its reply is 43h and friends.
const READ: u8 = 0x40;
/// The reply to a write.
const WRITTEN: u8 = 0x60;
/// Transfer aborted, either side.
const ABORT: u8 = 0x80;
/// Write of 4 bytes; the unused bytes are counted in bits 2 and 3.
const WRITE: u8 = 0x23;
/// Reply to a read with 4 bytes; not printed in the guide, CiA 301 (Z33).
const VALUE: u8 = 0x43;
/// Reply to a read that leaves the size open (CiA 301).
const VALUE_OF_OPEN_SIZE: u8 = 0x42;
/// Where an expedited specifier counts its unused bytes.
const UNUSED_BITS: u8 = 0b1100;

/// Master to drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SdoRequest {
    /// 40: read.
    Read(ObjectAddress),
    /// 2F, 2B, 27, 23: write 1, 2, 3, 4 bytes.
    Write(ObjectAddress, ObjectData),
    /// 80: the master gives the transfer up.
    Abort(ObjectAddress, AbortCode),
}

/// Drive to master.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SdoReply {
    /// 4F, 4B, 47, 43: the value read; 42: its size is that of the object.
    Value(ObjectAddress, ObjectData),
    /// 60: written.
    Written(ObjectAddress),
    /// 80: the drive refuses.
    Abort(ObjectAddress, AbortCode),
}

impl SdoRequest {
    /// The object it is about.
    #[must_use]
    pub const fn address(&self) -> ObjectAddress {
        match *self {
            Self::Read(address) | Self::Write(address, _) | Self::Abort(address, _) => address,
        }
    }

    /// The frame to a drive; unused bytes are 0 (Z2).
    #[must_use]
    pub const fn encode(&self, node: NodeId) -> DataFrame {
        let service = Service::SdoRequest(node);
        match *self {
            Self::Read(address) => compose(service, READ, address, 0),
            Self::Write(address, data) => {
                compose(service, sized(WRITE, data.len()), address, data.raw())
            }
            Self::Abort(address, code) => compose(service, ABORT, address, code.get()),
        }
    }

    /// A request as a drive hears it. What lies in the unused bytes is ignored (Z2).
    ///
    /// # Errors
    /// [`DecodeError`] for another service, a length other than 8, and specifiers that are not expedited.
    pub const fn decode(frame: &DataFrame) -> Result<(NodeId, Self), DecodeError> {
        let node = match node_of(frame, SDO_REQUEST) {
            Ok(node) => node,
            Err(error) => return Err(error),
        };
        let bytes = match exactly(frame, 8) {
            Ok(bytes) => bytes,
            Err(error) => return Err(error),
        };
        let (specifier, address, raw) = split(bytes);
        let request = match specifier {
            READ => Self::Read(address),
            ABORT => Self::Abort(address, AbortCode::new(raw)),
            _ if specifier & !UNUSED_BITS == WRITE => {
                Self::Write(address, ObjectData::from_raw(raw, size(specifier)))
            }
            actual => return Err(DecodeError::Specifier { actual }),
        };
        Ok((node, request))
    }
}

impl SdoReply {
    /// The object it is about.
    #[must_use]
    pub const fn address(&self) -> ObjectAddress {
        match *self {
            Self::Value(address, _) | Self::Written(address) | Self::Abort(address, _) => address,
        }
    }

    /// The frame of a drive; unused bytes are 0.
    #[must_use]
    pub const fn encode(&self, node: NodeId) -> DataFrame {
        let service = Service::SdoReply(node);
        match *self {
            Self::Value(address, data) if data.has_open_size() => {
                compose(service, VALUE_OF_OPEN_SIZE, address, data.raw())
            }
            Self::Value(address, data) => {
                compose(service, sized(VALUE, data.len()), address, data.raw())
            }
            Self::Written(address) => compose(service, WRITTEN, address, 0),
            Self::Abort(address, code) => compose(service, ABORT, address, code.get()),
        }
    }

    /// A reply as the master hears it.
    ///
    /// # Errors
    /// [`DecodeError`] for another service, a length other than 8, and specifiers that are not expedited.
    pub const fn decode(frame: &DataFrame) -> Result<(NodeId, Self), DecodeError> {
        match (node_of(frame, SDO_REPLY), Self::content(frame)) {
            (Ok(node), Ok(reply)) => Ok((node, reply)),
            (Err(error), _) | (_, Err(error)) => Err(error),
        }
    }

    /// What an SDO frame of a drive says, whoever the drive is.
    pub(crate) const fn content(frame: &DataFrame) -> Result<Self, DecodeError> {
        let bytes = match exactly(frame, 8) {
            Ok(bytes) => bytes,
            Err(error) => return Err(error),
        };
        let (specifier, address, raw) = split(bytes);
        let reply = match specifier {
            WRITTEN => Self::Written(address),
            VALUE_OF_OPEN_SIZE => Self::Value(address, ObjectData::of_open_size(raw)),
            ABORT => Self::Abort(address, AbortCode::new(raw)),
            _ if specifier & !UNUSED_BITS == VALUE => {
                Self::Value(address, ObjectData::from_raw(raw, size(specifier)))
            }
            actual => return Err(DecodeError::Specifier { actual }),
        };
        Ok(reply)
    }
}

/// The object that bytes 1 to 3 of an SDO frame name, whatever its specifier.
pub(crate) const fn address_of(frame: &DataFrame) -> ObjectAddress {
    split(*frame.bytes()).1
}

const fn sized(specifier: u8, len: u8) -> u8 {
    specifier | 4_u8.wrapping_sub(len) << 2 & UNUSED_BITS
}

const fn size(specifier: u8) -> u8 {
    4 - ((specifier & UNUSED_BITS) >> 2)
}

const fn split(bytes: [u8; 8]) -> (u8, ObjectAddress, u32) {
    let [specifier, index_low, index_high, sub, a, b, c, d] = bytes;
    let address = ObjectAddress::new(u16::from_le_bytes([index_low, index_high]), sub);
    (specifier, address, u32::from_le_bytes([a, b, c, d]))
}

const fn compose(service: Service, specifier: u8, address: ObjectAddress, raw: u32) -> DataFrame {
    let [index_low, index_high] = address.index.to_le_bytes();
    let [a, b, c, d] = raw.to_le_bytes();
    frame::compose(
        service,
        8,
        [specifier, index_low, index_high, address.sub, a, b, c, d],
    )
}

impl fmt::Display for SdoRequest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read(address) => write!(f, "read {address}"),
            Self::Write(address, data) => write!(f, "write {address} = 0x{:X}", data.raw()),
            Self::Abort(address, code) => write!(f, "abort {address}: {code}"),
        }
    }
}

impl fmt::Display for SdoReply {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Value(address, data) => write!(f, "{address} is 0x{:X}", data.raw()),
            Self::Written(address) => write!(f, "{address} written"),
            Self::Abort(address, code) => write!(f, "{address} refused: {code}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::ObjectValue;

    const TARGET_SPEED: ObjectAddress = ObjectAddress::new(0x60FF, 0);

    fn frame(id: u16, data: [u8; 8]) -> DataFrame {
        DataFrame::new(id, &data).unwrap()
    }

    #[test]
    fn transfers_print_as_what_they_do() {
        let data = 100_i32.to_data();
        let code = AbortCode::VALUE_RANGE;
        let requests = [
            SdoRequest::Read(TARGET_SPEED),
            SdoRequest::Write(TARGET_SPEED, data),
            SdoRequest::Abort(TARGET_SPEED, code),
        ];
        let expected = [
            "read 60FFh:00".into(),
            "write 60FFh:00 = 0x64".into(),
            std::format!("abort 60FFh:00: {code}"),
        ];
        assert_eq!(requests.map(|request| std::format!("{request}")), expected);
        let replies = [
            SdoReply::Value(TARGET_SPEED, data),
            SdoReply::Written(TARGET_SPEED),
            SdoReply::Abort(TARGET_SPEED, code),
        ];
        let expected = [
            "60FFh:00 is 0x64".into(),
            "60FFh:00 written".into(),
            std::format!("60FFh:00 refused: {code}"),
        ];
        assert_eq!(replies.map(|reply| std::format!("{reply}")), expected);
    }

    #[test]
    fn write_and_confirmation_as_printed() {
        // Guide section 3.3: 0x604 23 FF 60 00 64 00 00 00, answered with 60 FF 60 00.
        let request = SdoRequest::Write(TARGET_SPEED, ObjectData::from_raw(100, 4));
        let written = frame(0x604, [0x23, 0xFF, 0x60, 0, 0x64, 0, 0, 0]);
        assert_eq!(request.encode(NodeId::FACTORY), written);
        assert_eq!(SdoRequest::decode(&written), Ok((NodeId::FACTORY, request)));
        let reply = frame(0x584, [0x60, 0xFF, 0x60, 0, 0, 0, 0, 0]);
        assert_eq!(
            SdoReply::decode(&reply),
            Ok((NodeId::FACTORY, SdoReply::Written(TARGET_SPEED)))
        );
    }

    #[test]
    fn each_width_has_its_specifier() {
        let sizes = [
            (1, 0x2F, 0x4F),
            (2, 0x2B, 0x4B),
            (3, 0x27, 0x47),
            (4, 0x23, 0x43),
        ];
        for (len, write, value) in sizes {
            let data = ObjectData::from_raw(0x0102_0304, len);
            let request = SdoRequest::Write(TARGET_SPEED, data);
            assert_eq!(request.encode(NodeId::MIN).data().first(), Some(&write));
            let reply = SdoReply::Value(TARGET_SPEED, data);
            assert_eq!(reply.encode(NodeId::MIN).data().first(), Some(&value));
            assert_eq!(
                SdoReply::decode(&reply.encode(NodeId::MIN)),
                Ok((NodeId::MIN, reply))
            );
        }
    }

    #[test]
    fn a_value_of_open_size_is_accepted_and_comes_back_as_it_was() {
        let frame = frame(0x584, [0x42, 0x6C, 0x60, 0, 0xE8, 0x03, 0, 0]);
        let (node, reply) = SdoReply::decode(&frame).unwrap();
        assert_eq!(node, NodeId::FACTORY);
        match reply {
            SdoReply::Value(address, data) => {
                assert_eq!(address, ObjectAddress::new(0x606C, 0));
                assert_eq!(i32::from_data(data), Ok(1000));
                assert_eq!(u16::from_data(data), Ok(1000));
            }
            other => panic!("{other:?}"),
        }
        assert_eq!(reply.encode(node), frame);
    }

    #[test]
    fn every_specifier_is_known_or_refused() {
        for specifier in 0..=u8::MAX {
            let bytes = [specifier, 0xFF, 0x60, 0, 1, 2, 3, 4];
            let request = SdoRequest::decode(&frame(0x604, bytes));
            let known = matches!(specifier, 0x23 | 0x27 | 0x2B | 0x2F | 0x40 | 0x80);
            assert_eq!(request.is_ok(), known, "request {specifier:02X}");
            let reply = SdoReply::decode(&frame(0x584, bytes));
            let known = matches!(specifier, 0x42 | 0x43 | 0x47 | 0x4B | 0x4F | 0x60 | 0x80);
            assert_eq!(reply.is_ok(), known, "reply {specifier:02X}");
        }
    }

    #[test]
    fn a_short_frame_is_refused_not_read() {
        for len in 0..8 {
            let short = DataFrame::new(0x584, &[0x43, 0x64, 0x60, 0, 1, 2, 3, 4][..len]).unwrap();
            let error = DecodeError::Length {
                can_id: 0x584,
                expected: 8,
                actual: len as u8,
            };
            assert_eq!(SdoReply::decode(&short), Err(error));
        }
    }
}
