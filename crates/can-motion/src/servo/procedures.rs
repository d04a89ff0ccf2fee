//! The one procedure that a servo may have under way.

use bus_user::Instant;
use dyn_can::{ParamGroup2, Reply, ReplyKind, Request};

use crate::core::facts::{Latch, Work};
use crate::core::family::{Meaning, View};
use crate::core::procedure::Confirmation;
use crate::servo::activity::Activity;
use crate::servo::config::Timeouts;
use crate::servo::drive::{Log, Servo};
use crate::servo::fault::Fault;
use crate::servo::own_move::OwnMove;
use crate::servo::procedure::{Procedure, ProcedureEnd, ProcedureError, Run, WearLimits};

/// What an axis keeps of its procedures; takes no room in a program without them.
#[derive(Debug)]
pub(super) struct Procedures {
    #[cfg(feature = "procedures")]
    books: Books,
}

#[derive(Debug)]
struct Books {
    activity: Activity,
    wear: WearLimits,
    /// Speed and acceleration of what the drive does by itself, as read since the checks began.
    curve: Option<ParamGroup2>,
    /// The same, as configured.
    given_curve: Option<ParamGroup2>,
    /// Kinds of trigger for which the drive was ever given a move: what it forgets is not documented (D57).
    loads: u8,
    wrote_at: Option<Instant>,
    /// The drive was told to start anew, and until when it does.
    starts_until: Option<Instant>,
}

impl Procedures {
    /// None has run.
    #[cfg_attr(
        not(feature = "procedures"),
        expect(unused_variables, reason = "as above")
    )]
    pub(super) const fn new(wear: WearLimits, given_curve: Option<ParamGroup2>) -> Self {
        Self {
            #[cfg(feature = "procedures")]
            books: Books {
                activity: Activity::None,
                wear,
                curve: None,
                given_curve,
                loads: 0,
                wrote_at: None,
                starts_until: None,
            },
        }
    }

    #[inline]
    const fn books(&self) -> Option<&Books> {
        #[cfg(feature = "procedures")]
        return Some(&self.books);
        #[cfg(not(feature = "procedures"))]
        None
    }

    #[inline]
    const fn books_mut(&mut self) -> Option<&mut Books> {
        #[cfg(feature = "procedures")]
        return Some(&mut self.books);
        #[cfg(not(feature = "procedures"))]
        None
    }

    /// The procedure under way.
    #[inline]
    pub(super) fn run(&self) -> Option<&Run> {
        self.books()?.activity.run()
    }

    fn run_mut(&mut self) -> Option<&mut Run> {
        self.books_mut()?.activity.run_mut()
    }

    /// Whether nothing is under way.
    #[inline]
    pub(super) fn is_idle(&self) -> bool {
        self.books().is_none_or(|books| books.activity.is_none())
    }

    /// The motion that the drive makes by itself.
    #[inline]
    pub(super) fn own(&self) -> Option<&OwnMove> {
        self.books()?.activity.own()
    }

    pub(super) fn own_mut(&mut self) -> Option<&mut OwnMove> {
        self.books_mut()?.activity.own_mut()
    }

    /// A motion that was admitted begins.
    pub(super) fn begin_own(&mut self, own: OwnMove) {
        if let Some(books) = self.books_mut() {
            books.activity = Activity::Own(own);
        }
    }

    /// Something else follows what was under way, or nothing.
    pub(super) fn follow(&mut self, activity: Activity) {
        if let Some(books) = self.books_mut() {
            books.activity = activity;
        }
    }

    /// Whether there is room for procedures and motions of the drive.
    pub(super) const fn are_built(&self) -> bool {
        self.books().is_some()
    }

    /// Speed and acceleration of what the drive does by itself.
    pub(super) fn curve(&self) -> Option<ParamGroup2> {
        let books = self.books()?;
        books.curve.or(books.given_curve)
    }

    /// The drive reported them, or what it reported does not count any more.
    pub(super) fn note_curve(&mut self, curve: Option<ParamGroup2>) {
        if let Some(books) = self.books_mut() {
            books.curve = curve;
        }
    }

    pub(super) fn loads(&self) -> u8 {
        self.books().map_or(0, |books| books.loads)
    }

    pub(super) fn note_load(&mut self, kind: u8) {
        if let Some(books) = self.books_mut() {
            books.loads |= kind;
        }
    }

    /// Until when a drive that was told to start anew does, once.
    pub(super) fn take_start(&mut self) -> Option<Instant> {
        self.books_mut()?.starts_until.take()
    }

    /// A procedure that was admitted begins.
    pub(super) fn begin(&mut self, procedure: Procedure) {
        if let Some(books) = self.books_mut() {
            books.activity = Activity::Procedure(Run::new(procedure));
        }
    }

    fn end(&mut self) {
        if let Some(books) = self.books_mut() {
            books.activity = Activity::None;
        }
    }
}

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

    /// The controller gave the command of the procedure back unsent.
    pub(super) fn command_returned(&mut self) {
        if let Some(run) = self.procedures.run_mut() {
            run.returned();
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
