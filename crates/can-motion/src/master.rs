//! The master: axes, cycle, order of frames. Sans-I/O, so every method is told the time.

use crate::config::GroupId;
use crate::dyn_axes::Dyn;
use crate::event::{Event, Events};
use crate::family::{CycleConfig, Family, FaultKind, Happening, Hears, Life, Log, Sends};
use crate::fault::Reaction;
use crate::life::{AxisState, Reason};
use crate::placement::Placement;
use crate::plan::Burst;
use crate::snapshot::CycleCounters;
use crate::time::Instant;
use heapless::Vec;

/// Place in `Master::axis_of` of an address without an axis.
const NO_AXIS: u8 = u8::MAX;

/// An axis, where it writes its events, and the settings of the bus.
type InUse<'a, F> = (
    &'a mut <F as Family>::Axis,
    Log<'a, <F as Family>::EventKind>,
    &'a <F as Family>::Config,
);

/// A motion master for at most `N` axes on one bus, whose drives are of one family.
///
/// A cycle is: `set_target` for each axis, `begin_cycle`, then `service` (or `next_frame` and `on_accepted` by hand)
/// until nothing is left, again whenever the controller has room, and `on_frame` for what comes in.
#[derive(Debug)]
pub struct Master<const N: usize, F: Family = Dyn> {
    pub(crate) config: F::Config,
    pub(crate) axes: Vec<F::Axis, N>,
    pub(crate) events: Events<F::EventKind>,
    /// Place of each address in `axes`.
    axis_of: [u8; 128],
    /// One bit an axis: its set-point of this cycle has not been accepted yet.
    pub(crate) due: u64,
    /// An axis may have an enable or disable command to send. Noted, because looking through all axes for each next frame is a
    /// good part of the cost of a cycle.
    pub(crate) may_switch: bool,
    /// The frame of the whole bus has not been accepted in this cycle yet.
    pub(crate) cycle_frame_due: bool,
    pub(crate) requests_left: u8,
    pub(crate) request: Option<(u8, F::Request)>,
    /// Where the search for the next request starts, so that equals take turns.
    pub(crate) turn: u8,
    pub(crate) placement: Placement,
    pub(crate) quiet_until: Instant,
    pub(crate) cycle_started: Option<Instant>,
    pub(crate) cycle: CycleCounters,
    pub(crate) bus_off: bool,
}

impl<const N: usize, F: Family> Master<N, F> {
    /// A master without axes.
    pub(crate) fn empty(config: F::Config) -> Self {
        Self {
            placement: Placement::new(config.cycle_us(), Burst::NONE, false),
            config,
            axes: Vec::new(),
            events: Events::new(),
            axis_of: [NO_AXIS; 128],
            due: 0,
            may_switch: false,
            cycle_frame_due: false,
            requests_left: 0,
            request: None,
            turn: 0,
            quiet_until: Instant::default(),
            cycle_started: None,
            cycle: CycleCounters::default(),
            bus_off: false,
        }
    }

    /// Adds the axis of the drive with this address; one without room is left out, so the number of axes is checked before.
    pub(crate) fn add(&mut self, address: u8, axis: F::Axis) {
        let index = self.axes.len() as u8;
        if self.axes.push(axis).is_ok()
            && let Some(place) = self.axis_of.get_mut(usize::from(address))
        {
            *place = index;
        }
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
        self.may_switch = false;
        for (index, axis) in self.axes.iter().enumerate() {
            if axis.sends_each_cycle() {
                self.due |= 1 << index;
            }
            self.may_switch |= matches!(axis.state(), AxisState::Disabling | AxisState::Enabling);
        }
        self.cycle_frame_due = true;
        self.requests_left = self.config.requests_per_cycle();
        self.place_requests();
        self.choose_request(now);
    }

    fn count_cycle(&mut self, now: Instant) {
        self.cycle.cycles = self.cycle.cycles.wrapping_add(1);
        if let Some(started) = self.cycle_started {
            let cycle_us = u64::from(self.config.cycle_us().max(1));
            // Half a cycle of jitter still belongs to the cycle it was planned for.
            let passed = (now.us_since(started) + cycle_us / 2) / cycle_us;
            if passed > 1 {
                let missed = u32::try_from(passed - 1).unwrap_or(u32::MAX);
                self.cycle.missed = self.cycle.missed.wrapping_add(missed);
                self.events.push(now, None, Happening::CyclesMissed(missed));
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
                axis.merged();
                self.events
                    .push(now, Some(index as u8), Happening::SetPointMerged);
            }
        }
    }

    fn tick_axis(&mut self, now: Instant, index: usize) {
        let Some((axis, mut log, config)) = self.axis_in_use(now, index) else {
            return;
        };
        if let Some(fault) = axis.tick(config, &mut log) {
            self.raise(now, index, fault);
        }
    }

    pub(crate) fn axis_and_log(
        &mut self,
        now: Instant,
        index: usize,
    ) -> Option<(&mut F::Axis, Log<'_, F::EventKind>)> {
        let (axis, log, _) = self.axis_in_use(now, index)?;
        Some((axis, log))
    }

    /// An axis with what it needs in a cycle.
    pub(crate) fn axis_in_use(&mut self, now: Instant, index: usize) -> Option<InUse<'_, F>> {
        let axis = self.axes.get_mut(index)?;
        // Whoever writes events may change the state.
        self.may_switch = true;
        Some((
            axis,
            Log {
                events: &mut self.events,
                now,
                axis: index as u8,
            },
            &self.config,
        ))
    }

    /// The controller is bus-off: the fate of the frames that it held is not known.
    pub fn on_bus_off(&mut self, now: Instant) {
        if self.bus_off {
            return;
        }
        self.bus_off = true;
        self.events.push(now, None, Happening::BusOff);
        for index in 0..self.axes.len() {
            if let Some(axis) = self.axes.get_mut(index) {
                axis.abandon_request(now, &self.config);
            }
            self.raise(now, index, F::Fault::BUS);
        }
    }

    /// The controller takes part in the bus again. Nothing moves until the axes are cleared and enabled.
    pub fn on_bus_recovered(&mut self, now: Instant) {
        if self.bus_off {
            self.bus_off = false;
            self.events.push(now, None, Happening::BusRecovered);
        }
    }

    pub(crate) fn index_of(&self, frame: &F::Frame) -> Option<usize> {
        let address = F::address(frame)?;
        let index = *self.axis_of.get(usize::from(address))?;
        (index != NO_AXIS).then_some(usize::from(index))
    }

    /// Latches a fault and stops the group as configured.
    pub(crate) fn raise(&mut self, now: Instant, index: usize, fault: F::Fault) {
        let Some((axis, mut log)) = self.axis_and_log(now, index) else {
            return;
        };
        if axis.fault() == Some(fault) {
            return;
        }
        let (group, reaction) = (axis.group(), axis.reaction_to(fault));
        axis.latch(fault, &mut log);
        let own = if fault.cannot_ramp() {
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
        if axis.group() != group || (!is_own && !axis.state().stops_with_group()) {
            return;
        }
        if !is_own {
            axis.latch(F::Fault::GROUP, &mut log);
        }
        match (reaction, axis.state()) {
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
        self.stopped(index);
    }

    /// An axis may have stopped: its set-point of this cycle is void, or is the frame that stops it.
    pub(crate) fn stopped(&mut self, index: usize) {
        let Some(axis) = self.axes.get(index) else {
            return;
        };
        if axis.state().sends_set_points() {
            return;
        }
        if F::STOPS_BY_FRAME && axis.sends_each_cycle() {
            self.due |= 1 << index;
        } else {
            self.due &= !(1 << index);
        }
    }

    /// Cycles in which every streaming axis of the group can stop within its limit.
    pub(crate) fn ramp_cycles(&self, group: GroupId) -> u16 {
        self.axes
            .iter()
            .filter(|axis| axis.group() == group && axis.state() == AxisState::Streaming)
            .map(Life::cycles_to_stop)
            .max()
            .unwrap_or(0)
    }

    /// When `begin_cycle` should come next.
    #[must_use]
    pub fn poll_at(&self) -> Instant {
        self.cycle_started.map_or(Instant::default(), |started| {
            started + self.config.cycle_us()
        })
    }

    /// One axis at this moment; `None` when there is no such axis.
    #[must_use]
    pub fn snapshot(&self, axis: usize) -> Option<F::Snapshot> {
        self.axes.get(axis).map(Life::snapshot)
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
    pub fn next_event(&mut self) -> Option<Event<F::EventKind>> {
        self.events.pop()
    }
}
