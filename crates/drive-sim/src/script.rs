//! Scripted faults: "the next two frames of this node", "the third position request".
//!
//! Specification: none of its own. A script adds no chance and no time; which frames it hits follows from the order of frames on the bus alone.

use embedded_can::{Frame as _, Id};

use crate::fault::{Attempt, AttemptOutcome, Delivery, DeliveryOutcome, FaultModel};
use crate::frame::Frame;
use crate::node::NodeId;

/// Which frames a rule concerns; what is `None` matches everything.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FrameMatch {
    /// Sender. Not compared at a delivery, where a rule names the receiver instead.
    pub sender: Option<NodeId>,
    /// Identifier.
    pub id: Option<Id>,
    /// Matching frames that pass before the rule acts.
    pub skip: u32,
}

impl FrameMatch {
    /// Every frame.
    pub const ANY: Self = Self {
        sender: None,
        id: None,
        skip: 0,
    };

    /// Frames sent by `sender`.
    pub const fn sent_by(sender: NodeId) -> Self {
        Self {
            sender: Some(sender),
            ..Self::ANY
        }
    }

    /// Frames with the identifier `id`.
    pub fn with_id(id: impl Into<Id>) -> Self {
        Self {
            id: Some(id.into()),
            ..Self::ANY
        }
    }

    /// The same, after `skip` matching frames have passed.
    pub const fn after(self, skip: u32) -> Self {
        Self { skip, ..self }
    }

    fn matches(&self, sender: Option<NodeId>, frame: &Frame) -> bool {
        (self.sender.is_none() || sender.is_none() || self.sender == sender)
            && self.id.is_none_or(|id| id == frame.id())
    }
}

#[derive(Debug, Clone, Copy)]
struct Rule<A> {
    which: FrameMatch,
    left: u32,
    action: A,
}

impl<A: Copy> Rule<A> {
    fn apply(&mut self, sender: Option<NodeId>, frame: &Frame) -> Option<A> {
        if self.left == 0 || !self.which.matches(sender, frame) {
            return None;
        }
        if self.which.skip > 0 {
            self.which.skip -= 1;
            return None;
        }
        self.left -= 1;
        Some(self.action)
    }
}

/// A fault model that does what it was told. The first rule that acts on a frame decides; repetitions of a frame count as frames.
#[derive(Debug, Clone, Default)]
pub struct ScriptedFaults {
    attempts: Vec<Rule<AttemptOutcome>>,
    deliveries: Vec<Rule<NodeId>>,
}

impl ScriptedFaults {
    /// A script without rules.
    pub fn new() -> Self {
        Self::default()
    }

    /// Destroys the next `count` matching frames by an error in bit `at_bit`; see [`AttemptOutcome::BitError`].
    pub fn corrupt_next(&mut self, which: FrameMatch, count: u32, at_bit: u32) {
        self.attempts.push(Rule {
            which,
            left: count,
            action: AttemptOutcome::BitError { at_bit },
        });
    }

    /// Makes receivers get the next `count` matching frames while their senders repeat them; see [`AttemptOutcome::EofError`].
    pub fn duplicate_next(&mut self, which: FrameMatch, count: u32) {
        self.attempts.push(Rule {
            which,
            left: count,
            action: AttemptOutcome::EofError,
        });
    }

    /// Makes `receiver` lose the next `count` frames with a matching identifier; the sender in `which` is not compared.
    pub fn drop_next(&mut self, receiver: NodeId, which: FrameMatch, count: u32) {
        self.deliveries.push(Rule {
            which,
            left: count,
            action: receiver,
        });
    }

    /// Whether every rule has acted as often as it was told to.
    pub fn is_done(&self) -> bool {
        self.attempts.is_empty() && self.deliveries.is_empty()
    }
}

impl FaultModel for ScriptedFaults {
    fn on_attempt(&mut self, attempt: &Attempt) -> AttemptOutcome {
        let hit = self
            .attempts
            .iter_mut()
            .find_map(|rule| rule.apply(Some(attempt.node), &attempt.frame));
        self.attempts.retain(|rule| rule.left > 0);
        hit.unwrap_or_default()
    }

    fn on_delivery(&mut self, delivery: &Delivery) -> DeliveryOutcome {
        let mut of_receiver = self
            .deliveries
            .iter_mut()
            .filter(|rule| rule.action == delivery.receiver);
        let hit = of_receiver.find_map(|rule| rule.apply(None, &delivery.frame));
        self.deliveries.retain(|rule| rule.left > 0);
        if hit.is_some() {
            DeliveryOutcome::Drop
        } else {
            DeliveryOutcome::Store
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::tests::standard;
    use crate::wire::WireLength;

    fn attempt(node: usize, id: u16) -> Attempt {
        let frame = standard(id, &[]);
        Attempt {
            start_ns: 0,
            node: NodeId(node),
            frame,
            wire: WireLength::of(&frame),
            number: 1,
        }
    }

    #[test]
    fn skips_then_acts_as_often_as_told() {
        let mut script = ScriptedFaults::new();
        script.corrupt_next(FrameMatch::sent_by(NodeId(1)).after(1), 2, 30);
        let hits = [(1, 5), (2, 5), (1, 6), (1, 7), (1, 8)]
            .map(|(node, id)| script.on_attempt(&attempt(node, id)));
        let error = AttemptOutcome::BitError { at_bit: 30 };
        let intact = AttemptOutcome::Intact;
        assert_eq!(hits, [intact, intact, error, error, intact]);
        assert!(script.is_done());
    }

    #[test]
    fn matches_identifiers_and_receivers() {
        let mut script = ScriptedFaults::new();
        let which = FrameMatch::with_id(standard(0x20, &[]).id());
        script.duplicate_next(which, 1);
        script.drop_next(NodeId(3), which, 1);
        assert_eq!(script.on_attempt(&attempt(0, 0x21)), AttemptOutcome::Intact);
        assert_eq!(
            script.on_attempt(&attempt(0, 0x20)),
            AttemptOutcome::EofError
        );
        let mut deliver = |receiver, id| {
            script.on_delivery(&Delivery {
                end_ns: 0,
                receiver: NodeId(receiver),
                frame: standard(id, &[]),
            })
        };
        assert_eq!(deliver(2, 0x20), DeliveryOutcome::Store);
        assert_eq!(deliver(3, 0x21), DeliveryOutcome::Store);
        assert_eq!(deliver(3, 0x20), DeliveryOutcome::Drop);
        assert_eq!(deliver(3, 0x20), DeliveryOutcome::Store);
    }
}
