//! The observer: what passes between master and controller, against the drives' books and the master's own words.

use can_motion::facts::Knowledge;
use can_motion::{AxisSnapshot, AxisState, Event, EventKind, Fault, GroupId, Instant};
use drive_sim::{Frame, Record};
use dyn_can::{DriveId, FunctionCode};
use embedded_can::{Frame as _, Id};

use super::application::Permission;
use super::injection::Kind;
use super::moving::Moving;
use super::scenario::Scenario;
use super::tap::Note;
use super::violation::{Promise, Violation};

/// From the last motion to the position that must show what was lost or doubled: arrival, and the rarest poll.
const ARRIVAL_US: u64 = 300_000;

/// A bus on which no frame gets through for so long must show on an axis that streams.
const OUTAGE_SHOWS_US: u64 = 60_000;

/// What the observer knows of one axis.
#[derive(Debug, Clone, Default)]
pub(super) struct Watched {
    /// A motion that the drive makes by itself.
    pub(super) own: Option<Moving>,
    /// Steps accepted by the controller and not given back.
    handed_counts: i64,
    /// Steps accepted and not yet on the wire, oldest first.
    pub(super) pending: Vec<i64>,
    /// Handed, sent and commanded counts when the axis began to stream; `None` while it is not enabled.
    base: Option<Base>,
    /// The request that the drive has not answered, and when it was accepted.
    outstanding: Option<(FunctionCode, u64)>,
    /// Frames read by the master that answer what was outstanding.
    answers: u32,
    /// An injected fault may have changed what the drive received.
    pub(super) disturbed: bool,
    /// The drive was taken off the bus until it is repaired, so that nobody may hear its alarm.
    muted: bool,
    /// A disturbance may have driven the drive off the bus, and no repair brings it back.
    may_be_bus_off: bool,
    enables_allowed: u32,
}

#[derive(Debug, Clone, Copy)]
struct Base {
    handed_counts: i64,
    sent_counts: i64,
    commanded_counts: i64,
}

/// What the observer knows of one group.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Stopped {
    pub(super) by_alarm: bool,
    pub(super) by_fault: bool,
}

/// A drive and its axis at the end of a cycle.
pub(super) struct Seen {
    pub(super) snapshot: AxisSnapshot,
    pub(super) commanded_counts: i64,
    /// Where its commands lead the drive.
    pub(super) led_counts: i64,
}

#[derive(Debug)]
pub(super) struct Observer {
    pub(super) axes: Vec<Watched>,
    pub(super) groups: Vec<Stopped>,
    of_drive: [Option<usize>; 64],
    pub(super) group_of: Vec<usize>,
    ramping: Vec<bool>,
    /// Alarm and loss that must still show as an event.
    unnoticed: Vec<(usize, Kind)>,
    /// Axes that streamed when the bus failed and do so since, and when that must be over.
    outages: Vec<(usize, u64)>,
    faults: u32,
}

pub(super) fn broken(promise: Promise, now: Instant, what: String) -> Result<(), Violation> {
    Err(Violation {
        promise,
        at_us: now.as_us(),
        what,
    })
}

/// The step in the bytes of a set-point, most significant byte first.
fn step_of(frame: &Frame) -> i64 {
    match *frame.data() {
        [byte] => i64::from(byte as i8),
        [high, low] => i64::from(i16::from_be_bytes([high, low])),
        _ => i64::MAX,
    }
}

fn split(frame: &Frame) -> (u8, FunctionCode) {
    match frame.id() {
        Id::Standard(id) => (
            (id.as_raw() >> 5) as u8,
            FunctionCode::from_can_id(id.as_raw()),
        ),
        Id::Extended(_) => (0, FunctionCode::ForMotorDefine),
    }
}

impl Observer {
    pub(super) fn new(scenario: &Scenario) -> Self {
        let mut of_drive = [None; 64];
        for (index, axis) in scenario.axes.iter().enumerate() {
            of_drive[usize::from(axis.config.drive.get())] = Some(index);
        }
        Self {
            axes: vec![Watched::default(); scenario.axes.len()],
            groups: vec![Stopped::default(); usize::from(scenario.groups)],
            of_drive,
            group_of: scenario
                .axes
                .iter()
                .map(|axis| usize::from(axis.config.group.0))
                .collect(),
            ramping: vec![false; scenario.axes.len()],
            unnoticed: Vec::new(),
            outages: Vec::new(),
            faults: 0,
        }
    }

    /// A fault was injected.
    /// `is_faulted` tells whether an axis has a latched fault, which hides further ones.
    pub(super) fn injected(&mut self, kind: Kind, is_faulted: impl Fn(usize) -> bool) {
        let disturbs = kind.makes_drive_ignore()
            || matches!(
                kind,
                Kind::RepeatSetPoint { .. } | Kind::LoseSetPoint { .. } | Kind::Collide { .. }
            );
        if let (Some(axis), true) = (kind.axis(), disturbs) {
            self.axes[axis].disturbed = true;
        }
        if let Kind::Disturb { .. } = kind {
            self.axes.iter_mut().for_each(|axis| {
                axis.disturbed = true;
                axis.may_be_bus_off = true;
            });
        }
        if let Kind::Silence { axis, .. } = kind {
            self.axes[axis].muted = true;
        }
        let shows = matches!(
            kind,
            Kind::Alarm { .. } | Kind::Silence { for_us: None, .. }
        );
        if let (Some(axis), true) = (kind.axis(), shows)
            && !is_faulted(axis)
        {
            self.unnoticed.push((axis, kind));
        }
    }

    /// The bus may fail with it, for all axes alike.
    pub(super) fn bus_fails(&mut self, kind: Kind, now: Instant, streams: impl Fn(usize) -> bool) {
        if kind.outage_us() > OUTAGE_SHOWS_US {
            let until_us = now.as_us() + OUTAGE_SHOWS_US;
            let axes = (0..self.axes.len()).filter(|axis| streams(*axis));
            self.outages.extend(axes.map(|axis| (axis, until_us)));
        }
    }

    /// Somebody repaired the drive of an axis: what was wrong with it need not show any more.
    pub(super) fn repaired(&mut self, axis: usize) {
        self.axes[axis].muted = false;
        self.unnoticed.retain(|(of, _)| *of != axis);
    }

    /// A cycle begins; the application has just given these permissions.
    pub(super) fn cycle_begins(&mut self, permissions: &[Permission]) {
        for permission in permissions {
            let (Permission::Enable(GroupId(group)) | Permission::Resume(GroupId(group))) =
                *permission;
            self.groups[usize::from(group)] = Stopped::default();
            for axis in 0..self.axes.len() {
                if self.group_of[axis] == usize::from(group)
                    && matches!(permission, Permission::Enable(_))
                {
                    self.axes[axis].enables_allowed = 1;
                }
            }
        }
    }

    /// The states in which the master handed over what is noted next.
    pub(super) fn states(&mut self, axes: impl Iterator<Item = AxisSnapshot>) {
        for (ramping, axis) in self.ramping.iter_mut().zip(axes) {
            *ramping = axis.state == AxisState::RampingDown;
        }
    }

    /// What passed between master and controller.
    pub(super) fn note(
        &mut self,
        note: Note,
        scenario: &Scenario,
        now: Instant,
    ) -> Result<(), Violation> {
        match note {
            Note::Accepted(frame) => self.accepted(&frame, scenario, now),
            Note::Displaced(frame) => {
                self.displaced(&frame);
                Ok(())
            }
            Note::Received(frame) => {
                self.received(&frame, scenario, now);
                Ok(())
            }
            Note::SendFailed => Ok(()),
        }
    }

    fn accepted(
        &mut self,
        frame: &Frame,
        scenario: &Scenario,
        now: Instant,
    ) -> Result<(), Violation> {
        let (drive, function) = split(frame);
        if (drive, function) == (0, FunctionCode::SyncTrigger) {
            return self.trigger(frame, now);
        }
        let Some(index) = self.of_drive[usize::from(drive)] else {
            return broken(
                Promise::Commands,
                now,
                format!("{frame} goes to no drive of the master"),
            );
        };
        match function {
            FunctionCode::GoRelativePosPd => self.set_point(index, frame, scenario, now),
            FunctionCode::ServoDisable => self.switch(index, frame, now),
            FunctionCode::GoAbsolutePosPtp
            | FunctionCode::GoRelativePosPtp
            | FunctionCode::GoAbsolutePosSync
            | FunctionCode::GoRelativePosSync => self.move_frame(index, (function, frame), now),
            FunctionCode::EchoFunction
            | FunctionCode::ReadParamGroup3
            | FunctionCode::ReadDriveConfig
            | FunctionCode::ReadDriveStatus
            | FunctionCode::ReadMotorSpeed
            | FunctionCode::GeneralRead
            | FunctionCode::DiagnosticCounter => self.request(index, function, scenario, now),
            _ => broken(Promise::Commands, now, format!("nobody asked for {frame}")),
        }
    }

    fn set_point(
        &mut self,
        index: usize,
        frame: &Frame,
        scenario: &Scenario,
        now: Instant,
    ) -> Result<(), Violation> {
        let step = step_of(frame);
        let limit = i64::from(scenario.axes[index].config.limits.max_step.get());
        if step.abs() > limit {
            return broken(
                Promise::Limits,
                now,
                format!("axis {index}: step {step}, limit {limit}"),
            );
        }
        if self.streams_into_a_move(index) {
            return broken(
                Promise::Commands,
                now,
                format!("axis {index}: set-point {frame} in a move of its drive"),
            );
        }
        let group = self.groups[self.group_of[index]];
        if group.by_alarm {
            return broken(
                Promise::AlarmStops,
                now,
                format!("axis {index}: set-point {frame} behind an alarm"),
            );
        }
        if group.by_fault && !self.ramping[index] {
            return broken(
                Promise::FaultStops,
                now,
                format!("axis {index}: set-point {frame} behind a fault"),
            );
        }
        self.axes[index].handed_counts += step;
        self.axes[index].pending.push(step);
        Ok(())
    }

    fn switch(&mut self, index: usize, frame: &Frame, now: Instant) -> Result<(), Violation> {
        let axis = &mut self.axes[index];
        match frame.data() {
            [0x00] if axis.enables_allowed > 0 => axis.enables_allowed -= 1,
            [0xFF] => axis.enables_allowed = 0,
            _ => {
                return broken(
                    Promise::Commands,
                    now,
                    format!("axis {index}: nobody asked for {frame}"),
                );
            }
        }
        Ok(())
    }

    fn request(
        &mut self,
        index: usize,
        function: FunctionCode,
        scenario: &Scenario,
        now: Instant,
    ) -> Result<(), Violation> {
        let wait_us = 2 * u64::from(scenario.master.timeouts.reply_us);
        let axis = &mut self.axes[index];
        if let Some((before, since_us)) = axis.outstanding
            && now.as_us() < since_us + wait_us
        {
            let age_us = now.as_us() - since_us;
            let what =
                format!("axis {index}: {function} asked {age_us} us after the unanswered {before}");
            return broken(Promise::OneRequest, now, what);
        }
        axis.outstanding = Some((function, now.as_us()));
        Ok(())
    }

    fn displaced(&mut self, frame: &Frame) {
        let (drive, function) = split(frame);
        let Some(index) = self.of_drive[usize::from(drive)] else {
            return;
        };
        if matches!(
            function,
            FunctionCode::GoAbsolutePosPtp
                | FunctionCode::GoRelativePosPtp
                | FunctionCode::GoAbsolutePosSync
                | FunctionCode::GoRelativePosSync
        ) {
            self.move_frame_returns(index, function);
            return;
        }
        let axis = &mut self.axes[index];
        match function {
            FunctionCode::GoRelativePosPd => {
                axis.handed_counts -= step_of(frame);
                // Of equal identifiers the controller displaces the one handed over last.
                if let Some(place) = axis
                    .pending
                    .iter()
                    .rposition(|&step| step == step_of(frame))
                {
                    axis.pending.remove(place);
                }
            }
            FunctionCode::ServoDisable if frame.data() == [0x00] => axis.enables_allowed += 1,
            FunctionCode::ServoDisable => {}
            _ => axis.outstanding = None,
        }
    }

    fn received(&mut self, frame: &Frame, scenario: &Scenario, now: Instant) {
        let (drive, function) = split(frame);
        let Some(index) = self.of_drive[usize::from(drive)] else {
            return;
        };
        if function == FunctionCode::DriveError && frame.data() == [0xEE] {
            self.groups[self.group_of[index]].by_alarm = true;
        }
        // The master may notice a timeout only when its next cycle begins.
        let window_us = u64::from(scenario.master.timeouts.reply_us + scenario.master.cycle_us);
        let axis = &mut self.axes[index];
        if let Some((asked, since_us)) = axis.outstanding
            && asked == function
        {
            axis.outstanding = None;
            axis.answers += u32::from(now.as_us() <= since_us + window_us);
        }
    }

    /// A frame of the master ended on the wire.
    pub(super) fn on_wire(&mut self, record: &Record) {
        let (drive, function) = split(&record.frame);
        let is_through = record.outcome == drive_sim::Outcome::Delivered;
        if function == FunctionCode::GoRelativePosPd
            && is_through
            && let Some(index) = self.of_drive[usize::from(drive)]
            && !self.axes[index].pending.is_empty()
        {
            self.axes[index].pending.remove(0);
        }
    }

    /// The application threw away what the controller held, and told the master.
    pub(super) fn aborted(&mut self) {
        for axis in &mut self.axes {
            axis.pending.clear();
            axis.outstanding = None;
            axis.base = None;
        }
    }

    pub(super) fn event(&mut self, event: &Event<EventKind>) {
        let (EventKind::Fault(fault), Some(axis)) = (event.kind, event.axis) else {
            return;
        };
        self.faults += 1;
        let axis = usize::from(axis);
        self.groups[self.group_of[axis]].by_fault = true;
        let is_unheard = self.axes[axis].muted || self.axes[axis].may_be_bus_off;
        self.unnoticed.retain(|(of, kind)| {
            let shows = match (kind, fault) {
                (Kind::Alarm { .. }, Fault::AlarmFrame | Fault::AlarmStatus(_)) => true,
                // What is off the bus cannot tell of its alarm; that it is off must show instead.
                (Kind::Alarm { .. }, Fault::Lost) => is_unheard,
                (_, fault) => fault == Fault::Lost,
            };
            *of != axis || !shows
        });
    }

    /// A cycle has ended: the books must agree.
    pub(super) fn cycle_ends(&mut self, seen: &[Seen], now: Instant) -> Result<(), Violation> {
        self.outages
            .retain(|(axis, _)| seen[*axis].snapshot.state == AxisState::Streaming);
        if let Some((axis, _)) = self
            .outages
            .iter()
            .find(|(_, until_us)| now.as_us() > *until_us)
        {
            let what = format!("axis {axis} streams on, and no frame gets through");
            return broken(Promise::Noticed, now, what);
        }
        for (index, seen) in seen.iter().enumerate() {
            self.move_goes_on(index, seen, now)?;
        }
        for (index, (axis, seen)) in self.axes.iter_mut().zip(seen).enumerate() {
            let snapshot = &seen.snapshot;
            if snapshot.counters.replies > axis.answers {
                let what = format!(
                    "axis {index}: {} believed, {} answers",
                    snapshot.counters.replies, axis.answers
                );
                return broken(Promise::TrueReplies, now, what);
            }
            let is_anchored = snapshot.facts.knowledge == Knowledge::Anchored;
            let own_fault = snapshot.fault.is_some_and(|fault| fault != Fault::Group);
            let moves = axis.own.is_some() || snapshot.facts.has_own_move();
            if !snapshot.state.is_enabled() || !is_anchored || own_fault || moves {
                axis.base = None;
                continue;
            }
            let present = Base {
                handed_counts: axis.handed_counts,
                sent_counts: i64::from(snapshot.sent_counts),
                commanded_counts: seen.commanded_counts + axis.pending.iter().sum::<i64>(),
            };
            let base = *axis.base.get_or_insert(present);
            let handed = present.handed_counts - base.handed_counts;
            let sent = present.sent_counts - base.sent_counts;
            let received = present.commanded_counts - base.commanded_counts;
            if sent != handed {
                let what =
                    format!("axis {index}: the master counts {sent}, its controller took {handed}");
                return broken(Promise::Books, now, what);
            }
            if received != handed && !axis.disturbed {
                let what = format!("axis {index}: the drive got {received} of {handed}");
                return broken(Promise::Books, now, what);
            }
        }
        Ok(())
    }

    /// The run is over: what faults changed must be flagged, and nothing may have been overlooked.
    pub(super) fn finish(
        &self,
        seen: &[Seen],
        scenario: &Scenario,
        dropped: u32,
        now: Instant,
    ) -> Result<(), Violation> {
        for (index, (axis, seen)) in self.axes.iter().zip(seen).enumerate() {
            let Some(base) = axis.base else { continue };
            // While alarm frames come the polls rest, and nobody looks at the position.
            let Some(read) = seen.snapshot.feedback.position else {
                continue;
            };
            if read.at.as_us() < scenario.calm_from_us + ARRIVAL_US {
                continue;
            }
            // The books keep what was within the tolerance before a fault of the group, where the base begins anew.
            let shown = read.value.abs_diff(seen.snapshot.sent_counts);
            let handed = axis.handed_counts - base.handed_counts;
            let off = seen.commanded_counts + axis.pending.iter().sum::<i64>()
                - base.commanded_counts
                - handed;
            let tolerance = i64::from(scenario.axes[index].config.limits.drift_tolerance_counts);
            if off.abs() > tolerance && i64::from(shown) > tolerance {
                let what = format!(
                    "axis {index} is {off} counts off and not flagged, tolerance {tolerance}"
                );
                return broken(Promise::Books, now, what);
            }
        }
        if let Some((axis, kind)) = self.unnoticed.first() {
            return broken(
                Promise::Noticed,
                now,
                format!("axis {axis}: {kind:?} showed as no event"),
            );
        }
        self.moves_have_ended(!scenario.injections.is_empty(), now)?;
        if scenario.injections.is_empty() && self.faults > 0 {
            return broken(
                Promise::NoFalseAlarm,
                now,
                format!("{} faults without a cause", self.faults),
            );
        }
        if dropped > 0 {
            return broken(
                Promise::Orderly,
                now,
                format!("{dropped} events were dropped"),
            );
        }
        Ok(())
    }
}

/// The id of the drive of an axis.
pub(super) fn drive_of(scenario: &Scenario, axis: usize) -> DriveId {
    scenario.axes[axis].config.drive
}
