//! Frames of one servo on their way in, and what they mean.

use bus_user::Instant;
use dyn_can::{
    CommandMode, ConfigByte, DataFrame, DecodeError, Dialect, DriveError, DriveStatus, DynFrame,
    FunctionCode, ParamGroup3, Reply, ReplyKind, Revision, ServoMode,
};

use crate::core::facts::Motion;
use crate::core::family::{Context, Meaning, PowerReport, View};
use crate::core::stamp::Stamp;
use crate::core::state::Stage;
use crate::servo::drive::Servo;
use crate::servo::dyn_family::Dyn;
use crate::servo::event::{EventKind, Log};
use crate::servo::fault::Fault;
use crate::servo::frames::stage_reading;
use crate::servo::own_move::OwnMove;
use crate::servo::procedure::Run;
use crate::servo::request_slot::Unawaited;

/// Reads of the diagnostic counter that may be missed between two that are seen, by lost replies or repeated requests.
const COUNTER_SLACK: u8 = 8;

impl Servo {
    /// A frame of this drive came in.
    pub(super) fn read(
        &mut self,
        frame: &DataFrame,
        context: &mut Context<'_, Dyn>,
    ) -> Meaning<Fault> {
        let function = frame.function();
        if function == FunctionCode::DriveError {
            return self.read_error(frame, context);
        }
        match self.slot.awaited(function) {
            Ok((kind, deadline)) => {
                let waits_us = context.config.timeouts.reply_us;
                let asked_at = deadline.before(waits_us).at(context.log.now);
                self.read_reply(frame, kind, asked_at, context)
            }
            Err(Unawaited::Late) => {
                self.counters.late_replies = self.counters.late_replies.wrapping_add(1);
                context.log.push(EventKind::LateReply(function));
                Meaning::NONE
            }
            // An empty frame after a set command may be an acknowledgement (D40).
            Err(Unawaited::Stray) if frame.len() == 0 && self.sends_no_reply(function) => {
                Meaning::NONE
            }
            Err(Unawaited::Stray) => {
                self.counters.stray_replies = self.counters.stray_replies.wrapping_add(1);
                context.log.push(EventKind::StrayReply(function));
                Meaning::NONE
            }
        }
    }

    fn sends_no_reply(&self, function: FunctionCode) -> bool {
        function.admit_reply(self.dialect.revision).is_err()
    }

    /// A Drive_Error. One that says nothing that a document lists is taken for an alarm.
    fn read_error(&mut self, frame: &DataFrame, context: &mut Context<'_, Dyn>) -> Meaning<Fault> {
        match Reply::decode(frame, None, &self.dialect) {
            Ok((_, Reply::DriveError(DriveError::Alarm))) => {
                let fault = self.first_alarm(Fault::AlarmFrame);
                // A drive that alarms for ever must not keep the requests to the others quiet for ever.
                let quiet_us = fault.map(|_| context.config.timeouts.alarm_quiet_us);
                Meaning {
                    fault,
                    quiet_us,
                    ..Meaning::NONE
                }
            }
            Ok((_, Reply::DriveError(DriveError::DataError))) => {
                if self.procedure_refused(&mut context.log) {
                    return Meaning {
                        work_ended: true,
                        ..Meaning::NONE
                    };
                }
                Meaning::fault(Fault::DataError)
            }
            Ok((_, Reply::DriveError(DriveError::Unknown(byte)))) => {
                Meaning::fault(Fault::UnknownError { byte: Some(byte) })
            }
            Ok(_) | Err(_) => Meaning::fault(Fault::UnknownError {
                byte: frame.data().first().copied(),
            }),
        }
    }

    /// A drive that has an alarm reports it again and again; it is one fault until its checks begin anew.
    fn first_alarm(&mut self, fault: Fault) -> Option<Fault> {
        let is_first = !core::mem::replace(&mut self.has_alarmed, true);
        is_first.then_some(fault)
    }

    fn read_reply(
        &mut self,
        frame: &DataFrame,
        kind: ReplyKind,
        asked_at: Instant,
        context: &mut Context<'_, Dyn>,
    ) -> Meaning<Fault> {
        let (now, timeouts) = (context.log.now, &context.config.timeouts);
        self.slot.close(now, timeouts.settle_us);
        match self.decode_reply(frame, kind, context) {
            Ok(reply) => {
                self.counters.replies = self.counters.replies.wrapping_add(1);
                self.timeouts_in_row = 0;
                let usual_us = context.config.bus.usual_us(frame.len());
                self.responses.replied(now, usual_us);
                let suspicion = self.suspect(reply, context);
                self.feedback.note(now, reply);
                if let Reply::ParamGroup2(group) = reply {
                    self.procedures.note_curve(Some(group));
                }
                let work_ended = self.procedure_replied(kind, reply, &mut context.log);
                let mut meaning = self.meaning(kind, reply, asked_at, context);
                meaning.fault = suspicion.or(meaning.fault);
                self.judge_own(reply, asked_at, context, &mut meaning);
                meaning.work_ended = work_ended;
                meaning
            }
            Err(error) => {
                self.counters.bad_replies = self.counters.bad_replies.wrapping_add(1);
                context.log.push(EventKind::BadReply(error));
                let work_ended = self.procedure_missed(kind, &mut context.log);
                let is_gear = kind == ReplyKind::ParamGroup3 && is_asked(context.view, kind);
                let fault = if is_gear && self.feedback.revision.is_some() {
                    Some(self.gear_fault(None))
                } else {
                    self.miss_reply(timeouts.lost_after, context.view)
                };
                Meaning {
                    fault,
                    work_ended,
                    ..Meaning::NONE
                }
            }
        }
    }

    fn decode_reply(
        &mut self,
        frame: &DataFrame,
        kind: ReplyKind,
        context: &mut Context<'_, Dyn>,
    ) -> Result<Reply, DecodeError> {
        if kind == ReplyKind::ParamGroup3 && is_asked(context.view, kind) {
            self.recognise_revision(frame, &mut context.log);
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
        if self.config.detects_dialect {
            let Some(revision) = Revision::from_group3_reply_len(usize::from(frame.len())) else {
                return;
            };
            self.dialect = Dialect::of(revision);
        }
        self.feedback.revision = Some(self.dialect.revision);
        log.push(EventKind::Revision(self.dialect.revision));
    }

    /// What a reading says against the ledger.
    fn suspect(&mut self, reply: Reply, context: &Context<'_, Dyn>) -> Option<Fault> {
        match reply {
            Reply::DiagnosticCounter(actual) => {
                let expected = self.feedback.counter()?.wrapping_add(1);
                let restarted = actual.wrapping_sub(expected) >= COUNTER_SLACK;
                restarted.then_some(Fault::Reboot { expected, actual })
            }
            // A motion of the drive itself is judged for itself.
            Reply::Position(_) if context.view.facts.motion == Motion::DriveMove => None,
            Reply::Position(read_back) if context.view.facts.holds_anchor() => {
                let position = self.config.read_back.to_command_counts(read_back)?;
                let arrival_us = context.config.timeouts.arrival_us;
                let (now, limits) = (context.log.now, &self.config.limits);
                self.drift.judge(position, now, limits, arrival_us)
            }
            _ => None,
        }
    }

    /// What a reading means to the life of the axis.
    fn meaning(
        &mut self,
        kind: ReplyKind,
        reply: Reply,
        asked_at: Instant,
        context: &Context<'_, Dyn>,
    ) -> Meaning<Fault> {
        let is_asked = is_asked(context.view, kind);
        let to = |stage| Meaning {
            stage: is_asked.then_some(stage),
            ..Meaning::NONE
        };
        match reply {
            Reply::Echo(_) => to(Stage::Identifying),
            Reply::ParamGroup3(group) => match self.judge_group3(group) {
                Some(fault) if is_asked => Meaning::fault(fault),
                _ => to(Stage::CheckingConfig),
            },
            // In another mode for a while, and on its way back.
            Reply::DriveConfig(_) if self.may_be_in_other_mode() => Meaning::NONE,
            Reply::DriveConfig(byte) => {
                self.guarded_at = Stamp::of(context.log.now);
                match judge_config(byte) {
                    Some(fault) => Meaning::fault(fault),
                    None => to(Stage::CheckingStatus),
                }
            }
            Reply::DriveStatus(status) => Meaning {
                stage: (is_asked && !status.motion_busy()).then_some(Stage::Locating),
                ..self.status_meaning(status, asked_at)
            },
            Reply::Position(_) => match self.located() {
                Err(fault) if is_asked => Meaning::fault(fault),
                located => Meaning {
                    is_checked: is_asked && located.is_ok(),
                    is_located: true,
                    ..Meaning::NONE
                },
            },
            Reply::MotorSpeed(speed_rpm) => Meaning {
                stands: self.stands(speed_rpm, context),
                ..Meaning::NONE
            },
            _ => Meaning::NONE,
        }
    }

    fn status_meaning(&mut self, status: DriveStatus, asked_at: Instant) -> Meaning<Fault> {
        let alarm = status.alarm();
        let fault = match alarm.is_alarm() {
            true => self.first_alarm(Fault::AlarmStatus(alarm)),
            false => None,
        };
        Meaning {
            fault,
            power: Some(PowerReport {
                is_on: !status.is_disabled(),
                asked_at,
            }),
            ..Meaning::NONE
        }
    }

    /// Whether the shaft has stood still long enough; `None` while it is too early to say.
    fn stands(&mut self, speed_rpm: i16, context: &Context<'_, Dyn>) -> Option<bool> {
        let now = context.log.now;
        if speed_rpm != 0 {
            self.is_still = false;
            return Some(false);
        }
        if !core::mem::replace(&mut self.is_still, true) {
            self.still_since = Stamp::of(now);
        }
        // What was read before the application asked for power does not count (D59).
        let standstill_us = context.config.timeouts.standstill_us;
        let counts = self.still_since.has_lasted(now, standstill_us)
            && context.view.has_lasted(now, standstill_us);
        counts.then_some(true)
    }

    fn may_be_in_other_mode(&self) -> bool {
        let is_speed = self.procedures.own().is_some_and(OwnMove::is_speed);
        is_speed || self.procedures.run().is_some_and(Run::is_way_back)
    }

    fn judge_group3(&self, group: ParamGroup3) -> Option<Fault> {
        let actual = group.gear_number;
        if actual != self.config.gear {
            return Some(self.gear_fault(Some(actual.get())));
        }
        let has_brake = group.on_pos_range.enables_brake_output();
        (self.config.load_can_fall && !has_brake).then_some(Fault::NoBrake)
    }

    const fn gear_fault(&self, actual: Option<u16>) -> Fault {
        Fault::Gear {
            expected: self.config.gear.get(),
            actual,
        }
    }

    /// The position that was read last, in command counts.
    #[inline(always)]
    pub(super) fn located(&self) -> Result<i32, Fault> {
        let read_back = self.feedback.position().unwrap_or(0);
        let travel = &self.config.limits.travel;
        self.config
            .read_back
            .to_command_counts(read_back)
            .filter(|counts| (travel.min_counts..=travel.max_counts).contains(counts))
            .ok_or(Fault::PositionRange { read_back })
    }

    /// Waiting times of requests that are over.
    pub(super) fn expire(&mut self, context: &mut Context<'_, Dyn>) -> Meaning<Fault> {
        let (now, timeouts) = (context.log.now, &context.config.timeouts);
        let Some(kind) = self.slot.expire(now, timeouts.reply_us) else {
            return Meaning::NONE;
        };
        self.counters.timeouts = self.counters.timeouts.wrapping_add(1);
        // A drive that is lost was reported once.
        if !context.view.is_lost {
            context.log.push(EventKind::ReplyTimeout(kind));
        }
        Meaning {
            work_ended: self.procedure_missed(kind, &mut context.log),
            fault: self.miss_reply(timeouts.lost_after, context.view),
            ..Meaning::NONE
        }
    }

    fn miss_reply(&mut self, lost_after: u8, view: &View) -> Option<Fault> {
        self.timeouts_in_row = self.timeouts_in_row.saturating_add(1);
        (self.timeouts_in_row >= lost_after && !view.is_lost).then_some(Fault::Lost)
    }
}

/// Whether the checks wait for this reading.
#[inline(always)]
fn is_asked(view: &View, kind: ReplyKind) -> bool {
    view.facts.is_checking() && stage_reading(view.stage) == Some(kind)
}

/// Only command mode 0 and position mode take set-points (D45).
fn judge_config(byte: ConfigByte) -> Option<Fault> {
    match byte.config() {
        Ok(config)
            if config.command_mode == CommandMode::Rs232
                && config.servo_mode == ServoMode::Position =>
        {
            None
        }
        _ => Some(Fault::Config(byte)),
    }
}
