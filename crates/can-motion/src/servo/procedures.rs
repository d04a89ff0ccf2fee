//! The one procedure that a servo may have under way.

use bus_user::Instant;
use dyn_can::{Reply, ReplyKind, Request};

use crate::core::facts::{Latch, Work};
use crate::core::family::{Meaning, View};
use crate::core::procedure::Confirmation;
use crate::servo::books::Books;
use crate::servo::config::Timeouts;
use crate::servo::drive::Servo;
use crate::servo::event::Log;
use crate::servo::fault::Fault;
use crate::servo::procedure::{Procedure, ProcedureEnd, ProcedureError, Run};

impl Servo {
    /// Whether a procedure may run, and what kind of work it is. Under a fault, a write that removes its cause is a repair.
    pub(super) fn admit_procedure(
        &self,
        procedure: Procedure,
        confirmation: Confirmation,
        view: &View,
        now: Instant,
    ) -> Result<Work, ProcedureError> {
        let Some(books) = self.procedures.books() else {
            return Err(ProcedureError::NotBuilt);
        };
        if !books.activity.is_none() {
            return Err(ProcedureError::Busy);
        }
        if view.is_lost {
            return Err(ProcedureError::Lost);
        }
        if procedure.needs_confirmation() && confirmation == Confirmation::None {
            return Err(ProcedureError::Unconfirmed);
        }
        if let Some(command) = procedure.command() {
            command.function().admit_request(self.dialect.revision)?;
        }
        self.admit_wear(books, procedure.wear(), now)?;
        Ok(match (procedure.writes(), view.facts.latch) {
            (false, _) => Work::Read,
            (true, Latch::Own) => Work::Repair,
            (true, _) => Work::Write,
        })
    }

    /// Whether the way back from another mode may be written.
    pub(super) fn admit_way_back(&self, now: Instant) -> bool {
        let books = self.procedures.books();
        books.is_some_and(|books| self.admit_wear(books, 1, now).is_ok())
    }

    fn admit_wear(&self, books: &Books, wear: u16, now: Instant) -> Result<(), ProcedureError> {
        if wear == 0 {
            return Ok(());
        }
        let limits = books.wear;
        if self.counters.eeprom_writes.saturating_add(wear) > limits.budget {
            return Err(ProcedureError::WearBudget {
                budget: limits.budget,
            });
        }
        let interval_us = u64::from(limits.interval_us);
        let passed_us = books.wrote_at.map_or(interval_us, |at| now.us_since(at));
        match interval_us.saturating_sub(passed_us) {
            0 => Ok(()),
            wait_us => Err(ProcedureError::WearInterval { wait_us }),
        }
    }

    /// The controller accepted the command of the procedure.
    pub(super) fn note_command(
        &mut self,
        request: Request,
        timeouts: &Timeouts,
        now: Instant,
    ) -> Meaning<Fault> {
        let Some(books) = self.procedures.books_mut() else {
            return Meaning::NONE;
        };
        let Some(run) = books.activity.run_mut() else {
            return Meaning::NONE;
        };
        let quarantine_us = timeouts.reply_us;
        let wear = run.procedure().wear();
        run.sent(now);
        if wear != 0 {
            self.counters.eeprom_writes = self.counters.eeprom_writes.saturating_add(wear);
            books.wrote_at = Some(now);
        }
        let restarts = request == Request::DriveReset;
        if restarts {
            books.starts_until = Some(now + timeouts.power_on_us);
        }
        if let Some(kind) = request.reply_kind() {
            // What the drive answers to a reset is not stated, nor whether it does (D35): the answer is dropped.
            self.slot.ask(kind, now, quarantine_us);
            self.slot.close(now, quarantine_us);
        }
        Meaning {
            restarts,
            ..Meaning::NONE
        }
    }

    /// The controller gave the command of the procedure back unsent: nothing was written, and it is counted when it leaves.
    pub(super) fn command_returned(&mut self) {
        if let Some(run) = self.procedures.run_mut()
            && run.returned()
        {
            let wear = run.procedure().wear();
            self.counters.eeprom_writes = self.counters.eeprom_writes.saturating_sub(wear);
        }
    }

    /// Time passes. Returns whether the procedure ended.
    pub(super) fn tick_procedure(&mut self, log: &mut Log<'_>) -> bool {
        let now = log.now;
        let end = self.procedures.run_mut().and_then(|run| run.tick(now));
        self.finish(end, log)
    }

    /// A reply that the procedure may have waited for. Returns whether the procedure ended.
    pub(super) fn procedure_replied(
        &mut self,
        kind: ReplyKind,
        reply: Reply,
        log: &mut Log<'_>,
    ) -> bool {
        let waits = |run: &&mut Run| run.wanted_reading() == Some(kind);
        let end = self
            .procedures
            .run_mut()
            .filter(waits)
            .and_then(|run| run.replied(reply));
        self.finish(end, log)
    }

    /// The reply that the procedure waited for did not come, or does not decode. Returns whether the procedure ended.
    pub(super) fn procedure_missed(&mut self, kind: ReplyKind, log: &mut Log<'_>) -> bool {
        let waits = |run: &Run| run.wanted_reading() == Some(kind);
        let end = self
            .procedures
            .run()
            .is_some_and(waits)
            .then_some(ProcedureEnd::NoReply);
        self.finish(end, log)
    }

    /// A data error came: true when the command of the procedure explains it.
    pub(super) fn procedure_refused(&mut self, log: &mut Log<'_>) -> bool {
        let run = self.procedures.run();
        let explains = run.is_some_and(Run::explains_data_error);
        self.finish(explains.then_some(ProcedureEnd::Refused), log)
    }

    pub(super) fn abort_procedure(&mut self, log: &mut Log<'_>) {
        let end = self.procedures.run().map(|_| ProcedureEnd::Aborted);
        self.finish(end, log);
    }

    fn finish(&mut self, end: Option<ProcedureEnd>, log: &mut Log<'_>) -> bool {
        let Some(end) = end else { return false };
        self.procedures.end();
        #[cfg(feature = "procedures")]
        log.push(crate::servo::event::EventKind::Procedure(end));
        // Without them there is nothing that could end.
        #[cfg(not(feature = "procedures"))]
        let _ = (end, log);
        true
    }
}
