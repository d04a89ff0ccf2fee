//! The master on the bus: which frame goes out next, and what the outcome of each means to the books.

use crate::bus_user::{BusFrame, BusUser};
use crate::event::BusErrorKind;
use crate::family::{Family, FaultKind, Happening, Hears, Life, Sends, Switch};
use crate::life::AxisState;
use crate::master::Master;
use crate::outgoing::{Outgoing, Purpose};
use crate::time::Instant;

impl<const N: usize, F: Family> BusUser for Master<N, F> {
    type Outgoing = Outgoing<F>;
    type Frame = F::Frame;

    /// The frame that should go out next; asking changes nothing.
    ///
    /// Disable commands first, then the set-points of this cycle in ascending order of address, then what the whole bus gets once a
    /// cycle, then enable commands. Requests within their budget go behind all of them, or to the place among the set-points from
    /// which their replies meet none.
    fn next_frame(&self) -> Option<Outgoing<F>> {
        if self.bus_off {
            return None;
        }
        self.switch_frame(AxisState::Disabling, Switch::Disable)
            .or_else(|| self.placed_request_frame())
            .or_else(|| self.set_point_frame())
            .or_else(|| self.cycle_frame())
            .or_else(|| self.switch_frame(AxisState::Enabling, Switch::Enable))
            .or_else(|| self.request_frame())
    }

    fn on_accepted(&mut self, now: Instant, outgoing: &Outgoing<F>) {
        let Some(axis) = outgoing.axis else {
            self.cycle_frame_due = false;
            return;
        };
        let (index, cycle) = (usize::from(axis), self.cycle.cycles);
        let cycle_started = self.cycle_started.unwrap_or(now);
        let placement = self.placement;
        let may_switch = self.may_switch;
        let Some((axis, mut log, config)) = self.axis_in_use(now, index) else {
            return;
        };
        match outgoing.purpose {
            Purpose::Cycle => {}
            Purpose::SetPoint(step) => {
                axis.stepped(step, now);
                self.due &= !(1 << index);
                // A set-point that was accepted leaves the state as it is.
                self.may_switch = may_switch;
                self.placement.set_point_accepted();
            }
            Purpose::Switch(switch) => axis.switched(switch, &mut log),
            Purpose::Request(request) => {
                axis.requested(request, cycle, config, &mut log);
                axis.expect_reply(placement.request_leaves(now, cycle_started));
                self.requests_left = self.requests_left.saturating_sub(1);
                self.turn = (index as u8).wrapping_add(1);
                self.choose_request(now);
            }
        }
    }

    fn on_displaced(&mut self, now: Instant, frame: &F::Frame) {
        let cycle = self.cycle.cycles;
        if F::cycle_frame(&self.config) == Some(*frame) {
            self.cycle_frame_due = true;
            return;
        }
        let Some(index) = self.index_of(frame) else {
            self.events.push(now, None, F::foreign(frame));
            return;
        };
        let Some((axis, mut log)) = self.axis_and_log(now, index) else {
            return;
        };
        let was_request = axis.displaced(frame, cycle, &mut log);
        if axis.sends_each_cycle() && axis.owes_set_point() {
            self.due |= 1 << index;
        }
        if was_request {
            // It did not use its place in the budget. Without another try in this cycle the requests of the highest drive
            // would give way for ever to those of lower ones in a controller that sorts by identifier.
            self.requests_left = self.requests_left.saturating_add(1);
            self.choose_request(now);
        }
    }

    fn on_transmit_error(&mut self, now: Instant, outgoing: &Outgoing<F>, kind: BusErrorKind) {
        self.events
            .push(now, outgoing.axis, Happening::BusError(kind));
        match outgoing.purpose {
            Purpose::SetPoint(_) => {
                if let Some(axis) = outgoing.axis {
                    self.raise(now, usize::from(axis), F::Fault::BUS);
                }
            }
            // A request that may be under way must not be asked again before its timeout; a command is repeated.
            Purpose::Request(_) | Purpose::Cycle => self.on_accepted(now, outgoing),
            Purpose::Switch(_) => {}
        }
    }

    fn on_receive_error(&mut self, now: Instant, kind: BusErrorKind) {
        self.events.push(now, None, Happening::BusError(kind));
    }

    fn on_frame(&mut self, now: Instant, frame: &F::Frame) {
        let Some(index) = self.index_of(frame) else {
            self.events.push(now, None, F::foreign(frame));
            return;
        };
        let Some((axis, mut log, config)) = self.axis_in_use(now, index) else {
            return;
        };
        if let Some(fault) = axis.hear(frame, config, &mut log) {
            if let Some(quiet_us) = axis.quiet_us(fault, config) {
                self.quiet_until = now + quiet_us;
                self.request = None;
            }
            self.raise(now, index, fault);
        }
    }

    fn on_foreign_frame(&mut self, now: Instant, error: <F::Frame as BusFrame>::Error) {
        self.events.push(now, None, F::not_ours(error));
    }
}

impl<const N: usize, F: Family> Master<N, F> {
    fn set_point_frame(&self) -> Option<Outgoing<F>> {
        let index = self.due.trailing_zeros();
        let (frame, step) = self.axes.get(index as usize)?.set_point();
        Some(Outgoing {
            frame,
            axis: Some(index as u8),
            purpose: Purpose::SetPoint(step),
        })
    }

    fn cycle_frame(&self) -> Option<Outgoing<F>> {
        let frame = F::cycle_frame(&self.config)?;
        self.cycle_frame_due.then_some(Outgoing {
            frame,
            axis: None,
            purpose: Purpose::Cycle,
        })
    }

    fn switch_frame(&self, state: AxisState, switch: Switch) -> Option<Outgoing<F>> {
        if !self.may_switch {
            return None;
        }
        let index = self.axes.iter().position(|axis| axis.state() == state)?;
        Some(Outgoing {
            frame: self.axes.get(index)?.switch_frame(switch)?,
            axis: Some(index as u8),
            purpose: Purpose::Switch(switch),
        })
    }

    /// A request whose place is before set-points that are still to come.
    fn placed_request_frame(&self) -> Option<Outgoing<F>> {
        let is_its_turn = self.due != 0 && self.placement.is_reached(self.due);
        is_its_turn.then(|| self.request_frame())?
    }

    fn request_frame(&self) -> Option<Outgoing<F>> {
        let (index, request) = self.request?;
        Some(Outgoing {
            frame: self.axes.get(usize::from(index))?.request_frame(request)?,
            axis: Some(index),
            purpose: Purpose::Request(request),
        })
    }
}
