//! One attempt on the wire, from arbitration to delivery.

use super::Bus;
use crate::arbitration::{Contender, resolve};
use crate::fault::{Attempt, AttemptOutcome, Delivery, DeliveryOutcome, FaultModel};
use crate::frame::Frame;
use crate::log::{Outcome, Record};
use crate::node::{Node, NodeId};
use crate::wire::{INTERFRAME_BITS, WireLength};

/// Error frame with the interframe space behind it: 6 bits of error flag, 6 of the flags it provokes, 8 of delimiter, 3 of interframe
/// space. The standard allows 17 to 23 bits; the longest is taken always.
pub const ERROR_FRAME_BITS: u64 = 23;

/// Bits that an error-passive node waits longer after a frame of its own.
pub const SUSPEND_BITS: u64 = 8;

/// Bits of EOF, behind the ACK delimiter.
const EOF_BITS: u32 = 7;

/// Bit in which a start on a disturbed bus fails: the first one behind SOF.
const FIRST_BIT_BEHIND_SOF: u32 = 2;

#[derive(Debug, Clone, Copy)]
pub(crate) struct OnWire {
    start_ns: u64,
    pub(super) end_ns: u64,
    pub(super) free_ns: u64,
    node: NodeId,
    senders: u16,
    frame: Frame,
    outcome: Outcome,
}

/// Who holds the wire after arbitration.
struct Winner {
    attempt: Attempt,
    senders: u16,
    collision_at_bit: Option<u32>,
    /// Indices of nodes that gave up silently; almost always empty, and then without memory.
    silenced: Vec<usize>,
}

impl<F: FaultModel> Bus<F> {
    /// Arbitrates among all nodes that wait at `start_ns` and puts the winner on the wire.
    pub(super) fn start(&mut self, start_ns: u64) {
        self.now_ns = start_ns;
        self.count_recessive_bits(start_ns);
        // There is a winner whenever there is a start; without one nothing would be sent.
        let Some(winner) = self.arbitrate(start_ns) else {
            return;
        };
        let (outcome, bits) = self.judge(&winner);
        let end_ns = start_ns + u64::from(bits) * self.bit_ns;
        let bits_to_idle = if outcome == Outcome::Delivered {
            u64::from(INTERFRAME_BITS)
        } else {
            ERROR_FRAME_BITS
        };
        let free_ns = end_ns + bits_to_idle * self.bit_ns;
        for &index in &winner.silenced {
            self.nodes[index].may_send_from_ns = free_ns + SUSPEND_BITS * self.bit_ns;
        }
        self.begun_busy_ns += free_ns - start_ns;
        let Attempt { node, frame, .. } = winner.attempt;
        self.on_wire = Some(OnWire {
            start_ns,
            end_ns,
            free_ns,
            node,
            senders: winner.senders,
            frame,
            outcome,
        });
    }

    fn arbitrate(&mut self, start_ns: u64) -> Option<Winner> {
        let ready = |node: &Node| {
            node.waiting_priority()
                .filter(|_| node.may_send_from_ns <= start_ns)
        };
        let lowest = self.nodes.iter().filter_map(ready).min();
        let mut first = None;
        let mut senders = 0;
        for (index, node) in self
            .nodes
            .iter_mut()
            .enumerate()
            .filter(|(_, node)| ready(node) == lowest && lowest.is_some())
        {
            let begun = node.controller.begin();
            first = first.or(begun.map(|(frame, number)| (NodeId(index), frame, number)));
            senders += 1;
        }
        let (node, frame, number) = first?;
        let attempt = Attempt {
            start_ns,
            node,
            frame,
            wire: WireLength::of(&frame),
            number,
        };
        let winner = Winner {
            attempt,
            senders,
            collision_at_bit: None,
            silenced: Vec::new(),
        };
        Some(if senders > 1 {
            self.separate(winner)
        } else {
            winner
        })
    }

    /// Several nodes send the identifier that won.
    fn separate(&mut self, mut winner: Winner) -> Winner {
        let nodes = self.nodes.iter().enumerate();
        let (indices, contenders): (Vec<_>, Vec<_>) = nodes
            .filter_map(|(index, node)| {
                let frame = node.controller.frame_on_wire()?;
                Some((
                    index,
                    Contender {
                        frame,
                        is_passive: node.controller.is_passive(),
                    },
                ))
            })
            .unzip();
        let resolution = resolve(&contenders);
        winner.collision_at_bit = resolution.collision_at_bit;
        winner.silenced = resolution
            .silenced
            .iter()
            .map(|&contender| indices[contender])
            .collect();
        for &index in &winner.silenced {
            self.nodes[index].controller.transmit_error();
            self.nodes[index].listening_since_ns = winner.attempt.start_ns + 1;
        }
        winner.senders -= winner.silenced.len() as u16;
        let remaining =
            (0..indices.len()).find(|contender| !resolution.silenced.contains(contender));
        if let Some(contender) = remaining {
            let frame = contenders[contender].frame;
            winner.attempt = Attempt {
                node: NodeId(indices[contender]),
                frame,
                wire: WireLength::of(&frame),
                ..winner.attempt
            };
        }
        winner
    }

    /// How the attempt will end, and after how many bits.
    fn judge(&mut self, winner: &Winner) -> (Outcome, u32) {
        let Attempt { start_ns, wire, .. } = winner.attempt;
        let frame_bits = wire.bits_without_ifs;
        let end_ns = start_ns + u64::from(frame_bits) * self.bit_ns;
        if let Some(at_ns) = self.outages.first_disturbance(start_ns, end_ns) {
            let at_bit = ((at_ns - start_ns) / self.bit_ns) as u32 + 1;
            return (Outcome::BitError, at_bit.max(FIRST_BIT_BEHIND_SOF));
        }
        if let Some(at_bit) = winner.collision_at_bit {
            return (Outcome::Collision, at_bit);
        }
        let acknowledged = self.nodes.iter().any(|node| node.hears(start_ns));
        let ack_delimiter = frame_bits - EOF_BITS;
        match self.faults.on_attempt(&winner.attempt) {
            AttemptOutcome::BitError { at_bit } => {
                (Outcome::BitError, at_bit.clamp(1, ack_delimiter))
            }
            _ if !acknowledged => (Outcome::AckError, ack_delimiter - 1),
            AttemptOutcome::EofError => (Outcome::EofError, frame_bits),
            AttemptOutcome::Intact => (Outcome::Delivered, frame_bits),
        }
    }

    /// The attempt ends: senders learn its outcome, receivers get the frame.
    pub(super) fn finish(&mut self, on_wire: OnWire) {
        let OnWire {
            start_ns,
            end_ns,
            free_ns,
            node,
            senders,
            frame,
            ..
        } = on_wire;
        let outcome = self.final_outcome(&on_wire);
        for (index, node) in self.nodes.iter_mut().enumerate() {
            if node.controller.is_transmitting() {
                end_own_frame(node, outcome);
                if node.controller.is_passive() {
                    node.may_send_from_ns = free_ns + SUSPEND_BITS * self.bit_ns;
                }
            } else if node.hears(start_ns) {
                let delivery = Delivery {
                    end_ns,
                    receiver: NodeId(index),
                    frame,
                };
                hear(node, &delivery, outcome, &mut self.faults);
            }
            if let Some(recovery) = &mut node.recovery {
                // The delimiter (or ACK delimiter and EOF) and the interframe space are 11 recessive bits.
                recovery.sequences_left = recovery.sequences_left.saturating_sub(1);
                recovery.recessive_since_ns = free_ns;
            }
        }
        self.now_ns = end_ns;
        self.idle_from_ns = free_ns;
        self.on_wire = None;
        self.outages.forget_before(end_ns);
        self.log.push(Record {
            start_ns,
            end_ns,
            free_ns,
            node,
            senders,
            frame,
            outcome,
        });
    }

    /// What was foreseen at the start, unless senders or receivers left meanwhile.
    fn final_outcome(&self, on_wire: &OnWire) -> Outcome {
        if !self
            .nodes
            .iter()
            .any(|node| node.controller.is_transmitting())
        {
            return Outcome::Interrupted;
        }
        if on_wire.outcome.is_received()
            && !self.nodes.iter().any(|node| node.hears(on_wire.start_ns))
        {
            return Outcome::AckError;
        }
        on_wire.outcome
    }
}

fn end_own_frame(node: &mut Node, outcome: Outcome) {
    match outcome {
        Outcome::Delivered => node.controller.transmitted(),
        Outcome::AckError => node.controller.not_acknowledged(),
        _ => node.controller.transmit_error(),
    }
}

fn hear<F: FaultModel>(node: &mut Node, delivery: &Delivery, outcome: Outcome, faults: &mut F) {
    if !outcome.is_received() {
        node.controller.receive_error();
        return;
    }
    node.controller.heard();
    if !node.controller.accepts(&delivery.frame) {
        return;
    }
    match faults.on_delivery(delivery) {
        DeliveryOutcome::Store => node.controller.store_received(delivery.frame),
        DeliveryOutcome::Drop => node.controller.drop_received(),
    }
}
