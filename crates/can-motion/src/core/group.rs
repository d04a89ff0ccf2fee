//! The axes of a master, and what happens to one because of its group.

use bus_user::Instant;
use heapless::Vec;

use crate::core::axis::{Axis, Change};
use crate::core::calendar::Tick;
use crate::core::command::CommandError;
use crate::core::drive_move::MoveReport;
use crate::core::event::{CommonEvent, EventLog, Events};
use crate::core::facts::{Brake, Goal, Latch, Motion, Power, Work};
use crate::core::family::{
    CommonFault, Context, Drive, Family, FaultKind, GroupId, Meaning, PowerReport, Reaction,
};
use crate::core::state::AxisState;
use crate::core::step::{Input, accepts, step};

/// The most axes that a master can have: one bit each.
pub(crate) const MOST_AXES: usize = 64;

/// So often it is worked out at least when the requests are due.
const LOOK_AGAIN_US: u32 = 1 << 26;

/// A mask of axes, of which a processor of 32 bits needs half where there are no more axes: what is told here need not be computed.
#[inline]
pub(crate) const fn mask<const N: usize>(axes: u64) -> u64 {
    if N <= 32 { axes & 0xFFFF_FFFF } else { axes }
}

/// The lowest axis of a mask; beyond all of them when it is empty.
#[inline]
pub(crate) const fn lowest<const N: usize>(axes: u64) -> usize {
    if N <= 32 {
        (axes as u32).trailing_zeros() as usize
    } else {
        axes.trailing_zeros() as usize
    }
}

/// [`Axes::stream_on`] for 32 axes at most, with the length of their frames. Not inlined: the loop needs the registers for itself.
#[inline(never)]
fn stream_on<F: Family>(
    axes: &mut [Axis<F>],
    now: Instant,
    stuck_us: u32,
    matters: bool,
) -> (u64, u32) {
    let (mut streaming, mut bits) = (0, 0);
    let mut bit: u32 = 1;
    for axis in axes {
        if axis.streams_on(now, stuck_us) {
            streaming |= bit;
            if matters {
                bits += u32::from(axis.drive.cycle_frame_bits());
            }
        }
        bit <<= 1;
    }
    (streaming.into(), bits)
}

/// Whether the input ends every motion at once.
const fn ends_at_once(input: Input) -> bool {
    matches!(
        input,
        Input::Halt | Input::GroupFault { ramp: false } | Input::Fault { ramp: false, .. }
    )
}

/// The axes, in the order of the configuration.
#[derive(Debug)]
pub(crate) struct Axes<const N: usize, F: Family> {
    list: Vec<Axis<F>, N>,
    pub(crate) events: Events<F::EventKind>,
    /// Place of each address in the list, counted from 1; 0 for an address without an axis.
    axis_of: [u8; 128],
    /// One bit an axis: the controller has not accepted its frame of this cycle yet.
    pub(crate) due: u64,
    /// About the length of these frames, when the cycle began.
    pub(crate) due_bits: u32,
    /// One bit an axis: it may have a switch to send. An index, because a look at every axis for every frame is a good part of the
    /// cost of a cycle.
    pub(crate) switching: u64,
    /// What the controller holds for an axis that must stop at once is to be taken back.
    pub(crate) take_back: bool,
    /// One bit an axis that the latest trigger was for.
    pub(crate) triggered: u64,
    /// How often the facts of an axis have changed.
    pub(crate) changes: u32,
    /// One bit an axis, those from 32 on with the first ones: something has happened to it since it was worked out when its request is due.
    stale: u32,
    /// The first tick at which that is to be worked out anew for an axis to which nothing happens.
    look_at: Tick,
}

impl<const N: usize, F: Family> Axes<N, F> {
    pub(crate) const fn new() -> Self {
        Self {
            list: Vec::new(),
            events: Events::new(),
            axis_of: [0; 128],
            due: 0,
            due_bits: 0,
            switching: 0,
            take_back: false,
            triggered: 0,
            changes: 0,
            stale: 0,
            look_at: Tick::of(Instant::from_us(0)),
        }
    }

    /// Lets a cycle pass for the axes that do nothing but stream; one bit for each of them. Notes about the length of their frames where
    /// that `matters`.
    pub(crate) fn stream_on(&mut self, now: Instant, stuck_us: u32, matters: bool) -> u64 {
        let (streaming, bits) = if N <= u32::BITS as usize {
            stream_on(&mut self.list, now, stuck_us, matters)
        } else {
            let parts = self.list.chunks_mut(u32::BITS as usize);
            let each = parts.map(|part| stream_on(part, now, stuck_us, matters));
            (0..)
                .zip(each)
                .fold((0, 0), |(all, sum), (place, (some, bits))| {
                    (all | some << (u32::BITS * place), sum + bits)
                })
        };
        self.due_bits = bits;
        streaming
    }

    /// As [`Stamp::keep`](crate::core::stamp::Stamp::keep), for every axis.
    #[cold]
    #[inline(never)]
    pub(crate) fn keep_stamps(&mut self, now: Instant, is_long_ago: bool) {
        self.events.keep_stamps(now, is_long_ago);
        for axis in &mut self.list {
            axis.keep_stamps(now, is_long_ago);
        }
    }

    /// Works out when the requests are due, of the axes to which something has happened since, or whose time has come.
    pub(crate) fn look_ahead(&mut self, now: Instant, cycle: u32) {
        let tick = Tick::of(now);
        let mut stale = core::mem::take(&mut self.stale);
        if self.look_at.has_come(tick) {
            stale |= self.due_for_a_look(now);
        }
        while stale != 0 {
            let lower = stale.trailing_zeros() as usize;
            stale &= stale - 1;
            let mut index = lower;
            while let Some(axis) = self.list.get_mut(index) {
                index += 32;
                axis.look_ahead(now, cycle);
                let until = axis.asks.until();
                if until.has_come(tick) {
                    self.stale |= 1 << lower;
                } else {
                    self.look_at = self.look_at.earlier(until);
                }
                if N <= 32 {
                    break;
                }
            }
        }
    }

    /// The axes whose time has come, as in [`Self::stale`]; finds the first tick of the others.
    #[cold]
    fn due_for_a_look(&mut self, now: Instant) -> u32 {
        let (tick, mut due) = (Tick::of(now), 0);
        self.look_at = Tick::of(now + LOOK_AGAIN_US);
        for (index, axis) in self.list.iter().enumerate() {
            let until = axis.asks.until();
            if until.has_come(tick) {
                due |= 1 << (index % 32);
            } else {
                self.look_at = self.look_at.earlier(until);
            }
        }
        due
    }

    /// One bit for each of these axes.
    fn bits_where(&self, is_one: impl Fn(&Axis<F>) -> bool) -> u64 {
        let mut bits = 0;
        for (index, axis) in self.list.iter().enumerate() {
            bits |= u64::from(is_one(axis)) << index;
        }
        bits
    }

    /// Which axes owe the frame of this cycle.
    pub(crate) fn find_due(&mut self) {
        self.due = self.bits_where(|axis| axis.drive.owes_frame(&axis.view));
        let due = self
            .list
            .iter()
            .filter(|axis| axis.drive.owes_frame(&axis.view));
        self.due_bits = due
            .map(|axis| u32::from(axis.drive.cycle_frame_bits()))
            .sum();
    }

    /// Removes the axes, with what is left of them.
    pub(crate) fn clear(&mut self) {
        self.list.clear();
        self.events.clear();
        self.axis_of = [0; 128];
        (self.due, self.switching, self.take_back) = (0, 0, false);
        self.triggered = 0;
        self.stale = u32::MAX;
    }

    /// Adds an axis, made where it stays as far as the compiler can; one without room is left out, so the number of axes is checked before.
    #[inline(never)]
    pub(crate) fn add(&mut self, config: &F::Config, axis: &F::AxisConfig, rank: u32) {
        let index = self.list.len() as u8;
        if self
            .list
            .push(Axis::new(F::drive(config, axis, rank)))
            .is_ok()
            && let Some(place) = self.axis_of.get_mut(usize::from(F::address_of(axis)))
        {
            *place = index + 1;
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.list.len()
    }

    pub(crate) fn list(&self) -> &[Axis<F>] {
        &self.list
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Axis<F>> + Clone {
        self.list.iter()
    }

    pub(crate) fn get(&self, index: usize) -> Option<&Axis<F>> {
        self.list.get(index)
    }

    pub(crate) fn get_mut(&mut self, index: usize) -> Option<&mut Axis<F>> {
        self.list.get_mut(index)
    }

    #[inline(always)]
    pub(crate) fn index_of(&self, frame: &F::Frame) -> Option<usize> {
        let address = F::address(frame)?;
        let place = *self.axis_of.get(usize::from(address))?;
        usize::from(place).checked_sub(1)
    }

    /// An axis, and where it writes its events.
    pub(crate) fn with_log(
        &mut self,
        now: Instant,
        index: usize,
    ) -> Option<(&mut Axis<F>, EventLog<'_, F::EventKind>)> {
        let axis = self.list.get_mut(index)?;
        self.stale |= 1 << (index % 32);
        let log = EventLog {
            events: &mut self.events,
            now,
            axis: index as u8,
        };
        Some((axis, log))
    }

    /// Calls the drive of an axis with what it needs; `None` when there is no such axis.
    pub(crate) fn with_drive<R>(
        &mut self,
        (now, cycle, config): (Instant, u32, &F::Config),
        index: usize,
        call: impl FnOnce(&mut F::Drive, &mut Context<'_, F>) -> R,
    ) -> Option<R> {
        let (axis, log) = self.with_log(now, index)?;
        Some(axis.with_drive(config, cycle, log, call))
    }

    /// Lets something happen to an axis, with everything that follows for its group.
    pub(crate) fn apply(&mut self, now: Instant, index: usize, change: Change<F>) {
        let Some((axis, mut log)) = self.with_log(now, index) else {
            return;
        };
        let (before, after) = (axis.view.facts, step(axis.view.facts, change.input));
        let is_fault = matches!(change.input, Input::Fault { .. });
        if ends_at_once(change.input) && !before.moves() && before.power.may_be_on() {
            // What moves by itself, on its way to the latest set-point, is stopped too.
            axis.drive.end_motion(false);
        }
        if after == before || (is_fault && axis.has_lost_already(&after)) {
            return;
        }
        axis.become_(after, &change, &mut log);
        let (group, fault) = (axis.drive.group(), axis.fault());
        let (owes_frame, view) = (axis.drive.owes_frame(&axis.view), axis.view.facts);
        self.changes = self.changes.wrapping_add(1);
        let bit = 1 << index;
        // A command for a motion of its own may still lie in the controller.
        let gives_up_move = before.goal.is_move() && !view.goal.is_move() && view.has_own_move();
        self.take_back |= F::MAKES_MOVES && gives_up_move;
        if before.sends_set_points() && !view.sends_set_points() {
            // The set-point of this cycle is void, or replaced by the frame that stops the drive.
            self.due &= !bit;
            self.due |= if owes_frame { bit } else { 0 };
            self.take_back |= change.input != Input::RampDone;
        }
        let switches = matches!(view.power, Power::OnWanted | Power::OffWanted);
        self.switching &= !bit;
        self.switching |= if switches { bit } else { 0 };
        if after.latch == Latch::Own && (before.latch != Latch::Own || is_fault) {
            let cause = change.fault.or(fault);
            let was_in_use = before.is_in_use();
            self.spread(now, (index, was_in_use), group, cause, change.ramp_cycles);
        }
        if accepts(&after, Input::Start) {
            self.start(now, group);
        }
    }

    /// The ramp of a group whose reaction is one. It is looked at only then: frames are taken back as soon as a fault is worked out.
    fn ramp_after(&self, reaction: Reaction, group: GroupId) -> Option<u32> {
        if reaction == Reaction::RampDown {
            self.ramp_of(group)
        } else {
            None
        }
    }

    /// What a fault of one axis does to its group. An axis that was not in use is spared: a drive that was found on is not switched off
    /// by a fault.
    fn spread(
        &mut self,
        now: Instant,
        (index, was_in_use): (usize, bool),
        group: GroupId,
        cause: Option<F::Fault>,
        ramp_cycles: u32,
    ) {
        let Some((axis, cause)) = self.get(index).zip(cause) else {
            return;
        };
        let reaction = axis.drive.reaction_to(cause);
        let ramp = self.ramp_after(reaction, group);
        let input = Input::GroupFault {
            ramp: ramp.is_some(),
        };
        let ramp_cycles = ramp.unwrap_or(0).max(ramp_cycles);
        for other in 0..self.len() {
            if !self.is_in(other, group) {
                continue;
            }
            let mut is_in_use = was_in_use;
            if other != index {
                is_in_use = self
                    .get(other)
                    .is_some_and(|axis| axis.view.facts.is_in_use());
                self.apply(
                    now,
                    other,
                    Change {
                        ramp_cycles,
                        ..Change::of(input)
                    },
                );
            }
            if reaction == Reaction::Disable && is_in_use {
                self.apply(now, other, Change::of(Input::Disable));
            }
        }
    }

    fn start(&mut self, now: Instant, group: GroupId) {
        let mut axes = self.iter().filter(|axis| axis.drive.group() == group);
        let are_ready = axes.all(|axis| accepts(&axis.view.facts, Input::Start));
        drop(axes);
        if are_ready {
            self.apply_to_group(now, group, Change::of(Input::Start));
        }
    }

    /// Latches a fault of an axis.
    pub(crate) fn raise(&mut self, now: Instant, index: usize, fault: F::Fault) {
        let Some(axis) = self.get(index) else {
            return;
        };
        let (group, loss) = (axis.drive.group(), fault.loss());
        let ramp = self.ramp_after(axis.drive.reaction_to(fault), group);
        let change = Change {
            input: Input::Fault {
                loss,
                ramp: ramp.is_some(),
            },
            fault: Some(fault),
            ramp_cycles: ramp.unwrap_or(0),
        };
        let before = axis.view.facts;
        self.apply(now, index, change);
        if fault == F::Fault::from(CommonFault::Lost)
            && let Some((axis, mut log)) = self.with_log(now, index)
        {
            // A fault that was there before does not hide that the drive does not answer any more.
            if axis.view.facts == before {
                log.push(CommonEvent::Fault(fault));
            }
            axis.set_lost(true);
        }
    }

    /// What a frame, or the passing of time, means to an axis.
    pub(crate) fn take(
        &mut self,
        now: Instant,
        cycle_us: u32,
        index: usize,
        meaning: Meaning<F::Fault>,
    ) {
        if meaning.restarts {
            self.apply(now, index, Change::of(Input::Restarted));
        }
        if meaning.work_ended {
            self.apply(now, index, Change::of(Input::WorkEnded));
        }
        if let Some(fault) = meaning.fault {
            self.confirm_off(now, cycle_us, index, meaning.power);
            self.raise(now, index, fault);
        }
        let Some((axis, mut log)) = self.with_log(now, index) else {
            return;
        };
        let checks = axis.view.facts.is_checking() && meaning.fault.is_none();
        if let Some(stage) = meaning.stage.filter(|_| checks) {
            axis.set_stage(stage, &mut log);
        }
        if let Some(report) = meaning.power {
            axis.set_lost(false);
            let is_old = axis.is_before_switch(now, cycle_us, report);
            // A drive needs a moment; the command is repeated by time.
            let is_early = report.is_on && axis.view.facts.power == Power::OffSent;
            // What nearly every report says: it changes no fact.
            let is_known = report.is_on && axis.view.facts.power == Power::On;
            if !is_old && !is_early && !is_known {
                let input = if report.is_on {
                    Input::SaysOn
                } else {
                    Input::SaysOff
                };
                self.apply(now, index, Change::of(input));
            }
        }
        match meaning.brake {
            Some(Brake::Open) => self.apply(now, index, Change::of(Input::BrakeOpened)),
            Some(Brake::Closed) => self.apply(now, index, Change::of(Input::BrakeClosed)),
            _ => {}
        }
        if checks && meaning.is_checked {
            self.apply(now, index, Change::of(Input::Checked));
        }
        self.learn_position(now, index, meaning);
        match meaning.own_move.filter(|_| F::MAKES_MOVES) {
            Some(MoveReport::LoadSeen) => self.arm(now, index),
            Some(MoveReport::Ended(end)) => {
                self.apply(now, index, Change::of(Input::MoveEnded(end)));
            }
            None => {}
        }
    }

    /// A report that a drive is off may come together with a fault. The fault takes what is known of the power, and the drive would be
    /// switched off again although it has confirmed it.
    fn confirm_off(
        &mut self,
        now: Instant,
        cycle_us: u32,
        index: usize,
        report: Option<PowerReport>,
    ) {
        let confirms = self.get(index).zip(report).is_some_and(|(axis, report)| {
            axis.view.facts.power == Power::OffSent
                && !report.is_on
                && !axis.is_before_switch(now, cycle_us, report)
        });
        if confirms {
            self.apply(now, index, Change::of(Input::SaysOff));
        }
    }

    fn learn_position(&mut self, now: Instant, index: usize, meaning: Meaning<F::Fault>) {
        match meaning.stands {
            Some(true)
                if self
                    .get(index)
                    .is_some_and(|axis| axis.view.facts.awaits_standstill()) =>
            {
                self.apply(now, index, Change::of(Input::Stands));
            }
            // A drive that holds its anchor by its own power does not lose it when somebody shakes the shaft.
            Some(false)
                if self
                    .get(index)
                    .is_some_and(|axis| !axis.view.facts.holds_anchor()) =>
            {
                self.apply(now, index, Change::of(Input::Turns));
            }
            _ => {}
        }
        if !meaning.is_located {
            return;
        }
        let Some(axis) = self.list.get_mut(index) else {
            return;
        };
        if !axis.view.facts.awaits_anchor() {
            return;
        }
        match axis.drive.anchor(now) {
            Ok(()) => self.apply(now, index, Change::of(Input::Anchored)),
            Err(fault) => self.raise(now, index, fault),
        }
    }

    pub(crate) fn is_in(&self, index: usize, group: GroupId) -> bool {
        self.get(index)
            .is_some_and(|axis| axis.drive.group() == group)
    }

    fn apply_to_group(&mut self, now: Instant, group: GroupId, change: Change<F>) {
        for index in 0..self.len() {
            if self.is_in(index, group) {
                self.apply(now, index, change);
            }
        }
    }

    /// Cycles in which every axis of the group that streams can stop within its limit; `None` when one of them would leave its travel
    /// however it slows down.
    fn ramp_of(&self, group: GroupId) -> Option<u32> {
        let mut streams = self
            .iter()
            .filter(|axis| axis.drive.group() == group && axis.view.facts.motion == Motion::Stream);
        streams.try_fold(0, |most: u32, axis| {
            let own = axis.drive.cycles_to_stop();
            axis.drive.can_stop_in(own).then_some(most.max(own))
        })
    }

    /// A command that ends motion; never refused.
    pub(crate) fn end_motion(&mut self, now: Instant, group: GroupId, input: Input) {
        let ramp = self.ramp_of(group);
        if ramp.is_none() {
            self.apply_to_group(now, group, Change::of(Input::Halt));
        }
        let change = Change {
            ramp_cycles: ramp.unwrap_or(0),
            ..Change::of(input)
        };
        self.apply_to_group(now, group, change);
    }

    /// A command that an axis may refuse: then none of the group takes it.
    pub(crate) fn command(
        &mut self,
        now: Instant,
        group: GroupId,
        input: Input,
    ) -> Result<(), CommandError<F::Fault>> {
        let mut concerned: u64 = 0;
        let mut is_found = false;
        for (index, axis) in self.iter().enumerate() {
            if axis.drive.group() != group {
                continue;
            }
            is_found = true;
            if input == Input::Adopt && axis.view.facts.power != Power::FoundOn {
                continue;
            }
            self.admit(index, axis, input)?;
            concerned |= 1 << index;
        }
        if !is_found {
            return Err(CommandError::NoSuchGroup(group));
        }
        if concerned == 0 {
            let expected = AxisState::FoundOn;
            return Err(self.first_in(group, expected));
        }
        for index in 0..self.len() {
            if concerned & 1 << index != 0 {
                self.apply(now, index, Change::of(self.input_for(index, input)));
            }
        }
        Ok(())
    }

    /// The input by which an axis follows a command.
    fn input_for(&self, index: usize, input: Input) -> Input {
        let rearms = self.get(index).is_some_and(|axis| {
            let is_held = axis.view.facts.goal == Goal::Hold && axis.view.facts.power == Power::On;
            is_held && axis.drive.must_rearm()
        });
        match input {
            Input::Enable | Input::Resume if rearms => Input::Rearm,
            other => other,
        }
    }

    pub(crate) fn admit(
        &self,
        index: usize,
        axis: &Axis<F>,
        input: Input,
    ) -> Result<(), CommandError<F::Fault>> {
        let facts = &axis.view.facts;
        let input = self.input_for(index, input);
        if accepts(facts, input) {
            return Ok(());
        }
        let axis_index = index as u8;
        let is_move = matches!(input, Input::Move | Input::SyncMove);
        if facts.work.needs_off() || (is_move && facts.work != Work::None) {
            return Err(CommandError::Busy { axis: axis_index });
        }
        if input == Input::Clear && !facts.moves() {
            return Err(CommandError::Unclear { axis: axis_index });
        }
        if let Some(fault) = axis.fault().filter(|_| input != Input::Clear) {
            return Err(CommandError::Faulted {
                axis: axis_index,
                fault,
            });
        }
        if input == Input::Rearm && facts.brake != Brake::Absent {
            return Err(CommandError::LoadCanFall { axis: axis_index });
        }
        Err(CommandError::State {
            axis: axis_index,
            expected: match input {
                Input::Enable => AxisState::Ready,
                Input::Adopt => AxisState::FoundOn,
                Input::Clear => AxisState::Faulted,
                _ => AxisState::Holding,
            },
            actual: axis.state(),
        })
    }

    /// The first axis of a group, which is not in the state that it should be in.
    fn first_in(&self, group: GroupId, expected: AxisState) -> CommandError<F::Fault> {
        let first = self
            .iter()
            .enumerate()
            .find(|(_, axis)| axis.drive.group() == group);
        first.map_or(CommandError::NoSuchGroup(group), |(index, axis)| {
            CommandError::State {
                axis: index as u8,
                expected,
                actual: axis.state(),
            }
        })
    }

    /// Starts a piece of work; false when the facts do not allow it.
    pub(crate) fn start_work(&mut self, now: Instant, index: usize, work: Work) -> bool {
        let input = Input::StartWork(work);
        let is_accepted = self
            .get(index)
            .is_some_and(|axis| accepts(&axis.view.facts, input));
        self.apply(now, index, Change::of(input));
        is_accepted
    }
}
