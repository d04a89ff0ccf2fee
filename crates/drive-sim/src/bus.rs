//! The bus: virtual time, arbitration, delivery, retransmission, load.
//!
//! Law (Bosch CAN 2.0 B): a node starts only on an idle bus; all that wait at that instant arbitrate by identifier; the winner holds the wire for its
//! exact stuffed length; receivers have the frame at the end of EOF; three bits of interframe space later the bus is idle again. A frame
//! must be acknowledged by a node that does not send it itself. Every error ends in an error frame of [`ERROR_FRAME_BITS`] and an
//! automatic retransmission.
//!
//! Time is counted in nanoseconds from 0 and moves only in [`Bus::advance_to`] and [`Bus::run_to_frame_end`]. Everything handed over at one
//! instant takes part in the arbitration at that instant: a start is settled only when time moves past it.
//!
//! Simplified: propagation takes no time, all nodes agree on where an error frame ends, overload frames do not occur, and a node out of
//! bus-off or off listens from the next frame on.

mod transmission;

use can_frame::BitRate;

use crate::controller::{Controller, ControllerConfig};
use crate::fault::{FaultModel, NoFaults};
use crate::log::{LogMode, TrafficLog};
use crate::node::{Node, NodeId, RECOVERY_SEQUENCE_BITS, Recovery};
use crate::outage::{EmptyOutage, Outage, Outages};
use crate::port::Port;

pub use transmission::{ERROR_FRAME_BITS, SUSPEND_BITS};

use transmission::OnWire;

/// A CAN bus in virtual time.
///
/// # Panics
/// Methods that take a [`NodeId`] panic if it comes from another bus with more nodes.
#[derive(Debug, Clone)]
pub struct Bus<F = NoFaults> {
    rate: BitRate,
    bit_ns: u64,
    now_ns: u64,
    idle_from_ns: u64,
    /// Busy time of every attempt begun so far, counted to the end of its interframe space.
    begun_busy_ns: u64,
    nodes: Vec<Node>,
    on_wire: Option<OnWire>,
    outages: Outages,
    faults: F,
    log: TrafficLog,
}

/// Begin of a window over which the load is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LoadMark {
    /// Begin of the window.
    pub at_ns: u64,
    /// Busy time of the bus up to it.
    pub busy_ns: u64,
}

/// What happens next on an idle bus.
struct IdleEvents {
    start_ns: Option<u64>,
    /// End of the first bus-off recovery, and the index of its node.
    recovery: Option<(u64, usize)>,
}

impl Bus<NoFaults> {
    /// An empty bus without faults at time 0. The log is off.
    pub fn new(rate: BitRate) -> Self {
        Self::with_faults(rate, NoFaults)
    }
}

impl<F: FaultModel> Bus<F> {
    /// An empty bus at time 0 whose faults come from `faults`. The log is off.
    pub fn with_faults(rate: BitRate, faults: F) -> Self {
        Self {
            rate,
            bit_ns: rate.bit_ns(),
            now_ns: 0,
            idle_from_ns: 0,
            begun_busy_ns: 0,
            nodes: Vec::new(),
            on_wire: None,
            outages: Outages::default(),
            faults,
            log: TrafficLog::new(LogMode::Off),
        }
    }

    /// Connects a new node. Its controller is on and listens from the next frame on.
    pub fn add_node(&mut self, config: ControllerConfig) -> NodeId {
        self.nodes
            .push(Node::new(Controller::new(config), self.now_ns));
        NodeId(self.nodes.len() - 1)
    }

    /// What software on `node` may do.
    pub fn port(&mut self, node: NodeId) -> Port<'_> {
        Port {
            node: &mut self.nodes[node.0],
            now_ns: self.now_ns,
            idle_from_ns: self.idle_from_ns,
        }
    }

    /// The controller of `node`, to read its state and counters.
    pub fn controller(&self, node: NodeId) -> &Controller {
        &self.nodes[node.0].controller
    }

    pub(crate) fn pop_received(&mut self, node: NodeId) -> Option<crate::Frame> {
        self.nodes[node.0].controller.pop_received()
    }

    /// Plugs `node` in or out.
    ///
    /// A node without connection neither sends, receives nor acknowledges; its frames stay pending and its counters stay. To see
    /// what a node does behind a cut cable (no acknowledge), unplug the others instead.
    pub fn set_connected(&mut self, node: NodeId, connected: bool) {
        self.nodes[node.0].connect(connected, self.now_ns);
    }

    /// Adds a window in which the bus does not work. It acts on attempts that begin after this call.
    ///
    /// # Errors
    /// [`EmptyOutage`] if it ends before it begins.
    pub fn add_outage(&mut self, outage: Outage) -> Result<(), EmptyOutage> {
        self.outages.add(outage)
    }

    /// The fault model.
    pub fn faults(&self) -> &F {
        &self.faults
    }

    /// The fault model, to change what it will do.
    pub fn faults_mut(&mut self) -> &mut F {
        &mut self.faults
    }

    /// Begins a new, empty log.
    pub fn set_log(&mut self, mode: LogMode) {
        self.log = TrafficLog::new(mode);
    }

    /// The traffic so far, as far as it was kept.
    pub fn log(&self) -> &TrafficLog {
        &self.log
    }

    /// The traffic so far, to take records out.
    pub fn log_mut(&mut self) -> &mut TrafficLog {
        &mut self.log
    }

    /// The present instant.
    pub fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// The bit rate.
    pub fn bit_rate(&self) -> BitRate {
        self.rate
    }

    /// Whether a frame is on the wire.
    pub fn is_transmitting(&self) -> bool {
        self.on_wire.is_some()
    }

    /// Time up to now during which the bus was not idle: frames, error frames and interframe space.
    pub fn busy_ns(&self) -> u64 {
        let busy_until_ns = self
            .on_wire
            .map_or(self.idle_from_ns, |on_wire| on_wire.free_ns);
        self.begun_busy_ns - busy_until_ns.saturating_sub(self.now_ns)
    }

    /// Begins a window for [`Self::load_since`].
    pub fn load_mark(&self) -> LoadMark {
        LoadMark {
            at_ns: self.now_ns,
            busy_ns: self.busy_ns(),
        }
    }

    /// Busy share of the time since `mark`, 0.0..=1.0; 0.0 for an empty window.
    pub fn load_since(&self, mark: &LoadMark) -> f64 {
        match self.now_ns - mark.at_ns {
            0 => 0.0,
            window_ns => (self.busy_ns() - mark.busy_ns) as f64 / window_ns as f64,
        }
    }

    /// The next instant at which something changes by itself: the end of a frame, of the first bit of the next one, or of a bus-off recovery.
    pub fn next_event_ns(&self) -> Option<u64> {
        if let Some(on_wire) = self.on_wire {
            return Some(on_wire.end_ns);
        }
        let IdleEvents { start_ns, recovery } = self.idle_events();
        let first_bit_ns = start_ns.map(|start_ns| start_ns.saturating_add(self.bit_ns));
        let recovered_ns = recovery.map(|(at_ns, _)| at_ns);
        let events = first_bit_ns.into_iter().chain(recovered_ns);
        // An outage without end puts an event at the end of time.
        events.filter(|at_ns| *at_ns < u64::MAX).min()
    }

    /// Lets time pass until `t_ns`. An instant in the past changes nothing.
    pub fn advance_to(&mut self, t_ns: u64) {
        while self.run_to_frame_end(t_ns) {}
    }

    /// Lets time pass until the next attempt on the wire ends, in success or error, at most until `limit_ns`.
    ///
    /// Returns true if it stopped at the end of an attempt; then time may be short of the limit.
    pub fn run_to_frame_end(&mut self, limit_ns: u64) -> bool {
        loop {
            if let Some(on_wire) = self.on_wire {
                if on_wire.end_ns <= limit_ns {
                    self.finish(on_wire);
                    return true;
                }
                break;
            }
            let IdleEvents { start_ns, recovery } = self.idle_events();
            match (start_ns, recovery) {
                (_, Some((at_ns, index)))
                    if at_ns <= limit_ns && start_ns.is_none_or(|start_ns| at_ns <= start_ns) =>
                {
                    self.now_ns = self.now_ns.max(at_ns);
                    self.nodes[index].recover(at_ns);
                }
                (Some(start_ns), _) if start_ns < limit_ns => self.start(start_ns),
                _ => break,
            }
        }
        self.now_ns = self.now_ns.max(limit_ns);
        false
    }

    fn idle_events(&self) -> IdleEvents {
        let idle_ns = self.now_ns.max(self.idle_from_ns);
        let mut start_ns = None;
        let mut recovery = None;
        for (index, node) in self.nodes.iter().enumerate() {
            if let Some(running) = node.recovery {
                let at = (self.recovery_end_ns(running), index);
                recovery = Some(recovery.map_or(at, |first: (u64, usize)| first.min(at)));
            }
            if node.waiting_priority().is_some() {
                let ready_ns = idle_ns.max(node.may_send_from_ns);
                start_ns = Some(start_ns.map_or(ready_ns, |first: u64| first.min(ready_ns)));
            }
        }
        IdleEvents {
            start_ns: start_ns.map(|at_ns| self.outages.unblocked_from(at_ns)),
            recovery,
        }
    }

    /// When a recovery ends if the bus stays idle.
    fn recovery_end_ns(&self, recovery: Recovery) -> u64 {
        let sequence_ns = RECOVERY_SEQUENCE_BITS * self.bit_ns;
        let mut left = recovery.sequences_left;
        for (from_ns, until_ns) in self
            .outages
            .recessive_spans(recovery.recessive_since_ns, u64::MAX)
        {
            let in_span = (until_ns - from_ns) / sequence_ns;
            if left <= in_span {
                return from_ns + left * sequence_ns;
            }
            left -= in_span;
        }
        u64::MAX
    }

    /// Counts the idle time before a start towards the recoveries that are running.
    fn count_recessive_bits(&mut self, until_ns: u64) {
        let sequence_ns = RECOVERY_SEQUENCE_BITS * self.bit_ns;
        for recovery in self
            .nodes
            .iter_mut()
            .filter_map(|node| node.recovery.as_mut())
        {
            let spans = self
                .outages
                .recessive_spans(recovery.recessive_since_ns, until_ns);
            let sequences: u64 = spans
                .map(|(from_ns, until_ns)| (until_ns - from_ns) / sequence_ns)
                .sum();
            recovery.sequences_left = recovery.sequences_left.saturating_sub(sequences);
        }
    }
}

#[cfg(test)]
mod tests;
