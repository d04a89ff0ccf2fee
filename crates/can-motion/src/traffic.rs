//! The master on the bus: which frame goes out next, and what the outcome of each means to the books.

use dyn_can::{Address, DataFrame, FrameError, Request, ServoSwitch};

use crate::bus_user::BusUser;
use crate::event::{BusErrorKind, EventKind};
use crate::fault::Fault;
use crate::life::AxisState;
use crate::master::Master;
use crate::outgoing::{Outgoing, Purpose};
use crate::time::Instant;

impl<const N: usize> BusUser for Master<N> {
    type Outgoing = Outgoing;

    /// The frame that should go out next; asking changes nothing.
    ///
    /// Disable commands first, then the set-points of this cycle in ascending order of drive id, then enable
    /// commands, then requests within their budget.
    fn next_frame(&self) -> Option<Outgoing> {
        if self.bus_off {
            return None;
        }
        self.switch_frame(AxisState::Disabling, ServoSwitch::Disable)
            .or_else(|| self.set_point_frame())
            .or_else(|| self.switch_frame(AxisState::Enabling, ServoSwitch::Enable))
            .or_else(|| self.request_frame())
    }

    fn on_accepted(&mut self, now: Instant, outgoing: &Outgoing) {
        let (index, cycle) = (usize::from(outgoing.axis), self.cycle.cycles);
        let reply_us = self.config.timeouts.reply_us;
        let Some((axis, mut log)) = self.axis_and_log(now, index) else {
            return;
        };
        match outgoing.purpose {
            Purpose::SetPoint(step) => {
                axis.stepped(step, now);
                self.due &= !(1 << index);
            }
            Purpose::Switch(switch) => axis.switched(switch, &mut log),
            Purpose::Request(request) => {
                axis.requested(request, cycle, reply_us, &mut log);
                self.requests_left = self.requests_left.saturating_sub(1);
                self.turn = (index as u8).wrapping_add(1);
                self.choose_request(now);
            }
        }
    }

    fn on_displaced(&mut self, now: Instant, frame: &DataFrame) {
        let cycle = self.cycle.cycles;
        let Some(index) = self.index_of(frame.address()) else {
            self.events
                .push(now, None, EventKind::ForeignFrame { id: frame.id() });
            return;
        };
        let Some((axis, mut log)) = self.axis_and_log(now, index) else {
            return;
        };
        axis.displaced(frame, cycle, &mut log);
        if axis.state.sends_set_points() && axis.books.backlog_counts() != 0 {
            self.due |= 1 << index;
        }
    }

    fn on_transmit_error(&mut self, now: Instant, outgoing: &Outgoing, kind: BusErrorKind) {
        self.events
            .push(now, Some(outgoing.axis), EventKind::BusError(kind));
        match outgoing.purpose {
            Purpose::SetPoint(_) => self.raise(now, usize::from(outgoing.axis), Fault::Bus),
            // A request that may be under way must not be asked again before its timeout; a command is repeated.
            Purpose::Request(_) => self.on_accepted(now, outgoing),
            Purpose::Switch(_) => {}
        }
    }

    fn on_receive_error(&mut self, now: Instant, kind: BusErrorKind) {
        self.events.push(now, None, EventKind::BusError(kind));
    }

    fn on_frame(&mut self, now: Instant, frame: &DataFrame) {
        let config = self.config;
        let Some(index) = self.index_of(frame.address()) else {
            self.events
                .push(now, None, EventKind::ForeignFrame { id: frame.id() });
            return;
        };
        let Some((axis, mut log)) = self.axis_and_log(now, index) else {
            return;
        };
        if let Some(fault) = axis.hear(frame, &config, &mut log) {
            if fault == Fault::AlarmFrame && axis.is_first_alarm() {
                self.quiet_until = now + config.timeouts.alarm_quiet_us;
                self.request = None;
            }
            self.raise(now, index, fault);
        }
    }

    fn on_foreign_frame(&mut self, now: Instant, error: FrameError) {
        self.events.push(now, None, EventKind::NotOurs(error));
    }
}

impl<const N: usize> Master<N> {
    fn set_point_frame(&self) -> Option<Outgoing> {
        let index = self.due.trailing_zeros();
        let (frame, step) = self.axes.get(index as usize)?.set_point();
        Some(Outgoing {
            frame,
            axis: index as u8,
            purpose: Purpose::SetPoint(step),
        })
    }

    fn switch_frame(&self, state: AxisState, switch: ServoSwitch) -> Option<Outgoing> {
        let index = self.axes.iter().position(|axis| axis.state == state)?;
        let axis = self.axes.get(index)?;
        let request = Request::ServoDisable(switch);
        let frame = request
            .encode(Address::Drive(axis.config.drive), axis.dialect())
            .ok()?;
        Some(Outgoing {
            frame,
            axis: index as u8,
            purpose: Purpose::Switch(switch),
        })
    }

    fn request_frame(&self) -> Option<Outgoing> {
        let (index, request) = self.request?;
        let place = self.axes.get(usize::from(index));
        let axis = place.filter(|axis| axis.slot.is_free())?;
        let address = Address::Drive(axis.config.drive);
        // Procedures were checked against the revision when they started, and readings exist in both.
        let frame = request.encode(address, axis.dialect()).ok()?;
        Some(Outgoing {
            frame,
            axis: index,
            purpose: Purpose::Request(request),
        })
    }
}
