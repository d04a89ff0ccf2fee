//! What the master must know of a family of drives: the traits that a family implements.
//!
//! The core owns the life of an axis, groups, faults and the reaction to them, waiting times, and the order of frames. A family owns
//! the protocol: which readings identify, check and anchor a drive; the frames of set-point, switch and reading; what a received
//! frame means; and its ledger. `examples/third_family.rs` is a family in one short file.

use core::fmt::Debug;

use bus_plan::ResponseWindow;
use bus_user::{BusFrame, Instant};

use crate::core::drive_move::{DriveMove, MoveEnd, MoveRefusal, MoveReport};
use crate::core::event::{CommonEvent, EventLog};
use crate::core::exit::Class;
use crate::core::facts::{Brake, Facts, Work};
use crate::core::placement::{BehindFrames, RequestPlacement};
use crate::core::procedure::Confirmation;
use crate::core::stamp::Stamp;
use crate::core::state::{AxisState, Stage};
use crate::core::step::Loss;
use crate::core::step::may_be_asked;

/// Axes with the same group stop together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GroupId(pub u8);

/// Drives that speak one protocol. One bus speaks one protocol, so a master has one family.
pub trait Family: Debug + Clone + Copy + PartialEq + Eq + 'static {
    /// A frame on the wire.
    type Frame: BusFrame + Debug + Clone + Copy + PartialEq + Eq;
    /// Settings of the bus.
    type Config: CycleConfig + Debug + Copy;
    /// Settings of one axis.
    type AxisConfig: Debug + Copy + 'static;
    /// Why settings are refused.
    type ConfigError: Debug;
    /// The proof that the bus carries its axes.
    type Plan<'a>: Plan<Self>;
    /// Where requests go in the cycle.
    type Placement: RequestPlacement;
    /// A drive of an axis.
    type Drive: Drive<Family = Self> + Debug;
    /// A question to a drive, or the command of a procedure.
    type Request: Debug + Clone + Copy + PartialEq + Eq;
    /// A procedure beside the cycle.
    type Procedure: Debug + Copy;
    /// Why a procedure is not started.
    type ProcedureError: From<ProcedureRefusal> + Debug;
    /// What can go wrong with an axis.
    type Fault: FaultKind + Debug;
    /// What an event tells.
    type EventKind: From<CommonEvent<Self::Fault>> + Debug + Clone + Copy + PartialEq + Eq;
    /// An axis at one moment.
    type Snapshot: Debug;

    /// Each drive gets a frame in every cycle, whether it moves or not; its switches and its stop travel in that frame.
    const HAS_CYCLE_FRAMES: bool;

    /// A drive may make motions by itself ([`Drive::admit_move`]). Where this is false, nothing of them is in the image.
    const MAKES_MOVES: bool = true;

    /// The plan for these axes.
    fn plan<'a>(config: &Self::Config, axes: &'a [Self::AxisConfig]) -> Self::Plan<'a>;

    /// The address of the drive of an axis, 1..=127.
    fn address_of(axis: &Self::AxisConfig) -> u8;

    /// The drive of an axis; `rank` is the place of the axis.
    fn drive(config: &Self::Config, axis: &Self::AxisConfig, rank: u32) -> Self::Drive;

    /// A frame that goes out once a cycle, behind the set-points.
    fn frame_of_bus(config: &Self::Config) -> Option<Self::Frame> {
        let _ = config;
        None
    }

    /// The address of the drive that a frame comes from or goes to, 1..=127.
    fn address(frame: &Self::Frame) -> Option<u8>;

    /// Whether a frame starts the loaded moves of every drive on the bus.
    fn is_trigger(frame: &Self::Frame) -> bool {
        let _ = frame;
        false
    }

    /// The event of a frame of a drive without an axis.
    fn foreign(frame: &Self::Frame) -> Option<Self::EventKind> {
        let _ = frame;
        None
    }

    /// The event of a frame that this protocol does not have.
    fn not_ours(error: <Self::Frame as BusFrame>::Error) -> Option<Self::EventKind> {
        let _ = error;
        None
    }
}

/// Cycles without a set-point that are no outage yet.
pub(crate) const STUCK_CYCLES: u32 = 5;

/// The settings that the core needs, whatever the family. Times of more than 2^30 us, about 18 minutes, count as 2^30.
pub trait CycleConfig {
    /// Period of the cycle in microseconds.
    fn cycle_us(&self) -> u32;
    /// Requests that may go out in one cycle; 1 by default.
    fn requests_per_cycle(&self) -> u8 {
        1
    }
    /// For so long no set-point of an axis may get out before its group stops with a fault: the longer of 20 ms and five cycles by
    /// default.
    fn stuck_us(&self) -> u32 {
        self.cycle_us().saturating_mul(STUCK_CYCLES).max(20_000)
    }
    /// How long a drive may take to confirm a switch; a disable command is repeated after it. 200 ms by default.
    fn confirm_us(&self) -> u32 {
        200_000
    }
    /// How long to wait for a shaft that stands still; 5 s by default.
    fn standstill_limit_us(&self) -> u32 {
        5_000_000
    }
}

/// Settings with a cycle in microseconds and the defaults for everything else.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CycleUs(pub u32);

impl CycleConfig for CycleUs {
    fn cycle_us(&self) -> u32 {
        self.0
    }
}

/// The proof that the bus carries its axes, with the settings that it was made for.
pub trait Plan<F: Family> {
    /// The settings of the bus.
    fn config(&self) -> &F::Config;
    /// The settings of the axes, in ascending order of address.
    fn axes(&self) -> &[F::AxisConfig];
    /// Whether a master with room for so many axes can take them.
    ///
    /// # Errors
    /// When the settings cannot work, or the bus cannot carry them in time.
    fn admit(&self, room: usize) -> Result<(), F::ConfigError>;
    /// Where requests go in the cycle.
    fn placement(&self) -> F::Placement;
    /// What is worth an event although it is admitted.
    fn warnings(&self) -> impl Iterator<Item = F::EventKind>;
}

/// The plan of a family that counts no frames: nothing is proved, and the settings are checked elsewhere.
#[derive(Debug, Clone, Copy)]
pub struct Unplanned<'a, F: Family> {
    /// The settings of the bus.
    pub config: F::Config,
    /// The settings of the axes.
    pub axes: &'a [F::AxisConfig],
    /// What the check of the settings said.
    pub checked: Result<(), F::ConfigError>,
}

impl<F: Family<Placement = BehindFrames>> Plan<F> for Unplanned<'_, F>
where
    F::ConfigError: Clone,
{
    fn config(&self) -> &F::Config {
        &self.config
    }

    fn axes(&self) -> &[F::AxisConfig] {
        self.axes
    }

    /// Axes beyond the room of the master are left out by it: check their number.
    fn admit(&self, _: usize) -> Result<(), F::ConfigError> {
        self.checked.clone()
    }

    fn placement(&self) -> BehindFrames {
        BehindFrames
    }

    fn warnings(&self) -> impl Iterator<Item = F::EventKind> {
        core::iter::empty()
    }
}

/// What a fault does to its group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reaction {
    /// No further set-point: every axis stops where its latest set-point takes it.
    Halt,
    /// All axes slow down in proportion on their path, then stay enabled.
    RampDown,
    /// No further set-point, and every drive is disabled: its motor coasts.
    Disable,
}

/// What can go wrong with every axis, whatever the family. Each family has faults of its own besides, and one type for both.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CommonFault {
    /// Another axis of the group has a fault.
    Group,
    /// The bus failed.
    Bus,
    /// The drive does not answer.
    Lost,
    /// The shaft did not stand still, or the drive did not confirm, in time.
    NotConfirmed,
    /// The drive has no power although it should.
    SwitchedOff,
    /// The drive has power although it should not.
    SwitchedOn,
}

impl CommonFault {
    /// What it takes from its axis.
    #[must_use]
    pub const fn loss(self) -> Loss {
        match self {
            Self::Group => Loss::Nothing,
            Self::Bus | Self::Lost => Loss::Contact,
            Self::NotConfirmed | Self::SwitchedOff | Self::SwitchedOn => Loss::Anchor,
        }
    }
}

/// What the core must know of a fault.
pub trait FaultKind: Clone + Copy + PartialEq + Eq + From<CommonFault> {
    /// What it takes from its axis.
    fn loss(self) -> Loss;
}

/// Where an axis is, as its drive is told.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// The facts.
    pub facts: Facts,
    /// How far the checks are.
    pub stage: Stage,
    pub(crate) since: Stamp,
    /// The drive does not answer, whatever its fault was at first; asking it often costs the others their turns.
    pub is_lost: bool,
}

impl View {
    /// An axis that answers and has been where it is from `now` on.
    #[must_use]
    pub const fn new(facts: Facts, stage: Stage, now: Instant) -> Self {
        Self {
            facts,
            stage,
            since: Stamp::of(now),
            is_lost: false,
        }
    }

    /// Since when knowledge, power, goal and stage are like that, setbacks apart; at most about 18 minutes ago.
    #[must_use]
    pub const fn since(&self, now: Instant) -> Instant {
        self.since.at(now)
    }

    /// Whether they have been like that for so many microseconds; more than 2^30, about 18 minutes, count as 2^30.
    #[must_use]
    pub const fn has_lasted(&self, now: Instant, us: u32) -> bool {
        self.since.has_lasted(now, us)
    }
}

/// What a family needs to take part in an event of one of its axes.
#[derive(Debug)]
pub struct Context<'a, F: Family> {
    /// The settings of the bus.
    pub config: &'a F::Config,
    /// Where the axis is.
    pub view: &'a View,
    /// Number of the present cycle.
    pub cycle: u32,
    /// The present moment, and where events go.
    pub log: EventLog<'a, F::EventKind>,
}

/// A request that a drive is to be sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wanted<R> {
    /// What it is for.
    pub class: Class,
    /// The request.
    pub request: R,
    /// For how many cycles it has been due; below 0 it is not due yet, [`Self::URGENT`] goes before every poll.
    pub overdue_cycles: i32,
}

impl<R> Wanted<R> {
    /// More overdue than every poll.
    pub const URGENT: i32 = i32::MAX;

    /// A request before every poll.
    pub const fn urgent(class: Class, request: R) -> Self {
        Self {
            class,
            request,
            overdue_cycles: Self::URGENT,
        }
    }
}

/// When the request to send next is due.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outlook {
    /// For how many cycles it has been due: [`Wanted::overdue_cycles`]; `None` when there is none.
    pub overdue_cycles: Option<i32>,
    /// For so many microseconds it stays the same but for one cycle more in each, as long as nothing happens to the axis: no frame of its
    /// drive comes in or back, none of its requests goes out, none of its facts changes, [`Drive::tick`] is not called.
    pub for_us: u32,
}

impl Outlook {
    /// True for the present cycle.
    #[must_use]
    pub const fn now(overdue_cycles: Option<i32>) -> Self {
        Self {
            overdue_cycles,
            for_us: 0,
        }
    }

    /// True until something happens.
    #[must_use]
    pub const fn ever(overdue_cycles: Option<i32>) -> Self {
        Self {
            overdue_cycles,
            for_us: u32::MAX,
        }
    }
}

/// The report of a drive about its power.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PowerReport {
    /// The motor has power.
    pub is_on: bool,
    /// When it was asked for, or else when it came.
    pub asked_at: Instant,
}

/// What a frame, or the passing of time, means to an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Meaning<F> {
    /// A fault.
    pub fault: Option<F>,
    /// The drive reports its power.
    pub power: Option<PowerReport>,
    /// The checks go on here. Has no effect unless the axis is being checked.
    pub stage: Option<Stage>,
    /// The checks are passed. Has no effect unless the axis is being checked.
    pub is_checked: bool,
    /// The shaft has stood still long enough, or turns.
    pub stands: Option<bool>,
    /// A position came that may become the anchor.
    pub is_located: bool,
    /// The brake is confirmed open or closed.
    pub brake: Option<Brake>,
    /// What became of a motion that the drive makes by itself.
    pub own_move: Option<MoveReport>,
    /// The procedure ended.
    pub work_ended: bool,
    /// The drive was told to start anew.
    pub restarts: bool,
    /// For so long no drive is asked anything.
    pub quiet_us: Option<u32>,
}

impl<F> Meaning<F> {
    /// Nothing.
    pub const NONE: Self = Self {
        fault: None,
        power: None,
        stage: None,
        is_checked: false,
        stands: None,
        is_located: false,
        brake: None,
        own_move: None,
        work_ended: false,
        restarts: false,
        quiet_us: None,
    };

    /// A fault and nothing else.
    pub const fn fault(fault: F) -> Self {
        Self {
            fault: Some(fault),
            ..Self::NONE
        }
    }

    /// The checks go on here, and nothing else.
    pub const fn stage(stage: Stage) -> Self {
        Self {
            stage: Some(stage),
            ..Self::NONE
        }
    }
}

/// A frame that the controller gave back unsent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Returned {
    /// The frame of a cycle; what it carried is owed again.
    OfCycle,
    /// A command that switches the drive.
    Switch(Class),
    /// A request.
    Request,
    /// Nothing that this master sends.
    Foreign,
}

/// Why the core does not start a procedure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ProcedureRefusal {
    /// There is no such axis.
    NoSuchAxis {
        /// The axis asked for.
        actual: usize,
    },
    /// Another procedure of the axis is under way: wait for its end.
    Busy,
    /// Writing needs a drive that is checked and reports no power; repairing one that reports no power; reading one that answers.
    State {
        /// The state of the axis.
        actual: AxisState,
    },
}

/// A target that a drive refuses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutOfTravel {
    /// The smallest target.
    pub min: i32,
    /// The largest target.
    pub max: i32,
}

/// One drive of a family: its frames, its readings, its ledger. What an axis may do is decided by the core.
pub trait Drive {
    /// Its family.
    type Family: Family;

    /// The group that it stops with; group 0 by default.
    fn group(&self) -> GroupId {
        GroupId(0)
    }
    /// What a fault does to its group: [`Reaction::Halt`] by default.
    fn reaction_to(&self, fault: FaultOf<Self>) -> Reaction {
        let _ = fault;
        Reaction::Halt
    }
    /// The brake that this master operates, before anything is known of it.
    fn brake(&self) -> Brake {
        Brake::Absent
    }
    /// The axis at this moment.
    fn snapshot(
        &self,
        now: Instant,
        state: AxisState,
        facts: &Facts,
        fault: Option<FaultOf<Self>>,
    ) -> <Self::Family as Family>::Snapshot;

    // The ledger.

    /// Sets the target.
    ///
    /// # Errors
    /// [`OutOfTravel`] when it is outside the travel; nothing changes then.
    fn set_target(&mut self, target: i32) -> Result<(), OutOfTravel>;
    /// Takes the latest position as the anchor: nothing is owed.
    ///
    /// # Errors
    /// A fault when the position is outside the travel.
    fn anchor(&mut self, now: Instant) -> Result<(), FaultOf<Self>>;
    /// Set-points of the application begin.
    fn begin_motion(&mut self) {}
    /// A ramp begins that takes so many cycles.
    fn begin_ramp(&mut self, cycles: u32);
    /// Cycles that the axis needs to stop within its own limit.
    fn cycles_to_stop(&self) -> u32;
    /// Whether it stays within its travel when it stops in so many cycles.
    fn can_stop_in(&self, cycles: u32) -> bool;
    /// The ramp is through and nothing is owed.
    fn has_stopped(&self) -> bool;
    /// Set-points ended, by a ramp or at once; what is owed is forgotten.
    fn end_motion(&mut self, by_ramp: bool);
    /// Whether the drive must be switched off and on before set-points may go on.
    fn must_rearm(&self) -> bool {
        false
    }
    /// The set-point of the cycle before was not accepted.
    fn merged(&mut self) {}

    // Frames on their way out. The ledger changes only when the controller has accepted a frame.

    /// Whether the axis owes the frame of this cycle.
    fn owes_frame(&self, view: &View) -> bool {
        view.facts.sends_set_points()
    }
    /// The frame of this cycle.
    ///
    /// # Errors
    /// A fault when what is owed must not be sent.
    fn cycle_frame(&mut self, view: &View) -> Result<FrameOf<Self>, FaultOf<Self>>;
    /// The controller accepted it.
    fn cycle_frame_accepted(&mut self, now: Instant);
    /// About the length of the frame of this cycle on the wire in bits, for the placement of requests; 0 where that does not matter.
    fn cycle_frame_bits(&self) -> u8 {
        0
    }
    /// Length of the frame of the poll that comes next on the wire in bits; 0 where that does not matter.
    fn poll_bits(&self) -> u8 {
        0
    }
    /// The frame that switches the drive; `None` where the frame of a cycle does that.
    fn switch(&self, on: bool) -> Option<FrameOf<Self>>;
    /// When the request to send next is due, and for how long that stays so. By default it is asked in every cycle. What may not leave
    /// is no request: it would keep those of other axes waiting.
    fn outlook(&self, view: &View, now: Instant, cycle: u32) -> Outlook {
        let wanted = self
            .wanted(view, now, cycle)
            .filter(|wanted| may_be_asked(wanted.class, &view.facts));
        Outlook::now(wanted.map(|wanted| wanted.overdue_cycles))
    }
    /// The request to send next.
    fn wanted(&self, view: &View, now: Instant, cycle: u32) -> Option<Wanted<RequestOf<Self>>>;
    /// The frame of a request.
    fn request_frame(&self, request: RequestOf<Self>) -> Option<FrameOf<Self>>;
    /// The controller accepted a request, which leaves it at `leaves_at`.
    fn request_accepted(
        &mut self,
        request: RequestOf<Self>,
        leaves_at: Instant,
        context: &mut Context<'_, Self::Family>,
    ) -> Meaning<FaultOf<Self>>;
    /// The controller gave a frame back unsent.
    fn returned(
        &mut self,
        frame: &FrameOf<Self>,
        context: &mut Context<'_, Self::Family>,
    ) -> Returned;

    // Readings.

    /// Nothing that was read before is believed; the stage at which the checks begin. `is_cleared`: the application has just cleared a
    /// fault of this axis.
    fn start_over(&mut self, now: Instant, is_cleared: bool) -> Stage;
    /// How long the drive takes to answer, as far as is known.
    fn response_window(&self) -> Option<ResponseWindow> {
        None
    }
    /// A frame of this drive came in.
    fn receive(
        &mut self,
        frame: &FrameOf<Self>,
        context: &mut Context<'_, Self::Family>,
    ) -> Meaning<FaultOf<Self>>;
    /// Lets a cycle pass in which the axis streams and the drive has nothing to do but that; `false`, with nothing done, when it has:
    /// then [`Self::tick`] is called. A short cut: the default never takes it.
    fn streams_on(&mut self, now: Instant) -> bool {
        let _ = now;
        false
    }
    /// A cycle begins.
    fn tick(&mut self, context: &mut Context<'_, Self::Family>) -> Meaning<FaultOf<Self>> {
        let _ = context;
        Meaning::NONE
    }
    /// For a drive that keeps points in time in 32 bits: called every few minutes, so that one that is old does not look young when its
    /// bits wrap. `is_long_ago`: the last call was more than 2^30 us ago.
    fn keep_stamps(&mut self, now: Instant, is_long_ago: bool) {
        let _ = (now, is_long_ago);
    }
    /// The bus failed: a reply that is still awaited may come late, or never.
    fn abandon_request(&mut self, context: &mut Context<'_, Self::Family>) {
        let _ = context;
    }

    // Motion that the drive makes by itself. A family without it says nothing here; one with it asks for the frames of the classes
    // `DriveMove`, `Load`, `Trigger` and `DriveStop` by `wanted`, and reports how the motion ended by `Meaning::own_move`.

    /// Whether the drive can make a motion by itself from where it holds, started by its own frame or by a trigger.
    ///
    /// # Errors
    /// The reason why not: by default there are no such motions.
    fn admit_move(
        &self,
        wanted: DriveMove,
        by_trigger: bool,
        config: &<Self::Family as Family>::Config,
        now: Instant,
    ) -> Result<(), MoveRefusal> {
        let _ = (wanted, by_trigger, config, now);
        Err(MoveRefusal::Unsupported)
    }
    /// The application asked for a motion that was admitted.
    fn begin_move(&mut self, wanted: DriveMove, config: &<Self::Family as Family>::Config) {
        let _ = (wanted, config);
    }
    /// The drive was asked something after its loaded move had left, and answered: the trigger would start it.
    fn has_seen_load(&self) -> bool {
        false
    }
    /// The move that was loaded last.
    fn loaded_move(&self) -> Option<DriveMove> {
        None
    }
    /// Whether a trigger for motions of this kind may start something in this drive that was loaded at any time before.
    fn may_hold_load(&self, kind: DriveMove) -> bool {
        let _ = kind;
        false
    }
    /// A motion of the drive itself is over, or never began: `how` it ended, or `None` where that is not known.
    fn end_move(&mut self, now: Instant, how: Option<MoveEnd>) {
        let _ = (now, how);
    }

    // Procedures.

    /// Whether the drive can run a procedure, and what kind of work it is; none by default.
    ///
    /// # Errors
    /// The reason why not.
    fn admit(
        &self,
        procedure: <Self::Family as Family>::Procedure,
        confirmation: Confirmation,
        view: &View,
        now: Instant,
    ) -> Result<Work, <Self::Family as Family>::ProcedureError> {
        let _ = (procedure, confirmation, now);
        let actual = AxisState::of(&view.facts, view.stage);
        Err(ProcedureRefusal::State { actual }.into())
    }
    /// Starts a procedure that was admitted.
    fn begin_work(&mut self, procedure: <Self::Family as Family>::Procedure) {
        let _ = procedure;
    }
    /// A fault ended the procedure.
    fn abort_work(&mut self, log: &mut EventLog<'_, <Self::Family as Family>::EventKind>) {
        let _ = log;
    }
}

/// Faults of a drive.
pub type FaultOf<D> = <<D as Drive>::Family as Family>::Fault;
/// Frames of a drive.
pub type FrameOf<D> = <<D as Drive>::Family as Family>::Frame;
/// Requests of a drive.
pub type RequestOf<D> = <<D as Drive>::Family as Family>::Request;
