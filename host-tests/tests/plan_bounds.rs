//! The bus plan against the unmodified master on the simulated bus: what is admitted is in time, and no frame ends after its bound.

use can_motion::plan::{BusPlan, BusSetup, ResponseWindow, TxOrder};
use can_motion::{
    AxisConfig, AxisState, DriveMove, GroupId, Limits, MasterConfig, PollPeriods, StepChange,
    Timeouts, Travel,
};
use drive_sim::{DynDriveConfig, NodeId, Outcome, Record, ResponseDelay};
use dyn_can::{DriveId, FunctionCode, StepLimit};
use embedded_can::{Frame as _, Id};
use host_tests::rig::{GROUP, Rig};
use proptest::prelude::*;

/// One bit at 1 Mbit/s.
const BIT_NS: u64 = 1_000;
const CYCLES: usize = 150;
/// A group that stands comes to hold within so many cycles.
const HOLD_LIMIT_CYCLES: usize = 1_000;
/// The group of the drives that move by themselves.
const MOVERS: GroupId = GroupId(1);

/// A bus with its axes, and how they move.
#[derive(Debug, Clone)]
struct Case {
    drives: Vec<DriveId>,
    config: MasterConfig,
    polls: PollPeriods,
    steps: Vec<i32>,
    seed: u64,
    /// The last axes, so many, whose drives make moves of their own meanwhile.
    movers: usize,
}

impl Case {
    fn axes(&self) -> Vec<AxisConfig> {
        let axis = |(index, &drive): (usize, &DriveId)| AxisConfig {
            group: if self.moves(index) { MOVERS } else { GROUP },
            drive_curve: Some(DynDriveConfig::new(drive).group2),
            polls: self.polls,
            unwatched: self.polls.status_us.is_none(),
            limits: Limits {
                following_error_counts: u32::MAX,
                drift_tolerance_counts: u32::MAX,
                // A drive of the simulator follows any step; the wire is to carry the worst ones.
                ..Limits::new(StepLimit::MAX, StepChange::MAX, Travel::WHOLE)
            },
            ..host_tests::rig::axis_config(drive)
        };
        self.drives.iter().enumerate().map(axis).collect()
    }

    fn moves(&self, axis: usize) -> bool {
        axis + self.movers() >= self.drives.len()
    }

    /// One axis streams in any case.
    fn movers(&self) -> usize {
        self.movers.min(self.drives.len() - 1)
    }

    /// Drives that follow any step and do not mind.
    fn simulated(&self) -> Vec<DynDriveConfig> {
        let ResponseWindow { min_us, max_us } = self.config.bus.response;
        let window = ResponseDelay::between(u64::from(min_us) * 1_000, u64::from(max_us) * 1_000)
            .expect("a window");
        let drive = |&drive: &DriveId| DynDriveConfig {
            response_delay: window,
            seed: self.seed + u64::from(drive.get()),
            power_on_delay_ns: 0,
            lost_phase_steps: None,
            ..DynDriveConfig::new(drive)
        };
        self.drives.iter().map(drive).collect()
    }

    /// The step of an axis in a cycle, on the whole back and forth.
    fn step(&self, axis: usize, cycle: usize) -> i32 {
        let sign = if (axis + cycle).is_multiple_of(2) {
            1
        } else {
            -1
        };
        sign * self.steps[(axis * 7 + cycle * 3) % self.steps.len()]
    }
}

/// As many of the axes as the plan admits.
fn admitted(mut case: Case) -> Option<Case> {
    while !case.drives.is_empty() {
        if BusPlan::new(&case.config, &case.axes()).check().is_ok() {
            return Some(case);
        }
        case.drives.pop();
    }
    None
}

fn case() -> impl Strategy<Value = Case> {
    let ids = proptest::sample::subsequence((1..=63).collect::<Vec<i32>>(), 1..=14);
    let first_ids = (1..=14).prop_map(|count| (1..=count).collect::<Vec<i32>>());
    let period = || prop_oneof![1 => Just(None), 3 => (2..40_u32).prop_map(|ms| Some(ms * 1_000))];
    (
        prop_oneof![ids, first_ids],
        (
            prop_oneof![1 => Just(500_u32), 3 => Just(1_000), 1 => Just(2_000)],
            1..=3_u8,
            any::<bool>(),
        ),
        (50..2_500_u32, 0..=40_u32),
        (period(), period(), period()),
        // Some steps whose frames are stuffed most, some random ones. None is 0: a set-point that a mailbox controller gives back is
        // sent again only when its step is owed.
        proptest::collection::vec(
            prop_oneof![Just(8_191), Just(-4_096), Just(1), 1..=16_384, -16_384..=-1],
            1..40,
        ),
        any::<u32>(),
    )
        .prop_map(
            |(
                ids,
                (cycle_us, requests_per_cycle, is_fifo),
                (delay_us, percent),
                periods,
                steps,
                seed,
            )| {
                let spread_us = delay_us * percent / 100;
                let order = if is_fifo {
                    TxOrder::Fifo
                } else {
                    TxOrder::Identifier
                };
                let (status_us, position_us, torque_us) = periods;
                Case {
                    drives: ids
                        .into_iter()
                        .map(|id| DriveId::new(id).expect("1..=63"))
                        .collect(),
                    config: MasterConfig {
                        cycle_us,
                        requests_per_cycle,
                        timeouts: Timeouts {
                            power_on_us: 1,
                            standstill_us: 20_000,
                            ..Timeouts::DEFAULT
                        },
                        bus: BusSetup {
                            order,
                            response: ResponseWindow {
                                min_us: delay_us - spread_us,
                                max_us: delay_us + spread_us,
                            },
                            ..BusSetup::DEFAULT
                        },
                    },
                    polls: PollPeriods {
                        status_us,
                        position_us,
                        torque_us,
                        ..PollPeriods::OFF
                    },
                    steps,
                    seed: u64::from(seed),
                    movers: 0,
                }
            },
        )
}

/// Which drive and function a frame is of.
fn meaning(record: &Record) -> (u16, FunctionCode) {
    let Id::Standard(id) = record.frame.id() else {
        panic!("the protocol has no extended frames");
    };
    (id.as_raw() >> 5, FunctionCode::from_can_id(id.as_raw()))
}

/// Frames on the wire, judged one by one.
struct Judge<'a> {
    plan: BusPlan<'a>,
    case: &'a Case,
    master: NodeId,
    cycle_bits: u64,
    /// Set-points of each axis, counted.
    set_points: Vec<u64>,
    /// Cycle in which each drive was asked last.
    asked_in: [u64; 64],
}

impl Judge<'_> {
    fn axis(&self, drive: u16) -> usize {
        let mut drives = self.case.drives.iter();
        drives
            .position(|other| u16::from(other.get()) == drive)
            .expect("a drive of the case")
    }

    /// The bound that a frame of the stream breaks, with the bits that it took.
    fn judge(&mut self, record: &Record, first_cycle: u64) -> Result<(), String> {
        assert_eq!(record.outcome, Outcome::Delivered);
        let (drive, function) = meaning(record);
        let (from, bound) = match function {
            FunctionCode::GoRelativePosPd => {
                let axis = self.axis(drive);
                // One in each cycle: the n-th is of the n-th cycle.
                let cycle = first_cycle + self.set_points[axis];
                self.set_points[axis] += 1;
                (cycle, self.plan.set_point(axis))
            }
            _ if record.node == self.master => {
                let cycle = record.start_ns / BIT_NS / self.cycle_bits;
                self.asked_in[usize::from(drive)] = cycle;
                (cycle, self.plan.cycle().requests())
            }
            _ => (
                self.asked_in[usize::from(drive)],
                self.plan.cycle().replies(),
            ),
        };
        let bound = bound.and_then(|bound| bound.bits).expect("a bound");
        let took_bits = record.free_ns / BIT_NS - from * self.cycle_bits;
        if took_bits > u64::from(bound) {
            return Err(format!(
                "{function:?} of drive {drive} took {took_bits} bits, its bound is {bound}"
            ));
        }
        Ok(())
    }
}

/// Every axis streams, but the movers hold.
fn bring_up(case: &Case, rig: &mut Rig) {
    if case.movers() == 0 {
        rig.stream();
        return;
    }
    let axes = case.drives.len();
    let until = |rig: &mut Rig, wanted: &dyn Fn(usize, AxisState) -> bool| {
        for _ in 0..HOLD_LIMIT_CYCLES {
            if (0..axes).all(|axis| wanted(axis, rig.axis(axis).state)) {
                return;
            }
            rig.cycle();
        }
        let states: Vec<_> = (0..axes).map(|axis| rig.axis(axis).state).collect();
        panic!("the axes are {states:?}");
    };
    until(rig, &|_, state| state == AxisState::FoundOn);
    for group in [GROUP, MOVERS] {
        let now = rig.now();
        rig.master.adopt(now, group).expect("drives that are on");
    }
    until(rig, &|_, state| state == AxisState::Holding);
    let now = rig.now();
    rig.master.resume(now, GROUP).expect("axes that hold");
    until(rig, &|axis, state| {
        case.moves(axis) || state == AxisState::Streaming
    });
}

/// Tells those drives that hold to move a little, alternately each by itself and all by the trigger; how many were told.
fn tell_movers(case: &Case, rig: &mut Rig, cycle: usize) -> usize {
    let first = case.drives.len() - case.movers();
    let movers = first..case.drives.len();
    let holds = |axis: usize| rig.axis(axis).state == AxisState::Holding;
    if case.movers() == 0 || !movers.clone().all(holds) {
        return 0;
    }
    let by = if cycle.is_multiple_of(2) { 40 } else { -40 };
    let moves: Vec<_> = movers.map(|axis| (axis, DriveMove::By(by))).collect();
    let now = rig.now();
    if cycle.is_multiple_of(3) {
        return match rig.master.start_moves(now, &moves) {
            Ok(()) => moves.len(),
            Err(error) => panic!("{error}"),
        };
    }
    let mut tell = |&(axis, wanted): &(usize, DriveMove)| rig.master.start_move(now, axis, wanted);
    moves.iter().filter(|one| tell(one).is_ok()).count()
}

fn run(case: &Case) -> Result<(), String> {
    let axes = case.axes();
    let order = match case.config.bus.order {
        TxOrder::Fifo => drive_sim::TxOrder::Fifo,
        TxOrder::Identifier => drive_sim::TxOrder::ByIdentifier,
    };
    let mut rig = Rig::new(case.config, &axes, case.simulated(), order);
    bring_up(case, &mut rig);
    let cycle_bits = u64::from(case.config.cycle_us);
    let mut judge = Judge {
        plan: BusPlan::new(&case.config, &axes),
        case,
        master: rig.node,
        cycle_bits,
        set_points: vec![0; axes.len()],
        asked_in: [0; 64],
    };
    // Requests of the cycles before are answered among the first set-points.
    rig.cycles(8);
    let first_cycle = rig.now().as_us() / cycle_bits;
    let skip = rig.traffic.len();
    let mut told = 0;
    for cycle in 0..CYCLES {
        told += tell_movers(case, &mut rig, cycle);
        for axis in 0..axes.len() - case.movers() {
            let target = rig.axis(axis).target_counts + case.step(axis, cycle);
            if rig.master.set_target(axis, target).is_err() {
                let faults: Vec<_> = (0..axes.len()).map(|axis| rig.axis(axis).fault).collect();
                panic!("faults {faults:?} at cycle {cycle}");
            }
        }
        rig.cycle();
    }
    let asked_before = rig.traffic[..skip]
        .iter()
        .filter(|record| record.node == rig.node);
    for record in asked_before {
        let (drive, _) = meaning(record);
        judge.asked_in[usize::from(drive)] = record.start_ns / BIT_NS / cycle_bits;
    }
    for record in &rig.traffic[skip..] {
        judge.judge(record, first_cycle)?;
    }
    if case.movers() > 0 && told == 0 {
        return Err("no drive moved".to_owned());
    }
    let streams = judge.set_points.iter().take(axes.len() - case.movers());
    if streams
        .copied()
        .any(|set_points| set_points != CYCLES as u64)
    {
        return Err(format!(
            "set-points {:?}, not {CYCLES} each",
            judge.set_points
        ));
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3_000))]

    #[test]
    fn what_is_admitted_is_in_time(case in case()) {
        if let Some(case) = admitted(case) {
            prop_assert_eq!(run(&case), Ok(()));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Commands and triggers of moves are requests of the plan, and so are the readings that show their end.
    #[test]
    fn what_is_admitted_is_in_time_while_other_drives_move(case in case(), movers in 1..=4_usize) {
        let is_watched = case.polls.status_us.is_some() && case.polls.position_us.is_some();
        let case = admitted(Case { movers, ..case });
        if let Some(case) = case.filter(|case| is_watched && case.drives.len() > 1) {
            prop_assert_eq!(run(&case), Ok(()));
        }
    }
}
