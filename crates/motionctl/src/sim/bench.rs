//! The bench: the firmware's master, a virtual bus, and simulated drives, in virtual time.

use std::fs::File;
use std::io::{BufWriter, Write};

use can_motion::{
    AxisConfig, AxisState, Event, GroupId, Instant, Limits, Master, MasterConfig, PollPeriods,
};
use drive_sim::{
    BitRate, Bus, CandumpLine, ControllerConfig, ControllerState, DeviceId, DynDrive, ErrorState,
    LoadMark, LogMode, NodeId, ScriptedFaults, TxOrder,
};
use dyn_can::{DriveId, StepLimit};
use indicatif::{ProgressBar, ProgressStyle};

use super::error::SimError;
use super::faults::{Fault, Rig, Script};
use super::recording::{AxisSample, Kind, Recording, Sample};
use super::spectator::{Order, Spectator};
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
    pub(crate) faults: Script,
}

/// A bench that is ready to run.
pub(crate) struct Bench<'a> {
    bench: drive_sim::Bench<DynDrive, ScriptedFaults>,
    node: NodeId,
    devices: Vec<DeviceId>,
    master: Master<MOST_AXES>,
    /// Place in the master of each axis: the master wants its drives in ascending order.
    places: Vec<usize>,
    setup: Setup,
    watch: Watch,
    candump: Option<BufWriter<File>>,
    spectator: &'a mut dyn Spectator,
    recording: Option<Recording>,
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
    /// Connects master and drives. `records` keeps what a report or a view needs.
    pub(crate) fn new(
        setup: Setup,
        candump: Option<BufWriter<File>>,
        records: bool,
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
        let master = Master::new(config, &axes).map_err(SimError::Config)?;
        let place = |drive| {
            ascending
                .iter()
                .position(|other| other == drive)
                .unwrap_or(0)
        };
        let places: Vec<usize> = setup.drives.iter().map(place).collect();
        let watch = Watch::new(node, setup.drives.len());
        let recording = records.then(|| {
            let bit_ns = setup.bit_rate.bit_ns();
            Recording::new(setup.drives.clone(), node, setup.cycle_us, bit_ns)
        });
        let cycle_mark = bench.bus().load_mark();
        Ok(Self {
            bench,
            node,
            devices,
            master,
            places,
            setup,
            watch,
            candump,
            spectator,
            recording,
            cycle_mark,
            cycle: 0,
            motion_start_ns: None,
            cycles_to_miss: 0,
            stopped: false,
        })
    }

    /// Runs a motion from power-on to rest.
    pub(crate) fn run(
        mut self,
        plan: &Plan,
        show_progress: bool,
    ) -> Result<(Summary, Option<Recording>), SimError> {
        let ready = self.wait_for(AxisState::Ready)?
            && self.master.enable(self.now(), GROUP).is_ok()
            && self.wait_for(AxisState::Streaming)?;
        let anchors = self.targets();
        if ready {
            self.begin_motion();
            self.watch.start(self.bench.bus().load_mark());
            self.follow(plan, &anchors, show_progress)?;
            self.phase(if self.stopped {
                "stopped by the user"
            } else {
                "the motion ends"
            });
            self.settle()?;
            self.watch.stop(self.bench.bus());
        }
        if let Some(candump) = &mut self.candump {
            candump.flush().map_err(SimError::Log)?;
        }
        if self.setup.faults.left() > 0 {
            eprintln!(
                "note: {} faults of the script were not reached",
                self.setup.faults.left()
            );
        }
        let summary = self.summary(plan, &anchors);
        if let Some(recording) = &self.recording {
            self.spectator.end(recording, &summary)?;
        }
        Ok((summary, self.recording))
    }

    fn begin_motion(&mut self) {
        self.motion_start_ns = Some(self.bench.now_ns());
        let now_us = self.now().as_us();
        if let Some(recording) = &mut self.recording {
            recording.motion_start_us = Some(now_us);
        }
        self.phase("the motion begins");
    }

    fn phase(&mut self, text: &str) {
        let at_us = self.now().as_us();
        if let Some(recording) = &mut self.recording {
            recording.happened(at_us, None, Kind::Phase, text);
        }
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
        while self.now().as_us() < deadline_us && !self.watch.saw_fault() && !self.stopped {
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
            if self.watch.saw_fault() || self.stopped {
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
        self.apply_due_faults();
        let now = self.now();
        let is_missed = self.cycles_to_miss > 0;
        self.cycles_to_miss = self.cycles_to_miss.saturating_sub(1);
        if !is_missed {
            self.master.begin_cycle(now);
        }
        self.watch.cycle_begins(now, &self.master, &self.places);
        self.cycle += 1;
        let end_ns = self.cycle * u64::from(self.setup.cycle_us) * 1_000;
        if is_missed {
            self.bench.advance_to(end_ns);
        } else {
            self.serve_until(end_ns);
        }
        self.drain_log()?;
        let is_late = self.watch.cycle_ends(self.bench.bus());
        self.collect_events();
        self.record_sample(is_late);
        self.obey_spectator()
    }

    fn serve_until(&mut self, end_ns: u64) {
        let bus_off = ControllerState::On(ErrorState::BusOff);
        loop {
            let now = self.now();
            if self.bench.bus().controller(self.node).state() == bus_off {
                self.master.on_bus_off(now);
            }
            // Whether it is idle or blocked, the next event on the bus is the next chance.
            let _ = can_motion::service(&mut self.master, &mut self.bench.port(self.node), now);
            if !self.bench.step_to(end_ns) {
                break;
            }
        }
    }

    fn apply_due_faults(&mut self) {
        let Some(start_ns) = self.motion_start_ns else {
            return;
        };
        let at_ns = self.bench.now_ns() - start_ns;
        while let Some(fault) = self.setup.faults.next_due(at_ns) {
            self.apply(fault);
        }
    }

    fn apply(&mut self, fault: Fault) {
        if let Fault::MissCycles { cycles } = fault {
            self.cycles_to_miss += cycles;
        }
        fault.apply(&mut Rig {
            bench: &mut self.bench,
            master: self.node,
            drives: &self.setup.drives,
            devices: &self.devices,
        });
        let at_us = self.now().as_us();
        let axis = fault
            .drive()
            .and_then(|drive| self.setup.drives.iter().position(|other| *other == drive));
        if let Some(recording) = &mut self.recording {
            recording.happened(at_us, axis, Kind::Cause, fault.to_string());
        }
    }

    fn collect_events(&mut self) {
        while let Some(event) = self.master.next_event() {
            self.watch.event(&event);
            self.report(&event);
            let axis = event.axis.and_then(|axis| {
                self.places
                    .iter()
                    .position(|place| *place == usize::from(axis))
            });
            if let Some(recording) = &mut self.recording {
                recording.event(&event, axis);
            }
        }
    }

    fn record_sample(&mut self, is_late: bool) {
        let Some(recording) = &mut self.recording else {
            return;
        };
        let (now, now_ns) = (
            Instant::from_us(self.bench.now_ns() / 1_000),
            self.bench.now_ns(),
        );
        let axes = self.places.iter().zip(&self.devices);
        recording.samples.push(Sample {
            at_us: now.as_us(),
            load: self.bench.bus().load_since(&self.cycle_mark),
            is_late,
            axes: axes
                .filter_map(|(&place, &device)| {
                    let position = self.bench.device(device).position_counts(now_ns);
                    Some(AxisSample::new(
                        &self.master.snapshot(place)?,
                        position,
                        now,
                    ))
                })
                .collect(),
        });
        self.cycle_mark = self.bench.bus().load_mark();
    }

    fn obey_spectator(&mut self) -> Result<(), SimError> {
        let Some(recording) = &self.recording else {
            return Ok(());
        };
        for order in self
            .spectator
            .after_cycle(recording, &self.master, &self.places)?
        {
            match order {
                Order::Stop => {
                    self.master.stop(self.now(), GROUP);
                    self.stopped = true;
                }
                Order::Fault(fault) => self.apply(fault),
            }
        }
        Ok(())
    }

    fn drain_log(&mut self) -> Result<(), SimError> {
        for record in self.bench.bus_mut().log_mut().drain() {
            self.watch.record(&record);
            if let Some(recording) = &mut self.recording {
                recording.frame(&record);
            }
            if let (Some(file), Some(line)) = (&mut self.candump, CandumpLine::new(&record, "can0"))
            {
                writeln!(file, "{line}").map_err(SimError::Log)?;
            }
        }
        Ok(())
    }

    fn report(&self, event: &Event) {
        if self.spectator.owns_terminal() {
            return;
        }
        if let can_motion::EventKind::Fault(fault) = event.kind {
            let axis = event
                .axis
                .map_or(String::new(), |axis| format!(" axis {axis}:"));
            eprintln!("{} s:{axis} {fault}", event.at);
        }
    }

    fn summary(&self, plan: &Plan, anchors: &[i32]) -> Summary {
        let last = plan.last();
        let axes = self.places.iter().enumerate().filter_map(|(axis, &place)| {
            let snapshot = self.master.snapshot(place)?;
            let drive = self.bench.device(self.devices[axis]);
            let planned = anchors[axis].wrapping_add(last.get(axis).copied().unwrap_or(0));
            // Where the ramp of a stop ends is as good as any target.
            let target = if self.stopped {
                snapshot.target_counts
            } else {
                planned
            };
            let now_ns = self.bench.now_ns();
            let (watch, anchor) = (&self.watch, anchors[axis]);
            Some(watch.axis_summary(axis, &snapshot, drive, now_ns, anchor, target))
        });
        Summary::new(
            axes.collect(),
            &self.master.cycle_counters(),
            &self.watch,
            &self.setup,
            self.stopped,
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
