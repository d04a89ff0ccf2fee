//! The unmodified master on the virtual bus with simulated drives, cycle by cycle.

use can_motion::facts::Knowledge;
use can_motion::family::{CycleConfig, Family};
use can_motion::wheel::{WheelConfig, WheelLimits, WheelMasterConfig, WheelMode, Zlac};
use can_motion::{
    AxisConfig, AxisSnapshot, AxisState, Dyn, Event, EventKind, GroupId, Instant, Limits, Master,
    MasterConfig, StepChange, Travel,
};
use drive_sim::{
    Bench, BitRate, Bus, ControllerConfig, Device, DeviceId, DynDrive, DynDriveConfig, LogMode,
    NodeId, Record, ScriptedFaults, TxOrder, ZlacDrive, ZlacDriveConfig,
};
use dyn_can::{DriveId, GearNumber, StepLimit};

/// Room for the axes of any test.
pub const ROOM: usize = 16;

/// The group of every axis unless a test says otherwise.
pub const GROUP: GroupId = GroupId(0);

/// Limits of an axis that may do all that the protocol can say, 64 counts of acceleration a cycle: a test that is about a limit sets it.
pub const WIDEST: Limits = match StepChange::from_counts(64) {
    Some(change) => Limits::new(StepLimit::MAX, change, Travel::WHOLE),
    None => panic!("64 counts are a change of step"),
};

/// An axis with the gear number of a drive as it leaves the factory.
///
/// # Panics
/// Never: 4096 is a gear number.
#[must_use]
pub fn axis_config(drive: DriveId) -> AxisConfig {
    let gear = GearNumber::new(4_096).expect("a gear number");
    AxisConfig::new(drive, gear, WIDEST)
}

/// Whether the position of an axis is known.
#[must_use]
pub fn is_anchored(axis: &AxisSnapshot) -> bool {
    axis.facts.knowledge == Knowledge::Anchored
}

/// A wheel that follows speeds of the whole range, changing by 10 r/min in a cycle.
#[must_use]
pub fn wheel_config(node: zlac8030l::NodeId) -> WheelConfig {
    WheelConfig::new(node, WheelMode::Velocity, WheelLimits::speed(1_000, 10))
}

/// A master, a bus, and drives.
pub struct Rig<D: Device = DynDrive, F: Family = Dyn> {
    /// The bus with the drives.
    pub bench: Bench<D, ScriptedFaults>,
    /// The master's node.
    pub node: NodeId,
    /// The drives, in the order of the axes.
    pub drives: Vec<DeviceId>,
    /// The master.
    pub master: Master<ROOM, F>,
    /// Everything that the master has told so far.
    pub events: Vec<Event<F::EventKind>>,
    /// Everything that was on the wire so far.
    pub traffic: Vec<Record>,
    /// The adapter between master and bus takes nothing and hands nothing over.
    pub adapter_is_frozen: bool,
    cycle_us: u64,
    cycles: u64,
}

/// An adapter that has no room and received nothing.
struct FrozenAdapter;

impl embedded_can::nb::Can for FrozenAdapter {
    type Frame = drive_sim::Frame;
    type Error = drive_sim::ControllerError;

    fn transmit(&mut self, _: &Self::Frame) -> nb::Result<Option<Self::Frame>, Self::Error> {
        Err(nb::Error::WouldBlock)
    }

    fn receive(&mut self) -> nb::Result<Self::Frame, Self::Error> {
        Err(nb::Error::WouldBlock)
    }
}

impl<D: Device, F: Family> Rig<D, F> {
    fn connect(
        rate: BitRate,
        order: TxOrder,
        drives: impl Iterator<Item = D>,
        master: Master<ROOM, F>,
        config: &F::Config,
    ) -> Self {
        let mut bus = Bus::with_faults(rate, ScriptedFaults::new());
        bus.set_log(LogMode::Full);
        let mut bench = Bench::new(bus);
        let node = bench.add_master(ControllerConfig::bxcan(order));
        let drives = drives
            .map(|drive| bench.add_device(drive, ControllerConfig::device()))
            .collect();
        Self {
            bench,
            node,
            drives,
            master,
            events: Vec::new(),
            traffic: Vec::new(),
            adapter_is_frozen: false,
            cycle_us: u64::from(config.cycle_us()),
            cycles: 0,
        }
    }

    /// The present instant.
    pub fn now(&self) -> Instant {
        Instant::from_us(self.bench.now_ns() / 1_000)
    }

    /// One cycle of master and bus.
    pub fn cycle(&mut self) {
        let now = self.now();
        self.master.begin_cycle(now);
        self.serve_cycle();
    }

    /// One cycle in which something happens after its begin and before its first frame is offered.
    pub fn cycle_with(&mut self, happens: impl FnOnce(&mut Self)) {
        let now = self.now();
        self.master.begin_cycle(now);
        happens(self);
        self.serve_cycle();
    }

    /// One cycle of the bus in which the application forgot to begin one.
    pub fn skip_cycle(&mut self) {
        self.cycles += 1;
        self.bench.advance_to(self.cycles * self.cycle_us * 1_000);
        self.collect();
    }

    /// Many cycles.
    pub fn cycles(&mut self, count: usize) {
        (0..count).for_each(|_| self.cycle());
    }

    fn serve_cycle(&mut self) {
        self.cycles += 1;
        let end_ns = self.cycles * self.cycle_us * 1_000;
        loop {
            let now = self.now();
            // Whether it is idle or blocked, the next event on the bus is the next chance.
            let _ = if self.adapter_is_frozen {
                can_motion::service(&mut self.master, &mut FrozenAdapter, now)
            } else {
                can_motion::service(&mut self.master, &mut self.bench.port(self.node), now)
            };
            if !self.bench.step_to(end_ns) {
                break;
            }
        }
        self.collect();
    }

    fn collect(&mut self) {
        self.traffic.extend(self.bench.bus_mut().log_mut().drain());
        self.events
            .extend(std::iter::from_fn(|| self.master.next_event()));
    }

    /// Cycles until every axis is in a state.
    ///
    /// # Panics
    /// When that takes longer than five seconds; the message has the last events.
    pub fn run_until(&mut self, state: AxisState) {
        for _ in 0..5_000_000 / self.cycle_us {
            if self.master.all_are(GROUP, state) {
                return;
            }
            self.cycle();
        }
        let last: Vec<_> = self.events.iter().rev().take(8).collect();
        panic!("the axes do not become {state}; the last events, newest first: {last:#?}");
    }

    /// Cycles until every axis is checked and at rest, whether its drive has power or not.
    ///
    /// # Panics
    /// As [`Self::run_until`].
    pub fn run_until_checked(&mut self) {
        use AxisState::{FoundOn, Holding, Ready};
        for _ in 0..5_000_000 / self.cycle_us {
            let mut states = (0..self.drives.len()).map(|axis| self.state(axis));
            if states.all(|state| matches!(state, FoundOn | Holding | Ready)) {
                return;
            }
            drop(states);
            self.cycle();
        }
        self.run_until(Ready);
    }

    /// The state of an axis.
    ///
    /// # Panics
    /// When it has none of the states.
    pub fn state(&self, axis: usize) -> AxisState {
        self.master.state(axis).expect("an axis of the rig")
    }

    /// From power-on to drives without power: those that came up with their servo on are disabled.
    ///
    /// # Panics
    /// When the axes do not get there.
    pub fn ready(&mut self) {
        self.run_until_checked();
        let now = self.now();
        self.master.disable(now, GROUP);
        self.run_until(AxisState::Ready);
    }

    /// From power-on to streaming.
    ///
    /// # Panics
    /// When the axes do not get there.
    pub fn stream(&mut self) {
        self.ready();
        let now = self.now();
        self.master
            .enable(now, GROUP)
            .expect("ready axes can be enabled");
        self.run_until(AxisState::Streaming);
    }

    /// A snapshot of an axis.
    ///
    /// # Panics
    /// When there is no such axis.
    pub fn axis(&self, axis: usize) -> F::Snapshot {
        self.master.snapshot(axis).expect("an axis of the rig")
    }

    /// A simulated drive.
    pub fn drive(&self, axis: usize) -> &D {
        self.bench.device(self.drives[axis])
    }

    /// A simulated drive, to command faults.
    pub fn drive_mut(&mut self, axis: usize) -> &mut D {
        self.bench.device_mut(self.drives[axis])
    }

    /// True when an event of this kind was told.
    pub fn saw(&self, wanted: impl Fn(&F::EventKind) -> bool) -> bool {
        self.events.iter().any(|event| wanted(&event.kind))
    }
}

impl Rig {
    /// Drives 1, 2, 3 ... with the usual settings.
    pub fn with_axes(axes: usize) -> Self {
        let drives: Vec<DynDriveConfig> =
            DriveId::all().take(axes).map(DynDriveConfig::new).collect();
        let configs: Vec<AxisConfig> = DriveId::all().take(axes).map(axis_config).collect();
        Self::new(MasterConfig::DEFAULT, &configs, drives, TxOrder::Fifo)
    }

    /// Any master with any drives, in ascending order of drive id.
    ///
    /// # Panics
    /// When the master refuses the configuration.
    pub fn new(
        config: MasterConfig,
        axes: &[AxisConfig],
        drives: Vec<DynDriveConfig>,
        order: TxOrder,
    ) -> Self {
        let master = Master::new(config, axes).expect("a configuration that works");
        let drives = drives.into_iter().map(DynDrive::new);
        Self::connect(BitRate::Kbit1000, order, drives, master, &config)
    }

    /// Moves every axis at constant velocity for some cycles.
    ///
    /// # Panics
    /// When an axis takes no targets.
    pub fn move_all(&mut self, step_counts: &[i32], cycles: i32) {
        let start: Vec<i32> = (0..step_counts.len())
            .map(|axis| self.axis(axis).target_counts)
            .collect();
        for cycle in 1..=cycles {
            for (axis, (start, step)) in start.iter().zip(step_counts).enumerate() {
                self.master
                    .set_target(axis, start + step * cycle)
                    .expect("a streaming axis");
            }
            self.cycle();
        }
    }

    /// The states that an axis entered, in order.
    pub fn path(&self, axis: u8) -> Vec<AxisState> {
        let states = self
            .events
            .iter()
            .filter(|event| event.axis == Some(axis))
            .filter_map(|event| match event.kind {
                EventKind::State { to, .. } => Some(to),
                _ => None,
            });
        states.collect()
    }
}

/// Wheels on a bus of the bit rate of their master.
pub type WheelRig = Rig<ZlacDrive, Zlac>;

impl WheelRig {
    /// Any master of wheels with any drives, in ascending order of node.
    ///
    /// # Panics
    /// When the master refuses the configuration.
    pub fn wheels(
        config: WheelMasterConfig,
        wheels: &[WheelConfig],
        drives: Vec<ZlacDriveConfig>,
    ) -> Self {
        let master = Master::new(config, wheels).expect("a configuration that works");
        let drives = drives.into_iter().map(ZlacDrive::new);
        Self::connect(config.bit_rate, TxOrder::Fifo, drives, master, &config)
    }
}
