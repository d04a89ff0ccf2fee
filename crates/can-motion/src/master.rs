//! The master: axes, cycle, order of frames. Sans-I/O, so every method is told the time.

use dyn_can::{Address, DriveId, Request};

use crate::axis::{Axis, Log};
use crate::command::TargetError;
use crate::config::{AxisConfig, ConfigError, GroupId, MasterConfig};
use crate::event::{Event, EventKind, Events};
use crate::fault::{Fault, Reaction};
use crate::life::{AxisState, Reason};
use crate::ramp::cycles_to_stop;
use crate::snapshot::{AxisSnapshot, CycleCounters};
use crate::time::Instant;
use heapless::Vec;

/// Place in `Master::axis_of` of a drive without an axis.
const NO_AXIS: u8 = u8::MAX;

/// A motion master for at most `N` axes on one bus.
///
/// A cycle is: `set_target` for each axis, `begin_cycle`, then `service` (or `next_frame` and `on_accepted` by hand)
/// until nothing is left, again whenever the controller has room, and `on_frame` for what comes in.
#[derive(Debug)]
pub struct Master<const N: usize> {
    pub(crate) config: MasterConfig,
    pub(crate) axes: Vec<Axis, N>,
    pub(crate) events: Events,
    /// Place of each drive id in `axes`.
    pub(crate) axis_of: [u8; 64],
    /// One bit an axis: its set-point of this cycle has not been accepted yet.
    pub(crate) due: u64,
    pub(crate) requests_left: u8,
    pub(crate) request: Option<(u8, Request)>,
    /// Where the search for the next request starts, so that equals take turns.
    pub(crate) turn: u8,
    pub(crate) quiet_until: Instant,
    pub(crate) cycle_started: Option<Instant>,
    pub(crate) cycle: CycleCounters,
    pub(crate) bus_off: bool,
}

impl<const N: usize> Master<N> {
    /// A master for these axes, in ascending order of drive id.
    ///
    /// # Errors
    /// [`ConfigError`] when the configuration cannot work, or the bus cannot carry it in time.
    pub fn new(config: MasterConfig, axes: &[AxisConfig]) -> Result<Self, ConfigError> {
        config.validate(axes, N)?;
        let plan = config.plan(axes)?;
        let mut events = Events::new();
        for warning in plan.warnings().into_iter().flatten() {
            events.push(Instant::default(), None, EventKind::Plan(warning));
        }
        let mut axis_of = [NO_AXIS; 64];
        let mut places = Vec::new();
        for (index, axis) in (0..).zip(axes) {
            if let Some(place) = axis_of.get_mut(usize::from(axis.drive.get())) {
                *place = index;
            }
            // There is room: the number of axes was checked.
            let _ = places.push(Axis::new(*axis, &config, u32::from(index)));
        }
        Ok(Self {
            config,
            axes: places,
            events,
            axis_of,
            due: 0,
            requests_left: 0,
            request: None,
            turn: 0,
            quiet_until: Instant::default(),
            cycle_started: None,
            cycle: CycleCounters::default(),
            bus_off: false,
        })
    }

    /// Sets where an axis shall be, in command counts from its origin.
    ///
    /// # Errors
    /// [`TargetError`] when the axis does not stream or the target leaves its travel; nothing changes then.
    pub fn set_target(&mut self, axis: usize, counts: i32) -> Result<(), TargetError> {
        let Some(axis) = self.axes.get_mut(axis) else {
            return Err(TargetError::NoSuchAxis {
                axes: N,
                actual: axis,
            });
        };
        if axis.state != AxisState::Streaming {
            return Err(TargetError::NotStreaming { state: axis.state });
        }
        let (min, max) = (axis.config.limits.travel_min, axis.config.limits.travel_max);
        if counts < min || counts > max {
            return Err(TargetError::Travel {
                min,
                max,
                actual: counts,
            });
        }
        axis.books.set_target(counts);
        Ok(())
    }

    /// Starts a cycle: what the cycle before left over is merged, time passes, and every streaming axis owes a
    /// set-point.
    pub fn begin_cycle(&mut self, now: Instant) {
        self.count_cycle(now);
        self.merge_leftovers(now);
        for index in 0..self.axes.len() {
            self.tick_axis(now, index);
        }
        self.due = 0;
        for (index, axis) in self.axes.iter().enumerate() {
            if axis.state.sends_set_points() {
                self.due |= 1 << index;
            }
        }
        self.requests_left = self.config.requests_per_cycle;
        self.choose_request(now);
    }

    fn count_cycle(&mut self, now: Instant) {
        self.cycle.cycles = self.cycle.cycles.wrapping_add(1);
        if let Some(started) = self.cycle_started {
            let cycle_us = u64::from(self.config.cycle_us.max(1));
            // Half a cycle of jitter still belongs to the cycle it was planned for.
            let passed = (now.us_since(started) + cycle_us / 2) / cycle_us;
            if passed > 1 {
                let missed = u32::try_from(passed - 1).unwrap_or(u32::MAX);
                self.cycle.missed = self.cycle.missed.wrapping_add(missed);
                self.events.push(now, None, EventKind::CyclesMissed(missed));
            }
        }
        self.cycle_started = Some(now);
    }

    fn merge_leftovers(&mut self, now: Instant) {
        if self.due == 0 {
            return;
        }
        self.cycle.late = self.cycle.late.wrapping_add(1);
        for (index, axis) in self.axes.iter_mut().enumerate() {
            if self.due & 1 << index != 0 {
                axis.counters.merged = axis.counters.merged.wrapping_add(1);
                self.events
                    .push(now, Some(index as u8), EventKind::SetPointMerged);
            }
        }
    }

    fn tick_axis(&mut self, now: Instant, index: usize) {
        let timeouts = self.config.timeouts;
        let Some((axis, mut log)) = self.axis_and_log(now, index) else {
            return;
        };
        axis.advance_ramp(&mut log);
        if let Some(fault) = axis.tick(&timeouts, &mut log) {
            self.raise(now, index, fault);
        }
    }

    pub(crate) fn axis_and_log(
        &mut self,
        now: Instant,
        index: usize,
    ) -> Option<(&mut Axis, Log<'_>)> {
        let axis = self.axes.get_mut(index)?;
        Some((
            axis,
            Log {
                events: &mut self.events,
                now,
                axis: index as u8,
            },
        ))
    }

    /// Picks the reading to ask for next: what a state waits for, then the poll that is due longest.
    pub(crate) fn choose_request(&mut self, now: Instant) {
        self.request = None;
        if self.requests_left == 0 || self.bus_off || now < self.quiet_until {
            return;
        }
        let (turn, cycle) = (usize::from(self.turn), self.cycle.cycles);
        let axes = || self.axes.iter().enumerate();
        let mut longest = 0;
        for (index, axis) in axes().skip(turn).chain(axes().take(turn)) {
            let Some((request, overdue)) = axis.wanted_request(cycle) else {
                continue;
            };
            if self.request.is_none() || overdue > longest {
                longest = overdue;
                self.request = Some((index as u8, request));
            }
        }
    }

    /// The controller is bus-off: the fate of the frames that it held is not known.
    pub fn on_bus_off(&mut self, now: Instant) {
        if self.bus_off {
            return;
        }
        self.bus_off = true;
        self.events.push(now, None, EventKind::BusOff);
        for index in 0..self.axes.len() {
            if let Some(axis) = self.axes.get_mut(index) {
                axis.abandon_request(now, self.config.timeouts.reply_us);
            }
            self.raise(now, index, Fault::Bus);
        }
    }

    /// The controller takes part in the bus again. Nothing moves until the axes are cleared and enabled.
    pub fn on_bus_recovered(&mut self, now: Instant) {
        if self.bus_off {
            self.bus_off = false;
            self.events.push(now, None, EventKind::BusRecovered);
        }
    }

    pub(crate) fn index_of(&self, address: Address) -> Option<usize> {
        let drive: DriveId = address.drive()?;
        let index = *self.axis_of.get(usize::from(drive.get()))?;
        (index != NO_AXIS).then_some(usize::from(index))
    }

    /// Latches a fault and stops the group as configured.
    pub(crate) fn raise(&mut self, now: Instant, index: usize, fault: Fault) {
        let Some((axis, mut log)) = self.axis_and_log(now, index) else {
            return;
        };
        if axis.fault == Some(fault) {
            return;
        }
        let (group, reaction) = (axis.config.group, axis.config.reactions.to(fault));
        axis.latch(fault, &mut log);
        // An axis that is lost, or whose position is, cannot follow a ramp.
        let own = if fault == Fault::Lost || fault.loses_reference() {
            Reaction::Halt
        } else {
            reaction
        };
        let cycles = self.ramp_cycles(group);
        for other in 0..self.axes.len() {
            let is_own = other == index;
            self.react(
                now,
                other,
                group,
                if is_own { own } else { reaction },
                cycles,
                is_own,
            );
        }
    }

    fn react(
        &mut self,
        now: Instant,
        index: usize,
        group: GroupId,
        reaction: Reaction,
        ramp_cycles: u16,
        is_own: bool,
    ) {
        let Some((axis, mut log)) = self.axis_and_log(now, index) else {
            return;
        };
        if axis.config.group != group || (!is_own && !axis.state.stops_with_group()) {
            return;
        }
        if !is_own {
            axis.latch(Fault::Group, &mut log);
        }
        match (reaction, axis.state) {
            // What is being disabled goes on being disabled.
            (_, AxisState::Faulted | AxisState::Disabling | AxisState::ConfirmingDisable)
            | (Reaction::RampDown, AxisState::RampingDown) => {}
            (Reaction::RampDown, AxisState::Streaming) => {
                axis.start_ramp(ramp_cycles, false, Reason::Fault, &mut log);
            }
            (Reaction::Disable, _) if axis.may_be_enabled() => {
                axis.halt(AxisState::Disabling, Reason::Fault, &mut log);
            }
            _ => axis.halt(AxisState::Faulted, Reason::Fault, &mut log),
        }
        if !axis.state.sends_set_points() {
            self.due &= !(1 << index);
        }
    }

    /// Cycles in which every streaming axis of the group can stop within its limit.
    pub(crate) fn ramp_cycles(&self, group: GroupId) -> u16 {
        self.axes
            .iter()
            .filter(|axis| axis.config.group == group && axis.state == AxisState::Streaming)
            .map(|axis| {
                cycles_to_stop(axis.books.velocity_counts(), axis.config.limits.ramp_change)
            })
            .max()
            .unwrap_or(0)
    }

    pub(crate) fn forget_set_point(&mut self, index: usize) {
        self.due &= !(1 << index);
    }

    /// When `begin_cycle` should come next.
    #[must_use]
    pub fn poll_at(&self) -> Instant {
        self.cycle_started
            .map_or(Instant::default(), |started| started + self.config.cycle_us)
    }

    /// One axis at this moment; `None` when there is no such axis.
    #[must_use]
    pub fn snapshot(&self, axis: usize) -> Option<AxisSnapshot> {
        self.axes.get(axis).map(Axis::snapshot)
    }

    /// The cycle counters.
    #[must_use]
    pub fn cycle_counters(&self) -> CycleCounters {
        CycleCounters {
            events_dropped: self.events.dropped(),
            ..self.cycle
        }
    }

    /// The oldest event that was not read yet.
    pub fn next_event(&mut self) -> Option<Event> {
        self.events.pop()
    }
}
