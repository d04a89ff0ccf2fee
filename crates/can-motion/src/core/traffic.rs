//! The master on the bus: which frame goes out next, and what the outcome of each means.

use bus_user::{BusErrorKind, BusFrame, BusUser, Instant, Outcome, Progress, Sink};

use crate::core::axis::Change;
use crate::core::event::CommonEvent;
use crate::core::exit::{Class, may_leave};
use crate::core::facts::Work;
use crate::core::family::{CommonFault, CycleConfig, Drive, Family, Meaning, Returned};
use crate::core::group::{lowest, mask};
use crate::core::master::Master;
use crate::core::stamp::Stamp;
use crate::core::step::Input;

/// Where a frame comes from.
enum Source<F: Family> {
    /// What an axis sends every cycle.
    Cycle,
    /// What the whole bus gets every cycle.
    Bus,
    /// A command that switches a drive.
    Switch,
    /// A request.
    Request(F::Request),
}

/// Whose frame it is, and what for.
struct Sender<F: Family> {
    /// The axis concerned; `None` for the frame of the whole bus.
    axis: Option<usize>,
    class: Class,
    source: Source<F>,
}

/// What became of the most urgent frame.
enum Attempt {
    /// The controller has taken it.
    Sent,
    /// It is one of the cycle, as long as an axis owes one that may leave.
    OfCycle,
    /// There is none.
    Nothing,
    /// The controller has no room.
    Full,
    /// The controller failed.
    Failed,
}

impl<const N: usize, F: Family> BusUser for Master<N, F> {
    type Frame = F::Frame;

    /// Disable commands first, then the frames of this cycle in ascending order of address, then what the whole bus gets once a cycle,
    /// then enable commands. Requests within their budget go behind all of them, or to the place from which their replies meet none.
    fn send<S: Sink<F::Frame>>(&mut self, now: Instant, sink: &mut S) -> Progress {
        if self.bus_off {
            return Progress::Idle;
        }
        if self.axes.take_back {
            self.take_back(now, sink);
        }
        loop {
            // Nearly every frame is one of the cycle: a short way for these.
            if !sink.has_room() {
                if mask::<N>(self.axes.due) == 0 && !self.has_more() {
                    return Progress::Idle;
                }
                self.full_since.get_or_insert(now);
                return Progress::Blocked;
            }
            let is_turn = mask::<N>(self.axes.switching) == 0
                && !self.schedule.is_reached::<N>(self.axes.due);
            let mut attempt = if is_turn {
                Attempt::OfCycle
            } else {
                self.send_next(now, sink)
            };
            if matches!(attempt, Attempt::OfCycle) {
                attempt = self.send_cycle_frame(now, sink);
            }
            match attempt {
                Attempt::Sent | Attempt::OfCycle => {}
                Attempt::Full => {
                    self.full_since.get_or_insert(now);
                    return Progress::Blocked;
                }
                Attempt::Nothing => {
                    self.full_since = None;
                    return Progress::Idle;
                }
                Attempt::Failed => return Progress::Idle,
            }
        }
    }

    fn on_displaced(&mut self, now: Instant, frame: &F::Frame) {
        self.keep_stamps(now);
        let Some(config) = self.config.get() else {
            return;
        };
        if F::frame_of_bus(config) == Some(*frame) {
            self.frame_of_bus_due = true;
            return;
        }
        if F::MAKES_MOVES && F::is_trigger(frame) {
            self.axes.trigger_returned(now);
            self.schedule.returned();
            self.schedule.choose(now, self.cycle.cycles, &mut self.axes);
            return;
        }
        let Some(index) = self.axes.index_of(frame) else {
            self.foreign(now, F::foreign(frame));
            return;
        };
        let at = (now, self.cycle.cycles, config);
        let returned = self
            .axes
            .with_drive(at, index, |drive, context| drive.returned(frame, context));
        match returned {
            Some(Returned::OfCycle) => {
                let owes = |axis: &crate::core::axis::Axis<F>| axis.drive.owes_frame(&axis.view);
                if self.axes.get(index).is_some_and(owes) {
                    self.axes.due |= 1 << index;
                }
            }
            Some(Returned::Switch(class)) => {
                let input = Input::Displaced(class);
                self.axes.apply(now, index, Change::of(input));
                if F::MAKES_MOVES && class.is_of_own_move() {
                    self.schedule.returned();
                    self.schedule.choose(now, self.cycle.cycles, &mut self.axes);
                }
            }
            Some(Returned::Request) => {
                self.schedule.returned();
                self.schedule.choose(now, self.cycle.cycles, &mut self.axes);
            }
            Some(Returned::Foreign) | None => {}
        }
    }

    fn on_receive_error(&mut self, now: Instant, kind: BusErrorKind) {
        let event = CommonEvent::BusError(kind);
        self.axes.events.push(now, None, event);
    }

    fn on_frame(&mut self, now: Instant, frame: &F::Frame) {
        self.keep_stamps(now);
        let Some(index) = self.axes.index_of(frame) else {
            self.foreign(now, F::foreign(frame));
            return;
        };
        let Some(config) = self.config.get() else {
            return;
        };
        let at = (now, self.cycle.cycles, config);
        let cycle_us = config.cycle_us();
        if let Some(meaning) = self
            .axes
            .with_drive(at, index, |drive, context| drive.receive(frame, context))
        {
            if let Some(quiet_us) = meaning.quiet_us {
                self.schedule.be_quiet(now, quiet_us);
            }
            self.axes.take(now, cycle_us, index, meaning);
        }
    }

    fn on_foreign_frame(&mut self, now: Instant, error: <F::Frame as BusFrame>::Error) {
        self.foreign(now, F::not_ours(error));
    }
}

/// What goes out next. A frame of an axis is made here and nowhere else, after the exit was asked.
impl<const N: usize, F: Family> Master<N, F> {
    #[cold]
    #[inline(never)]
    fn take_back<S: Sink<F::Frame>>(&mut self, now: Instant, sink: &mut S) {
        self.axes.take_back = false;
        while let Some(frame) = sink.take_back() {
            self.on_displaced(now, &frame);
        }
    }

    /// A frame that no axis has anything to do with.
    fn foreign(&mut self, now: Instant, event: Option<F::EventKind>) {
        if let Some(event) = event {
            self.axes.events.push(now, None, event);
        }
    }

    /// Whether there may be something to send beside the frames of the cycle.
    fn has_more(&self) -> bool {
        self.axes.switching != 0 || self.schedule.next.is_some() || self.frame_of_bus().is_some()
    }

    /// Makes the most urgent frame and offers it, unless it is one of the cycle.
    #[inline(never)]
    fn send_next<S: Sink<F::Frame>>(&mut self, now: Instant, sink: &mut S) -> Attempt {
        if self.axes.switching != 0
            && let Some((frame, sender)) = self.switch(Class::SwitchOff)
        {
            return self.offer(now, sink, &frame, &sender);
        }
        if self.axes.due != 0 {
            if self.schedule.is_reached::<N>(self.axes.due)
                && let Some((frame, sender)) = self.request(now)
            {
                return self.offer(now, sink, &frame, &sender);
            }
            return Attempt::OfCycle;
        }
        let last = if let Some(frame) = self.frame_of_bus() {
            let sender = Sender {
                axis: None,
                class: Class::Poll,
                source: Source::Bus,
            };
            Some((frame, sender))
        } else if self.axes.switching != 0 {
            self.switch(Class::SwitchOn)
        } else {
            None
        };
        match last.or_else(|| self.request(now)) {
            Some((frame, sender)) => self.offer(now, sink, &frame, &sender),
            None => Attempt::Nothing,
        }
    }

    /// [`Attempt::OfCycle`] when no axis owes a frame that may leave any more. Always inlined, because [`BusUser::send`] does nothing else
    /// most of the time.
    #[inline(always)]
    fn send_cycle_frame<S: Sink<F::Frame>>(&mut self, now: Instant, sink: &mut S) -> Attempt {
        while mask::<N>(self.axes.due) != 0 {
            let index = lowest::<N>(self.axes.due);
            let Some(axis) = self.axes.get_mut(index) else {
                self.axes.due = 0;
                break;
            };
            let class = if F::HAS_CYCLE_FRAMES {
                Class::of_cycle(&axis.view.facts)
            } else {
                Class::SetPoint
            };
            if may_leave(class, &axis.view.facts) {
                match axis.drive.cycle_frame(&axis.view) {
                    Ok(frame) => match sink.offer(&frame) {
                        Outcome::Accepted => {
                            axis.drive.cycle_frame_accepted(now);
                            axis.sent_at = Stamp::of(now);
                            self.cycle_frame_sent(now, index, class);
                            return Attempt::Sent;
                        }
                        other => {
                            let sender = Sender {
                                axis: Some(index),
                                class,
                                source: Source::Cycle,
                            };
                            return self.conclude(now, &sender, other);
                        }
                    },
                    Err(fault) => self.axes.raise(now, index, fault),
                }
            }
            self.axes.due &= !(1 << index);
        }
        Attempt::OfCycle
    }

    fn offer<S: Sink<F::Frame>>(
        &mut self,
        now: Instant,
        sink: &mut S,
        frame: &F::Frame,
        sender: &Sender<F>,
    ) -> Attempt {
        let outcome = sink.offer(frame);
        self.conclude(now, sender, outcome)
    }

    #[inline(never)]
    fn conclude(
        &mut self,
        now: Instant,
        sender: &Sender<F>,
        outcome: Outcome<F::Frame>,
    ) -> Attempt {
        match outcome {
            Outcome::Accepted => self.accepted(now, sender),
            Outcome::Displaced(displaced) => {
                self.accepted(now, sender);
                self.on_displaced(now, &displaced);
            }
            Outcome::Full => return Attempt::Full,
            Outcome::Failed(kind) => {
                self.failed(now, sender, kind);
                return Attempt::Failed;
            }
        }
        Attempt::Sent
    }

    fn frame_of_bus(&self) -> Option<F::Frame> {
        let config = self.config.get().filter(|_| self.frame_of_bus_due)?;
        F::frame_of_bus(config)
    }

    fn switch(&self, class: Class) -> Option<(F::Frame, Sender<F>)> {
        use crate::core::facts::Power;
        let (wanted, is_on) = match class {
            Class::SwitchOn => (Power::OnWanted, true),
            _ => (Power::OffWanted, false),
        };
        let mut switching = self.axes.switching;
        while switching != 0 {
            let index = switching.trailing_zeros() as usize;
            switching &= switching - 1;
            if let Some(axis) = self.axes.get(index)
                && axis.view.facts.power == wanted
                && may_leave(class, &axis.view.facts)
                && let Some(frame) = axis.drive.switch(is_on)
            {
                let sender = Sender {
                    axis: Some(index),
                    class,
                    source: Source::Switch,
                };
                return Some((frame, sender));
            }
        }
        None
    }

    fn request(&mut self, now: Instant) -> Option<(F::Frame, Sender<F>)> {
        let index = usize::from(self.schedule.next?);
        let axis = self.axes.get(index)?;
        let wanted = axis.drive.wanted(&axis.view, now, self.cycle.cycles)?;
        if wanted.class == Class::Repair && axis.view.facts.work == Work::None {
            self.axes.start_work(now, index, Work::Repair);
        }
        if F::MAKES_MOVES && wanted.class == Class::Trigger && !self.axes.may_be_triggered(index) {
            // Something came up since the moves were loaded: they stay where they are.
            let group = self.axes.get(index)?.drive.group();
            self.axes.end_motion(now, group, Input::Halt);
            return None;
        }
        let axis = self.axes.get(index)?;
        if !may_leave(wanted.class, &axis.view.facts) {
            return None;
        }
        let frame = axis.drive.request_frame(wanted.request)?;
        let sender = Sender {
            axis: Some(index),
            class: wanted.class,
            source: Source::Request(wanted.request),
        };
        Some((frame, sender))
    }

    fn accepted(&mut self, now: Instant, sender: &Sender<F>) {
        let Some(index) = sender.axis else {
            self.full_since = None;
            self.frame_of_bus_due = false;
            return;
        };
        match sender.source {
            Source::Request(request) => self.request_accepted(now, index, sender.class, request),
            Source::Cycle => self.cycle_frame_accepted(now, index, sender.class),
            Source::Switch | Source::Bus => self.switch_accepted(now, index, sender.class),
        }
    }

    fn cycle_frame_accepted(&mut self, now: Instant, index: usize, class: Class) {
        if let Some(axis) = self.axes.get_mut(index) {
            axis.drive.cycle_frame_accepted(now);
            axis.sent_at = Stamp::of(now);
        }
        self.cycle_frame_sent(now, index, class);
    }

    #[inline]
    fn cycle_frame_sent(&mut self, now: Instant, index: usize, class: Class) {
        // It is the lowest: frames go out in this order.
        let due = mask::<N>(self.axes.due);
        self.axes.due = due & due.wrapping_sub(1);
        self.full_since = None;
        self.schedule.frame_accepted();
        if matches!(class, Class::SwitchOn | Class::SwitchOff) {
            self.switch_accepted(now, index, class);
        }
    }

    fn switch_accepted(&mut self, now: Instant, index: usize, class: Class) {
        self.full_since = None;
        self.axes
            .apply(now, index, Change::of(Input::Accepted(class)));
    }

    fn request_accepted(&mut self, now: Instant, index: usize, class: Class, request: F::Request) {
        self.full_since = None;
        let Some(config) = self.config.get() else {
            return;
        };
        let started = self.cycle_started.unwrap_or(now);
        let leaves_at = self.schedule.request_leaves(now, started);
        let (at, cycle_us) = ((now, self.cycle.cycles, config), config.cycle_us());
        let meaning = self.axes.with_drive(at, index, |drive, context| {
            drive.request_accepted(request, leaves_at, context)
        });
        self.schedule.accepted(index);
        // A question changes no fact.
        if F::MAKES_MOVES && class == Class::Trigger {
            self.axes.trigger_accepted(now, index);
        } else if !matches!(class, Class::Reading | Class::Poll) {
            self.axes
                .apply(now, index, Change::of(Input::Accepted(class)));
        }
        if let Some(meaning) = meaning
            && meaning != Meaning::NONE
        {
            self.axes.take(now, cycle_us, index, meaning);
        }
        self.schedule.choose(now, self.cycle.cycles, &mut self.axes);
    }

    fn failed(&mut self, now: Instant, sender: &Sender<F>, kind: BusErrorKind) {
        let axis = sender.axis.map(|index| index as u8);
        let event = CommonEvent::BusError(kind);
        self.axes.events.push(now, axis, event);
        match (sender.class, sender.axis) {
            (Class::SetPoint, Some(index)) => self.axes.raise(now, index, CommonFault::Bus.into()),
            // Keeps its place: it is the same in the next try.
            (Class::StopFrame, _) => {}
            // What may be under way counts as sent: a request is not asked again before its timeout, a switch not taken for undone.
            _ => self.accepted(now, sender),
        }
    }
}
