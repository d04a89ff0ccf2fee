//! Requests of one servo on their way out, and frames that come back unsent.

use bus_user::Instant;
use dyn_can::{Address, DataFrame, ReadSelector, ReplyKind, Request, ServoSwitch};

use crate::core::exit::Class;
use crate::core::facts::{Motion, Power, Work};
use crate::core::family::{Context, Meaning, Returned, View, Wanted};
use crate::core::stamp::Stamp;
use crate::core::state::Stage;
use crate::core::step::may_be_asked;
use crate::servo::ask::Ask;
use crate::servo::drive::Servo;
use crate::servo::dyn_family::Dyn;
use crate::servo::event::EventKind;
use crate::servo::fault::Fault;
use crate::servo::own_move::{OwnMove, concerns_own_move};
use crate::servo::poll_kind::PollKind;
use crate::servo::procedure::Run;

/// The configuration of a drive with power is read again once in [`GUARD_WINDOWS`] windows, each drive in the window of its id: the
/// readings of all drives at once would make polls late.
const GUARD_WINDOW_US: u32 = 1 << 16;
/// A bus carries at most 14 axes at 1 kHz, so few drives share a window.
const GUARD_WINDOWS: u32 = 16;
/// When no window came for so long, as with slow cycles, the reading is urgent.
const GUARD_URGENT_US: u32 = 2 * GUARD_WINDOWS * GUARD_WINDOW_US;
/// Within its window a reading gets ahead of polls that are late by one more cycle every so often.
const GUARD_PATIENCE_US: u32 = 2_000;
/// A poll that is due in so many cycles is due soon: a reply is on its way for less.
const ROOM_CYCLES: i32 = 4;

impl Servo {
    /// What to ask next, and for how many cycles that has been due: what the life of the axis needs, then what a procedure needs, then
    /// the poll that is due longest.
    pub(super) fn next_ask(&self, view: &View, now: Instant, cycle: u32) -> Option<(Ask, i32)> {
        const URGENT: i32 = Wanted::<Request>::URGENT;
        if let Some(own) = self.procedures.own()
            && let Some(ask) = self.own_ask(own, view, now)
        {
            return Some((ask, URGENT));
        }
        if !self.slot.is_free() {
            return None;
        }
        if view.is_lost {
            let is_time = self.retry_at.has_come(now);
            return is_time.then_some((Ask::Reading(ReplyKind::DriveStatus), URGENT));
        }
        // The way back to position mode is what the checks wait for.
        let is_way_back = self.procedures.run().is_some_and(Run::is_way_back);
        if is_way_back && let Some(ask) = self.procedure_ask(view) {
            return Some((ask, URGENT));
        }
        if let Some(kind) = needed_reading(view) {
            return Some((Ask::Reading(kind), URGENT));
        }
        if view.facts.is_checking() && view.stage == Stage::PowerOn {
            return None;
        }
        if let Some(ask) = self.procedure_ask(view) {
            return Some((ask, URGENT));
        }
        let poll = self.polls.most_overdue(cycle);
        let guard = self.guard(view, now, poll.map(|poll| poll.overdue));
        if let Some(overdue_cycles) = guard {
            return Some((Ask::Poll(ReplyKind::DriveConfig), overdue_cycles));
        }
        let poll = poll?;
        Some((Ask::Poll(poll.kind.reply_kind()), poll.overdue))
    }

    fn procedure_ask(&self, view: &View) -> Option<Ask> {
        let run = self.procedures.run().filter(|run| run.may_go_on(view))?;
        match run.wanted_command() {
            // One that has to wait keeps no poll waiting.
            Some(_) => may_be_asked(command_class(run, view), &view.facts).then_some(Ask::Command),
            None => run.wanted_reading().map(Ask::Reading),
        }
    }

    /// For how long the guard asks nothing.
    pub(super) fn unguarded_us(&self, view: &View, now: Instant) -> u32 {
        if !self.is_guarded(view) {
            return u32::MAX;
        }
        let now_us = now.as_us() as u32;
        let age_us = self.guarded_at.age_us(now);
        let urgent_us = GUARD_URGENT_US.saturating_sub(age_us);
        let windows = self.own_window().wrapping_sub(now_us / GUARD_WINDOW_US) % GUARD_WINDOWS;
        let own_us = match windows {
            0 => GUARD_WINDOW_US.saturating_sub(age_us),
            windows => windows * GUARD_WINDOW_US - now_us % GUARD_WINDOW_US,
        };
        own_us.min(urgent_us)
    }

    fn is_guarded(&self, view: &View) -> bool {
        view.facts.power == Power::On && !self.config.unwatched
    }

    fn own_window(&self) -> u32 {
        u32::from(self.config.drive.get()) % GUARD_WINDOWS
    }

    /// The request that asks it, and what that is for.
    pub(super) fn request_for(
        &self,
        ask: Ask,
        view: &View,
        now: Instant,
    ) -> Option<(Class, Request)> {
        Some(match ask {
            Ask::Reading(kind) => (Class::Reading, self.request(kind)),
            Ask::Poll(kind) => (Class::Poll, self.request(kind)),
            Ask::Command => {
                let run = self.procedures.run()?;
                (command_class(run, view), run.wanted_command()?)
            }
            Ask::Own(class) => (class, self.own_request(class, now)?),
        })
    }

    /// By how many cycles the reading of the configuration of a drive with power is due again: somebody else may have changed its mode.
    /// Request and reply are as long as those of the status, so the plan of the bus knows them.
    fn guard(&self, view: &View, now: Instant, poll_overdue: Option<i32>) -> Option<i32> {
        // Constant speed has a mode of its own.
        let is_speed = self.procedures.own().is_some_and(OwnMove::is_speed);
        if !self.is_guarded(view) || is_speed {
            return None;
        }
        // The lower half of the time is enough: windows and their places are powers of two.
        let now_us = now.as_us() as u32;
        let age_us = self.guarded_at.age_us(now);
        if age_us >= GUARD_URGENT_US {
            return Some(Wanted::<Request>::URGENT);
        }
        let window = now_us / GUARD_WINDOW_US;
        let is_turn = window % GUARD_WINDOWS == self.own_window();
        if !is_turn || age_us < GUARD_WINDOW_US {
            return None;
        }
        let in_window_us = now_us % GUARD_WINDOW_US;
        let has_room = poll_overdue.is_none_or(|cycles| cycles < -ROOM_CYCLES);
        let is_pressing = in_window_us >= GUARD_WINDOW_US / 2;
        (has_room || is_pressing).then_some((in_window_us / GUARD_PATIENCE_US) as i32)
    }

    /// The request that asks for a reading.
    #[inline(always)]
    pub(super) fn request(&self, kind: ReplyKind) -> Request {
        match kind {
            ReplyKind::DriveId => Request::ReadDriveId,
            ReplyKind::DriveConfig => Request::ReadDriveConfig,
            ReplyKind::DriveStatus => Request::ReadDriveStatus,
            ReplyKind::Position => Request::GeneralRead(ReadSelector::Position),
            ReplyKind::Torque => Request::GeneralRead(ReadSelector::Torque),
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

    /// The frame of a request. Procedures were checked against the revision when they started, and readings exist in both.
    #[inline(always)]
    pub(super) fn frame_of(&self, request: Request) -> Option<DataFrame> {
        let address = Address::Drive(self.config.drive);
        request.encode(address, &self.dialect).ok()
    }

    /// The controller accepted a request.
    pub(super) fn note_request(
        &mut self,
        request: Request,
        leaves_at: Instant,
        context: &mut Context<'_, Dyn>,
    ) -> Meaning<Fault> {
        let (now, timeouts) = (context.log.now, &context.config.timeouts);
        self.counters.requests = self.counters.requests.wrapping_add(1);
        if concerns_own_move(&request) {
            self.note_own(request, context.view, now);
            return Meaning::NONE;
        }
        self.retry_at = Stamp::of(now).after(timeouts.confirm_us);
        self.responses.asked(leaves_at);
        let is_command = self
            .procedures
            .run()
            .and_then(Run::wanted_command)
            .is_some_and(|command| command == request);
        if is_command {
            return self.note_command(request, timeouts, now);
        }
        if let Some(kind) = request.reply_kind() {
            self.slot.ask(kind, now, timeouts.reply_us);
            if kind == ReplyKind::Position {
                let sent = self.ledger.sent_counts();
                self.drift.asked(sent, self.ledger.sent_before());
            }
            if let Some(poll) = PollKind::of_reply(kind) {
                self.polls.asked(poll, context.cycle);
            }
        }
        Meaning::NONE
    }

    /// The controller gave a frame back unsent.
    pub(super) fn note_returned(
        &mut self,
        frame: &DataFrame,
        context: &mut Context<'_, Dyn>,
    ) -> Returned {
        let Ok((_, request)) = Request::decode(frame, &self.dialect) else {
            context.log.push(EventKind::ForeignFrame { id: frame.id() });
            return Returned::Foreign;
        };
        self.counters.displaced = self.counters.displaced.wrapping_add(1);
        match request {
            Request::GoRelativePosPd(step) => {
                self.ledger.returned(step);
                self.drift.widen(self.ledger.sent_counts());
                let is_told = context.view.facts.motion != Motion::Rest;
                if let Some(own) = self.procedures.own_mut() {
                    own.begins_elsewhere(step, is_told);
                }
                if !context.view.facts.sends_set_points() {
                    self.ledger.end_motion();
                }
                context.log.push(EventKind::SetPointDisplaced);
                return Returned::OfCycle;
            }
            Request::ServoDisable(ServoSwitch::Enable) => return Returned::Switch(Class::SwitchOn),
            Request::ServoDisable(ServoSwitch::Disable) => {
                return Returned::Switch(Class::SwitchOff);
            }
            Request::DriveReset => self.command_returned(),
            own if concerns_own_move(&own) => return self.own_returned(own),
            other => match other.reply_kind() {
                Some(kind) => {
                    self.slot.forget();
                    if let Some(poll) = PollKind::of_reply(kind) {
                        self.polls.returned(poll, context.cycle);
                    }
                    context.log.push(EventKind::RequestDisplaced(kind));
                }
                None => self.command_returned(),
            },
        }
        Returned::Request
    }
}

/// What the command of a procedure is for.
fn command_class(run: &Run, view: &View) -> Class {
    match view.facts.work {
        _ if run.is_way_back() => Class::Repair,
        Work::Repair => Class::Repair,
        _ => Class::Write,
    }
}

/// The reading that the life of the axis waits for.
fn needed_reading(view: &View) -> Option<ReplyKind> {
    let facts = &view.facts;
    if facts.holds_anchor() {
        return None;
    }
    if matches!(facts.power, Power::OnSent | Power::OffSent) {
        return Some(ReplyKind::DriveStatus);
    }
    if facts.is_checking() {
        return stage_reading(view.stage);
    }
    if facts.awaits_power() {
        return Some(ReplyKind::DriveStatus);
    }
    if facts.awaits_standstill() {
        return Some(ReplyKind::MotorSpeed);
    }
    facts.awaits_anchor().then_some(ReplyKind::Position)
}

/// The reading of a stage of the checks.
pub(super) const fn stage_reading(stage: Stage) -> Option<ReplyKind> {
    match stage {
        Stage::PowerOn => None,
        Stage::Probing => Some(ReplyKind::Echo),
        Stage::Identifying => Some(ReplyKind::ParamGroup3),
        Stage::CheckingConfig => Some(ReplyKind::DriveConfig),
        Stage::CheckingStatus => Some(ReplyKind::DriveStatus),
        Stage::Locating => Some(ReplyKind::Position),
    }
}
