//! The one procedure that an axis may have under way.

use dyn_can::{Reply, ReplyKind, Request};

use super::{Axis, Log};
use crate::event::EventKind;
use crate::family::Life;
use crate::life::{AxisState, Reason};
use crate::procedure::{Confirmation, Procedure, ProcedureEnd, ProcedureError, Run};
use crate::time::Instant;

impl Axis {
    /// Starts a procedure, or says why not.
    pub(crate) fn start(
        &mut self,
        procedure: Procedure,
        confirmation: Confirmation,
        now: Instant,
    ) -> Result<(), ProcedureError> {
        if self.run.is_some() {
            return Err(ProcedureError::Busy);
        }
        let allowed = match procedure.writes() {
            true => matches!(self.state, AxisState::Ready | AxisState::Faulted),
            false => self.state.may_poll(),
        };
        if !allowed || self.is_lost() {
            return Err(ProcedureError::State { actual: self.state });
        }
        if procedure.needs_confirmation() && confirmation == Confirmation::None {
            return Err(ProcedureError::Unconfirmed);
        }
        if let Some(command) = procedure.command() {
            command.function().admit_request(self.dialect.revision)?;
        }
        self.admit_wear(procedure.wear(), now)?;
        self.run = Some(Run::new(procedure));
        Ok(())
    }

    fn admit_wear(&self, wear: u16, now: Instant) -> Result<(), ProcedureError> {
        if wear == 0 {
            return Ok(());
        }
        let limits = self.config.wear;
        if self.counters.eeprom_writes.saturating_add(wear) > limits.budget {
            return Err(ProcedureError::WearBudget {
                budget: limits.budget,
            });
        }
        let interval_us = u64::from(limits.interval_us);
        let passed_us = self.wrote_at.map_or(interval_us, |at| now.us_since(at));
        match interval_us.saturating_sub(passed_us) {
            0 => Ok(()),
            wait_us => Err(ProcedureError::WearInterval { wait_us }),
        }
    }

    pub(super) fn wanted_command(&self) -> Option<Request> {
        self.run.and_then(|run| run.wanted_command())
    }

    /// The controller accepted the command of the procedure.
    pub(crate) fn told(&mut self, request: Request, quarantine_us: u32, log: &mut Log<'_>) {
        let Some(run) = &mut self.run else { return };
        let procedure = run.procedure();
        let end = run.sent(log.now);
        let wear = procedure.wear();
        if wear != 0 {
            self.counters.eeprom_writes = self.counters.eeprom_writes.saturating_add(wear);
            self.wrote_at = Some(log.now);
        }
        if let Some(kind) = request.reply_kind() {
            // What the drive answers to a reset is not stated, nor whether it does (D35): the answer is dropped.
            self.slot.ask(kind, log.now, quarantine_us);
            self.slot.close(log.now, quarantine_us);
        }
        if let Some(end) = end {
            self.finish(end, log);
        }
        match procedure {
            Procedure::SetOrigin => self.reanchor(AxisState::Anchoring, log),
            Procedure::DriveReset => self.reanchor(AxisState::PowerOn, log),
            _ => {}
        }
    }

    /// The position is not what it was; a fault stays latched.
    fn reanchor(&mut self, next: AxisState, log: &mut Log<'_>) {
        self.referenced = false;
        if self.fault.is_none() {
            self.enter(next, Reason::Command, log);
        }
    }

    /// The controller gave the command of a procedure back unsent; one that ended with its command starts anew.
    pub(super) fn command_returned(&mut self, request: Request) {
        match request {
            Request::SetOrigin => self.run = Some(Run::new(Procedure::SetOrigin)),
            Request::DriveReset => self.run = Some(Run::new(Procedure::DriveReset)),
            _ => {
                if let Some(run) = &mut self.run {
                    run.returned();
                }
            }
        }
    }

    /// A reply that the procedure may have waited for.
    pub(super) fn procedure_replied(&mut self, kind: ReplyKind, reply: Reply, log: &mut Log<'_>) {
        let Some(run) = self
            .run
            .as_mut()
            .filter(|run| run.wanted_reading() == Some(kind))
        else {
            return;
        };
        let procedure = run.procedure();
        let Some(end) = run.replied(reply) else {
            return;
        };
        self.finish(end, log);
        // The gear changes what a command count is.
        if end == ProcedureEnd::Written
            && matches!(procedure, Procedure::WriteGroup3(set) if set.gear_number.is_some())
        {
            self.reanchor(AxisState::Anchoring, log);
        }
    }

    /// The reply that the procedure waited for did not come, or does not decode.
    pub(super) fn procedure_missed(&mut self, kind: ReplyKind, log: &mut Log<'_>) {
        if self
            .run
            .is_some_and(|run| run.wanted_reading() == Some(kind))
        {
            self.finish(ProcedureEnd::NoReply, log);
        }
    }

    /// A data error came: true when the procedure's command explains it.
    pub(super) fn procedure_refused(&mut self, log: &mut Log<'_>) -> bool {
        let explains = self.run.is_some_and(|run| run.explains_data_error());
        if explains {
            self.finish(ProcedureEnd::Refused, log);
        }
        explains
    }

    pub(super) fn procedure_aborted(&mut self, log: &mut Log<'_>) {
        if self.run.is_some() {
            self.finish(ProcedureEnd::Aborted, log);
        }
    }

    fn finish(&mut self, end: ProcedureEnd, log: &mut Log<'_>) {
        self.run = None;
        log.push(EventKind::Procedure(end));
    }
}
