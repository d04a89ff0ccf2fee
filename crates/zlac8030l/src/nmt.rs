//! Network management: commands to the drives, boot-up and heartbeat from them (guide sections 3.2, 3.4, 6; CiA 301).

use core::fmt;

use can_frame::DataFrame;

use crate::error::DecodeError;
use crate::frame::{compose, exactly, node_of};
use crate::node::{HEARTBEAT, NodeId, Service};

/// A command of the NMT master. The guide shows start and pre-operational; the others are CiA 301.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum NmtCommand {
    /// 01: operational, PDOs run.
    Start = 0x01,
    /// 02: stopped, nothing but NMT and heartbeat.
    Stop = 0x02,
    /// 80: pre-operational, SDO without PDO.
    PreOperational = 0x80,
    /// 81: as after power-on.
    ResetNode = 0x81,
    /// 82: communication objects as after power-on.
    ResetCommunication = 0x82,
}

/// An NMT frame: a command to one node or to all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NmtRequest {
    /// What to do.
    pub command: NmtCommand,
    /// Who; `None` for every node on the bus.
    pub node: Option<NodeId>,
}

impl NmtRequest {
    /// The frame.
    #[must_use]
    pub const fn encode(&self) -> DataFrame {
        let node = match self.node {
            Some(node) => node.get(),
            None => 0,
        };
        compose(
            Service::Nmt,
            2,
            [self.command as u8, node, 0, 0, 0, 0, 0, 0],
        )
    }

    /// An NMT frame as a drive hears it.
    ///
    /// # Errors
    /// [`DecodeError`] for another service, a length other than 2, an unknown command and nodes beyond 127.
    pub const fn decode(frame: &DataFrame) -> Result<Self, DecodeError> {
        if frame.id() != Service::Nmt.can_id() {
            return Err(DecodeError::Service { can_id: frame.id() });
        }
        let [command, number, ..] = match exactly(frame, 2) {
            Ok(bytes) => bytes,
            Err(error) => return Err(error),
        };
        let command = match command {
            0x01 => NmtCommand::Start,
            0x02 => NmtCommand::Stop,
            0x80 => NmtCommand::PreOperational,
            0x81 => NmtCommand::ResetNode,
            0x82 => NmtCommand::ResetCommunication,
            actual => return Err(DecodeError::NmtCommand { actual }),
        };
        let node = match NodeId::new(number as i32) {
            Ok(node) => Some(node),
            Err(_) if number == 0 => None,
            Err(_) => return Err(DecodeError::NmtNode { actual: number }),
        };
        Ok(Self { command, node })
    }
}

/// State of a node, as its heartbeat tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum NmtState {
    /// 00: sent once after power-on or reset.
    BootUp = 0x00,
    /// 04: stopped.
    Stopped = 0x04,
    /// 05: operational.
    Operational = 0x05,
    /// 7F: pre-operational.
    PreOperational = 0x7F,
}

/// A boot-up or heartbeat frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Heartbeat {
    /// Who sent it.
    pub node: NodeId,
    /// Its state.
    pub state: NmtState,
}

impl Heartbeat {
    /// The frame of a drive.
    #[must_use]
    pub const fn encode(&self) -> DataFrame {
        compose(
            Service::Heartbeat(self.node),
            1,
            [self.state as u8, 0, 0, 0, 0, 0, 0, 0],
        )
    }

    /// A heartbeat as the master hears it. The toggle bit of node guarding is no heartbeat and is refused.
    ///
    /// # Errors
    /// [`DecodeError`] for another service, node 0, a length other than 1, and an unknown state.
    pub const fn decode(frame: &DataFrame) -> Result<Self, DecodeError> {
        let node = match node_of(frame, HEARTBEAT) {
            Ok(node) => node,
            Err(error) => return Err(error),
        };
        let [state, ..] = match exactly(frame, 1) {
            Ok(bytes) => bytes,
            Err(error) => return Err(error),
        };
        let state = match state {
            0x00 => NmtState::BootUp,
            0x04 => NmtState::Stopped,
            0x05 => NmtState::Operational,
            0x7F => NmtState::PreOperational,
            actual => return Err(DecodeError::NmtState { actual }),
        };
        Ok(Self { node, state })
    }
}

impl fmt::Display for NmtCommand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Start => "start",
            Self::Stop => "stop",
            Self::PreOperational => "enter pre-operational",
            Self::ResetNode => "reset node",
            Self::ResetCommunication => "reset communication",
        })
    }
}

impl fmt::Display for NmtState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BootUp => "boot-up",
            Self::Stopped => "stopped",
            Self::Operational => "operational",
            Self::PreOperational => "pre-operational",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn start_of_node_4_as_printed() {
        let request = NmtRequest {
            command: NmtCommand::Start,
            node: Some(NodeId::FACTORY),
        };
        let frame = DataFrame::new(0x000, &[0x01, 0x04]).unwrap();
        assert_eq!(request.encode(), frame);
        assert_eq!(NmtRequest::decode(&frame), Ok(request));
    }

    #[test]
    fn every_command_and_state_byte_is_known_or_refused() {
        for byte in 0..=u8::MAX {
            let nmt = NmtRequest::decode(&DataFrame::new(0, &[byte, 1]).unwrap());
            assert_eq!(nmt.is_ok(), matches!(byte, 1 | 2 | 0x80..=0x82));
            let heartbeat = Heartbeat::decode(&DataFrame::new(0x704, &[byte]).unwrap());
            assert_eq!(heartbeat.is_ok(), matches!(byte, 0 | 4 | 5 | 0x7F));
        }
        assert_eq!(
            NmtRequest::decode(&DataFrame::new(0, &[1, 128]).unwrap()),
            Err(DecodeError::NmtNode { actual: 128 })
        );
    }

    #[test]
    fn node_0_is_every_node() {
        let frame = DataFrame::new(0x000, &[0x80, 0]).unwrap();
        let request = NmtRequest {
            command: NmtCommand::PreOperational,
            node: None,
        };
        assert_eq!(request.encode(), frame);
        assert_eq!(NmtRequest::decode(&frame), Ok(request));
    }

    #[test]
    fn commands_and_states_are_named_as_in_cia_301() {
        let commands = [
            NmtCommand::Start,
            NmtCommand::Stop,
            NmtCommand::PreOperational,
            NmtCommand::ResetNode,
            NmtCommand::ResetCommunication,
        ];
        assert_eq!(
            commands.map(|command| std::format!("{command}")),
            [
                "start",
                "stop",
                "enter pre-operational",
                "reset node",
                "reset communication"
            ]
        );
        let states = [
            NmtState::BootUp,
            NmtState::Stopped,
            NmtState::Operational,
            NmtState::PreOperational,
        ];
        assert_eq!(
            states.map(|state| std::format!("{state}")),
            ["boot-up", "stopped", "operational", "pre-operational"]
        );
    }
}
