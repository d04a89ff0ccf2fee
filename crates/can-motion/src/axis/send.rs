//! Frames of one axis on their way out, and back.

use dyn_can::{Address, DataFrame, PdStep, ReplyKind, Request, ServoSwitch, go_relative_pos_pd};

use super::{Axis, Log};
use crate::config::MasterConfig;
use crate::event::EventKind;
use crate::family::{Life, Sends, Switch};
use crate::life::{AxisState, Reason};
use crate::plan::wire::exact_bits;
use crate::polls::PollKind;
use crate::time::Instant;

impl Sends for Axis {
    /// The request to send next, and for how many cycles it has been due: what a state waits for, then what a procedure
    /// wants, beat every poll.
    fn wanted_request(&self, cycle: u32) -> Option<(Request, i32)> {
        if !self.slot.is_free() {
            return None;
        }
        if let Some(kind) = self.state.wanted_reading() {
            return Some((self.request(kind), i32::MAX));
        }
        if !self.state.may_poll() || self.is_lost() {
            return None;
        }
        if let Some(request) = self.wanted_command() {
            return Some((request, i32::MAX));
        }
        if let Some(kind) = self.run.and_then(|run| run.wanted_reading()) {
            return Some((self.request(kind), i32::MAX));
        }
        let poll = self.polls.most_overdue(cycle)?;
        Some((self.request(poll.kind.reply_kind()), poll.overdue))
    }

    fn sends_each_cycle(&self) -> bool {
        self.state.sends_set_points()
    }

    /// The set-point of this cycle.
    fn set_point(&self) -> (DataFrame, PdStep) {
        let step = self.books.next_step(self.config.limits.max_step);
        (
            go_relative_pos_pd(self.config.drive, step, self.dialect.number_order),
            step,
        )
    }

    fn switch_frame(&self, switch: Switch) -> Option<DataFrame> {
        let switch = match switch {
            Switch::Enable => ServoSwitch::Enable,
            Switch::Disable => ServoSwitch::Disable,
        };
        let address = Address::Drive(self.config.drive);
        let request = Request::ServoDisable(switch);
        request.encode(address, &self.dialect).ok()
    }

    fn request_frame(&self, request: Request) -> Option<DataFrame> {
        let address = Address::Drive(self.config.drive);
        // Procedures were checked against the revision when they started, and readings exist in both.
        let frame = request.encode(address, &self.dialect).ok()?;
        self.slot.is_free().then_some(frame)
    }

    fn set_point_bits(&self) -> u16 {
        let (frame, _) = self.set_point();
        exact_bits(frame.id(), frame.data())
    }

    fn request_bits(&self, request: Request) -> u16 {
        let frame = self.request_frame(request);
        frame.map_or(0, |frame| exact_bits(frame.id(), frame.data()))
    }

    /// The controller accepted a set-point.
    fn stepped(&mut self, step: PdStep, now: Instant) {
        self.books.sent(step);
        self.drift.stepped(step, now);
        self.counters.set_points = self.counters.set_points.wrapping_add(1);
    }

    /// The controller accepted the request.
    fn requested(
        &mut self,
        request: Request,
        cycle: u32,
        config: &MasterConfig,
        log: &mut Log<'_>,
    ) {
        let reply_us = config.timeouts.reply_us;
        self.counters.requests = self.counters.requests.wrapping_add(1);
        if self.wanted_command() == Some(request) {
            self.told(request, reply_us, log);
        } else if let Some(kind) = request.reply_kind() {
            self.slot.ask(kind, log.now, reply_us);
            if let Some(poll) = PollKind::of_reply(kind) {
                self.polls.asked(poll, cycle);
            }
        }
    }

    /// The controller accepted the enable or disable command.
    fn switched(&mut self, switch: Switch, log: &mut Log<'_>) {
        self.may_be_enabled = switch == Switch::Enable;
        let next = match switch {
            Switch::Enable => AxisState::ConfirmingEnable,
            Switch::Disable => AxisState::ConfirmingDisable,
        };
        self.enter(next, Reason::Sent, log);
    }

    /// The controller gave a frame back unsent.
    fn displaced(&mut self, frame: &DataFrame, cycle: u32, log: &mut Log<'_>) -> bool {
        let Ok((_, request)) = Request::decode(frame, &self.dialect) else {
            log.push(EventKind::ForeignFrame { id: frame.id() });
            return false;
        };
        self.counters.displaced = self.counters.displaced.wrapping_add(1);
        match request {
            Request::GoRelativePosPd(step) => {
                self.books.returned(step);
                if !self.state.sends_set_points() {
                    self.books.drop_backlog();
                }
                log.push(EventKind::SetPointDisplaced);
                return false;
            }
            Request::ServoDisable(switch) => {
                self.switch_displaced(switch, log);
                return false;
            }
            Request::DriveReset => self.command_returned(request),
            other => {
                if let Some(kind) = other.reply_kind() {
                    self.slot.forget();
                    if let Some(poll) = PollKind::of_reply(kind) {
                        self.polls.returned(poll, cycle);
                    }
                    log.push(EventKind::RequestDisplaced(kind));
                } else {
                    self.command_returned(other);
                }
            }
        }
        true
    }

    fn owes_set_point(&self) -> bool {
        self.books.backlog_counts() != 0
    }

    fn merged(&mut self) {
        self.counters.merged = self.counters.merged.wrapping_add(1);
    }
}

impl Axis {
    /// The request that asks for a reading.
    fn request(&self, kind: ReplyKind) -> Request {
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

    pub(super) const fn echo_bytes(&self) -> [u8; 4] {
        [
            self.config.drive.get(),
            self.echo_token,
            !self.echo_token,
            0x55,
        ]
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
}
