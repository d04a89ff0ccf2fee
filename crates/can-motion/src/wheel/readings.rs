//! Frames of one wheel on their way in, and what they mean.

use bus_user::Instant;
use zlac8030l::{
    DataFrame, DecodeError, Emcy, FaultCode, HeartbeatEvent, Message, NmtState, ObjectValue,
    PdoNumber, SdoEnd, SdoEvent, SdoHeard, SdoIgnored, SdoRequest, SetUpError, State, StatusWord,
};

use crate::core::facts::{Goal, Knowledge, Power, Work};
use crate::core::family::{Context, Drive, Meaning, PowerReport, View};
use crate::core::snapshot::Stamped;
use crate::core::state::Stage;
use crate::wheel::config::WheelMasterConfig;
use crate::wheel::drive::{Reset, Wheel};
use crate::wheel::event::{Log, WheelEventKind};
use crate::wheel::fault::WheelFault;
use crate::wheel::process_data;
use crate::wheel::request::{HealthReading, Purpose};
use crate::wheel::zlac_family::Zlac;

impl Wheel {
    /// A frame of this drive came in.
    pub(super) fn read(
        &mut self,
        frame: &DataFrame,
        context: &mut Context<'_, Zlac>,
    ) -> Meaning<WheelFault> {
        let meaning = match Message::decode(frame) {
            // Until the mapping is that of the set-up it may be any.
            Ok(Message::Tpdo(..)) if !self.is_set_up => return Meaning::NONE,
            Ok(Message::Tpdo(_, process_data::STATUS, _)) => self.read_status(frame, context),
            Ok(Message::Tpdo(_, process_data::POSITION, _)) => {
                let meaning = self.read_position(frame, context);
                self.judge_arrival(&mut context.log);
                meaning
            }
            Ok(Message::SdoReply(..)) => return self.read_reply(frame, context),
            Ok(Message::Heartbeat(beat)) => return self.read_heartbeat(beat.state, context),
            Ok(Message::Emcy(_, emergency)) => return read_emergency(emergency, &mut context.log),
            Ok(Message::Tpdo(_, PdoNumber::Pdo2 | PdoNumber::Pdo3, _)) => return Meaning::NONE,
            Ok(_) => {
                let event = WheelEventKind::ForeignFrame { id: frame.id() };
                context.log.push(event);
                return Meaning::NONE;
            }
            Err(error) => Err(error),
        };
        meaning.unwrap_or_else(|error| {
            context.log.push(WheelEventKind::BadFrame(error));
            // Also what is not expedited: the client has to give up on it.
            self.read_reply(frame, context)
        })
    }

    fn read_status(
        &mut self,
        frame: &DataFrame,
        context: &Context<'_, Zlac>,
    ) -> Result<Meaning<WheelFault>, DecodeError> {
        let (status, fault_code, speed_decirpm) = process_data::status(frame)?;
        let now = context.log.now;
        self.feedback.status = stamped(status, now);
        self.feedback.fault_code = stamped(fault_code, now);
        self.feedback.speed_decirpm = stamped(speed_decirpm, now);
        let view = context.view;
        let is_still = speed_decirpm.unsigned_abs() <= u32::from(self.config.limits.standstill);
        self.still_since = is_still.then(|| self.still_since.unwrap_or(now));
        let is_done = view.facts.is_checking()
            && view.stage == Stage::CheckingStatus
            && self.is_reset_and_started();
        let is_judged = view.facts.knowledge != Knowledge::Unknown || is_done;
        let fault = self
            .status_fault(status, view, context.config, now)
            .filter(|_| is_judged)
            .or_else(|| self.following_speed(speed_decirpm, view, now));
        Ok(Meaning {
            fault,
            power: power_report(status, view, now),
            stage: is_done.then_some(Stage::Locating),
            stands: self.stands(is_still, context),
            ..Meaning::NONE
        })
    }

    /// The drive was told to start its PDOs and did, and nothing is left to reset.
    fn is_reset_and_started(&self) -> bool {
        self.reset == Reset::No && !self.may_be_mapped && self.takes_frames()
    }

    /// What the status says against what the axis expects.
    fn status_fault(
        &self,
        status: StatusWord,
        view: &View,
        config: &WheelMasterConfig,
        now: Instant,
    ) -> Option<WheelFault> {
        let code = self.feedback.fault_code.map(|code| code.value);
        if let Some(code) = code.filter(|code| code.is_fault()) {
            return Some(WheelFault::Drive(code));
        }
        if status.external_emergency_stop() {
            return Some(WheelFault::EmergencyInput);
        }
        let is_on = view.facts.power == Power::On;
        // The release of a quick stop takes a moment.
        let is_settled = view.has_lasted(now, config.timeouts.confirm_us);
        let is_stopped = status.emergency_stop() && !self.quick_stop && is_settled;
        let is_unknown = status.state() == State::Undocumented;
        (is_on && (is_stopped || is_unknown)).then_some(WheelFault::NotEnabled)
    }

    /// Whether the wheel has stood still long enough; `None` while it is too early to say.
    fn stands(&self, is_still: bool, context: &Context<'_, Zlac>) -> Option<bool> {
        if !is_still {
            return Some(false);
        }
        // What was read before the application asked for power does not count.
        let since = self.still_since?.max(context.view.since(context.log.now));
        let counted_us = context.log.now.us_since(since);
        (counted_us >= u64::from(context.config.timeouts.standstill_us)).then_some(true)
    }

    fn read_position(
        &mut self,
        frame: &DataFrame,
        context: &Context<'_, Zlac>,
    ) -> Result<Meaning<WheelFault>, DecodeError> {
        let (position_counts, torque) = process_data::position(frame)?;
        let now = context.log.now;
        self.feedback.position_counts = stamped(position_counts, now);
        self.feedback.torque = stamped(torque, now);
        let view = context.view;
        let is_checked = view.facts.is_checking() && view.stage == Stage::Locating;
        let fault = match self.located() {
            Err(fault) if is_checked => Some(fault),
            _ => self.following_error(position_counts, view),
        };
        Ok(Meaning {
            fault,
            is_checked: is_checked && fault.is_none(),
            work_ended: is_checked && view.facts.work == Work::Repair,
            is_located: true,
            ..Meaning::NONE
        })
    }

    /// The position that was read last, in counts.
    pub(super) fn located(&self) -> Result<i32, WheelFault> {
        let actual = self.feedback.position_counts.map_or(0, |read| read.value);
        let values = &self.config.limits.values;
        if self.is_position() && !(values.min..=values.max).contains(&actual) {
            return Err(WheelFault::PositionRange { actual });
        }
        Ok(actual)
    }

    fn following_error(&self, position_counts: i32, view: &View) -> Option<WheelFault> {
        let follows = self.is_position() && view.facts.moves();
        let error = i64::from(position_counts) - i64::from(self.ledger.sent());
        let is_far = error.unsigned_abs() > u64::from(self.config.limits.following_error);
        let counts = error.max(i64::from(i32::MIN)).min(i64::from(i32::MAX)) as i32;
        (follows && is_far).then_some(WheelFault::FollowingError { counts })
    }

    /// A wheel in velocity mode that turns at another speed than it was told for too long, or one in torque mode that is too fast.
    ///
    /// In velocity mode no target explains a speed far above the fastest one: the drive counts another fraction of an r/min than it
    /// says, as after a write of 202Fh:05 without a restart (Z34), or something drives the wheel. That does not wait.
    fn following_speed(
        &mut self,
        actual_decirpm: i32,
        view: &View,
        now: Instant,
    ) -> Option<WheelFault> {
        let follows = !self.is_position() && view.facts.moves();
        let resolution = i32::from(self.config.speed_resolution.max(1));
        let sent_decirpm = if self.is_torque() {
            0
        } else {
            // At most ten times 1000 r/min, so that nothing overflows.
            self.ledger.sent().saturating_mul(10) / resolution
        };
        let limits = &self.config.limits;
        if follows && !self.is_torque() {
            let values = &limits.values;
            let largest = values.min.unsigned_abs().max(values.max.unsigned_abs());
            let fastest = largest.saturating_mul(15) / resolution.unsigned_abs();
            let most_decirpm = fastest.saturating_add(u32::from(limits.following_speed));
            if actual_decirpm.unsigned_abs() > most_decirpm {
                return Some(WheelFault::OverSpeed {
                    most_decirpm: i32::try_from(most_decirpm).unwrap_or(i32::MAX),
                    actual_decirpm,
                });
            }
        }
        let difference = actual_decirpm.abs_diff(sent_decirpm);
        // While it brakes a wheel in torque mode is as fast as it is.
        let brakes = self.is_torque() && self.quick_stop;
        if !follows || brakes || difference <= u32::from(limits.following_speed) {
            self.off_since = None;
            return None;
        }
        let since = *self.off_since.get_or_insert(now);
        let is_long = now.us_since(since) >= u64::from(limits.following_speed_us);
        let fault = if self.is_torque() {
            WheelFault::OverSpeed {
                most_decirpm: i32::from(limits.following_speed),
                actual_decirpm,
            }
        } else {
            WheelFault::FollowingSpeed {
                sent_decirpm,
                actual_decirpm,
            }
        };
        is_long.then_some(fault)
    }

    fn read_heartbeat(
        &mut self,
        state: NmtState,
        context: &mut Context<'_, Zlac>,
    ) -> Meaning<WheelFault> {
        let now = context.log.now;
        self.feedback.nmt = stamped(state, now);
        match self.heartbeat.on_heartbeat(now.as_us(), state) {
            None => Meaning::NONE,
            Some(HeartbeatEvent::BootUp) => self.read_boot_up(context),
            Some(HeartbeatEvent::State(state)) => {
                context.log.push(WheelEventKind::Nmt(state));
                self.is_told_to_stop = false;
                let must_run = context.view.facts.knowledge != Knowledge::Unknown;
                let has_stopped = must_run && state != NmtState::Operational;
                Meaning {
                    fault: has_stopped.then_some(WheelFault::NotOperational(state)),
                    ..Meaning::NONE
                }
            }
        }
    }

    /// What was set up is gone. While nothing was set up yet, that is how a drive announces itself.
    fn read_boot_up(&mut self, context: &mut Context<'_, Zlac>) -> Meaning<WheelFault> {
        let now = context.log.now;
        context.log.push(WheelEventKind::Nmt(NmtState::BootUp));
        self.sdo.abandon(now.as_us());
        self.purpose = None;
        let was_set_up = self.is_set_up;
        self.forget_set_up();
        let is_cleared = self.reset != Reset::No;
        let _ = self.start_over(Instant::default(), is_cleared);
        if context.view.facts.is_checking() && !was_set_up {
            return Meaning::stage(Stage::Probing);
        }
        Meaning::fault(WheelFault::Reboot)
    }

    fn read_reply(
        &mut self,
        frame: &DataFrame,
        context: &mut Context<'_, Zlac>,
    ) -> Meaning<WheelFault> {
        match self.sdo.on_frame(context.log.now.as_us(), frame) {
            SdoHeard::Ended(event) => {
                self.counters.replies = self.counters.replies.wrapping_add(1);
                self.transfer_ended(event, context)
            }
            SdoHeard::Ignored(SdoIgnored::Foreign) => Meaning::NONE,
            SdoHeard::Ignored(reason) => {
                self.counters.late_replies = self.counters.late_replies.wrapping_add(1);
                context.log.push(WheelEventKind::ReplyIgnored(reason));
                Meaning::NONE
            }
        }
    }

    /// A transfer has ended, well or not: what that means by its purpose.
    fn transfer_ended(
        &mut self,
        event: SdoEvent,
        context: &mut Context<'_, Zlac>,
    ) -> Meaning<WheelFault> {
        self.note_abort(&event);
        let purpose = self.purpose.take();
        let lost = self.note_timeout(event, purpose, context);
        let mut meaning = Meaning::NONE;
        match purpose {
            Some(Purpose::Procedure) => {
                context.log.push(WheelEventKind::Transfer(event));
                meaning.work_ended = self.procedure.take().is_some();
            }
            Some(Purpose::Brake(brake)) => match event.end {
                SdoEnd::Written => meaning.brake = Some(brake),
                // Asked again, and counted.
                SdoEnd::TimedOut => {}
                end => meaning.fault = Some(WheelFault::Transfer(end)),
            },
            // One that was refused is not told again and again.
            Some(Purpose::Stop) => self.is_told_to_stop = event.end != SdoEnd::TimedOut,
            Some(Purpose::Health(reading)) => self.note_health(reading, event.end, context.log.now),
            Some(Purpose::Power) => meaning.power = self.power_read(event.end, context.view),
            Some(Purpose::Check) if context.view.facts.is_checking() => {
                meaning = self.check_ended(event.end, context);
            }
            _ => {}
        }
        meaning.fault = meaning.fault.or(lost);
        meaning
    }

    /// A reading of health; one that was refused or not answered is asked again in its turn.
    fn note_health(&mut self, reading: HealthReading, end: SdoEnd, now: Instant) {
        let SdoEnd::Value(data) = end else {
            return;
        };
        let signed = i16::from_data(data)
            .ok()
            .and_then(|value| stamped(value, now));
        let feedback = &mut self.feedback;
        match reading {
            HealthReading::MotorTemperature => {
                feedback.motor_decidegrees = signed.or(feedback.motor_decidegrees);
            }
            HealthReading::DriverTemperature => {
                feedback.driver_decidegrees = signed.or(feedback.driver_decidegrees);
            }
            HealthReading::BusVoltage => {
                let volts = u16::from_data(data).ok();
                let volts = volts.and_then(|value| stamped(value, now));
                feedback.bus_centivolts = volts.or(feedback.bus_centivolts);
            }
        }
    }

    /// Counts the transfers in a row that had no answer.
    fn note_timeout(
        &mut self,
        event: SdoEvent,
        purpose: Option<Purpose>,
        context: &mut Context<'_, Zlac>,
    ) -> Option<WheelFault> {
        if event.end != SdoEnd::TimedOut {
            self.timeouts_in_row = 0;
            return None;
        }
        self.counters.timeouts = self.counters.timeouts.wrapping_add(1);
        let is_asked_for = matches!(purpose, Some(Purpose::Procedure | Purpose::Health(_)));
        if context.view.is_lost || is_asked_for {
            return None;
        }
        context.log.push(WheelEventKind::TransferTimeout(event));
        self.timeouts_in_row = self.timeouts_in_row.saturating_add(1);
        let is_lost = self.timeouts_in_row >= context.config.timeouts.lost_after;
        is_lost.then_some(WheelFault::Lost)
    }

    /// What a status word that was read tells of the power.
    fn power_read(&self, end: SdoEnd, view: &View) -> Option<PowerReport> {
        match end {
            SdoEnd::Value(data) => {
                power_report(StatusWord::new(data.raw() as u16), view, self.asked_at)
            }
            _ => None,
        }
    }

    fn check_ended(&mut self, end: SdoEnd, context: &mut Context<'_, Zlac>) -> Meaning<WheelFault> {
        if context.view.stage == Stage::CheckingConfig {
            return self.follow_script(end, context);
        }
        let value = match end {
            // What these stages read has 16 bits; a reply may leave that open.
            SdoEnd::Value(data) => u16::from_data(data).map_or(data.raw(), u32::from),
            SdoEnd::Written => 0,
            SdoEnd::TimedOut => return Meaning::NONE,
            end => return Meaning::fault(WheelFault::Transfer(end)),
        };
        match context.view.stage {
            Stage::Probing if !self.is_known => self.is_known = true,
            Stage::Probing => {
                return Meaning {
                    power: self.power_read(end, context.view),
                    ..Meaning::stage(Stage::Identifying)
                };
            }
            Stage::Identifying => return self.judge_resolution(value),
            // A drive that is to keep its power is not reset.
            Stage::CheckingStatus
                if self.reset == Reset::Allowed
                    && value != 0
                    && context.view.facts.goal != Goal::Off =>
            {
                return Meaning::fault(WheelFault::Drive(FaultCode::new(value as u16)));
            }
            Stage::CheckingStatus => {
                self.reset = match self.reset {
                    Reset::Allowed if value != 0 => Reset::Edge,
                    Reset::Edge => Reset::Release,
                    _ => Reset::No,
                };
            }
            _ => {}
        }
        Meaning::NONE
    }

    fn judge_resolution(&self, actual: u32) -> Meaning<WheelFault> {
        let expected = self.config.speed_resolution;
        if actual != u32::from(expected) {
            return Meaning::fault(WheelFault::SpeedResolution { expected, actual });
        }
        Meaning::stage(Stage::CheckingConfig)
    }

    fn follow_script(
        &mut self,
        end: SdoEnd,
        context: &mut Context<'_, Zlac>,
    ) -> Meaning<WheelFault> {
        let steps = self.steps();
        self.script.on_end(&steps, end);
        match self.script.outcome() {
            None => match self.script.wanted(&steps) {
                // Nothing is written to a drive that has power or is to have it.
                Some(SdoRequest::Write(address, expected))
                    if context.view.facts.goal != Goal::Off =>
                {
                    let actual = match end {
                        SdoEnd::Value(actual) => actual.raw(),
                        _ => 0,
                    };
                    Meaning::fault(WheelFault::SetUp(SetUpError::Differs {
                        address,
                        expected: expected.raw(),
                        actual,
                    }))
                }
                _ => Meaning::NONE,
            },
            Some(Ok(report)) => {
                context.log.push(WheelEventKind::SetUp(report));
                self.is_set_up = true;
                Meaning::stage(Stage::CheckingStatus)
            }
            Some(Err(error)) => Meaning::fault(WheelFault::SetUp(error)),
        }
    }

    /// Waiting times.
    pub(super) fn pass_time(&mut self, context: &mut Context<'_, Zlac>) -> Meaning<WheelFault> {
        let now = context.log.now;
        let ended = self.sdo.poll(now.as_us());
        let mut meaning = match ended {
            Some(event) => self.transfer_ended(event, context),
            None => Meaning::NONE,
        };
        let timeouts = &context.config.timeouts;
        let view = context.view;
        if view.stage == Stage::PowerOn && view.has_lasted(now, timeouts.power_on_us) {
            meaning.stage = Some(Stage::Probing);
        }
        let waits_for_feedback = view.facts.is_checking()
            && match view.stage {
                Stage::CheckingStatus => self.reset == Reset::No && !self.may_be_mapped,
                Stage::Locating => true,
                _ => false,
            };
        let is_late = waits_for_feedback && view.has_lasted(now, timeouts.confirm_us);
        meaning.fault = meaning
            .fault
            .or_else(|| self.silence(context.config, view, now))
            .or(is_late.then_some(WheelFault::ConfirmTimeout));
        meaning
    }

    /// The feedback of a drive that is set up must come.
    fn silence(&self, config: &WheelMasterConfig, view: &View, now: Instant) -> Option<WheelFault> {
        let is_known = view.facts.knowledge != Knowledge::Unknown;
        if !is_known {
            return None;
        }
        let limit_us = u64::from(config.timeouts.feedback_lost_us);
        let is_stale = |at: Option<Instant>| at.is_none_or(|at| now.us_since(at) >= limit_us);
        let stale = is_stale(self.feedback.status.map(|read| read.at))
            || is_stale(self.feedback.position_counts.map(|read| read.at));
        (stale || self.heartbeat.is_lost(now.as_us())).then_some(WheelFault::Lost)
    }
}

fn stamped<T>(value: T, at: Instant) -> Option<Stamped<T>> {
    Some(Stamped { value, at })
}

/// Whether the motor has power; `None` in a state that no document describes, and while a quick stop is being released. In the fault state
/// of CiA 402, bit 3, the power stage is off; the guide does not describe it, so it only counts as a report and never as a permission.
fn power_report(status: StatusWord, view: &View, asked_at: Instant) -> Option<PowerReport> {
    let is_early = view.facts.power == Power::OnSent && status.emergency_stop();
    let is_on = match status.state() {
        State::OperationEnabled if is_early => return None,
        State::OperationEnabled => true,
        State::NotEnabled | State::ReadyToSwitchOn | State::SwitchedOn => false,
        State::Undocumented if status.fault_bit() => false,
        State::Undocumented => return None,
    };
    Some(PowerReport { is_on, asked_at })
}

/// An emergency message; one with error code 0 tells that an error is gone.
fn read_emergency(emergency: Emcy, log: &mut Log<'_>) -> Meaning<WheelFault> {
    if emergency.error_code != 0 {
        return Meaning::fault(WheelFault::Emergency(emergency));
    }
    log.push(WheelEventKind::EmergencyOver(emergency));
    Meaning::NONE
}
