//! The bench: the master of wheels, a virtual bus, and simulated hub-motor drives, in virtual time.

mod twist;

use std::fs::File;
use std::io::{BufWriter, Write};

use can_motion::wheel::{
    FeedbackTiming, WheelConfig, WheelEventKind, WheelLimits, WheelMaster, WheelMasterConfig,
    WheelMode,
};
use can_motion::{AxisState, GroupId, Instant};
use drive_sim::{
    Bus, CandumpLine, ControllerConfig, ControllerState, DeviceId, ErrorState, LoadMark, LogMode,
    NodeId as BusNode, ScriptedFaults, TxOrder, ZlacDrive, ZlacDriveConfig,
};
use embedded_can::{Frame as _, Id};
use indicatif::ProgressBar;
use zlac8030l::{NodeId, PdoNumber, Service, objects};

use super::csv::{Table, WheelRow};
use super::faults::Fault;
use super::setup::{MOST_SPEED, MOST_WHEELS, Setup};
use super::summary::{Summary, WheelSummary};
use crate::output::tell;
use crate::sim::error::SimError;
use crate::trajectory::Plan;

const GROUP: GroupId = GroupId(0);
/// Time for the drives to become ready, and to be enabled, before the simulation gives up.
const START_UP_LIMIT_US: u64 = 10_000_000;
/// Time after the motion for the wheels to come to rest.
const SETTLE_US: u64 = 300_000;

/// What is measured of one wheel.
#[derive(Debug, Clone, Copy, Default)]
struct WheelWatch {
    /// Place in the master, which wants ascending nodes.
    place: usize,
    start_counts: i64,
    start_set_points: u32,
    start_received: u64,
    /// Sum of the speeds that were commanded.
    commanded: i64,
    largest_error_rpm: f64,
    /// Age of the oldest feedback, once there was any; and whether there was none at some time.
    worst_age_us: Option<u64>,
    was_unread: bool,
}

/// A bench that is ready to run.
pub(super) struct Bench {
    bench: drive_sim::Bench<ZlacDrive, ScriptedFaults>,
    node: BusNode,
    devices: Vec<DeviceId>,
    master: WheelMaster<MOST_WHEELS>,
    setup: Setup,
    candump: Option<BufWriter<File>>,
    table: Option<Table>,
    /// Begin of the present cycle, for its load.
    cycle_mark: LoadMark,
    /// When the motion began; fault scripts count from there.
    motion_start_ns: Option<u64>,
    /// Cycles in which the application is to do nothing.
    cycles_to_miss: u32,
    wheels: Vec<WheelWatch>,
    cycle: u64,
    set_points_of_cycle: usize,
    late_cycles: u32,
    faults: u32,
}

impl Bench {
    /// Connects master and drives.
    pub(super) fn new(
        setup: Setup,
        candump: Option<BufWriter<File>>,
        table: Option<Table>,
    ) -> Result<Self, SimError> {
        let mut bus = Bus::with_faults(setup.bit_rate, ScriptedFaults::new());
        bus.set_log(LogMode::Full);
        let mut bench = drive_sim::Bench::new(bus);
        let node = bench.add_master(ControllerConfig::bxcan(TxOrder::Fifo));
        let connect = |node: &NodeId| {
            let drive = ZlacDrive::new(drive_of(*node, &setup));
            bench.add_device(drive, ControllerConfig::device())
        };
        let devices = setup.nodes.iter().map(connect).collect();
        let mut ascending = setup.nodes.clone();
        ascending.sort_unstable();
        let wheels: Vec<WheelConfig> = ascending
            .iter()
            .map(|node| wheel_of(*node, &setup))
            .collect();
        let master = WheelMaster::new(master_config(&setup), &wheels).map_err(SimError::Wheels)?;
        let place = |node| {
            ascending
                .iter()
                .position(|other| other == node)
                .unwrap_or(0)
        };
        let watch = |node| WheelWatch {
            place: place(node),
            ..WheelWatch::default()
        };
        Ok(Self {
            table,
            cycle_mark: bench.bus().load_mark(),
            motion_start_ns: None,
            cycles_to_miss: 0,
            wheels: setup.nodes.iter().map(watch).collect(),
            bench,
            node,
            devices,
            master,
            setup,
            candump,
            cycle: 0,
            set_points_of_cycle: 0,
            late_cycles: 0,
            faults: 0,
        })
    }

    /// From power-on to rest, with the speeds in between.
    pub(super) fn run(mut self, plan: &Plan, show_progress: bool) -> Result<Summary, SimError> {
        self.run_until(AxisState::Ready)?;
        // Refused only when a wheel is not ready, and the summary will say so.
        let _ = self.master.enable(self.now(), GROUP);
        self.run_until(AxisState::Streaming)?;
        self.begin_motion();
        let bar = if show_progress {
            ProgressBar::new(plan.cycles() as u64)
        } else {
            ProgressBar::hidden()
        };
        let mark = self.bench.bus().load_mark();
        for speeds in plan.rows() {
            for (wheel, speed) in speeds.iter().enumerate() {
                // Refused after a fault, which the summary shows.
                let _ = self.master.set_target(self.wheels[wheel].place, *speed);
                self.wheels[wheel].commanded += i64::from(*speed);
            }
            self.one_cycle()?;
            self.late_cycles += u32::from(self.set_points_of_cycle < self.wheels.len());
            self.watch_wheels();
            bar.inc(1);
        }
        let mean_bus_load = self.bench.bus().load_since(&mark);
        bar.finish_and_clear();
        for _ in 0..SETTLE_US / u64::from(self.setup.cycle_us) {
            self.one_cycle()?;
        }
        self.close_files()?;
        Ok(self.summary(plan.cycles(), mean_bus_load))
    }

    fn now(&self) -> Instant {
        Instant::from_us(self.bench.now_ns() / 1_000)
    }

    fn run_until(&mut self, state: AxisState) -> Result<(), SimError> {
        for _ in 0..START_UP_LIMIT_US / u64::from(self.setup.cycle_us) {
            if self.master.all_are(GROUP, state) {
                break;
            }
            self.one_cycle()?;
        }
        Ok(())
    }

    fn begin_motion(&mut self) {
        self.faults = 0;
        let now_ns = self.bench.now_ns();
        self.motion_start_ns = Some(now_ns);
        for (watch, device) in self.wheels.iter_mut().zip(&self.devices) {
            let drive = self.bench.device(*device);
            watch.start_counts = drive.travel_counts(now_ns);
            watch.start_received = drive.books().rpdos;
            let snapshot = self.master.snapshot(watch.place);
            watch.start_set_points = snapshot.map_or(0, |wheel| wheel.counters.set_points);
        }
    }

    /// One cycle: control words and targets out, feedback in, until the next cycle is due.
    fn one_cycle(&mut self) -> Result<(), SimError> {
        self.apply_due_faults();
        let now = self.now();
        let is_missed = self.cycles_to_miss > 0;
        self.cycles_to_miss = self.cycles_to_miss.saturating_sub(1);
        self.cycle += 1;
        let end_ns = self.cycle * u64::from(self.setup.cycle_us) * 1_000;
        if is_missed {
            self.bench.advance_to(end_ns);
        } else {
            self.master.begin_cycle(now);
            self.serve_until(end_ns);
        }
        while let Some(event) = self.master.next_event() {
            self.faults += u32::from(matches!(event.kind, WheelEventKind::Fault(_)));
        }
        self.drain_log()?;
        self.write_row()
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
            if let Fault::MissCycles { cycles } = fault {
                self.cycles_to_miss += cycles;
            }
            fault.apply(&mut self.bench, &self.setup.nodes, &self.devices);
            tell(format_args!("{:.3} s: {fault}", at_ns as f64 * 1e-9));
        }
    }

    fn write_row(&mut self) -> Result<(), SimError> {
        let Some(table) = &mut self.table else {
            return Ok(());
        };
        let now_ns = self.bench.now_ns();
        let load = self.bench.bus().load_since(&self.cycle_mark);
        self.cycle_mark = self.bench.bus().load_mark();
        let (bench, master) = (&self.bench, &self.master);
        let rows = self.wheels.iter().zip(&self.devices);
        let rows: Vec<WheelRow> = rows
            .filter_map(|(watch, device)| {
                let drive = bench.device(*device);
                Some(WheelRow {
                    snapshot: master.snapshot(watch.place)?,
                    shaft_rpm: drive.speed_rpm(now_ns),
                    travel_counts: drive.travel_counts(now_ns),
                })
            })
            .collect();
        let is_late = self.motion_start_ns.is_some() && self.set_points_of_cycle < rows.len();
        let now = Instant::from_us(now_ns / 1_000);
        table.row(now, load, is_late, &rows).map_err(SimError::Log)
    }

    /// Everything is in its file.
    fn close_files(&mut self) -> Result<(), SimError> {
        if let Some(table) = &mut self.table {
            table.end().map_err(SimError::Log)?;
        }
        match &mut self.candump {
            Some(candump) => candump.flush().map_err(SimError::Log),
            None => Ok(()),
        }
    }

    /// Counts the set-points that ended on the wire, and writes the log.
    fn drain_log(&mut self) -> Result<(), SimError> {
        self.set_points_of_cycle = 0;
        for record in self.bench.bus_mut().log_mut().drain() {
            let id = match record.frame.id() {
                Id::Standard(id) => Service::of(id.as_raw()).ok(),
                Id::Extended(_) => None,
            };
            let is_set_point = matches!(id, Some(Service::Rpdo(PdoNumber::Pdo1, _)));
            let line = CandumpLine::new(&record, "can0");
            self.set_points_of_cycle += usize::from(is_set_point && line.is_some());
            if let (Some(out), Some(line)) = (&mut self.candump, line) {
                writeln!(out, "{line}").map_err(SimError::Log)?;
            }
        }
        Ok(())
    }

    fn watch_wheels(&mut self) {
        let now_ns = self.bench.now_ns();
        for (watch, device) in self.wheels.iter_mut().zip(&self.devices) {
            let Some(wheel) = self.master.snapshot(watch.place) else {
                continue;
            };
            let sent_rpm = f64::from(wheel.sent) / f64::from(self.setup.speed_resolution);
            let error_rpm = (sent_rpm - self.bench.device(*device).speed_rpm(now_ns)).abs();
            watch.largest_error_rpm = watch.largest_error_rpm.max(error_rpm);
            let now = Instant::from_us(now_ns / 1_000);
            let age_us = wheel.feedback.status.map(|read| now.us_since(read.at));
            watch.was_unread |= age_us.is_none();
            watch.worst_age_us = watch.worst_age_us.max(age_us);
        }
    }

    fn summary(&self, cycles: usize, mean_bus_load: f64) -> Summary {
        let wheels = (0..self.wheels.len()).filter_map(|wheel| self.wheel_summary(wheel));
        Summary::new(
            wheels.collect(),
            &self.setup,
            cycles,
            (
                self.late_cycles,
                self.master.cycle_counters().late,
                self.faults,
            ),
            mean_bus_load,
        )
    }

    fn wheel_summary(&self, wheel: usize) -> Option<WheelSummary> {
        let (watch, drive) = (
            self.wheels.get(wheel)?,
            self.bench.device(*self.devices.get(wheel)?),
        );
        let snapshot = self.master.snapshot(watch.place)?;
        let now_ns = self.bench.now_ns();
        let turns = |counts: f64| counts / drive.counts_per_turn();
        let minutes = f64::from(self.setup.cycle_us) / 60e6;
        let commanded_rpm = watch.commanded as f64 / f64::from(self.setup.speed_resolution);
        let wear = drive.eeprom_wear();
        Some(WheelSummary {
            wheel,
            node: snapshot.node.get(),
            state: snapshot.state.to_string(),
            fault: snapshot.fault.map(|fault| fault.to_string()),
            set_points: snapshot.counters.set_points - watch.start_set_points,
            received: drive.books().rpdos - watch.start_received,
            commanded_turns: commanded_rpm * minutes,
            travelled_turns: turns((drive.travel_counts(now_ns) - watch.start_counts) as f64),
            largest_speed_error_rpm: watch.largest_error_rpm,
            final_speed_rpm: drive.speed_rpm(now_ns),
            oldest_feedback_ms: watch
                .worst_age_us
                .filter(|_| !watch.was_unread)
                .map(|age_us| age_us as f64 / 1e3),
            sdo_timeouts: snapshot.counters.timeouts,
            eeprom_writes: wear.single_writes + wear.saves + wear.restores,
            streamed: snapshot.state == AxisState::Streaming,
        })
    }
}

fn master_config(setup: &Setup) -> WheelMasterConfig {
    WheelMasterConfig {
        cycle_us: setup.cycle_us,
        bit_rate: setup.bit_rate,
        feedback: FeedbackTiming::Sync,
        ..WheelMasterConfig::DEFAULT
    }
}

fn wheel_of(node: NodeId, setup: &Setup) -> WheelConfig {
    WheelConfig {
        speed_resolution: setup.speed_resolution,
        ramp_ms: setup.ramp_ms,
        // The file says how fast speeds change.
        ..WheelConfig::new(
            node,
            WheelMode::Velocity,
            WheelLimits::speed(MOST_SPEED as u16, 2 * MOST_SPEED as u32),
        )
    }
}

/// A drive whose speed resolution was stored when it was commissioned.
fn drive_of(node: NodeId, setup: &Setup) -> ZlacDriveConfig {
    let resolution = objects::SPEED_RESOLUTION.address();
    ZlacDriveConfig {
        stored: vec![(resolution, setup.speed_resolution.into())],
        response_delay: setup.response_delay,
        seed: setup.seed.wrapping_add(u64::from(node.get())),
        ..ZlacDriveConfig::new(node)
    }
}
