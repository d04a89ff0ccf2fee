//! Everything that touches the interface of the master and of the simulated drives. The tests say what an application does and
//! what drives and bus saw of it.

pub(crate) mod enums;
pub(crate) mod servos;
pub(crate) mod wheels;

use can_motion::GroupId;
use can_motion::family::{CycleConfig, Family};
use drive_sim::{Device, Frame, Outage, OutageKind, Record};
use embedded_can::nb::Can;
use embedded_can::{Frame as _, Id, StandardId};
use host_tests::rig::{GROUP, Rig};

/// A master with its bus and drives.
pub(crate) struct Machine<D: Device, F: Family>(pub(crate) Rig<D, F>);

/// A call of the application that acts on a group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Call {
    Enable,
    Adopt,
    Resume,
    Stop,
    Halt,
    Disable,
    Clear,
}

impl<D: Device, F: Family> Machine<D, F>
where
    F::Fault: core::fmt::Display + core::fmt::Debug,
    F::Config: CycleConfig,
{
    /// A call for group 0; the text of a refusal.
    pub(crate) fn call(&mut self, call: Call) -> Result<(), String> {
        self.call_group(call, GROUP)
    }

    /// A call for a group; the text of a refusal.
    pub(crate) fn call_group(&mut self, call: Call, group: GroupId) -> Result<(), String> {
        let (now, master) = (self.0.now(), &mut self.0.master);
        let refused = |error: can_motion::CommandError<F::Fault>| error.to_string();
        match call {
            Call::Enable => master.enable(now, group).map_err(refused),
            Call::Adopt => master.adopt(now, group).map_err(refused),
            Call::Resume => master.resume(now, group).map_err(refused),
            Call::Clear => master.clear(now, group).map_err(refused),
            Call::Stop => {
                master.stop(now, group);
                Ok(())
            }
            Call::Halt => {
                master.halt(now, group);
                Ok(())
            }
            Call::Disable => {
                master.disable(now, group);
                Ok(())
            }
        }
    }

    /// Cycles in which the application does nothing.
    pub(crate) fn run(&mut self, cycles: usize) {
        self.0.cycles(cycles);
    }

    /// Cycles that the application does not begin.
    pub(crate) fn hang(&mut self, cycles: i32) {
        (0..cycles).for_each(|_| self.0.skip_cycle());
    }

    /// From power-on to set-points in group 0.
    pub(crate) fn stream(&mut self) {
        self.0.stream();
    }

    /// From power-on to the moment when the drives are checked and off.
    pub(crate) fn become_ready(&mut self) {
        self.0.ready();
    }

    /// From power-on to the moment when the drives are checked, whether they are on or not.
    pub(crate) fn become_checked(&mut self) {
        self.0.run_until_checked();
    }

    pub(crate) fn now_ns(&self) -> u64 {
        self.0.bench.now_ns()
    }

    /// The place in the traffic from which [`Self::frames_since`] counts.
    pub(crate) fn mark(&self) -> usize {
        self.0.traffic.len()
    }

    /// Frames that were on the bus since a mark, of anybody.
    pub(crate) fn records_since(&self, mark: usize) -> &[Record] {
        &self.0.traffic[mark..]
    }

    /// Frames of the master that were received by the drives since a mark.
    pub(crate) fn frames_since(&self, mark: usize) -> impl Iterator<Item = &Record> {
        let node = self.0.node;
        self.records_since(mark)
            .iter()
            .filter(move |record| record.node == node && record.outcome.is_received())
    }

    /// A drive's plug is pulled: it neither sends, receives nor acknowledges, and what moves goes on.
    pub(crate) fn unplug(&mut self, axis: usize) {
        self.set_plugged(axis, false);
    }

    pub(crate) fn plug_in(&mut self, axis: usize) {
        self.set_plugged(axis, true);
    }

    fn set_plugged(&mut self, axis: usize, plugged: bool) {
        let node = self.0.bench.node_of(self.0.drives[axis]);
        self.0.bench.bus_mut().set_connected(node, plugged);
    }

    pub(crate) fn drives(&self) -> usize {
        self.0.drives.len()
    }

    /// Nobody can send for so long from now on; what waits in the controllers stays there.
    pub(crate) fn block_bus_for_ms(&mut self, ms: u64) {
        let from_ns = self.now_ns();
        let outage = Outage {
            kind: OutageKind::Blocked,
            from_ns,
            until_ns: from_ns + ms * 1_000_000,
        };
        self.0.bench.bus_mut().add_outage(outage).unwrap();
    }

    /// The adapter takes no frame and hands none over, until it works again.
    pub(crate) fn freeze_adapter(&mut self, frozen: bool) {
        self.0.adapter_is_frozen = frozen;
    }

    /// Another node, which sends what a test wants.
    pub(crate) fn add_stranger(&mut self) -> drive_sim::NodeId {
        let config = drive_sim::ControllerConfig::device();
        self.0.bench.add_master(config)
    }

    /// A frame of a stranger waits for the bus.
    pub(crate) fn stranger_sends(&mut self, stranger: drive_sim::NodeId, id: u16, data: &[u8]) {
        let frame = Frame::new(StandardId::new(id).unwrap(), data).unwrap();
        self.0.bench.port(stranger).transmit(&frame).unwrap();
    }

    /// Events of one axis, or of the bus, that the application could read so far.
    pub(crate) fn events(&self) -> usize {
        self.0.events.len()
    }
}

/// The identifier of a frame; the families have no extended frames.
pub(crate) fn id_of(record: &Record) -> u16 {
    match record.frame.id() {
        Id::Standard(id) => id.as_raw(),
        Id::Extended(_) => panic!("an extended frame: {:?}", record.frame),
    }
}

/// Fails with all violations at once, so that a failure tells the whole finding.
#[track_caller]
pub(crate) fn assert_none(violations: &[String]) {
    assert!(
        violations.is_empty(),
        "{} of these:\n  {}",
        violations.len(),
        violations
            .iter()
            .take(40)
            .cloned()
            .collect::<Vec<_>>()
            .join("\n  ")
    );
}
