//! NMT state, boot-up and heartbeat (CiA 301).
//!
//! Specification: pre-operational follows boot-up; the heartbeat counts from when its time was written.

use super::ZlacDrive;
use super::objects;
use super::outbox::Message;

/// State byte of a heartbeat.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NodeState {
    /// Without power, or not yet started.
    Down {
        starts_ns: u64,
    },
    Stopped,
    Operational,
    PreOperational,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Network {
    state: NodeState,
    heartbeat_ns: Option<u64>,
}

impl Network {
    pub(super) fn starting_at(starts_ns: u64) -> Self {
        Self {
            state: NodeState::Down { starts_ns },
            heartbeat_ns: None,
        }
    }

    pub(super) fn is_up(&self) -> bool {
        !matches!(self.state, NodeState::Down { .. })
    }

    pub(super) fn state(&self) -> NodeState {
        self.state
    }

    pub(super) fn starts_by(&self, now_ns: u64) -> bool {
        matches!(self.state, NodeState::Down { starts_ns } if starts_ns <= now_ns)
    }

    /// Pre-operational, with the boot-up message. A stored heartbeat starts at once.
    pub(super) fn boot(&mut self, now_ns: u64, node: u16) -> Message {
        self.state = NodeState::PreOperational;
        self.heartbeat_ns = Some(now_ns);
        (0x700 + node, vec![0x00])
    }

    pub(super) fn next_event_ns(&self) -> Option<u64> {
        match self.state {
            NodeState::Down { starts_ns } => Some(starts_ns),
            _ => self.heartbeat_ns,
        }
    }

    /// The heartbeat time was written.
    pub(super) fn restart_heartbeat(&mut self, now_ns: u64, period_ms: u32) {
        self.heartbeat_ns = (period_ms != 0).then_some(now_ns + u64::from(period_ms) * super::MS);
    }

    pub(super) fn heartbeat_due(
        &mut self,
        now_ns: u64,
        node: u16,
        period_ms: u32,
    ) -> Option<Message> {
        if !self.is_up() || self.heartbeat_ns? > now_ns {
            return None;
        }
        self.restart_heartbeat(now_ns, period_ms);
        self.heartbeat_ns?;
        let state = match self.state {
            NodeState::Down { .. } => return None,
            NodeState::Stopped => 0x04,
            NodeState::Operational => 0x05,
            NodeState::PreOperational => 0x7F,
        };
        Some((0x700 + node, vec![state]))
    }
}

impl ZlacDrive {
    pub(super) fn obey_nmt(&mut self, now_ns: u64, data: &[u8]) {
        let [command, node] = *data else { return };
        if node != 0 && u16::from(node) != self.node() {
            return;
        }
        match command {
            0x01 => self.network.state = NodeState::Operational,
            0x02 => self.network.state = NodeState::Stopped,
            0x80 => self.network.state = NodeState::PreOperational,
            0x81 => self.cut_power(now_ns, 0),
            0x82 => {
                let frame = self.network.boot(now_ns, self.node());
                self.outbox.at_once(now_ns, frame);
            }
            _ => {}
        }
        let operational = self.network.state == NodeState::Operational;
        self.process_data
            .restart(now_ns, operational, &self.memory, &self.config);
    }

    pub(super) fn heartbeat_written(&mut self, now_ns: u64) {
        self.network
            .restart_heartbeat(now_ns, self.memory.get(objects::HEARTBEAT));
    }
}
