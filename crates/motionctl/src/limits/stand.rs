//! The test stand: the unmodified master at 1 kHz and 1 Mbit/s, and simulated drives whose set-points never end.

use can_motion::plan::{BusPlan, BusSetup, ResponseWindow};
use can_motion::{
    AxisConfig, AxisState, EventKind, Fault, GroupId, Instant, Limits, MasterConfig, PollKind,
    PollPeriods, ServoMaster, StepChange, Travel,
};
use drive_sim::{
    Bench, BitRate, Bus, ControllerConfig, DynDrive, DynDriveConfig, LogMode, NodeId, Outage,
    OutageKind, ResponseDelay, SplitMix64, TxOrder,
};
use dyn_can::{DriveId, StepLimit};

use super::error::LimitsError;
use super::measure::{BIT_NS, Measurements};
use super::payload::Payload;
use super::tap::{HandedOver, Tap};

/// Most axes that are tried.
pub(crate) const MOST_AXES: usize = 16;

pub(crate) const CYCLE_US: u32 = 1_000;
const CYCLE_NS: u64 = CYCLE_US as u64 * 1_000;
const GROUP: GroupId = GroupId(0);
const POLL_PERIOD_US: u32 = 20_000;
/// Periods in which every axis is polled once before anything is measured.
const POLL_PERIODS_BEFORE: u32 = 3;
/// Cycles in which the axes must stream.
const START_UP_CYCLES: u64 = 5_000;
/// The drives cannot follow these steps, and need not: only the frames count.
const NO_LIMITS: Limits = Limits {
    backlog_counts: u32::MAX,
    following_error_counts: u32::MAX,
    drift_tolerance_counts: u32::MAX,
    ..Limits::new(StepLimit::MAX, StepChange::MAX, Travel::WHOLE)
};
/// Far enough from 0 that every position is read with four bytes.
pub(crate) const START_COUNTS: i32 = 1 << 25;

/// What is on the stand.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Load {
    pub(crate) axes: usize,
    /// Mean response delay of polled drives; `None` for set-points only.
    pub(crate) delay_us: Option<u32>,
    pub(crate) payload: PayloadKind,
    pub(crate) seed: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PayloadKind {
    Worst,
    Random,
}

impl Load {
    fn window(&self) -> ResponseWindow {
        let delay_us = self.delay_us.unwrap_or(500);
        ResponseWindow {
            min_us: delay_us - delay_us / 4,
            max_us: delay_us + delay_us / 4,
        }
    }

    fn config(&self) -> MasterConfig {
        MasterConfig {
            cycle_us: CYCLE_US,
            bus: BusSetup {
                response: self.window(),
                ..BusSetup::DEFAULT
            },
            ..MasterConfig::DEFAULT
        }
    }

    fn drives(&self) -> impl Iterator<Item = DriveId> {
        DriveId::all().take(self.axes)
    }

    fn axis(&self, drive: DriveId) -> AxisConfig {
        let period = self.delay_us.map(|_| POLL_PERIOD_US);
        AxisConfig {
            polls: PollPeriods {
                status_us: period,
                position_us: period,
                ..PollPeriods::OFF
            },
            unwatched: period.is_none(),
            ..AxisConfig::new(
                drive,
                DynDriveConfig::new(drive).group3.gear_number,
                NO_LIMITS,
            )
        }
    }

    fn drive(&self, drive: DriveId) -> DynDrive {
        let ResponseWindow { min_us, max_us } = self.window();
        let ns = |us| u64::from(us) * 1_000;
        DynDrive::new(DynDriveConfig {
            // The window is around its mean, so it does not end before it begins.
            response_delay: ResponseDelay::between(ns(min_us), ns(max_us))
                .unwrap_or(ResponseDelay::fixed(ns(min_us))),
            seed: self.seed.wrapping_add(u64::from(drive.get())),
            start_position_counts: START_COUNTS.into(),
            lost_phase_steps: None,
            ..DynDriveConfig::new(drive)
        })
    }
}

/// Master, bus and drives, streaming.
pub(crate) struct Stand {
    bench: Bench<DynDrive>,
    node: NodeId,
    master: ServoMaster<MOST_AXES>,
    handed_over: HandedOver,
    payloads: Vec<Payload>,
    random: SplitMix64,
    targets: Vec<i32>,
    cycle: u64,
    fault: Option<Fault>,
    polled: bool,
    pub(crate) measured: Measurements,
    /// `None` when a poll had no reply at all yet, which is older than any age.
    worst_poll_age_us: Option<u64>,
    late_hand_overs_before: u32,
}

/// The older of two ages; `None` is a poll that never had a reply, which is older than any age.
fn older(a: Option<u64>, b: Option<u64>) -> Option<u64> {
    Some(a?.max(b?))
}

impl Stand {
    /// Brings the axes up to streaming. A load that the master refuses is not an error of the stand.
    pub(crate) fn new(load: &Load) -> Result<Self, LimitsError> {
        let axes: Vec<AxisConfig> = load.drives().map(|drive| load.axis(drive)).collect();
        let config = load.config();
        let master = ServoMaster::new(config, &axes).map_err(LimitsError::Refused)?;
        let mut bus = Bus::new(BitRate::Kbit1000);
        bus.set_log(LogMode::Full);
        let mut bench = Bench::new(bus);
        let node = bench.add_master(ControllerConfig::bxcan(TxOrder::Fifo));
        for drive in load.drives() {
            bench.add_device(load.drive(drive), ControllerConfig::device());
        }
        let payload = match load.payload {
            PayloadKind::Worst => Payload::worst,
            PayloadKind::Random => Payload::random,
        };
        let mut stand = Self {
            bench,
            node,
            master,
            handed_over: HandedOver::default(),
            payloads: load.drives().map(payload).collect(),
            random: SplitMix64::new(load.seed),
            targets: Vec::new(),
            cycle: 0,
            fault: None,
            polled: load.delay_us.is_some(),
            measured: Measurements::new(&BusPlan::new(&config, &axes), axes.len()),
            worst_poll_age_us: Some(0),
            late_hand_overs_before: 0,
        };
        stand.start_up()?;
        // While shafts stand still, only that is read: the polls begin with the set-points.
        for _ in 0..POLL_PERIODS_BEFORE * POLL_PERIOD_US / CYCLE_US {
            stand.cycle();
        }
        // What was measured until now is not streaming.
        let plan = BusPlan::new(&config, &axes);
        stand.measured.restart(&plan, axes.len());
        stand.late_hand_overs_before = stand.master.cycle_counters().late;
        Ok(stand)
    }

    fn start_up(&mut self) -> Result<(), LimitsError> {
        // The drives come up with their servo on.
        self.cycle_until(AxisState::FoundOn)?;
        let now = self.now();
        self.master.adopt(now, GROUP).map_err(LimitsError::Enable)?;
        self.cycle_until(AxisState::Holding)?;
        let now = self.now();
        self.master
            .enable(now, GROUP)
            .map_err(LimitsError::Enable)?;
        self.cycle_until(AxisState::Streaming)?;
        let place = 0..self.payloads.len();
        let snapshots = place.filter_map(|axis| self.master.snapshot(axis));
        self.targets = snapshots.map(|axis| axis.target_counts).collect();
        Ok(())
    }

    fn cycle_until(&mut self, state: AxisState) -> Result<(), LimitsError> {
        while !self.master.all_are(GROUP, state) {
            if self.cycle > START_UP_CYCLES || self.fault.is_some() {
                return Err(LimitsError::StartUp { fault: self.fault });
            }
            self.cycle();
        }
        Ok(())
    }

    /// Cycles with a new set-point for each axis.
    pub(crate) fn stream(&mut self, cycles: u64) -> Result<(), LimitsError> {
        for _ in 0..cycles {
            let axes = self.payloads.iter().zip(&mut self.targets);
            for (axis, (payload, target)) in axes.enumerate() {
                let from_start = *target - START_COUNTS;
                *target += payload.step(from_start, &mut self.random);
                self.master
                    .set_target(axis, *target)
                    .map_err(LimitsError::Target)?;
            }
            self.cycle();
            self.note_poll_ages();
            if let Some(fault) = self.fault {
                return Err(LimitsError::Fault(fault));
            }
        }
        Ok(())
    }

    fn now(&self) -> Instant {
        Instant::from_us(self.bench.now_ns() / 1_000)
    }

    fn cycle(&mut self) {
        let now = self.now();
        self.master.begin_cycle(now);
        let end_ns = (self.cycle + 1) * CYCLE_NS;
        loop {
            let now = self.now();
            let mut tap = Tap {
                port: self.bench.port(self.node),
                handed_over: &mut self.handed_over,
                cycle: self.cycle,
            };
            // Whether it is idle or blocked, the next event on the bus is the next chance.
            let _ = can_motion::service(&mut self.master, &mut tap, now);
            if !self.bench.step_to(end_ns) {
                break;
            }
        }
        self.cycle += 1;
        self.measure();
        while let Some(event) = self.master.next_event() {
            if let EventKind::Fault(fault) = event.kind {
                self.fault.get_or_insert(fault);
            }
        }
    }

    fn measure(&mut self) {
        for record in self.bench.bus_mut().log_mut().drain() {
            if !record.outcome.is_received() {
                self.measured.failed(&record);
            } else if record.node != self.node {
                self.measured.replied(&record);
            } else if let Some(cycle) = self.handed_over.sent() {
                self.measured.sent(&record, cycle);
            }
        }
    }

    fn note_poll_ages(&mut self) {
        if !self.polled {
            return;
        }
        let now = self.now();
        for axis in 0..self.payloads.len() {
            let Some(snapshot) = self.master.snapshot(axis) else {
                continue;
            };
            for kind in [PollKind::Status, PollKind::Position] {
                let age_us = snapshot.feedback.polled_at(kind).map(|at| now.us_since(at));
                self.worst_poll_age_us = older(self.worst_poll_age_us, age_us);
            }
        }
    }

    /// Age of the oldest poll in periods; `None` when one had no reply at all.
    pub(crate) fn worst_poll_age_periods(&self) -> Option<f64> {
        let age_us = self.worst_poll_age_us?;
        Some(age_us as f64 / f64::from(POLL_PERIOD_US))
    }

    /// Set-points that missed their cycle, on the wire or already on the way to the controller.
    pub(crate) fn late(&self) -> u64 {
        let late_hand_overs = self.master.cycle_counters().late - self.late_hand_overs_before;
        self.measured.late_set_points + u64::from(late_hand_overs)
    }

    /// Nobody can send for some time, from a moment after the start of the next cycle on.
    pub(crate) fn block(&mut self, after_us: u64, for_us: u64) -> Result<(), LimitsError> {
        let from_ns = self.bench.now_ns() + after_us * BIT_NS;
        let outage = Outage {
            kind: OutageKind::Blocked,
            from_ns,
            until_ns: from_ns + for_us * BIT_NS,
        };
        self.bench
            .bus_mut()
            .add_outage(outage)
            .map_err(LimitsError::Outage)
    }
}
