//! Requests of one wheel on their way out, and frames that come back unsent.

use bus_user::Instant;
use zlac8030l::{
    CanopenFrame, ControlWord, DataFrame, NmtCommand, NmtRequest, NmtState, SdoRequest, Service,
    objects,
};

use crate::core::exit::{Class, may_leave};
use crate::core::facts::{Brake, Facts, Power, Work};
use crate::core::family::{Context, Returned, View, Wanted};
use crate::core::state::Stage;
use crate::core::step::may_be_asked;
use crate::wheel::drive::{Reset, Wheel};
use crate::wheel::event::WheelEventKind;
use crate::wheel::process_data;
use crate::wheel::request::{HealthReading, Purpose, WheelRequest};
use crate::wheel::zlac_family::Zlac;

/// Value of the holding brake 2030h:0E that closes it.
const BRAKE_CLOSED: u16 = 1;
/// Value of the holding brake 2030h:0E that opens it.
const BRAKE_OPEN: u16 = 0;

impl Wheel {
    /// The request to send next.
    pub(super) fn next_request(&self, view: &View, now: Instant) -> Option<Wanted<WheelRequest>> {
        if let Some(abort) = self.abort {
            return Some(Wanted::urgent(Class::Reading, WheelRequest::Abort(abort)));
        }
        if let Some((class, command)) = self.wanted_nmt(view) {
            return Some(Wanted::urgent(class, WheelRequest::Nmt(command)));
        }
        let (class, purpose, request) = self.wanted_transfer(view, now)?;
        let is_ready = self.sdo.ready(now.as_us(), request.address()).is_ok();
        is_ready.then(|| Wanted::urgent(class, WheelRequest::Transfer(purpose, request)))
    }

    fn wanted_nmt(&self, view: &View) -> Option<(Class, NmtCommand)> {
        let was_heard = self.feedback.nmt.is_some();
        if self.heartbeat.state() == Some(NmtState::Stopped) {
            // It answers nothing and can be told nothing else, whatever its power is. Once a heartbeat.
            return was_heard.then_some((Class::Reading, NmtCommand::PreOperational));
        }
        let is_checking = view.facts.is_checking() && may_be_asked(Class::Repair, &view.facts);
        let command = self.check_nmt(view).filter(|_| is_checking)?;
        Some((Class::Repair, command))
    }

    /// A mapping changes only while PDOs rest; one that is right already is left in operation.
    fn check_nmt(&self, view: &View) -> Option<NmtCommand> {
        let is_operational = self.heartbeat.state() == Some(NmtState::Operational);
        match view.stage {
            Stage::CheckingConfig if !self.may_be_mapped => {
                let wanted = self.script.wanted(&self.steps())?;
                matches!(wanted, SdoRequest::Write(..)).then_some(NmtCommand::PreOperational)
            }
            Stage::CheckingStatus if self.reset == Reset::No && self.may_be_mapped => {
                Some(NmtCommand::Start)
            }
            Stage::CheckingStatus if self.reset == Reset::No && !is_operational => {
                let was_told = self.feedback.nmt.is_some();
                was_told.then_some(NmtCommand::Start)
            }
            _ => None,
        }
    }

    fn wanted_transfer(&self, view: &View, now: Instant) -> Option<(Class, Purpose, SdoRequest)> {
        let (facts, timeouts) = (&view.facts, &self.master.timeouts);
        if view.is_lost {
            // Seldom: each question that is not answered costs the others their turns.
            let is_time = now.us_since(self.asked_at) >= u64::from(timeouts.confirm_us);
            return is_time.then(power_reading);
        }
        if self.is_to_be_stopped(facts) {
            let request = objects::CONTROL_WORD.write(ControlWord::QUICK_STOP.get());
            return Some((Class::StopFrame, Purpose::Stop, request));
        }
        let may_read_power = !facts.is_checking() || facts.power == Power::OffSent;
        if facts.awaits_power() && !self.takes_frames() && may_read_power {
            return Some(power_reading());
        }
        if may_leave(Class::BrakeClose, facts) && self.may_close_brake(view, now) {
            let request = objects::HOLDING_BRAKE.write(BRAKE_CLOSED);
            return Some((Class::BrakeClose, Purpose::Brake(Brake::Closed), request));
        }
        if may_leave(Class::BrakeOpen, facts) {
            let request = objects::HOLDING_BRAKE.write(BRAKE_OPEN);
            return Some((Class::BrakeOpen, Purpose::Brake(Brake::Open), request));
        }
        if facts.is_checking() {
            let request = self.check_transfer(view.stage)?;
            if !matches!(request, SdoRequest::Write(..)) {
                return Some((Class::Reading, Purpose::Check, request));
            }
            if may_be_asked(Class::Repair, facts) {
                return Some((Class::Repair, Purpose::Check, request));
            }
            // It waits for a drive without power.
            let is_time = now.us_since(self.asked_at) >= u64::from(timeouts.confirm_us);
            return is_time.then(power_reading);
        }
        let Some(request) = self.procedure else {
            let reading = self.wanted_health(now)?;
            return Some((Class::Poll, Purpose::Health(reading), reading.request()));
        };
        let class = match facts.work {
            Work::Write => Class::Write,
            Work::Repair => Class::Repair,
            _ => Class::Poll,
        };
        Some((class, Purpose::Procedure, request))
    }

    /// A drive that somebody took out of operation takes no frame of a cycle: it is told to stop by a transfer.
    fn is_to_be_stopped(&self, facts: &Facts) -> bool {
        let is_out = self.heartbeat.state() == Some(NmtState::PreOperational);
        let may_turn = facts.power.may_be_on() && facts.power != Power::OffSent;
        let is_told = self.is_told_to_stop || facts.is_checking();
        self.is_set_up && is_out && may_turn && !is_told && may_leave(Class::StopFrame, facts)
    }

    /// The reading whose turn it is.
    fn wanted_health(&self, now: Instant) -> Option<HealthReading> {
        let every_us = self.config.polls.health_us? / HealthReading::COUNT;
        let is_time = self
            .health_asked_at
            .is_none_or(|at| now.us_since(at) >= u64::from(every_us));
        (self.takes_frames() && is_time).then_some(self.health_next)
    }

    /// A holding brake is not made to stop a wheel that turns. Where nobody reports the speed, it waits as long as a standstill may take.
    fn may_close_brake(&self, view: &View, now: Instant) -> bool {
        let limit_us = self.master.timeouts.standstill_limit_us;
        self.still_since.is_some() || view.has_lasted(now, limit_us)
    }

    fn check_transfer(&self, stage: Stage) -> Option<SdoRequest> {
        match stage {
            Stage::Probing if !self.is_known => Some(objects::DEVICE_TYPE.read()),
            Stage::Probing => Some(objects::STATUS_WORD.read()),
            Stage::Identifying => Some(objects::SPEED_RESOLUTION.read()),
            Stage::CheckingConfig => self.script.wanted(&self.steps()),
            Stage::CheckingStatus => match self.reset {
                Reset::No => None,
                Reset::Allowed => Some(objects::FAULT_CODE.read()),
                Reset::Edge => Some(objects::CONTROL_WORD.write(ControlWord::FAULT_RESET.get())),
                Reset::Release => {
                    Some(objects::CONTROL_WORD.write(ControlWord::DISABLE_VOLTAGE.get()))
                }
            },
            Stage::PowerOn | Stage::Locating => None,
        }
    }

    /// The controller accepted a request.
    pub(super) fn note_request(&mut self, request: WheelRequest, now: Instant) {
        self.counters.requests = self.counters.requests.wrapping_add(1);
        match request {
            WheelRequest::Nmt(command) => {
                self.may_be_mapped = command == NmtCommand::PreOperational;
                self.feedback.nmt = None;
            }
            WheelRequest::Abort(_) => self.abort = None,
            WheelRequest::Transfer(purpose, request) => {
                // It was ready when it was offered, and time has only passed since.
                let _ = self.sdo.start(now.as_us(), request);
                self.purpose = Some(purpose);
                self.asked_at = now;
                if let Purpose::Health(reading) = purpose {
                    self.health_next = reading.next();
                    self.health_asked_at = Some(now);
                }
            }
        }
    }

    /// The controller gave a frame back unsent.
    pub(super) fn note_returned(
        &mut self,
        frame: &DataFrame,
        context: &mut Context<'_, Zlac>,
    ) -> Returned {
        self.counters.displaced = self.counters.displaced.wrapping_add(1);
        match frame.service() {
            Ok(Service::Rpdo(..)) => {
                self.ledger.returned(process_data::target(frame));
                context.log.push(WheelEventKind::TargetDisplaced);
                return Returned::OfCycle;
            }
            Ok(Service::SdoRequest(_)) => {
                if let Some(returned) = self.withdraw(frame) {
                    return returned;
                }
            }
            Ok(Service::Nmt) => self.nmt_returned(frame),
            _ => {
                let event = WheelEventKind::ForeignFrame { id: frame.id() };
                context.log.push(event);
                return Returned::Foreign;
            }
        }
        context.log.push(WheelEventKind::RequestDisplaced);
        Returned::Request
    }

    fn nmt_returned(&mut self, frame: &DataFrame) {
        let was_start =
            NmtRequest::decode(frame).is_ok_and(|request| request.command == NmtCommand::Start);
        self.may_be_mapped = was_start;
    }

    /// The controller gave a transfer back: no reply will come.
    fn withdraw(&mut self, frame: &DataFrame) -> Option<Returned> {
        let Ok((_, request)) = SdoRequest::decode(frame) else {
            return None;
        };
        if matches!(request, SdoRequest::Abort(..)) {
            self.abort = Some(request);
            return None;
        }
        let switch_off = objects::CONTROL_WORD.write(ControlWord::DISABLE_VOLTAGE.get());
        // A transfer of another purpose may be under way beside the command; only a reset of a fault writes the same.
        let is_release = self.purpose == Some(Purpose::Check) && self.reset == Reset::Release;
        if request == switch_off && !is_release {
            return Some(Returned::Switch(Class::SwitchOff));
        }
        self.sdo.withdraw();
        self.purpose = None;
        None
    }
}

fn power_reading() -> (Class, Purpose, SdoRequest) {
    (Class::Reading, Purpose::Power, objects::STATUS_WORD.read())
}
