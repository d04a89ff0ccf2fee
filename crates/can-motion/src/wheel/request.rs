//! What goes to a wheel in the gaps of the cycle.

use zlac8030l::{DataFrame, NmtCommand, NmtRequest, NodeId, SdoRequest};

use crate::core::facts::Brake;

/// What a transfer is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// The checks of the drive.
    Check,
    /// Whether the motor has power, while no feedback says so.
    Power,
    /// The holding brake.
    Brake(Brake),
    /// A procedure of the application.
    Procedure,
}

/// Something that goes out in the gaps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WheelRequest {
    /// A command of network management.
    Nmt(NmtCommand),
    /// The start of a transfer.
    Transfer(Purpose, SdoRequest),
    /// The abort of a transfer that was given up.
    Abort(SdoRequest),
}

impl WheelRequest {
    pub(super) fn encode(self, node: NodeId) -> DataFrame {
        match self {
            Self::Nmt(command) => NmtRequest {
                command,
                node: Some(node),
            }
            .encode(),
            Self::Transfer(_, request) | Self::Abort(request) => request.encode(node),
        }
    }
}
