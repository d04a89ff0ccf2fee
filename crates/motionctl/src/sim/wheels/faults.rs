//! Faults of simulated hub motors and their bus, from a script: `docs/fault-scripts.md` describes it.

use core::fmt;

use drive_sim::{
    Bench, DeviceId, FrameMatch, Outage, OutageKind, ReplyDamage, ScriptedFaults, ZlacDrive,
};
use serde::Deserialize;
use toml::Spanned;
use zlac8030l::NodeId;

const NS_PER_S: f64 = 1e9;
/// A day: longer than any run, and exact in nanoseconds.
const MOST_S: f64 = 86_400.0;

/// A time of the script.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(try_from = "f64")]
struct Time(u64);

impl TryFrom<f64> for Time {
    type Error = String;

    fn try_from(time_s: f64) -> Result<Self, String> {
        if (0.0..=MOST_S).contains(&time_s) {
            Ok(Self((time_s * NS_PER_S).round() as u64))
        } else {
            Err(format!("must be 0..={MOST_S} s, got {time_s}"))
        }
    }
}

/// A node of the script.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(try_from = "i32")]
struct Node(NodeId);

impl TryFrom<i32> for Node {
    type Error = String;

    fn try_from(number: i32) -> Result<Self, String> {
        NodeId::new(number)
            .map(Self)
            .map_err(|error| error.to_string())
    }
}

/// Bits of 603Fh by their names in the guide.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum TripName {
    OverVoltage,
    UnderVoltage,
    OverCurrent,
    Overload,
    Encoder,
    Hall,
    MotorTemperature,
}

impl TripName {
    const fn bits(self) -> u16 {
        match self {
            Self::OverVoltage => 0x0001,
            Self::UnderVoltage => 0x0002,
            Self::OverCurrent => 0x0004,
            Self::Overload => 0x0008,
            Self::Encoder => 0x0020,
            Self::Hall => 0x0200,
            Self::MotorTemperature => 0x0400,
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TripEntry {
    at_s: Time,
    node: Node,
    fault: TripName,
    for_s: Option<Time>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct WhileEntry {
    at_s: Time,
    node: Node,
    for_s: Option<Time>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PowerCycleEntry {
    at_s: Time,
    node: Node,
    off_s: Time,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct CorruptEntry {
    at_s: Time,
    frames: u32,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct BusEntry {
    at_s: Time,
    for_s: Time,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MissEntry {
    at_s: Time,
    cycles: u32,
}

/// The whole file.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct File {
    trip: Vec<Spanned<TripEntry>>,
    emergency_input: Vec<Spanned<WhileEntry>>,
    silence: Vec<Spanned<WhileEntry>>,
    unplug: Vec<Spanned<WhileEntry>>,
    drop_reply: Vec<Spanned<WhileEntry>>,
    power_cycle: Vec<Spanned<PowerCycleEntry>>,
    corrupt: Vec<Spanned<CorruptEntry>>,
    block: Vec<Spanned<BusEntry>>,
    disturb: Vec<Spanned<BusEntry>>,
    miss_cycles: Vec<Spanned<MissEntry>>,
}

/// Something that goes wrong, or right again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fault {
    Trip { node: NodeId, bits: u16 },
    CauseGone { node: NodeId },
    EmergencyInput { node: NodeId, active: bool },
    Silence { node: NodeId },
    Wake { node: NodeId },
    Unplug { node: NodeId },
    PlugIn { node: NodeId },
    DropReply { node: NodeId },
    PowerCycle { node: NodeId, off_ns: u64 },
    Corrupt { frames: u32 },
    Block { for_ns: u64 },
    Disturb { for_ns: u64 },
    MissCycles { cycles: u32 },
}

/// In the middle of a frame.
const BIT_OF_ERROR: u32 = 20;

impl Fault {
    pub(super) const fn node(self) -> Option<NodeId> {
        match self {
            Self::Trip { node, .. }
            | Self::CauseGone { node }
            | Self::EmergencyInput { node, .. }
            | Self::Silence { node }
            | Self::Wake { node }
            | Self::Unplug { node }
            | Self::PlugIn { node }
            | Self::DropReply { node }
            | Self::PowerCycle { node, .. } => Some(node),
            Self::Corrupt { .. }
            | Self::Block { .. }
            | Self::Disturb { .. }
            | Self::MissCycles { .. } => None,
        }
    }

    /// Commands the fault, from this instant on. Missed cycles are up to who runs the cycles.
    pub(super) fn apply(
        self,
        bench: &mut Bench<ZlacDrive, ScriptedFaults>,
        nodes: &[NodeId],
        devices: &[DeviceId],
    ) {
        let place = |node| nodes.iter().position(|other| *other == node);
        let device = self.node().and_then(place);
        match device.and_then(|place| devices.get(place)) {
            Some(&device) => self.apply_to_drive(bench, device),
            None => self.apply_to_bus(bench),
        }
    }

    fn apply_to_drive(self, bench: &mut Bench<ZlacDrive, ScriptedFaults>, device: DeviceId) {
        let bus_node = bench.node_of(device);
        let faults = bench.device_mut(device).faults_mut();
        match self {
            Self::Trip { bits, .. } => faults.trip(bits),
            Self::CauseGone { .. } => faults.remove_cause(),
            Self::EmergencyInput { active, .. } => faults.emergency_input(active),
            Self::Silence { .. } => faults.fall_silent(),
            Self::Wake { .. } => faults.wake(),
            Self::DropReply { .. } => faults.damage_next_reply(ReplyDamage::Drop),
            Self::PowerCycle { off_ns, .. } => faults.power_cycle(off_ns),
            Self::Unplug { .. } => bench.bus_mut().set_connected(bus_node, false),
            Self::PlugIn { .. } => bench.bus_mut().set_connected(bus_node, true),
            Self::Corrupt { .. }
            | Self::Block { .. }
            | Self::Disturb { .. }
            | Self::MissCycles { .. } => {}
        }
    }

    fn apply_to_bus(self, bench: &mut Bench<ZlacDrive, ScriptedFaults>) {
        let from_ns = bench.now_ns();
        let bus = bench.bus_mut();
        let (kind, for_ns) = match self {
            Self::Corrupt { frames } => {
                let script = bus.faults_mut();
                script.corrupt_next(FrameMatch::ANY, frames, BIT_OF_ERROR);
                return;
            }
            Self::Block { for_ns } => (OutageKind::Blocked, for_ns),
            Self::Disturb { for_ns } => (OutageKind::Disturbed, for_ns),
            _ => return,
        };
        // An outage of no time is no outage.
        let _ = bus.add_outage(Outage {
            kind,
            from_ns,
            until_ns: from_ns.saturating_add(for_ns),
        });
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ms = |ns: u64| ns as f64 * 1e-6;
        match *self {
            Self::Trip { node, bits } => {
                write!(f, "node {node} trips: {}", zlac8030l::FaultCode::new(bits))
            }
            Self::CauseGone { node } => write!(f, "the cause of the fault of node {node} is gone"),
            Self::EmergencyInput { node, active: true } => {
                write!(f, "an emergency stop input of node {node} becomes active")
            }
            Self::EmergencyInput { node, .. } => {
                write!(f, "the emergency stop input of node {node} is released")
            }
            Self::Silence { node } => write!(f, "node {node} falls silent"),
            Self::Wake { node } => write!(f, "node {node} answers again"),
            Self::Unplug { node } => write!(f, "node {node} is pulled off the bus"),
            Self::PlugIn { node } => write!(f, "node {node} is back on the bus"),
            Self::DropReply { node } => write!(f, "node {node} does not send its next SDO reply"),
            Self::PowerCycle { node, off_ns } => {
                write!(f, "node {node} loses its power for {} ms", ms(off_ns))
            }
            Self::Corrupt { frames } => write!(f, "the next {frames} frames are destroyed"),
            Self::Block { for_ns } => write!(f, "the bus is blocked for {} ms", ms(for_ns)),
            Self::Disturb { for_ns } => write!(f, "the bus is disturbed for {} ms", ms(for_ns)),
            Self::MissCycles { cycles } => write!(f, "the application misses {cycles} cycles"),
        }
    }
}

/// Faults in the order of their times, which count from the start of the motion.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub(super) struct Script {
    /// The last comes first.
    pending: Vec<(u64, Fault)>,
}

impl Script {
    /// Reads a script for these nodes.
    ///
    /// # Errors
    /// What is wrong, with its line.
    pub(super) fn parse(text: &str, nodes: &[NodeId]) -> Result<Self, String> {
        let file: File = toml::from_str(text).map_err(|error| error.to_string())?;
        let mut reader = Reader {
            text,
            nodes,
            faults: Vec::new(),
        };
        for entry in &file.trip {
            let TripEntry {
                at_s,
                node: Node(node),
                fault,
                for_s,
            } = *entry.get_ref();
            let bits = fault.bits();
            let end = for_s.map(|after| (after, Fault::CauseGone { node }));
            reader.take(entry, at_s, Fault::Trip { node, bits }, end)?;
        }
        for entry in &file.emergency_input {
            reader.while_it_lasts(entry, |node, active| Fault::EmergencyInput { node, active })?;
        }
        for entry in &file.silence {
            reader.while_it_lasts(entry, |node, begins| {
                if begins {
                    Fault::Silence { node }
                } else {
                    Fault::Wake { node }
                }
            })?;
        }
        for entry in &file.unplug {
            reader.while_it_lasts(entry, |node, begins| {
                if begins {
                    Fault::Unplug { node }
                } else {
                    Fault::PlugIn { node }
                }
            })?;
        }
        for entry in &file.drop_reply {
            let WhileEntry { at_s, node, .. } = *entry.get_ref();
            reader.take(entry, at_s, Fault::DropReply { node: node.0 }, None)?;
        }
        for entry in &file.power_cycle {
            let PowerCycleEntry { at_s, node, off_s } = *entry.get_ref();
            let fault = Fault::PowerCycle {
                node: node.0,
                off_ns: off_s.0,
            };
            reader.take(entry, at_s, fault, None)?;
        }
        reader.take_bus(&file)?;
        let mut pending = reader.faults;
        // Stable: what happens at one time happens in the order of the lists.
        pending.sort_by_key(|(at_ns, _)| *at_ns);
        pending.reverse();
        Ok(Self { pending })
    }

    /// The next fault that is due at this time of the motion.
    pub(super) fn next_due(&mut self, at_ns: u64) -> Option<Fault> {
        self.pending
            .pop_if(|(due_ns, _)| *due_ns <= at_ns)
            .map(|(_, fault)| fault)
    }

    /// Faults whose time has not come.
    pub(super) fn left(&self) -> usize {
        self.pending.len()
    }
}

struct Reader<'a> {
    text: &'a str,
    nodes: &'a [NodeId],
    faults: Vec<(u64, Fault)>,
}

impl Reader<'_> {
    fn while_it_lasts(
        &mut self,
        entry: &Spanned<WhileEntry>,
        fault: impl Fn(NodeId, bool) -> Fault,
    ) -> Result<(), String> {
        let WhileEntry {
            at_s,
            node: Node(node),
            for_s,
        } = *entry.get_ref();
        let end = for_s.map(|after| (after, fault(node, false)));
        self.take(entry, at_s, fault(node, true), end)
    }

    fn take_bus(&mut self, file: &File) -> Result<(), String> {
        for entry in &file.corrupt {
            let CorruptEntry { at_s, frames } = *entry.get_ref();
            self.take(entry, at_s, Fault::Corrupt { frames }, None)?;
        }
        for entry in &file.block {
            let BusEntry { at_s, for_s } = *entry.get_ref();
            self.take(entry, at_s, Fault::Block { for_ns: for_s.0 }, None)?;
        }
        for entry in &file.disturb {
            let BusEntry { at_s, for_s } = *entry.get_ref();
            self.take(entry, at_s, Fault::Disturb { for_ns: for_s.0 }, None)?;
        }
        for entry in &file.miss_cycles {
            let MissEntry { at_s, cycles } = *entry.get_ref();
            self.take(entry, at_s, Fault::MissCycles { cycles }, None)?;
        }
        Ok(())
    }

    fn take<E>(
        &mut self,
        entry: &Spanned<E>,
        at: Time,
        fault: Fault,
        end: Option<(Time, Fault)>,
    ) -> Result<(), String> {
        if let Some(node) = fault.node().filter(|node| !self.nodes.contains(node)) {
            let before = self.text.get(..entry.span().start).unwrap_or_default();
            let line = before.matches('\n').count() + 1;
            let nodes: Vec<String> = self.nodes.iter().map(ToString::to_string).collect();
            return Err(format!(
                "line {line}: node {node} takes no part; the nodes are {}",
                nodes.join(", ")
            ));
        }
        self.faults.push((at.0, fault));
        self.faults
            .extend(end.map(|(after, fault)| (at.0.saturating_add(after.0), fault)));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nodes() -> Vec<NodeId> {
        [4, 5].map(|node| NodeId::new(node).unwrap()).to_vec()
    }

    #[test]
    fn faults_come_in_the_order_of_their_times_and_end() {
        let text = "[[silence]]\nat_s = 2\nnode = 5\nfor_s = 0.5\n[[trip]]\nat_s = 1\nnode = 4\nfault = \"over-current\"\n[[block]]\nat_s = 1\nfor_s = 0.01\n";
        let mut script = Script::parse(text, &nodes()).unwrap();
        assert_eq!(script.left(), 4);
        assert_eq!(script.next_due(999_999_999), None);
        let due: Vec<String> = core::iter::from_fn(|| script.next_due(2_500_000_000))
            .map(|fault| fault.to_string())
            .collect();
        assert_eq!(
            due,
            [
                "node 4 trips: 0004h: over-current",
                "the bus is blocked for 10 ms",
                "node 5 falls silent",
                "node 5 answers again"
            ]
        );
    }

    #[test]
    fn wrong_scripts_say_where() {
        for (text, words) in [
            (
                "\n[[silence]]\nat_s = 1\nnode = 9\n",
                "line 2: node 9 takes no part; the nodes are 4, 5",
            ),
            (
                "[[silence]]\nat_s = -1\nnode = 4\n",
                "must be 0..=86400 s, got -1",
            ),
            ("[[silence]]\nat_s = 1\ndrive = 4\n", "line 3"),
            (
                "[[trip]]\nat_s = 1\nnode = 4\nfault = \"lost-phase\"\n",
                "over-current",
            ),
            ("[[alarm]]\n", "line 1"),
        ] {
            let error = Script::parse(text, &nodes()).expect_err(text);
            assert!(error.contains(words), "{text}: {error}");
        }
    }
}
