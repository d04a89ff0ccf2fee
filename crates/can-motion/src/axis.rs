//! One axis: its state, its books, and the one request that its drive may owe.

use dyn_can::{
    DataFrame, DecodeError, Dialect, DriveError, FunctionCode, PdStep, Reply, ReplyKind, Request,
    Revision, ServoSwitch, go_relative_pos_pd,
};

use crate::config::{AxisConfig, DialectChoice, MasterConfig, Timeouts};
use crate::event::{EventKind, Events};
use crate::fault::Fault;
use crate::feedback::{Feedback, Stamped};
use crate::life::{self, AxisState, Reason, Step};
use crate::polls::{PollClock, PollKind};
use crate::ramp::Ramp;
use crate::request_slot::{RequestSlot, Unawaited};
use crate::set_point::SetPoint;
use crate::snapshot::{AxisSnapshot, Counters};
use crate::time::Instant;

/// Where an axis writes its events.
pub(crate) struct Log<'a> {
    pub(crate) events: &'a mut Events,
    pub(crate) now: Instant,
    pub(crate) axis: u8,
}

impl Log<'_> {
    pub(crate) fn push(&mut self, kind: EventKind) {
        self.events.push(self.now, Some(self.axis), kind);
    }
}

#[derive(Debug)]
pub(crate) struct Axis {
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
    feedback: Feedback,
    timeouts_in_row: u8,
    still_since: Option<Instant>,
    /// Differs from one echo request to the next, so that a late echo is not taken for the next one.
    echo_token: u8,
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
            feedback: Feedback::default(),
            timeouts_in_row: 0,
            still_since: None,
            echo_token: 0,
        }
    }

    pub(crate) const fn dialect(&self) -> &Dialect {
        &self.dialect
    }

    pub(crate) const fn may_be_enabled(&self) -> bool {
        self.may_be_enabled
    }

    pub(crate) fn snapshot(&self) -> AxisSnapshot {
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
            counters: self.counters,
        }
    }

    pub(crate) fn enter(&mut self, to: AxisState, reason: Reason, log: &mut Log<'_>) {
        // A stop that ends while a fault is latched, or without a known position, does not end in readiness.
        let to = match to {
            AxisState::Ready | AxisState::Holding if self.fault.is_some() => AxisState::Faulted,
            AxisState::Ready if !self.referenced => AxisState::Anchoring,
            other => other,
        };
        log.push(EventKind::State {
            from: self.state,
            to,
            reason,
        });
        self.state = to;
        self.since = log.now;
        match to {
            AxisState::AwaitingStandstill => self.still_since = None,
            // Only a status read from now on may confirm.
            AxisState::ConfirmingEnable | AxisState::ConfirmingDisable => {
                self.feedback.status = None;
            }
            _ => {}
        }
    }

    /// Lets time pass.
    pub(crate) fn tick(&mut self, timeouts: &Timeouts, log: &mut Log<'_>) -> Option<Fault> {
        if let Some(kind) = self.slot.expire(log.now, timeouts.reply_us) {
            log.push(EventKind::ReplyTimeout(kind));
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
                Some(Fault::EnableTimeout)
            }
            AxisState::ConfirmingEnable | AxisState::ConfirmingDisable
                if over(timeouts.confirm_us) =>
            {
                Some(Fault::EnableTimeout)
            }
            state if state.sends_set_points() => self.backlog_fault(),
            _ => None,
        }
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
    pub(crate) fn advance_ramp(&mut self, log: &mut Log<'_>) {
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

    pub(crate) fn disable_after_ramp(&mut self) {
        self.disable_after_ramp = true;
    }

    pub(crate) fn start_ramp(
        &mut self,
        cycles: u16,
        then_disable: bool,
        reason: Reason,
        log: &mut Log<'_>,
    ) {
        let velocity = self.books.velocity_counts();
        self.books.drop_backlog();
        self.ramp = Some(Ramp::new(self.books.sent_counts(), velocity, cycles));
        self.disable_after_ramp = then_disable;
        self.enter(AxisState::RampingDown, reason, log);
    }

    /// No further set-point; what is owed is forgotten.
    pub(crate) fn halt(&mut self, to: AxisState, reason: Reason, log: &mut Log<'_>) {
        self.books.drop_backlog();
        self.ramp = None;
        self.held = self.state.is_enabled();
        self.enter(to, reason, log);
    }

    /// Notes a fault; the first one of its own stays.
    pub(crate) fn latch(&mut self, fault: Fault, log: &mut Log<'_>) {
        log.push(EventKind::Fault(fault));
        if self.fault.is_none_or(|latched| latched == Fault::Group) {
            self.fault = Some(fault);
        }
        if fault.loses_reference() {
            self.referenced = false;
        }
    }

    /// The bus failed: a reply that is still awaited may come late, or never.
    pub(crate) fn abandon_request(&mut self, now: Instant, quarantine_us: u32) {
        self.slot.close(now, quarantine_us);
    }

    /// The application has seen the fault.
    pub(crate) fn clear(&mut self, log: &mut Log<'_>) {
        let Some(fault) = self.fault.take() else {
            return;
        };
        self.timeouts_in_row = 0;
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

    /// The reading to ask for, and for how many cycles it has been due; what a state waits for beats every poll.
    pub(crate) fn wanted_request(&self, cycle: u32) -> Option<(ReplyKind, u32)> {
        if !self.slot.is_free() {
            return None;
        }
        if let Some(kind) = self.state.wanted_reading() {
            return Some((kind, u32::MAX));
        }
        let poll = self
            .polls
            .most_overdue(cycle)
            .filter(|_| self.state.may_poll())?;
        Some((poll.kind.reply_kind(), poll.overdue))
    }

    /// The set-point of this cycle.
    pub(crate) fn set_point(&self) -> (DataFrame, PdStep) {
        let step = self.books.next_step(self.config.limits.max_step);
        (
            go_relative_pos_pd(self.config.drive, step, self.dialect.number_order),
            step,
        )
    }

    /// The request that asks for a reading.
    pub(crate) fn request(&self, kind: ReplyKind) -> Request {
        use dyn_can::ReadSelector::{Position, Torque};
        match kind {
            ReplyKind::DriveId => Request::ReadDriveId,
            ReplyKind::DriveConfig => Request::ReadDriveConfig,
            ReplyKind::DriveStatus => Request::ReadDriveStatus,
            ReplyKind::Position => Request::GeneralRead(Position),
            ReplyKind::Torque => Request::GeneralRead(Torque),
            ReplyKind::ParamGroup1 => Request::ReadParamGroup1,
            ReplyKind::ParamGroup2 => Request::ReadParamGroup2,
            ReplyKind::ParamGroup3 => Request::ReadParamGroup3,
            ReplyKind::MotorSpeed => Request::ReadMotorSpeed,
            ReplyKind::DriveReset => Request::DriveReset,
            ReplyKind::Echo => Request::EchoFunction(self.echo_bytes()),
            ReplyKind::DiagnosticCounter => Request::DiagnosticCounter,
        }
    }

    const fn echo_bytes(&self) -> [u8; 4] {
        [
            self.config.drive.get(),
            self.echo_token,
            !self.echo_token,
            0x55,
        ]
    }

    /// The controller accepted the request.
    pub(crate) fn asked(&mut self, kind: ReplyKind, cycle: u32, now: Instant, reply_us: u32) {
        self.slot.ask(kind, now, reply_us);
        self.counters.requests = self.counters.requests.wrapping_add(1);
        if let Some(poll) = PollKind::of_reply(kind) {
            self.polls.asked(poll, cycle);
        }
    }

    /// The controller accepted the enable or disable command.
    pub(crate) fn switched(&mut self, switch: ServoSwitch, log: &mut Log<'_>) {
        self.may_be_enabled = switch == ServoSwitch::Enable;
        let next = match switch {
            ServoSwitch::Enable => AxisState::ConfirmingEnable,
            ServoSwitch::Disable => AxisState::ConfirmingDisable,
        };
        self.enter(next, Reason::Sent, log);
    }

    /// The controller gave a frame back unsent.
    pub(crate) fn displaced(&mut self, frame: &DataFrame, cycle: u32, log: &mut Log<'_>) {
        let Ok((_, request)) = Request::decode(frame, &self.dialect) else {
            log.push(EventKind::ForeignFrame { id: frame.id() });
            return;
        };
        self.counters.displaced = self.counters.displaced.wrapping_add(1);
        match request {
            Request::GoRelativePosPd(step) => {
                self.books.returned(step);
                if !self.state.sends_set_points() {
                    self.books.drop_backlog();
                }
                log.push(EventKind::SetPointDisplaced);
            }
            Request::ServoDisable(switch) => self.switch_displaced(switch, log),
            other => {
                if let Some(kind) = other.reply_kind() {
                    self.slot.forget();
                    if let Some(poll) = PollKind::of_reply(kind) {
                        self.polls.returned(poll, cycle);
                    }
                    log.push(EventKind::RequestDisplaced(kind));
                }
            }
        }
    }

    /// An enable command is repeated only while it is still wanted; a disable command always.
    fn switch_displaced(&mut self, switch: ServoSwitch, log: &mut Log<'_>) {
        match switch {
            ServoSwitch::Enable if self.state == AxisState::ConfirmingEnable => {
                self.enter(AxisState::Enabling, Reason::Displaced, log);
            }
            ServoSwitch::Enable => self.may_be_enabled = false,
            ServoSwitch::Disable => self.enter(AxisState::Disabling, Reason::Displaced, log),
        }
    }

    /// A frame of this drive came in.
    pub(crate) fn hear(
        &mut self,
        frame: &DataFrame,
        timeouts: &Timeouts,
        log: &mut Log<'_>,
    ) -> Option<Fault> {
        let function = frame.function();
        if function == FunctionCode::DriveError {
            return self.hear_error(frame, log);
        }
        match self.slot.awaited(function) {
            Ok((kind, _)) => self.take_reply(frame, kind, timeouts, log),
            Err(Unawaited::Late) => {
                self.counters.late_replies = self.counters.late_replies.wrapping_add(1);
                log.push(EventKind::LateReply(function));
                None
            }
            // An empty frame after a set command may be an acknowledgement (D40).
            Err(Unawaited::Stray) if frame.len() == 0 && self.sends_no_reply(function) => None,
            Err(Unawaited::Stray) => {
                self.counters.stray_replies = self.counters.stray_replies.wrapping_add(1);
                log.push(EventKind::StrayReply(function));
                None
            }
        }
    }

    fn sends_no_reply(&self, function: FunctionCode) -> bool {
        function.admit_reply(self.dialect.revision).is_err()
    }

    fn hear_error(&mut self, frame: &DataFrame, log: &mut Log<'_>) -> Option<Fault> {
        match Reply::decode(frame, None, &self.dialect) {
            Ok((_, Reply::DriveError(DriveError::Alarm))) => Some(Fault::AlarmFrame),
            Ok((_, Reply::DriveError(DriveError::DataError))) => Some(Fault::DataError),
            Ok((_, Reply::DriveError(DriveError::Unknown(byte)))) => {
                Some(Fault::UnknownError(byte))
            }
            Ok(_) => None,
            Err(error) => {
                log.push(EventKind::BadReply(error));
                None
            }
        }
    }

    fn take_reply(
        &mut self,
        frame: &DataFrame,
        kind: ReplyKind,
        timeouts: &Timeouts,
        log: &mut Log<'_>,
    ) -> Option<Fault> {
        self.slot.close(log.now, timeouts.settle_us);
        match self.decode_reply(frame, kind, log) {
            Ok(reply) => {
                self.counters.replies = self.counters.replies.wrapping_add(1);
                self.timeouts_in_row = 0;
                self.feedback.note(log.now, reply);
                self.note_standstill();
                self.follow(kind, timeouts, log)
            }
            Err(error) => {
                self.counters.bad_replies = self.counters.bad_replies.wrapping_add(1);
                log.push(EventKind::BadReply(error));
                self.miss_reply(timeouts)
            }
        }
    }

    fn decode_reply(
        &mut self,
        frame: &DataFrame,
        kind: ReplyKind,
        log: &mut Log<'_>,
    ) -> Result<Reply, DecodeError> {
        if kind == ReplyKind::ParamGroup3 {
            self.recognise_revision(frame, log);
        }
        let (_, reply) = Reply::decode(frame, Some(kind), &self.dialect)?;
        if let Reply::Echo(actual) = reply {
            let expected = self.echo_bytes();
            self.echo_token = self.echo_token.wrapping_add(1);
            if actual != expected {
                return Err(DecodeError::EchoMismatch { expected, actual });
            }
        }
        Ok(reply)
    }

    fn recognise_revision(&mut self, frame: &DataFrame, log: &mut Log<'_>) {
        if self.config.dialect == DialectChoice::Detect
            && let Some(revision) = Revision::from_group3_reply_len(usize::from(frame.len()))
        {
            self.dialect = Dialect::of(revision);
        }
        self.feedback.revision = Some(self.dialect.revision);
        log.push(EventKind::Revision(self.dialect.revision));
    }

    /// Since when the speed readings are zero without a break.
    fn note_standstill(&mut self) {
        self.still_since = match self.feedback.speed_rpm {
            Some(Stamped { value: 0, at }) => self.still_since.or(Some(at)),
            _ => None,
        };
    }

    /// Acts on a reading that has just come.
    fn follow(&mut self, kind: ReplyKind, timeouts: &Timeouts, log: &mut Log<'_>) -> Option<Fault> {
        if kind == ReplyKind::DriveStatus
            && let Some(fault) = life::status_fault(self.state, &self.feedback)
        {
            return Some(fault);
        }
        if self.state.wanted_reading() != Some(kind) {
            return None;
        }
        let standstill = self
            .still_since
            .is_some_and(|since| log.now.us_since(since) >= u64::from(timeouts.standstill_us));
        match life::after_reading(self.state, &self.feedback, standstill) {
            Step::Stay => None,
            Step::Go(next) => {
                self.enter(next, Reason::Reading, log);
                None
            }
            Step::Anchor(next) => self.anchor(next, log),
            Step::Fault(fault) => Some(fault),
        }
    }

    fn anchor(&mut self, next: AxisState, log: &mut Log<'_>) -> Option<Fault> {
        let read_back = self.feedback.position?.value;
        let limits = &self.config.limits;
        let counts = self
            .config
            .read_back
            .to_command_counts(read_back)
            .filter(|counts| (limits.travel_min..=limits.travel_max).contains(counts));
        let Some(counts) = counts else {
            return Some(Fault::PositionRange { read_back });
        };
        self.books.anchor(counts);
        self.referenced = true;
        self.enter(next, Reason::Reading, log);
        None
    }
}
