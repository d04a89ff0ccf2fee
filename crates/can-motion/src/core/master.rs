//! The master: axes, cycle, commands. Sans-I/O, so every method is told the time.

use bus_user::Instant;

use crate::core::axis::{Axis, Change};
use crate::core::command::{CommandError, MoveError, TargetError};
use crate::core::drive_move::DriveMove;
use crate::core::event::{CommonEvent, Event};
use crate::core::exit::{Class, may_leave};
use crate::core::facts::{Facts, Goal, Motion, Power};
use crate::core::family::{
    CommonFault, CycleConfig, Drive, Family, GroupId, Plan, ProcedureRefusal,
};
use crate::core::group::Axes;
use crate::core::late::Late;
use crate::core::procedure::Confirmation;
use crate::core::schedule::Schedule;
use crate::core::snapshot::CycleCounters;
use crate::core::stamp::{KEPT_EVERY_US, MOST_AGE_US, Stamp};
use crate::core::state::AxisState;
use crate::core::step::Input;

/// A motion master for at most `N` axes on one bus, whose drives are of one family; `N` is at most 64.
///
/// A cycle is: `set_target` for each axis, `begin_cycle`, then [`service`](crate::service) (or [`send`](crate::BusUser::send) with a
/// sink of your own) until nothing is left, again whenever the controller has room, and `on_frame` for what comes in.
#[derive(Debug)]
pub struct Master<const N: usize, F: Family> {
    /// The settings; without axes there are none.
    pub(crate) config: Late<F::Config>,
    pub(crate) axes: Axes<N, F>,
    pub(crate) schedule: Schedule<F>,
    /// The frame of the whole bus has not been accepted in this cycle yet.
    pub(crate) frame_of_bus_due: bool,
    pub(crate) cycle_started: Option<Instant>,
    pub(crate) cycle: CycleCounters,
    pub(crate) bus_off: bool,
    /// Since when the controller has no room.
    pub(crate) full_since: Option<Instant>,
    /// When the stamps of the axes were kept last; none of them is far from it.
    kept_at: Instant,
}

impl<const N: usize, F: Family> Master<N, F> {
    /// A master for these axes, in ascending order of address.
    ///
    /// # Errors
    /// When the configuration cannot work, or the bus cannot carry it in time.
    pub fn new(config: F::Config, axes: &[F::AxisConfig]) -> Result<Self, F::ConfigError> {
        Self::with_plan(&F::plan(&config, axes))
    }

    /// A master for the axes of a plan that was made before, usually in a `const`: the analysis is then no part of the program.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_plan(plan: &F::Plan<'_>) -> Result<Self, F::ConfigError> {
        let mut master = Self::vacant();
        master.take_on(plan)?;
        Ok(master)
    }

    /// A master without axes, for a static: all of it is zero, and [`Self::take_on`] makes it the master of a plan where it lies, without a
    /// copy on the stack.
    #[must_use]
    pub const fn vacant() -> Self {
        const {
            assert!(
                N <= crate::core::group::MOST_AXES,
                "a master has at most 64 axes"
            );
        }
        Self {
            config: Late::Not,
            axes: Axes::new(),
            schedule: Schedule::new(),
            frame_of_bus_due: false,
            cycle_started: None,
            cycle: CycleCounters::NONE,
            bus_off: false,
            full_since: None,
            kept_at: Instant::from_us(0),
        }
    }

    /// Becomes the master for the axes of a plan, which replace those that it has.
    ///
    /// # Errors
    /// As [`Self::new`]; nothing changes then.
    pub fn take_on(&mut self, plan: &F::Plan<'_>) -> Result<(), F::ConfigError> {
        plan.admit(N)?;
        self.axes.clear();
        self.schedule = Schedule::new();
        (self.cycle, self.cycle_started) = (CycleCounters::NONE, None);
        (self.bus_off, self.full_since) = (false, None);
        let config = *plan.config();
        self.schedule.placement = Late::Come(plan.placement());
        for warning in plan.warnings() {
            self.axes.events.push(Instant::default(), None, warning);
        }
        for (rank, axis) in (0..).zip(plan.axes()) {
            self.axes.add(&config, axis, rank);
        }
        self.config = Late::Come(config);
        Ok(())
    }

    /// Starts a cycle: what the cycle before left over is merged, time passes, and every axis in motion owes a set-point.
    pub fn begin_cycle(&mut self, now: Instant) {
        let Some(config) = self.config.get() else {
            return;
        };
        let (cycle_us, stuck_us) = (config.cycle_us(), config.stuck_us());
        let requests = config.requests_per_cycle();
        self.keep_stamps(now);
        let is_on_time = self.count_cycle(now, cycle_us);
        if self.axes.due != 0 || !is_on_time {
            self.merge_leftovers(now, is_on_time);
        }
        if self.full_since.is_some() {
            self.watch_bus(now, stuck_us);
        }
        let matters = self.schedule.needs_requests();
        let streaming = self.axes.stream_on(now, stuck_us, matters);
        self.axes.due = streaming;
        if streaming.count_ones() as usize != self.axes.len() {
            self.tick_others(now, streaming);
        }
        self.frame_of_bus_due = true;
        let cycle = self.cycle.cycles;
        self.schedule
            .begin_cycle(now, cycle, requests, &mut self.axes);
    }

    /// Lets no stamp of an axis grow so old that it looks young.
    #[inline(always)]
    pub(crate) fn keep_stamps(&mut self, now: Instant) {
        let pause_us = now.us_since(self.kept_at);
        if pause_us >= u64::from(KEPT_EVERY_US) {
            self.kept_at = now;
            let is_long_ago = pause_us >= u64::from(MOST_AGE_US);
            self.axes.keep_stamps(now, is_long_ago);
        }
    }

    /// The axes that do more in this cycle than to stream on.
    #[inline(never)]
    fn tick_others(&mut self, now: Instant, streaming: u64) {
        for index in 0..self.axes.len() {
            if streaming & 1 << index == 0 {
                self.tick(now, index);
            }
        }
        self.axes.find_due();
    }

    /// Whether no cycle was missed.
    fn count_cycle(&mut self, now: Instant, cycle_us: u32) -> bool {
        self.cycle.cycles = self.cycle.cycles.wrapping_add(1);
        let started = self.cycle_started.replace(now);
        let cycle_us = u64::from(cycle_us.max(1));
        // Half a cycle of jitter still belongs to the cycle it was planned for.
        let is_on_time =
            started.is_none_or(|started| now.us_since(started) < cycle_us + cycle_us.div_ceil(2));
        if let Some(started) = started
            && !is_on_time
        {
            let passed = (now.us_since(started) + cycle_us / 2) / cycle_us;
            self.note_missed(now, u32::try_from(passed - 1).unwrap_or(u32::MAX));
        }
        is_on_time
    }

    #[cold]
    fn note_missed(&mut self, now: Instant, cycles: u32) {
        self.cycle.missed = self.cycle.missed.wrapping_add(cycles);
        let event = CommonEvent::CyclesMissed(cycles);
        self.axes.events.push(now, None, event);
    }

    /// What the cycle before left over, or cycles that were never begun, is not sent in one piece.
    #[inline(never)]
    fn merge_leftovers(&mut self, now: Instant, is_on_time: bool) {
        let due = self.axes.due;
        self.cycle.late = self.cycle.late.wrapping_add(u32::from(due != 0));
        for index in 0..self.axes.len() {
            let is_due = due & 1 << index != 0;
            if let Some((axis, mut log)) = self.axes.with_log(now, index)
                // One that was on time keeps its velocity, whatever was late beside it.
                && (is_due || (!is_on_time && axis.view.facts.sends_set_points()))
            {
                axis.drive.merged();
                if is_due {
                    log.push(CommonEvent::SetPointMerged);
                }
            }
        }
    }

    /// A controller that has had no room for too long stops every group that has or wants power: nobody is on the bus, or it is blocked.
    fn watch_bus(&mut self, now: Instant, stuck_us: u32) {
        let stuck_us = u64::from(stuck_us);
        let is_stuck = self
            .full_since
            .is_some_and(|since| now.us_since(since) >= stuck_us);
        if !is_stuck {
            return;
        }
        self.fail_bus(now, |axis| axis.view.facts.goal != Goal::Off);
    }

    /// Nothing of these axes got out for too long.
    fn fail_bus(&mut self, now: Instant, is_concerned: impl Fn(&Axis<F>) -> bool) {
        for index in 0..self.axes.len() {
            if self.axes.get(index).is_some_and(&is_concerned) {
                self.axes.raise(now, index, CommonFault::Bus.into());
            }
        }
    }

    /// Lets time pass for one axis.
    fn tick(&mut self, now: Instant, index: usize) {
        let Some(config) = self.config.get() else {
            return;
        };
        let at = (now, self.cycle.cycles, config);
        let cycle_us = config.cycle_us();
        let Some(meaning) = self
            .axes
            .with_drive(at, index, |drive, context| drive.tick(context))
        else {
            return;
        };
        self.axes.take(now, cycle_us, index, meaning);
        let Some(axis) = self.axes.get(index) else {
            return;
        };
        let over = |since: Stamp, limit_us: u32| since.has_lasted(now, limit_us);
        let facts = axis.view.facts;
        let awaits_shaft = facts.awaits_standstill() || facts.awaits_anchor();
        let is_sent = matches!(facts.power, Power::OnSent | Power::OffSent);
        if facts.motion == Motion::Ramp && axis.drive.has_stopped() {
            self.axes.apply(now, index, Change::of(Input::RampDone));
        } else if facts.sends_set_points() && over(axis.sent_at, config.stuck_us()) {
            self.fail_group(now, axis.drive.group());
        } else if is_sent && over(axis.switched_at, config.confirm_us()) {
            self.axes
                .apply(now, index, Change::of(Input::ConfirmTimeout));
        } else if facts.power == Power::OffWanted && over(axis.switched_at, config.confirm_us()) {
            // A brake that does not close, or a bus that takes nothing.
            if let Some((axis, mut log)) = self.axes.with_log(now, index) {
                axis.note_unconfirmed(&mut log);
            }
        } else if awaits_shaft && over(axis.view.since, config.standstill_limit_us()) {
            self.axes
                .raise(now, index, CommonFault::NotConfirmed.into());
        }
    }

    /// Nothing of a group got out for too long: what was accepted may still be waiting anywhere.
    fn fail_group(&mut self, now: Instant, group: GroupId) {
        self.fail_bus(now, |axis| {
            let is_meant = axis.view.facts.goal != Goal::Off || axis.view.facts.moves();
            axis.drive.group() == group && is_meant
        });
    }

    /// Enables the drives of a group, each when its shaft has stood still, and takes along those that hold. When all are on, each axis
    /// streams its own position until it gets a target.
    ///
    /// # Errors
    /// [`CommandError`] unless every axis of the group is [`AxisState::Ready`] or [`AxisState::Holding`]; nothing changes then. A drive
    /// that was found on needs [`Self::adopt`] or [`Self::disable`] first.
    pub fn enable(&mut self, now: Instant, group: GroupId) -> Result<(), CommandError<F::Fault>> {
        self.command(now, group, Input::Enable)
    }

    /// Takes over the drives of a group that were found on, without switching them: when their shafts stand still they hold. The other
    /// drives of the group stay as they are.
    ///
    /// # Errors
    /// [`CommandError`] when no drive of the group is [`AxisState::FoundOn`]; nothing changes then.
    pub fn adopt(&mut self, now: Instant, group: GroupId) -> Result<(), CommandError<F::Fault>> {
        self.command(now, group, Input::Adopt)
    }

    /// Lets a group that holds stream again, from where it stands: set the next targets from the snapshot.
    ///
    /// # Errors
    /// [`CommandError`] unless every axis of the group is [`AxisState::Holding`]; nothing changes then.
    pub fn resume(&mut self, now: Instant, group: GroupId) -> Result<(), CommandError<F::Fault>> {
        self.command(now, group, Input::Resume)
    }

    /// Forgets the latched faults of a group. It moves nothing and switches nothing: what holds goes on holding, what is off stays off.
    /// An axis with a fault of its own is checked anew.
    ///
    /// # Errors
    /// [`CommandError`] when the bus is off, the group has no axis, an axis still slows down, a repair is under way, or it is not known
    /// whether a drive still holds; nothing changes then.
    pub fn clear(&mut self, now: Instant, group: GroupId) -> Result<(), CommandError<F::Fault>> {
        self.command(now, group, Input::Clear)
    }

    fn command(
        &mut self,
        now: Instant,
        group: GroupId,
        input: Input,
    ) -> Result<(), CommandError<F::Fault>> {
        self.keep_stamps(now);
        self.admit_bus()?;
        self.axes.command(now, group, input)
    }

    /// Slows a group down, all axes in proportion on their path, then holds. An axis that is not on yet stays off.
    pub fn stop(&mut self, now: Instant, group: GroupId) {
        self.keep_stamps(now);
        self.axes.end_motion(now, group, Input::Stop);
    }

    /// Stops a group at once: no further set-point. An axis that is not on yet stays off.
    pub fn halt(&mut self, now: Instant, group: GroupId) {
        self.keep_stamps(now);
        self.axes.end_motion(now, group, Input::Halt);
    }

    /// Slows a group down, then disables its drives; an axis that does not move is disabled at once, whatever is known of it. The
    /// command is repeated until the drive confirms it.
    pub fn disable(&mut self, now: Instant, group: GroupId) {
        self.keep_stamps(now);
        self.axes.end_motion(now, group, Input::Disable);
    }

    /// Sets where an axis shall be: for servos in command counts from the origin, for wheels in the unit of the mode.
    ///
    /// # Errors
    /// [`TargetError`] when the axis does not stream or the target leaves its travel; nothing changes then.
    pub fn set_target(&mut self, axis: usize, target: i32) -> Result<(), TargetError> {
        let axes = self.axes.len();
        let Some(place) = self.axes.get_mut(axis) else {
            return Err(TargetError::NoSuchAxis { axes, actual: axis });
        };
        if place.view.facts.motion != Motion::Stream {
            return Err(TargetError::NotStreaming {
                state: place.state(),
            });
        }
        place
            .drive
            .set_target(target)
            .map_err(|travel| TargetError::Travel {
                min: travel.min,
                max: travel.max,
                actual: target,
            })
    }

    /// Lets the drive of an axis that holds make a motion by itself, until it has arrived or `stop`, `halt` or `disable` ends it. The axis
    /// then holds again: its state says so, and why.
    ///
    /// # Errors
    /// [`MoveError`] unless the axis is [`AxisState::Holding`] and its drive can make the motion within the limits of the axis; nothing
    /// changes then.
    pub fn start_move(
        &mut self,
        now: Instant,
        axis: usize,
        wanted: DriveMove,
    ) -> Result<(), MoveError<F::Fault>> {
        self.admit_bus()?;
        match self.config.get() {
            Some(config) => self.axes.start_move((now, config), axis, wanted),
            None => Err(MoveError::NoSuchAxis {
                axes: 0,
                actual: axis,
            }),
        }
    }

    /// Lets the drives of several axes of one group that hold make a move each, all started by one trigger. The moves are all absolute or
    /// all relative.
    ///
    /// A move that was loaded and is not started, because of a fault or `stop`, leaves its axis [`AxisState::Loaded`] until `disable`.
    ///
    /// # Errors
    /// [`MoveError`] as [`Self::start_move`], and when the trigger could start something that nobody asked for; nothing changes then.
    pub fn start_moves(
        &mut self,
        now: Instant,
        moves: &[(usize, DriveMove)],
    ) -> Result<(), MoveError<F::Fault>> {
        self.admit_bus()?;
        match self.config.get() {
            Some(config) => self.axes.start_moves((now, config), moves),
            None => Err(MoveError::NotTogether),
        }
    }

    fn admit_bus(&self) -> Result<(), CommandError<F::Fault>> {
        if self.bus_off {
            return Err(CommandError::BusOff);
        }
        Ok(())
    }

    /// Starts a procedure beside the cycle; its end is an event.
    ///
    /// # Errors
    /// When it may not run now; nothing changes then.
    pub fn start(
        &mut self,
        now: Instant,
        axis: usize,
        procedure: F::Procedure,
        confirmation: Confirmation,
    ) -> Result<(), F::ProcedureError> {
        self.keep_stamps(now);
        let Some(place) = self.axes.get(axis) else {
            return Err(ProcedureRefusal::NoSuchAxis { actual: axis }.into());
        };
        if place.view.facts.work != crate::core::facts::Work::None {
            return Err(ProcedureRefusal::Busy.into());
        }
        let actual = place.state();
        let work = place
            .drive
            .admit(procedure, confirmation, &place.view, now)?;
        if !self.axes.start_work(now, axis, work) {
            return Err(ProcedureRefusal::State { actual }.into());
        }
        if let Some((place, _)) = self.axes.with_log(now, axis) {
            place.drive.begin_work(procedure);
        }
        Ok(())
    }

    /// The controller is bus-off: the fate of the frames that it held is not known.
    pub fn on_bus_off(&mut self, now: Instant) {
        if self.bus_off {
            return;
        }
        self.bus_off = true;
        self.axes.events.push(now, None, CommonEvent::BusOff);
        for index in 0..self.axes.len() {
            if let Some(config) = self.config.get() {
                let at = (now, self.cycle.cycles, config);
                self.axes.with_drive(at, index, |drive, context| {
                    drive.abandon_request(context);
                });
            }
            self.axes.raise(now, index, CommonFault::Bus.into());
        }
    }

    /// The controller takes part in the bus again. Nothing moves until the axes are cleared and enabled.
    pub fn on_bus_recovered(&mut self, now: Instant) {
        if self.bus_off {
            self.bus_off = false;
            self.axes.events.push(now, None, CommonEvent::BusRecovered);
        }
    }

    /// When `begin_cycle` should come next.
    #[must_use]
    pub fn poll_at(&self) -> Instant {
        let cycle_us = self.config.get().map_or(0, CycleConfig::cycle_us);
        self.cycle_started
            .map_or(Instant::default(), |started| started + cycle_us)
    }

    /// True when every axis of the group is in this state; false for a group without axes.
    #[must_use]
    pub fn all_are(&self, group: GroupId, state: AxisState) -> bool {
        let mut states = self
            .axes
            .iter()
            .filter(|axis| axis.drive.group() == group)
            .map(crate::core::axis::Axis::state)
            .peekable();
        states.peek().is_some() && states.all(|actual| actual == state)
    }

    /// The state of an axis; `None` when there is no such axis.
    #[must_use]
    pub fn state(&self, axis: usize) -> Option<AxisState> {
        self.axes.get(axis).map(crate::core::axis::Axis::state)
    }

    /// One axis at this moment; `None` when there is no such axis.
    #[must_use]
    pub fn snapshot(&self, axis: usize) -> Option<F::Snapshot> {
        self.inlined_snapshot(axis)
    }

    /// The same, inlined: for a caller that needs little of it, and often.
    #[must_use]
    #[inline(always)]
    pub fn inlined_snapshot(&self, axis: usize) -> Option<F::Snapshot> {
        let axis = self.axes.get(axis)?;
        Some(axis.snapshot(self.kept_at))
    }

    /// The facts of one axis, without the readings of its snapshot; `None` when there is no such axis.
    #[must_use]
    pub fn facts(&self, axis: usize) -> Option<Facts> {
        self.axes.get(axis).map(|axis| axis.view.facts)
    }

    /// How often the facts of any axis have changed, modulo 2^32: who has looked at them needs not look again before.
    #[must_use]
    pub const fn changes(&self) -> u32 {
        self.axes.changes
    }

    /// The cycle counters.
    #[must_use]
    pub fn cycle_counters(&self) -> CycleCounters {
        CycleCounters {
            events_dropped: self.axes.events.dropped(),
            ..self.cycle
        }
    }

    /// The oldest event that was not read yet.
    pub fn next_event(&mut self) -> Option<Event<F::EventKind>> {
        self.axes.events.pop(self.kept_at)
    }

    /// Whether a frame of this class may go to this axis now: what the exit says.
    #[must_use]
    pub fn may_leave(&self, axis: usize, class: Class) -> bool {
        self.axes
            .get(axis)
            .is_some_and(|axis| may_leave(class, &axis.view.facts))
    }
}
