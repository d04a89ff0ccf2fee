//! Frames of one axis on their way in.

use dyn_can::{
    DataFrame, DecodeError, Dialect, DriveError, DynFrame, FunctionCode, Reply, ReplyKind, Revision,
};

use super::{Axis, Log};
use crate::config::{DialectChoice, MasterConfig, Timeouts};
use crate::event::EventKind;
use crate::family::{Hears, Life};
use crate::fault::Fault;
use crate::feedback::Stamped;
use crate::life::{self, AxisState, Reason, Step};
use crate::plan::ResponseWindow;
use crate::request_slot::Unawaited;
use crate::time::Instant;

/// Reads of the diagnostic counter that may be missed between two that are seen, by lost replies or repeated requests.
const COUNTER_SLACK: u8 = 8;

impl Hears for Axis {
    /// A frame of this drive came in.
    fn hear(
        &mut self,
        frame: &DataFrame,
        config: &MasterConfig,
        log: &mut Log<'_>,
    ) -> Option<Fault> {
        let function = frame.function();
        if function == FunctionCode::DriveError {
            return self.hear_error(frame, log);
        }
        match self.slot.awaited(function) {
            Ok((kind, since)) => self.take_reply(frame, kind, since, config, log),
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

    fn expect_reply(&mut self, leaves: Instant) {
        self.responses.asked(leaves);
    }

    fn response_window(&self) -> Option<ResponseWindow> {
        self.responses.window()
    }

    fn quiet_us(&mut self, fault: Fault, config: &MasterConfig) -> Option<u32> {
        // A drive that alarms for ever must not keep the requests to the others quiet for ever: only its first alarm counts.
        let is_first =
            fault == Fault::AlarmFrame && !core::mem::replace(&mut self.alarm_heard, true);
        is_first.then_some(config.timeouts.alarm_quiet_us)
    }

    /// The bus failed: a reply that is still awaited may come late, or never.
    fn abandon_request(&mut self, now: Instant, config: &MasterConfig) {
        self.slot.close(now, config.timeouts.reply_us);
    }
}

impl Axis {
    fn sends_no_reply(&self, function: FunctionCode) -> bool {
        function.admit_reply(self.dialect.revision).is_err()
    }

    fn hear_error(&mut self, frame: &DataFrame, log: &mut Log<'_>) -> Option<Fault> {
        match Reply::decode(frame, None, &self.dialect) {
            Ok((_, Reply::DriveError(DriveError::Alarm))) => Some(Fault::AlarmFrame),
            Ok((_, Reply::DriveError(DriveError::DataError))) => {
                (!self.procedure_refused(log)).then_some(Fault::DataError)
            }
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
        asked_at: Instant,
        config: &MasterConfig,
        log: &mut Log<'_>,
    ) -> Option<Fault> {
        self.slot.close(log.now, config.timeouts.settle_us);
        let counter_before = self.feedback.counter;
        match self.decode_reply(frame, kind, log) {
            Ok(reply) => {
                self.counters.replies = self.counters.replies.wrapping_add(1);
                self.timeouts_in_row = 0;
                self.responses
                    .replied(log.now, config.bus.usual_us(frame.len()));
                self.feedback.note(log.now, reply);
                self.note_standstill(reply, log.now);
                self.procedure_replied(kind, reply, log);
                self.suspect(reply, counter_before, asked_at, config, log.now)
                    .or_else(|| self.follow(kind, &config.timeouts, log))
            }
            Err(error) => {
                self.counters.bad_replies = self.counters.bad_replies.wrapping_add(1);
                log.push(EventKind::BadReply(error));
                self.procedure_missed(kind, log);
                if self.state == AxisState::Identifying && self.feedback.revision.is_some() {
                    // The length has told the revision; what the parameters are does not matter for motion.
                    self.enter(AxisState::CheckingConfig, Reason::Reading, log);
                    return None;
                }
                self.miss_reply(&config.timeouts)
            }
        }
    }

    fn decode_reply(
        &mut self,
        frame: &DataFrame,
        kind: ReplyKind,
        log: &mut Log<'_>,
    ) -> Result<Reply, DecodeError> {
        if kind == ReplyKind::ParamGroup3 && self.state == AxisState::Identifying {
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
        if self.config.dialect == DialectChoice::Detect {
            let Some(revision) = Revision::from_group3_reply_len(usize::from(frame.len())) else {
                return;
            };
            self.dialect = Dialect::of(revision);
        }
        self.feedback.revision = Some(self.dialect.revision);
        log.push(EventKind::Revision(self.dialect.revision));
    }

    /// Since when the speed readings are zero without a break.
    fn note_standstill(&mut self, reply: Reply, now: Instant) {
        if let Reply::MotorSpeed(speed_rpm) = reply {
            self.still_since = (speed_rpm == 0).then(|| self.still_since.unwrap_or(now));
        }
    }

    /// What a reading says against the books.
    fn suspect(
        &mut self,
        reply: Reply,
        counter_before: Option<Stamped<u8>>,
        asked_at: Instant,
        config: &MasterConfig,
        now: Instant,
    ) -> Option<Fault> {
        match reply {
            Reply::DiagnosticCounter(actual) => {
                let expected = counter_before?.value.wrapping_add(1);
                let restarted = actual.wrapping_sub(expected) >= COUNTER_SLACK;
                restarted.then_some(Fault::Reboot { expected, actual })
            }
            Reply::Position(read_back) if self.referenced && self.state.is_enabled() => {
                let position = self.config.read_back.to_command_counts(read_back)?;
                let asked_cycles = now
                    .us_since(asked_at)
                    .div_ceil(u64::from(config.cycle_us.max(1)))
                    + 1;
                let arrival_us = config.timeouts.arrival_us;
                let (sent, limits) = (self.books.sent_counts(), &self.config.limits);
                self.drift
                    .judge(position, sent, asked_cycles, now, limits, arrival_us)
            }
            _ => None,
        }
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
        self.drift.anchor(counts, log.now);
        self.referenced = true;
        self.enter(next, Reason::Reading, log);
        None
    }
}
