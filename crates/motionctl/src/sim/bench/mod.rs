//! The bench: the firmware's master, a virtual bus, and simulated drives, in virtual time.

mod cycle;
mod record;
mod run;

use can_motion::{
    AxisConfig, GroupId, Instant, Limits, MasterConfig, ServoMaster, StepChange, Travel,
};
use drive_sim::{
    Bus, ControllerConfig, DeviceId, DynDrive, LoadMark, LogMode, NodeId, ScriptedFaults,
};
use dyn_can::DriveId;

use super::error::SimError;
use super::setup::{MOST_AXES, Setup};
use super::spectator::Spectator;
use super::watch::Watch;
use crate::recording::Recorder;
pub(crate) use record::wire_frame;
pub(crate) use run::Run;

const GROUP: GroupId = GroupId(0);

/// A bench that is ready to run.
pub(crate) struct Bench<'a> {
    bench: drive_sim::Bench<DynDrive, ScriptedFaults>,
    node: NodeId,
    devices: Vec<DeviceId>,
    master: ServoMaster<MOST_AXES>,
    /// Place in the master of each axis: the master wants its drives in ascending order.
    places: Vec<usize>,
    setup: Setup,
    watch: Watch,
    spectator: &'a mut dyn Spectator,
    recorder: Recorder,
    /// Begin of the present cycle, for its load.
    cycle_mark: LoadMark,
    cycle: u64,
    /// When the motion began; fault scripts count from there.
    motion_start_ns: Option<u64>,
    /// Cycles in which the application is to do nothing.
    cycles_to_miss: u32,
    stopped: bool,
}

impl<'a> Bench<'a> {
    /// Connects master and drives.
    pub(crate) fn new(
        setup: Setup,
        recorder: Recorder,
        spectator: &'a mut dyn Spectator,
    ) -> Result<Self, SimError> {
        let mut bus = Bus::with_faults(setup.bit_rate, ScriptedFaults::new());
        bus.set_log(LogMode::Full);
        let mut bench = drive_sim::Bench::new(bus);
        let node = bench.add_master(ControllerConfig::bxcan(setup.tx_order));
        let devices = setup
            .drives
            .iter()
            .map(|&drive| {
                bench.add_device(setup.drive_options.drive(drive), ControllerConfig::device())
            })
            .collect();
        let mut ascending = setup.drives.clone();
        ascending.sort_unstable();
        let axes: Vec<AxisConfig> = ascending
            .iter()
            .map(|&drive| axis_of(&setup, drive))
            .collect();
        let config = MasterConfig {
            cycle_us: setup.cycle_us,
            bus: setup
                .drive_options
                .bus_setup(setup.bit_rate, setup.tx_order),
            ..MasterConfig::DEFAULT
        };
        let master = ServoMaster::new(config, &axes).map_err(SimError::Config)?;
        let place = |drive| {
            ascending
                .iter()
                .position(|other| other == drive)
                .unwrap_or(0)
        };
        let places: Vec<usize> = setup.drives.iter().map(place).collect();
        let watch = Watch::new(node, setup.drives.len());
        let cycle_mark = bench.bus().load_mark();
        Ok(Self {
            bench,
            node,
            devices,
            master,
            places,
            setup,
            watch,
            spectator,
            recorder,
            cycle_mark,
            cycle: 0,
            motion_start_ns: None,
            cycles_to_miss: 0,
            stopped: false,
        })
    }

    fn now(&self) -> Instant {
        Instant::from_us(self.bench.now_ns() / 1_000)
    }
}

fn axis_of(setup: &Setup, drive: DriveId) -> AxisConfig {
    let limits = Limits::new(setup.max_step, StepChange::MAX, Travel::WHOLE);
    AxisConfig {
        polls: setup.polls,
        unwatched: setup.polls.status_us.is_none(),
        ..AxisConfig::new(drive, setup.drive_options.gear(drive), limits)
    }
}
