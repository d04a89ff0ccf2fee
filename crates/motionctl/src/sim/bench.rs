//! The bench: the firmware's master, a virtual bus, and simulated drives, in virtual time.

use std::fs::File;
use std::io::{BufWriter, Write};

use can_motion::{
    AxisConfig, AxisState, Event, GroupId, Instant, Limits, Master, MasterConfig, PollPeriods,
};
use drive_sim::{
    BitRate, Bus, CandumpLine, ControllerConfig, DeviceId, DynDrive, LogMode, NodeId, TxOrder,
};
use dyn_can::{DriveId, StepLimit};
use indicatif::{ProgressBar, ProgressStyle};

use super::error::SimError;
use super::summary::Summary;
use super::watch::Watch;
use crate::trajectory::Plan;
use crate::virtual_drives::VirtualDriveOptions;

/// Axes that a simulation can hold: the widest choice of a bus at any bit rate and cycle.
pub(crate) const MOST_AXES: usize = 63;

const GROUP: GroupId = GroupId(0);
/// Time for the drives to become ready, and to be enabled, before the simulation gives up.
const START_UP_LIMIT_US: u64 = 10_000_000;
/// Time after the motion for the drives to arrive and to be read once more.
const SETTLE_US: u64 = 300_000;
/// Cycles between two updates of the progress bar.
const PROGRESS_STEP: usize = 100;

/// What to simulate.
#[derive(Debug)]
pub(crate) struct Setup {
    /// Drive of each axis, in the order of the columns.
    pub(crate) drives: Vec<DriveId>,
    pub(crate) cycle_us: u32,
    pub(crate) bit_rate: BitRate,
    pub(crate) max_step: StepLimit,
    pub(crate) polls: PollPeriods,
    pub(crate) drive_options: VirtualDriveOptions,
    pub(crate) tx_order: TxOrder,
}

/// A bench that is ready to run.
pub(crate) struct Bench {
    bench: drive_sim::Bench<DynDrive>,
    node: NodeId,
    devices: Vec<DeviceId>,
    master: Master<MOST_AXES>,
    /// Place in the master of each axis: the master wants its drives in ascending order.
    places: Vec<usize>,
    setup: Setup,
    watch: Watch,
    candump: Option<BufWriter<File>>,
    cycle: u64,
}

impl Bench {
    /// Connects master and drives.
    pub(crate) fn new(setup: Setup, candump: Option<BufWriter<File>>) -> Result<Self, SimError> {
        let mut bus = Bus::new(setup.bit_rate);
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
        let master = Master::new(config, &axes).map_err(SimError::Config)?;
        let place = |drive| {
            ascending
                .iter()
                .position(|other| other == drive)
                .unwrap_or(0)
        };
        let places: Vec<usize> = setup.drives.iter().map(place).collect();
        let watch = Watch::new(node, setup.drives.len());
        Ok(Self {
            bench,
            node,
            devices,
            master,
            places,
            setup,
            watch,
            candump,
            cycle: 0,
        })
    }

    /// Runs a motion from power-on to rest.
    pub(crate) fn run(mut self, plan: &Plan, show_progress: bool) -> Result<Summary, SimError> {
        let ready = self.wait_for(AxisState::Ready)?
            && self.master.enable(self.now(), GROUP).is_ok()
            && self.wait_for(AxisState::Streaming)?;
        let anchors = self.targets();
        if ready {
            self.watch.start(self.bench.bus().load_mark());
            self.follow(plan, &anchors, show_progress)?;
            self.settle()?;
            self.watch.stop(self.bench.bus());
        }
        if let Some(candump) = &mut self.candump {
            candump.flush().map_err(SimError::Log)?;
        }
        Ok(self.summary(plan, &anchors))
    }

    fn now(&self) -> Instant {
        Instant::from_us(self.bench.now_ns() / 1_000)
    }

    fn targets(&self) -> Vec<i32> {
        let target = |&place| {
            self.master
                .snapshot(place)
                .map_or(0, |axis| axis.target_counts)
        };
        self.places.iter().map(target).collect()
    }

    fn wait_for(&mut self, state: AxisState) -> Result<bool, SimError> {
        let deadline_us = self.now().as_us() + START_UP_LIMIT_US;
        while self.now().as_us() < deadline_us && !self.watch.saw_fault() {
            self.one_cycle()?;
            if self.master.all_are(GROUP, state) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn follow(
        &mut self,
        plan: &Plan,
        anchors: &[i32],
        show_progress: bool,
    ) -> Result<(), SimError> {
        let bar = progress_bar(plan.cycles.len(), show_progress);
        for (index, row) in plan.cycles.iter().enumerate() {
            for (axis, (&place, &offset)) in self.places.iter().zip(row).enumerate() {
                // A refusal is an axis that stopped by a fault, which the watch has seen.
                let _ = self
                    .master
                    .set_target(place, anchors[axis].wrapping_add(offset));
            }
            self.one_cycle()?;
            if index % PROGRESS_STEP == 0 {
                bar.set_position(index as u64);
            }
            if self.watch.saw_fault() {
                break;
            }
        }
        bar.finish_and_clear();
        Ok(())
    }

    fn settle(&mut self) -> Result<(), SimError> {
        for _ in 0..SETTLE_US.div_ceil(u64::from(self.setup.cycle_us)) {
            self.one_cycle()?;
        }
        Ok(())
    }

    /// One cycle: set-points and a request out, replies in, until the next cycle is due.
    fn one_cycle(&mut self) -> Result<(), SimError> {
        let now = self.now();
        self.master.begin_cycle(now);
        self.watch.cycle_begins(now, &self.master, &self.places);
        self.cycle += 1;
        let end_ns = self.cycle * u64::from(self.setup.cycle_us) * 1_000;
        loop {
            let now = self.now();
            // Whether it is idle or blocked, the next event on the bus is the next chance.
            let _ = can_motion::service(&mut self.master, &mut self.bench.port(self.node), now);
            if !self.bench.step_to(end_ns) {
                break;
            }
        }
        self.drain_log()?;
        self.watch.cycle_ends(self.bench.bus());
        while let Some(event) = self.master.next_event() {
            self.watch.event(&event);
            self.report(&event);
        }
        Ok(())
    }

    fn drain_log(&mut self) -> Result<(), SimError> {
        for record in self.bench.bus_mut().log_mut().drain() {
            self.watch.record(&record);
            if let (Some(file), Some(line)) = (&mut self.candump, CandumpLine::new(&record, "can0"))
            {
                writeln!(file, "{line}").map_err(SimError::Log)?;
            }
        }
        Ok(())
    }

    fn report(&self, event: &Event) {
        if let can_motion::EventKind::Fault(fault) = event.kind {
            let axis = event
                .axis
                .map_or(String::new(), |axis| format!(" axis {axis}:"));
            eprintln!("{} s:{axis} {fault}", event.at);
        }
    }

    fn summary(self, plan: &Plan, anchors: &[i32]) -> Summary {
        let last = plan.last();
        let axes = self.places.iter().enumerate().filter_map(|(axis, &place)| {
            let snapshot = self.master.snapshot(place)?;
            let drive = self.bench.device(self.devices[axis]);
            let target = anchors[axis].wrapping_add(last.get(axis).copied().unwrap_or(0));
            let now_ns = self.bench.now_ns();
            let (watch, anchor) = (&self.watch, anchors[axis]);
            Some(watch.axis_summary(axis, &snapshot, drive, now_ns, anchor, target))
        });
        Summary::new(
            axes.collect(),
            &self.master.cycle_counters(),
            &self.watch,
            &self.setup,
        )
    }
}

fn axis_of(setup: &Setup, drive: DriveId) -> AxisConfig {
    AxisConfig {
        limits: Limits {
            max_step: setup.max_step,
            ..Limits::WIDEST
        },
        polls: setup.polls,
        ..AxisConfig::new(drive)
    }
}

fn progress_bar(cycles: usize, show: bool) -> ProgressBar {
    if !show {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} cycles, {eta} left");
    let bar = ProgressBar::new(cycles as u64);
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
