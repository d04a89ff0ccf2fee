//! The master on the bus: which frame goes out next, and what the outcome of each means.

use bus_user::{BusErrorKind, BusFrame, BusUser, Instant, Outcome, Progress, Sink};

use crate::core::axis::Change;
use crate::core::event::CommonEvent;
use crate::core::exit::{Class, may_leave};
use crate::core::facts::Work;
use crate::core::family::{CommonFault, CycleConfig, Drive, Family, Returned};
use crate::core::master::Master;
use crate::core::placement::RequestPlacement;
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

/// A frame on its way to the controller.
struct Offer<F: Family> {
    frame: F::Frame,
    /// The axis concerned; `None` for the frame of the whole bus.
    axis: Option<usize>,
    class: Class,
    source: Source<F>,
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
            self.axes.take_back = false;
            while let Some(frame) = sink.take_back() {
                self.on_displaced(now, &frame);
            }
        }
        while let Some(offer) = self.next_offer(now) {
            match sink.offer(&offer.frame) {
                Outcome::Accepted => self.accepted(now, &offer),
                Outcome::Displaced(displaced) => {
                    self.accepted(now, &offer);
                    self.on_displaced(now, &displaced);
                }
                Outcome::Full => {
                    self.full_since.get_or_insert(now);
                    return Progress::Blocked;
                }
                Outcome::Failed(kind) => {
                    self.failed(now, &offer, kind);
                    return Progress::Idle;
                }
            }
        }
        Progress::Idle
    }

    fn on_displaced(&mut self, now: Instant, frame: &F::Frame) {
        if F::frame_of_bus(&self.config) == Some(*frame) {
            self.frame_of_bus_due = true;
            return;
        }
        let Some(index) = self.axes.index_of(frame) else {
            self.foreign(now, F::foreign(frame));
            return;
        };
        let at = (now, self.cycle.cycles, &self.config);
        let returned = self
            .axes
            .with_drive(at, index, |drive, context| drive.returned(frame, context));
        match returned {
            Some(Returned::OfCycle) => {
                let owes = |axis: &crate::core::axis::Axis<F>| axis.drive.owes_frame(&axis.view());
                if self.axes.get(index).is_some_and(owes) {
                    self.axes.due |= 1 << index;
                }
            }
            Some(Returned::Switch(class)) => {
                let input = Input::Displaced(class);
                self.axes.apply(now, index, Change::of(input));
            }
            Some(Returned::Request) => {
                self.schedule.returned();
                self.schedule.choose(now, self.cycle.cycles, &self.axes);
            }
            Some(Returned::Foreign) | None => {}
        }
    }

    fn on_receive_error(&mut self, now: Instant, kind: BusErrorKind) {
        let event = CommonEvent::BusError(kind);
        self.axes.events.push(now, None, event);
    }

    fn on_frame(&mut self, now: Instant, frame: &F::Frame) {
        let Some(index) = self.axes.index_of(frame) else {
            self.foreign(now, F::foreign(frame));
            return;
        };
        let at = (now, self.cycle.cycles, &self.config);
        let cycle_us = self.config.cycle_us();
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

/// What is offered next. A frame of an axis is made here and nowhere else, after the exit was asked.
impl<const N: usize, F: Family> Master<N, F> {
    /// A frame that no axis has anything to do with.
    fn foreign(&mut self, now: Instant, event: Option<F::EventKind>) {
        if let Some(event) = event {
            self.axes.events.push(now, None, event);
        }
    }

    fn next_offer(&mut self, now: Instant) -> Option<Offer<F>> {
        if let Some(offer) = self.switch(Class::SwitchOff) {
            return Some(offer);
        }
        if self.axes.due != 0
            && self.schedule.placement.is_reached(self.axes.due)
            && let Some(offer) = self.request(now)
        {
            return Some(offer);
        }
        self.cycle_frame(now)
            .or_else(|| self.frame_of_bus())
            .or_else(|| self.switch(Class::SwitchOn))
            .or_else(|| self.request(now))
    }

    fn cycle_frame(&mut self, now: Instant) -> Option<Offer<F>> {
        while self.axes.due != 0 {
            let index = self.axes.due.trailing_zeros() as usize;
            let (axis, _) = self.axes.with_log(now, index)?;
            let class = if F::HAS_CYCLE_FRAMES {
                Class::of_cycle(&axis.facts)
            } else {
                Class::SetPoint
            };
            if may_leave(class, &axis.facts) {
                match axis.drive.cycle_frame(&axis.view()) {
                    Ok(frame) => {
                        return Some(Offer {
                            frame,
                            axis: Some(index),
                            class,
                            source: Source::Cycle,
                        });
                    }
                    Err(fault) => self.axes.raise(now, index, fault),
                }
            }
            self.axes.due &= !(1 << index);
        }
        None
    }

    fn frame_of_bus(&self) -> Option<Offer<F>> {
        let frame = F::frame_of_bus(&self.config)?;
        self.frame_of_bus_due.then_some(Offer {
            frame,
            axis: None,
            class: Class::Poll,
            source: Source::Bus,
        })
    }

    fn switch(&self, class: Class) -> Option<Offer<F>> {
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
                && axis.facts.power == wanted
                && may_leave(class, &axis.facts)
                && let Some(frame) = axis.drive.switch(is_on)
            {
                return Some(Offer {
                    frame,
                    axis: Some(index),
                    class,
                    source: Source::Switch,
                });
            }
        }
        None
    }

    fn request(&mut self, now: Instant) -> Option<Offer<F>> {
        let index = self.schedule.next?;
        let axis = self.axes.get(index)?;
        let wanted = axis.drive.wanted(&axis.view(), now, self.cycle.cycles)?;
        if wanted.class == Class::Repair && axis.facts.work == Work::None {
            self.axes.start_work(now, index, Work::Repair);
        }
        let axis = self.axes.get(index)?;
        if !may_leave(wanted.class, &axis.facts) {
            return None;
        }
        Some(Offer {
            frame: axis.drive.request_frame(wanted.request)?,
            axis: Some(index),
            class: wanted.class,
            source: Source::Request(wanted.request),
        })
    }

    fn accepted(&mut self, now: Instant, offer: &Offer<F>) {
        self.full_since = None;
        let Some(index) = offer.axis else {
            self.frame_of_bus_due = false;
            return;
        };
        match offer.source {
            Source::Request(request) => {
                return self.request_accepted(now, index, offer.class, request);
            }
            Source::Cycle => {
                if let Some((axis, _)) = self.axes.with_log(now, index) {
                    axis.drive.cycle_frame_accepted(now);
                    axis.sent_at = now;
                    self.axes.due &= !(1 << index);
                    self.schedule.placement.frame_accepted();
                }
            }
            Source::Switch | Source::Bus => {}
        }
        if matches!(offer.class, Class::SwitchOn | Class::SwitchOff) {
            self.axes
                .apply(now, index, Change::of(Input::Accepted(offer.class)));
        }
    }

    fn request_accepted(&mut self, now: Instant, index: usize, class: Class, request: F::Request) {
        let started = self.cycle_started.unwrap_or(now);
        let leaves_at = self.schedule.placement.request_leaves(now, started);
        let at = (now, self.cycle.cycles, &self.config);
        let meaning = self.axes.with_drive(at, index, |drive, context| {
            drive.request_accepted(request, leaves_at, context)
        });
        self.schedule.accepted(index);
        self.axes
            .apply(now, index, Change::of(Input::Accepted(class)));
        if let Some(meaning) = meaning {
            self.axes.take(now, self.config.cycle_us(), index, meaning);
        }
        self.schedule.choose(now, self.cycle.cycles, &self.axes);
    }

    fn failed(&mut self, now: Instant, offer: &Offer<F>, kind: BusErrorKind) {
        let axis = offer.axis.map(|index| index as u8);
        let event = CommonEvent::BusError(kind);
        self.axes.events.push(now, axis, event);
        match (offer.class, offer.axis) {
            (Class::SetPoint, Some(index)) => self.axes.raise(now, index, CommonFault::Bus.into()),
            // Keeps its place: it is the same in the next try.
            (Class::StopFrame, _) => {}
            // What may be under way counts as sent: a request is not asked again before its timeout, a switch not taken for undone.
            _ => self.accepted(now, offer),
        }
    }
}
