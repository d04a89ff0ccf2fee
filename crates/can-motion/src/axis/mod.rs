//! One axis: its state, its books, and the one request that its drive may owe.

mod hear;
mod procedures;
mod send;

use dyn_can::Dialect;

use crate::config::{AxisConfig, GroupId, MasterConfig, Timeouts};
use crate::drift::DriftWatch;
use crate::dyn_axes::Dyn;
use crate::event::EventKind;
use crate::family::{self, Happening, Life};
use crate::fault::{Fault, Reaction};
use crate::feedback::Feedback;
use crate::life::{AxisState, Reason};
use crate::polls::PollClock;
use crate::procedure::Run;
use crate::ramp::{Ramp, cycles_to_stop};
use crate::request_slot::RequestSlot;
use crate::response_watch::ResponseWatch;
use crate::set_point::SetPoint;
use crate::snapshot::{AxisSnapshot, Counters};
use crate::time::Instant;

/// Where an axis writes its events.
pub(crate) type Log<'a> = family::Log<'a, EventKind>;

/// An axis with a DYN drive.
#[derive(Debug)]
pub struct Axis {
    pub(crate) config: AxisConfig,
    pub(crate) state: AxisState,
    pub(crate) fault: Option<Fault>,
    pub(crate) books: SetPoint,
    pub(crate) slot: RequestSlot,
    pub(crate) polls: PollClock,
    pub(crate) counters: Counters,
    dialect: Dialect,
    since: Instant,
    /// The position is known: nothing has happened since the anchor that could have moved it unnoticed.
    referenced: bool,
    /// An enable command went out, and no disable command since.
    may_be_enabled: bool,
    /// The fault found the axis enabled and confirmed, so that it can hold when the fault is cleared.
    held: bool,
    ramp: Option<Ramp>,
    disable_after_ramp: bool,
    /// An alarm frame came since the last `clear`.
    alarm_heard: bool,
    feedback: Feedback,
    drift: DriftWatch,
    responses: ResponseWatch,
    timeouts_in_row: u8,
    still_since: Option<Instant>,
    /// Differs from one echo request to the next, so that a late echo is not taken for the next one.
    echo_token: u8,
    run: Option<Run>,
    wrote_at: Option<Instant>,
}

impl Axis {
    pub(crate) fn new(config: AxisConfig, master: &MasterConfig, rank: u32) -> Self {
        Self {
            config,
            state: AxisState::PowerOn,
            fault: None,
            books: SetPoint::default(),
            slot: RequestSlot::default(),
            polls: PollClock::new(&config.polls, master.cycle_us, rank),
            counters: Counters::default(),
            dialect: config.initial_dialect(),
            since: Instant::default(),
            referenced: false,
            may_be_enabled: false,
            held: false,
            ramp: None,
            disable_after_ramp: false,
            alarm_heard: false,
            feedback: Feedback::default(),
            drift: DriftWatch::new(),
            responses: ResponseWatch::default(),
            timeouts_in_row: 0,
            still_since: None,
            echo_token: 0,
            run: None,
            wrote_at: None,
        }
    }

    /// The drive does not answer; asking it costs the others their turns.
    pub(crate) fn is_lost(&self) -> bool {
        self.fault == Some(Fault::Lost)
    }

    fn backlog_fault(&self) -> Option<Fault> {
        let counts = self.books.backlog_counts();
        (counts.unsigned_abs() > self.config.limits.backlog).then_some(Fault::Backlog { counts })
    }

    fn miss_reply(&mut self, timeouts: &Timeouts) -> Option<Fault> {
        self.timeouts_in_row = self.timeouts_in_row.saturating_add(1);
        if self.timeouts_in_row < timeouts.lost_after || self.fault == Some(Fault::Lost) {
            return None;
        }
        self.timeouts_in_row = 0;
        Some(Fault::Lost)
    }

    /// Moves the target along the ramp; at its end the axis holds or is disabled.
    fn advance_ramp(&mut self, log: &mut Log<'_>) {
        let Some(ramp) = &mut self.ramp else { return };
        if !ramp.is_done() {
            self.books.set_target(ramp.next_target());
        } else if self.books.backlog_counts() == 0 {
            self.ramp = None;
            let next = if self.disable_after_ramp {
                AxisState::Disabling
            } else {
                AxisState::Holding
            };
            self.enter(next, Reason::Standstill, log);
        }
    }
}

impl Life for Axis {
    type Family = Dyn;

    fn group(&self) -> GroupId {
        self.config.group
    }

    fn state(&self) -> AxisState {
        self.state
    }

    fn fault(&self) -> Option<Fault> {
        self.fault
    }

    fn may_be_enabled(&self) -> bool {
        self.may_be_enabled
    }

    fn reaction_to(&self, fault: Fault) -> Reaction {
        self.config.reactions.to(fault)
    }

    fn cycles_to_stop(&self) -> u16 {
        cycles_to_stop(
            i32::from(self.books.velocity_counts()),
            u32::from(self.config.limits.ramp_change),
        )
    }

    fn snapshot(&self) -> AxisSnapshot {
        AxisSnapshot {
            drive: self.config.drive,
            group: self.config.group,
            state: self.state,
            fault: self.fault,
            referenced: self.referenced,
            target_counts: self.books.target_counts(),
            sent_counts: self.books.sent_counts(),
            backlog_counts: self.books.backlog_counts(),
            feedback: self.feedback,
            response: self.responses.window(),
            counters: self.counters,
        }
    }

    /// Lets time pass.
    fn tick(&mut self, config: &MasterConfig, log: &mut Log<'_>) -> Option<Fault> {
        let timeouts = &config.timeouts;
        self.advance_ramp(log);
        self.drift.cycle(self.books.sent_counts());
        if let Some(run) = &mut self.run {
            run.tick(log.now);
        }
        if let Some(kind) = self.slot.expire(log.now, timeouts.reply_us) {
            log.push(EventKind::ReplyTimeout(kind));
            self.procedure_missed(kind, log);
            self.counters.timeouts = self.counters.timeouts.wrapping_add(1);
            if let Some(fault) = self.miss_reply(timeouts) {
                return Some(fault);
            }
        }
        let elapsed_us = log.now.us_since(self.since);
        let over = |limit_us: u32| elapsed_us >= u64::from(limit_us);
        match self.state {
            AxisState::PowerOn if over(timeouts.power_on_us) => {
                self.enter(AxisState::Probing, Reason::Elapsed, log);
                None
            }
            AxisState::AwaitingStandstill if over(timeouts.standstill_limit_us) => {
                Some(Fault::ConfirmTimeout)
            }
            AxisState::ConfirmingEnable if over(timeouts.confirm_us) => Some(Fault::ConfirmTimeout),
            AxisState::ConfirmingDisable if over(timeouts.confirm_us) => {
                // The command went out; a drive that does not say so is not asked for ever.
                self.enter(AxisState::Faulted, Reason::Elapsed, log);
                Some(Fault::ConfirmTimeout)
            }
            state if state.sends_set_points() => self.backlog_fault(),
            _ => None,
        }
    }

    fn enter(&mut self, to: AxisState, reason: Reason, log: &mut Log<'_>) {
        // A stop that ends while a fault is latched, or without a known position, does not end in readiness.
        let to = match to {
            AxisState::Ready | AxisState::Holding if self.fault.is_some() => AxisState::Faulted,
            AxisState::Ready if !self.referenced => AxisState::Anchoring,
            other => other,
        };
        log.push(Happening::State {
            from: self.state,
            to,
            reason,
        });
        self.state = to;
        self.since = log.now;
        match to {
            // Nothing read before is believed of a drive that may have been exchanged or restarted.
            AxisState::Probing => self.feedback = Feedback::default(),
            AxisState::AwaitingStandstill => self.still_since = None,
            // Only a status read from now on may confirm.
            AxisState::ConfirmingEnable | AxisState::ConfirmingDisable => {
                self.feedback.status = None;
            }
            _ => {}
        }
    }

    fn start_ramp(&mut self, cycles: u16, then_disable: bool, reason: Reason, log: &mut Log<'_>) {
        let velocity = i32::from(self.books.velocity_counts());
        self.books.drop_backlog();
        self.ramp = Some(Ramp::new(self.books.sent_counts(), velocity, cycles));
        self.disable_after_ramp = then_disable;
        self.enter(AxisState::RampingDown, reason, log);
    }

    fn disable_after_ramp(&mut self) {
        self.disable_after_ramp = true;
    }

    /// No further set-point; what is owed is forgotten.
    fn halt(&mut self, to: AxisState, reason: Reason, log: &mut Log<'_>) {
        self.books.drop_backlog();
        self.ramp = None;
        self.held = self.state.is_enabled();
        self.enter(to, reason, log);
    }

    /// Notes a fault; the first one of its own stays.
    fn latch(&mut self, fault: Fault, log: &mut Log<'_>) {
        log.push(Happening::Fault(fault));
        self.procedure_aborted(log);
        if self.fault.is_none_or(|latched| latched == Fault::Group) {
            self.fault = Some(fault);
        }
        if fault.loses_reference() {
            self.referenced = false;
        }
    }

    /// The application has seen the fault.
    fn clear(&mut self, log: &mut Log<'_>) {
        let Some(fault) = self.fault.take() else {
            return;
        };
        self.timeouts_in_row = 0;
        self.alarm_heard = false;
        let next = if fault != Fault::Group || !self.referenced {
            self.referenced = false;
            AxisState::Probing
        } else if self.held {
            AxisState::Holding
        } else {
            AxisState::Ready
        };
        self.enter(next, Reason::Command, log);
    }
}
