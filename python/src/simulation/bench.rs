//! Master, bus and drives.

use board_link::segment::MOST_AXES;
use can_motion::plan::{BusSetup, ResponseWindow};
use can_motion::{
    AxisConfig, AxisState, EventKind, GroupId, Instant, Limits, MasterConfig, PollPeriods,
    ServoMaster, StepChange, Timeouts, Travel, service,
};
use drive_sim::{
    Bus, ControllerConfig, DeviceId, DynDrive, DynDriveConfig, LoadMark, LogMode, NodeId, Outcome,
    ResponseDelay, TxOrder,
};
use dyn_can::{DriveId, FunctionCode, StepLimit};
use embedded_can::{Frame as _, Id};

use super::{AxisSummary, Summary, gear};

const GROUP: GroupId = GroupId(0);
/// The drives are ready by then, or something is wrong.
const START_UP_US: u64 = 10_000_000;
const START_UP_CYCLES: u64 = 1_000;
/// For the drives to arrive, and to be read once more.
const SETTLE_US: u64 = 300_000;
const RESPONSE_NS: (u64, u64) = (375_000, 625_000);

/// Those of the firmware, but none within a cycle.
fn polls(cycle_us: u32) -> PollPeriods {
    let period_us = |default_us: Option<u32>| default_us.map(|us| us.max(cycle_us));
    PollPeriods {
        status_us: period_us(PollPeriods::DEFAULT.status_us),
        position_us: period_us(PollPeriods::DEFAULT.position_us),
        ..PollPeriods::DEFAULT
    }
}

/// Those of the firmware, longer where its cycle is: a reply is noticed in a later cycle, and a cycle asks one drive.
fn timeouts(cycle_us: u32, drives: usize) -> Timeouts {
    let defaults = Timeouts::DEFAULT;
    let reply_us = defaults.reply_us.max(2 * cycle_us);
    let round_us = cycle_us * (drives as u32 + 2);
    Timeouts {
        reply_us,
        confirm_us: defaults.confirm_us.max(reply_us + 2 * round_us),
        ..defaults
    }
}

pub(super) struct Bench {
    bench: drive_sim::Bench<DynDrive>,
    node: NodeId,
    devices: Vec<DeviceId>,
    master: ServoMaster<MOST_AXES>,
    /// Place in the master of each axis: it wants its drives in ascending order.
    places: Vec<usize>,
    drives: Vec<DriveId>,
    anchors: Vec<i32>,
    bit_rate: drive_sim::BitRate,
    cycle_us: u32,
    cycle: u64,
    motion_mark: Option<LoadMark>,
    cycles: u32,
    late_cycles: u32,
    faults: u32,
}

impl Bench {
    pub(super) fn new(
        drives: &[DriveId],
        bit_rate: drive_sim::BitRate,
        cycle_us: u32,
        seed: u64,
    ) -> Result<Self, String> {
        let mut bus = Bus::new(bit_rate);
        bus.set_log(LogMode::Full);
        let mut bench = drive_sim::Bench::new(bus);
        let node = bench.add_master(ControllerConfig::bxcan(TxOrder::Fifo));
        let delay = ResponseDelay::between(RESPONSE_NS.0, RESPONSE_NS.1);
        let delay = delay.unwrap_or(ResponseDelay::fixed(RESPONSE_NS.1));
        let add = |&drive: &DriveId| {
            let config = DynDriveConfig {
                response_delay: delay,
                seed: seed.wrapping_add(u64::from(drive.get())),
                ..DynDriveConfig::new(drive)
            };
            bench.add_device(DynDrive::new(config), ControllerConfig::device())
        };
        let devices = drives.iter().map(add).collect();
        let mut ascending = drives.to_vec();
        ascending.sort_unstable();
        let gear = gear()?;
        let limits = Limits::new(StepLimit::MAX, StepChange::MAX, Travel::WHOLE);
        let axes: Vec<AxisConfig> = ascending
            .iter()
            .map(|&drive| AxisConfig {
                polls: polls(cycle_us),
                ..AxisConfig::new(drive, gear, limits)
            })
            .collect();
        let config = MasterConfig {
            cycle_us,
            bus: BusSetup {
                bit_rate,
                response: ResponseWindow {
                    min_us: (RESPONSE_NS.0 / 1_000) as u32,
                    max_us: (RESPONSE_NS.1 / 1_000) as u32,
                },
                ..BusSetup::DEFAULT
            },
            timeouts: timeouts(cycle_us, drives.len()),
            ..MasterConfig::DEFAULT
        };
        let master = ServoMaster::new(config, &axes).map_err(|error| error.to_string())?;
        let place = |drive: &DriveId| ascending.iter().position(|other| other == drive);
        let places = drives.iter().filter_map(place).collect();
        Ok(Self {
            bench,
            node,
            devices,
            master,
            places,
            drives: drives.to_vec(),
            anchors: vec![0; drives.len()],
            bit_rate,
            cycle_us,
            cycle: 0,
            motion_mark: None,
            cycles: 0,
            late_cycles: 0,
            faults: 0,
        })
    }

    fn now(&self) -> Instant {
        Instant::from_us(self.bench.now_ns() / 1_000)
    }

    /// From power-on until every axis follows set-points.
    pub(super) fn bring_up(&mut self) -> Result<(), String> {
        let most_us = START_UP_US.max(START_UP_CYCLES * u64::from(self.cycle_us));
        while self.now().as_us() < most_us && !self.has_failed() {
            let now = self.now();
            if self.master.all_are(GROUP, AxisState::Streaming) {
                self.anchors = self
                    .places
                    .iter()
                    .map(|&place| self.target(place))
                    .collect();
                self.motion_mark = Some(self.bench.bus().load_mark());
                return Ok(());
            }
            // Refused as long as the drives are not there; tried again.
            if self.master.all_are(GROUP, AxisState::FoundOn) {
                let _ = self.master.adopt(now, GROUP);
            } else if self.master.all_are(GROUP, AxisState::Ready) {
                let _ = self.master.enable(now, GROUP);
            } else if self.master.all_are(GROUP, AxisState::Holding) {
                let _ = self.master.resume(now, GROUP);
            }
            self.one_cycle();
        }
        let states = self
            .places
            .iter()
            .filter_map(|&place| self.master.snapshot(place));
        let states: Vec<String> = states.map(|axis| axis.state.to_string()).collect();
        Err(format!(
            "the drives were not ready in {} s: {}",
            most_us / 1_000_000,
            states.join(", ")
        ))
    }

    fn target(&self, place: usize) -> i32 {
        self.master
            .snapshot(place)
            .map_or(0, |axis| axis.target_counts)
    }

    /// A cycle with these targets, from where the axes stood; gives how far the motors are from there.
    pub(super) fn cycle(&mut self, offsets: &[i32]) -> Vec<i64> {
        for ((&place, anchor), offset) in self.places.iter().zip(&self.anchors).zip(offsets) {
            // A refusal is an axis that stopped by a fault, which is counted.
            let _ = self.master.set_target(place, anchor.wrapping_add(*offset));
        }
        let owed = self
            .places
            .iter()
            .filter_map(|&place| self.master.snapshot(place));
        let owed = owed.filter(|axis| axis.state.sends_set_points()).count();
        let ended = self.one_cycle();
        self.cycles += 1;
        self.late_cycles += u32::from(ended < owed);
        let now_ns = self.bench.now_ns();
        let motors = self.devices.iter().zip(&self.anchors);
        motors
            .map(|(&device, &anchor)| {
                self.bench.device(device).position_counts(now_ns) - i64::from(anchor)
            })
            .collect()
    }

    /// Set-points that were through before the next cycle.
    fn one_cycle(&mut self) -> usize {
        let now = self.now();
        self.master.begin_cycle(now);
        self.cycle += 1;
        let end_ns = self.cycle * u64::from(self.cycle_us) * 1_000;
        loop {
            let now = self.now();
            // Whether it is idle or blocked, the next event on the bus is the next chance.
            let _ = service(&mut self.master, &mut self.bench.port(self.node), now);
            if !self.bench.step_to(end_ns) {
                break;
            }
        }
        while let Some(event) = self.master.next_event() {
            self.faults += u32::from(matches!(event.kind, EventKind::Fault(_)));
        }
        let node = self.node;
        let is_set_point = |id: Id| match id {
            Id::Standard(id) => {
                FunctionCode::from_can_id(id.as_raw()) == FunctionCode::GoRelativePosPd
            }
            Id::Extended(_) => false,
        };
        let records = self.bench.bus_mut().log_mut().drain();
        records
            .filter(|record| {
                record.node == node
                    && record.outcome == Outcome::Delivered
                    && is_set_point(record.frame.id())
            })
            .count()
    }

    pub(super) const fn has_failed(&self) -> bool {
        self.faults > 0
    }

    /// Lets the axes come to rest; `way` is how far each was to go.
    pub(super) fn finish(mut self, way: &[i32]) -> Summary {
        let load = self.motion_mark.as_ref();
        let mean_bus_load = load.map_or(0.0, |mark| self.bench.bus().load_since(mark));
        for _ in 0..SETTLE_US.div_ceil(u64::from(self.cycle_us)) {
            self.one_cycle();
        }
        let axes: Vec<AxisSummary> = (0..self.drives.len())
            .filter_map(|axis| self.axis_summary(axis, way))
            .collect();
        let late_hand_overs = self.master.cycle_counters().late;
        let are_exact = axes.iter().all(|axis| {
            axis.fault.is_none()
                && axis.sent_counts == axis.target_counts
                && axis.received_counts == i64::from(axis.target_counts)
        });
        Summary {
            promises_kept: are_exact
                && self.cycles > 0
                && self.late_cycles == 0
                && self.faults == 0
                && late_hand_overs == 0,
            axes,
            cycle_us: self.cycle_us,
            bit_rate_kbit: self.bit_rate.kbit_per_s(),
            cycles: self.cycles,
            late_cycles: self.late_cycles,
            late_hand_overs,
            faults: self.faults,
            mean_bus_load,
        }
    }

    fn axis_summary(&self, axis: usize, way: &[i32]) -> Option<AxisSummary> {
        let snapshot = self.master.snapshot(*self.places.get(axis)?)?;
        let drive = self.bench.device(*self.devices.get(axis)?);
        let anchor = *self.anchors.get(axis)?;
        Some(AxisSummary {
            axis,
            drive: snapshot.drive.get(),
            state: snapshot.state.to_string(),
            fault: snapshot.fault.map(|fault| fault.to_string()),
            set_points: snapshot.counters.set_points,
            target_counts: *way.get(axis)?,
            sent_counts: snapshot.sent_counts.wrapping_sub(anchor),
            received_counts: drive.commanded_counts(),
            position_error_counts: i64::from(snapshot.target_counts)
                - drive.position_counts(self.bench.now_ns()),
        })
    }
}
