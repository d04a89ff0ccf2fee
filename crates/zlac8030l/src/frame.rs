//! What the frames of CANopen carry: service and node in the identifier, a message in the data.

use can_frame::DataFrame;

use crate::error::DecodeError;
use crate::node::{NodeId, Service};

/// What the identifier of a frame says.
pub trait CanopenFrame {
    /// What the identifier is for.
    ///
    /// # Errors
    /// [`DecodeError::Node`] and [`DecodeError::Service`], see [`Service::of`].
    fn service(&self) -> Result<Service, DecodeError>;
}

impl CanopenFrame for DataFrame {
    fn service(&self) -> Result<Service, DecodeError> {
        Service::of(self.id())
    }
}

/// A message of `len` bytes, at most 8, whose other bytes are zero.
pub(crate) const fn compose(service: Service, len: u8, data: [u8; 8]) -> DataFrame {
    DataFrame::from_fields(service.can_id(), len, data)
}

/// The node of a frame whose identifier is a function code (its upper four bits) and a node.
pub(crate) const fn node_of(frame: &DataFrame, function: u16) -> Result<NodeId, DecodeError> {
    let can_id = frame.id();
    if can_id >> 7 != function {
        return Err(DecodeError::Service { can_id });
    }
    match NodeId::new((can_id & 0x7F) as i32) {
        Ok(node) => Ok(node),
        Err(_) => Err(DecodeError::Node { can_id }),
    }
}

/// All eight bytes of a message that has exactly `expected` of them.
pub(crate) const fn exactly(frame: &DataFrame, expected: u8) -> Result<[u8; 8], DecodeError> {
    if frame.len() != expected {
        return Err(DecodeError::Length {
            can_id: frame.id(),
            expected,
            actual: frame.len(),
        });
    }
    Ok(*frame.bytes())
}
