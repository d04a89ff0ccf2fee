//! The bench: the master of wheels, a virtual bus, and simulated hub-motor drives, in virtual time.

mod record;
mod twist;

use can_motion::wheel::{
    FeedbackTiming, WheelConfig, WheelLimits, WheelMaster, WheelMasterConfig, WheelMode,
};
use can_motion::{AxisState, GroupId, Instant};
use drive_sim::{
    Bus, ControllerConfig, ControllerState, DeviceId, ErrorState, LoadMark, LogMode,
    NodeId as BusNode, ScriptedFaults, TxOrder, ZlacDrive, ZlacDriveConfig,
};
use indicatif::ProgressBar;
use zlac8030l::{NodeId, objects};

use super::setup::{MOST_SPEED, MOST_WHEELS, Setup};
use super::summary::{Summary, WheelSummary};
use crate::output::tell;
use crate::recording::{Recorded, Recorder};
use crate::sim::error::SimError;
use crate::sim::spectator::Spectator;
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
pub(super) struct Bench<'a> {
    bench: drive_sim::Bench<ZlacDrive, ScriptedFaults>,
    node: BusNode,
    devices: Vec<DeviceId>,
    master: WheelMaster<MOST_WHEELS>,
    setup: Setup,
    spectator: &'a mut dyn Spectator,
    recorder: Recorder,
    /// The spectator has asked for the end.
    stopped: bool,
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

impl<'a> Bench<'a> {
    /// Connects master and drives.
    pub(super) fn new(
        setup: Setup,
        recorder: Recorder,
        spectator: &'a mut dyn Spectator,
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
            cycle_mark: bench.bus().load_mark(),
            motion_start_ns: None,
            cycles_to_miss: 0,
            wheels: setup.nodes.iter().map(watch).collect(),
            bench,
            node,
            devices,
            master,
            setup,
            recorder,
            spectator,
            stopped: false,
            cycle: 0,
            set_points_of_cycle: 0,
            late_cycles: 0,
            faults: 0,
        })
    }

    /// From power-on to rest, with the speeds in between.
    pub(super) fn run(
        mut self,
        plan: &Plan,
        show_progress: bool,
    ) -> Result<(Summary, Recorded), SimError> {
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
        let mut cycles = 0;
        for speeds in plan.rows() {
            if self.stopped {
                break;
            }
            cycles += 1;
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
        self.stand();
        for _ in 0..SETTLE_US / u64::from(self.setup.cycle_us) {
            self.one_cycle()?;
        }
        let summary = self.summary(cycles, mean_bus_load);
        let recorded = self.close(summary.verdict(), summary.promises_kept)?;
        Ok((summary, recorded))
    }

    /// Speed 0 for every wheel, which the last line of a file has anyway.
    fn stand(&mut self) {
        self.phase(if self.stopped {
            "stopped by the user"
        } else {
            "the motion ends"
        });
        for watch in &self.wheels {
            // Refused after a fault, which the summary shows.
            let _ = self.master.set_target(watch.place, 0);
        }
    }

    fn now(&self) -> Instant {
        Instant::from_us(self.bench.now_ns() / 1_000)
    }

    fn run_until(&mut self, state: AxisState) -> Result<(), SimError> {
        for _ in 0..START_UP_LIMIT_US / u64::from(self.setup.cycle_us) {
            if self.master.all_are(GROUP, state) || self.stopped {
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
        self.recorder.motion_begins(now_ns / 1_000, self.cycle);
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
        self.collect_events();
        self.drain_log();
        self.record_cycle();
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
            tell(format_args!("{:.3} s: {fault}", at_ns as f64 * 1e-9));
        }
    }

    /// Shows the result, and closes every file.
    fn close(self, verdict: &str, is_good: bool) -> Result<Recorded, SimError> {
        if let Some(recording) = self.recorder.model() {
            self.spectator.end(recording, verdict, is_good)?;
        }
        Ok(self.recorder.finish())
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
            self.stopped,
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
