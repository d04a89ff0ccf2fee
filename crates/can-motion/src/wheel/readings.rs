//! Frames of one wheel on their way in.

use zlac8030l::{
    DataFrame, Emcy, HeartbeatEvent, HeartbeatWatch, Message, NmtState, PdoNumber, SdoEnd,
    SdoEvent, SdoHeard, SdoIgnored, State, StatusWord,
};

use super::axis::{Log, Reset, Wheel};
use super::config::{WheelMasterConfig, WheelMode};
use super::event::WheelEventKind;
use super::fault::WheelFault;
use super::process_data;
use crate::family::{Hears, Life};
use crate::feedback::Stamped;
use crate::life::{AxisState, Reason};
use crate::time::Instant;

impl Hears for Wheel {
    fn hear(
        &mut self,
        frame: &DataFrame,
        config: &WheelMasterConfig,
        log: &mut Log<'_>,
    ) -> Option<WheelFault> {
        match Message::decode(frame) {
            Ok(Message::Tpdo(_, process_data::STATUS, _)) => self.hear_status(frame, config, log),
            Ok(Message::Tpdo(_, process_data::POSITION, _)) => self.hear_position(frame, log),
            Ok(Message::SdoReply(..)) => self.hear_reply(frame, config, log),
            Ok(Message::Heartbeat(heartbeat)) => self.hear_heartbeat(heartbeat.state, config, log),
            Ok(Message::Emcy(_, emergency)) => hear_emergency(emergency, log),
            Ok(Message::Tpdo(_, PdoNumber::Pdo2 | PdoNumber::Pdo3, _)) => None,
            Ok(_) => {
                log.push(WheelEventKind::ForeignFrame { id: frame.id() });
                None
            }
            // Also what is not expedited: the client has to give up on it.
            Err(error) => {
                log.push(WheelEventKind::BadFrame(error));
                self.hear_reply(frame, config, log)
            }
        }
    }

    fn quiet_us(&mut self, _: WheelFault, _: &WheelMasterConfig) -> Option<u32> {
        None
    }

    fn abandon_request(&mut self, now: Instant, _: &WheelMasterConfig) {
        self.sdo.abandon(now.as_us());
    }
}

/// An emergency message; one with error code 0 tells that an error is gone.
fn hear_emergency(emergency: Emcy, log: &mut Log<'_>) -> Option<WheelFault> {
    if emergency.error_code != 0 {
        return Some(WheelFault::Emergency(emergency));
    }
    log.push(WheelEventKind::EmergencyOver(emergency));
    None
}

impl Wheel {
    fn hear_status(
        &mut self,
        frame: &DataFrame,
        config: &WheelMasterConfig,
        log: &mut Log<'_>,
    ) -> Option<WheelFault> {
        let (status, fault_code, speed_decirpm) = match process_data::status(frame) {
            Ok(values) => values,
            Err(error) => {
                log.push(WheelEventKind::BadFrame(error));
                return None;
            }
        };
        self.feedback.status = Some(Stamped {
            value: status,
            at: log.now,
        });
        self.feedback.fault_code = Some(fault_code);
        self.feedback.speed_decirpm = Some(speed_decirpm);
        let stands = speed_decirpm.unsigned_abs() <= u32::from(self.config.limits.standstill);
        self.still_since = stands.then(|| self.still_since.unwrap_or(log.now));
        self.status_fault(status, config, log.now)
            .or_else(|| self.following_speed(speed_decirpm, log.now))
            .or_else(|| {
                self.follow_status(status, config, log);
                None
            })
    }

    /// What the status says against what the state expects.
    fn status_fault(
        &self,
        status: StatusWord,
        config: &WheelMasterConfig,
        now: Instant,
    ) -> Option<WheelFault> {
        let is_judged = self.state.is_known() || self.is_checked();
        if !is_judged || self.state == AxisState::Faulted {
            return None;
        }
        if let Some(code) = self.feedback.fault_code.filter(|code| code.is_fault()) {
            return Some(WheelFault::Drive(code));
        }
        if status.external_emergency_stop() {
            return Some(WheelFault::EmergencyInput);
        }
        // The release of a quick stop takes a moment.
        let settled = now.us_since(self.since) >= u64::from(config.timeouts.confirm_us);
        let stopped = status.emergency_stop() && !self.quick_stop && settled;
        let is_off = status.state() != State::OperationEnabled;
        (self.state.is_enabled() && (is_off || stopped)).then_some(WheelFault::NotEnabled)
    }

    /// The drive was told to start its PDOs, and nothing is left to reset.
    fn is_checked(&self) -> bool {
        self.state == AxisState::CheckingStatus && self.reset == Reset::No && !self.nmt_due
    }

    fn follow_status(&mut self, status: StatusWord, config: &WheelMasterConfig, log: &mut Log<'_>) {
        let standstill_us = u64::from(config.timeouts.standstill_us);
        let stands = self
            .still_since
            .is_some_and(|since| log.now.us_since(since) >= standstill_us);
        let next = match self.state {
            AxisState::CheckingStatus
                if self.is_checked() && self.heartbeat.state() == Some(NmtState::Operational) =>
            {
                AxisState::Anchoring
            }
            AxisState::AwaitingStandstill if stands => AxisState::Reanchoring,
            AxisState::ConfirmingEnable
                if status.state() == State::OperationEnabled && !status.emergency_stop() =>
            {
                AxisState::Streaming
            }
            AxisState::ConfirmingDisable if status.state() == State::NotEnabled => AxisState::Ready,
            _ => return,
        };
        self.enter(next, Reason::Reading, log);
    }

    fn hear_position(&mut self, frame: &DataFrame, log: &mut Log<'_>) -> Option<WheelFault> {
        let (position_counts, torque) = match process_data::position(frame) {
            Ok(values) => values,
            Err(error) => {
                log.push(WheelEventKind::BadFrame(error));
                return None;
            }
        };
        self.feedback.position_counts = Some(Stamped {
            value: position_counts,
            at: log.now,
        });
        self.feedback.torque = Some(torque);
        match self.state {
            AxisState::Anchoring => self.take_anchor(position_counts, AxisState::Ready, log),
            AxisState::Reanchoring => self.take_anchor(position_counts, AxisState::Enabling, log),
            _ => self.following_error(position_counts),
        }
    }

    fn take_anchor(
        &mut self,
        position_counts: i32,
        next: AxisState,
        log: &mut Log<'_>,
    ) -> Option<WheelFault> {
        let limits = &self.config.limits;
        let is_position = matches!(self.config.mode, WheelMode::Position { .. });
        if is_position && !(limits.min..=limits.max).contains(&position_counts) {
            return Some(WheelFault::PositionRange {
                actual: position_counts,
            });
        }
        self.anchor();
        self.enter(next, Reason::Reading, log);
        None
    }

    fn following_error(&self, position_counts: i32) -> Option<WheelFault> {
        let follows =
            matches!(self.config.mode, WheelMode::Position { .. }) && self.state.sends_set_points();
        let error = i64::from(position_counts) - i64::from(self.books.sent());
        let is_far = error.unsigned_abs() > u64::from(self.config.limits.following_error);
        (follows && is_far).then(|| WheelFault::FollowingError {
            counts: error.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32,
        })
    }

    /// A wheel in velocity mode that turns at another speed than it was told for too long.
    fn following_speed(&mut self, actual_decirpm: i32, now: Instant) -> Option<WheelFault> {
        let follows = self.config.mode == WheelMode::Velocity && self.state.sends_set_points();
        let resolution = i32::from(self.config.speed_resolution.max(1));
        // At most ten times 1000 r/min, so that nothing overflows.
        let sent_decirpm = self.books.sent().saturating_mul(10) / resolution;
        let limits = &self.config.limits;
        let difference = actual_decirpm.abs_diff(sent_decirpm);
        if !follows || difference <= u32::from(limits.following_speed) {
            self.off_since = None;
            return None;
        }
        let since = *self.off_since.get_or_insert(now);
        let is_long = now.us_since(since) >= u64::from(limits.following_speed_us);
        is_long.then_some(WheelFault::FollowingSpeed {
            sent_decirpm,
            actual_decirpm,
        })
    }

    fn hear_heartbeat(
        &mut self,
        state: NmtState,
        config: &WheelMasterConfig,
        log: &mut Log<'_>,
    ) -> Option<WheelFault> {
        self.feedback.nmt = Some(state);
        match self.heartbeat.on_heartbeat(log.now.as_us(), state)? {
            HeartbeatEvent::BootUp => self.hear_boot_up(config, log),
            HeartbeatEvent::State(state) => {
                log.push(WheelEventKind::Nmt(state));
                let must_run = self.state.is_known() && self.state != AxisState::Faulted;
                (must_run && state != NmtState::Operational)
                    .then_some(WheelFault::NotOperational(state))
            }
        }
    }

    /// What was set up is gone. While nothing was set up yet, that is how a drive announces itself.
    fn hear_boot_up(
        &mut self,
        config: &WheelMasterConfig,
        log: &mut Log<'_>,
    ) -> Option<WheelFault> {
        log.push(WheelEventKind::Nmt(NmtState::BootUp));
        self.sdo.abandon(log.now.as_us());
        self.heartbeat = HeartbeatWatch::new(config.timeouts.heartbeat_lost_us);
        self.is_set_up = false;
        self.may_be_enabled = false;
        match self.state {
            AxisState::PowerOn | AxisState::Probing => {
                self.enter(AxisState::Probing, Reason::Reading, log);
                None
            }
            AxisState::Faulted => None,
            _ => Some(WheelFault::Reboot),
        }
    }

    fn hear_reply(
        &mut self,
        frame: &DataFrame,
        config: &WheelMasterConfig,
        log: &mut Log<'_>,
    ) -> Option<WheelFault> {
        match self.sdo.on_frame(log.now.as_us(), frame) {
            SdoHeard::Ended(event) => {
                self.counters.replies = self.counters.replies.wrapping_add(1);
                self.transfer_ended(event, config, log)
            }
            SdoHeard::Ignored(SdoIgnored::Foreign) => None,
            SdoHeard::Ignored(reason) => {
                self.counters.late_replies = self.counters.late_replies.wrapping_add(1);
                log.push(WheelEventKind::ReplyIgnored(reason));
                None
            }
        }
    }

    /// A transfer has ended, well or not: where that leads.
    pub(super) fn transfer_ended(
        &mut self,
        event: SdoEvent,
        config: &WheelMasterConfig,
        log: &mut Log<'_>,
    ) -> Option<WheelFault> {
        self.note_abort(&event);
        let timed_out = event.end == SdoEnd::TimedOut;
        if timed_out {
            self.counters.timeouts = self.counters.timeouts.wrapping_add(1);
        } else {
            self.timeouts_in_row = 0;
        }
        match self.state {
            AxisState::CheckingConfig => self.follow_script(event.end, log),
            AxisState::Probing | AxisState::Identifying | AxisState::CheckingStatus
                if timed_out =>
            {
                log.push(WheelEventKind::TransferTimeout(event));
                self.miss(config.timeouts.lost_after)
            }
            AxisState::Probing | AxisState::Identifying | AxisState::CheckingStatus => {
                self.follow_value(event.end, log)
            }
            _ => {
                log.push(WheelEventKind::Transfer(event));
                None
            }
        }
    }

    fn follow_script(&mut self, end: SdoEnd, log: &mut Log<'_>) -> Option<WheelFault> {
        let steps = self.steps();
        self.script.on_end(&steps, end);
        match self.script.outcome()? {
            Ok(report) => {
                log.push(WheelEventKind::SetUp(report));
                self.is_set_up = true;
                self.enter(AxisState::CheckingStatus, Reason::Reading, log);
                None
            }
            Err(error) => Some(WheelFault::SetUp(error)),
        }
    }

    fn follow_value(&mut self, end: SdoEnd, log: &mut Log<'_>) -> Option<WheelFault> {
        let value = match end {
            SdoEnd::Value(data) => data.raw(),
            SdoEnd::Written => 0,
            _ => return Some(WheelFault::Transfer(end)),
        };
        match self.state {
            AxisState::Probing => self.enter(AxisState::Identifying, Reason::Reading, log),
            AxisState::Identifying => {
                let expected = self.config.speed_resolution;
                if value != u32::from(expected) {
                    return Some(WheelFault::SpeedResolution {
                        expected,
                        actual: value,
                    });
                }
                self.enter(AxisState::CheckingConfig, Reason::Reading, log);
            }
            AxisState::CheckingStatus => {
                self.reset = match self.reset {
                    Reset::Allowed if value != 0 => Reset::Edge,
                    Reset::Edge => Reset::Release,
                    _ => Reset::No,
                };
                self.nmt_due = self.reset == Reset::No;
            }
            _ => {}
        }
        None
    }
}
