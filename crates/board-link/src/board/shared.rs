//! What the ports of a board share.

use super::application::{Application, Command};
use super::events::Events;
use super::slots::Slots;
use crate::message::{Event, Snapshot};
use crate::reason::Reason;
use crate::refused::Refused;
use crate::segment::{Admission, StreamPhase};

/// Results that no port has fetched yet.
const RESULTS: usize = 8;
/// The ticket of a command for which nobody waits.
const NOBODY: u16 = 0;

/// How a board watches its hosts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoardConfig {
    /// So many cycles without a request of the session that commands are a silent host: the axes stop, and nobody commands.
    pub silence: u32,
    /// So many cycles the application may take for a command.
    pub patience: u32,
}

impl BoardConfig {
    /// Half a second of silence, ten seconds of patience, with this many cycles in a second.
    #[must_use]
    pub const fn with_cycles_per_second(cycles: u32) -> Self {
        Self {
            silence: cycles / 2,
            patience: cycles.saturating_mul(10),
        }
    }
}

/// The session that commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Session {
    pub(super) number: u32,
    /// The cycle of its latest request.
    pub(super) latest: u64,
}

/// What the ports of a board share: who commands, what was admitted, what has happened.
pub struct Board<'q, A, const AXES: usize> {
    pub(super) app: A,
    /// None without settings.
    pub(super) admission: Option<Admission<'q, AXES>>,
    pub(super) config: BoardConfig,
    pub(super) session: Option<Session>,
    pub(super) events: Events,
    /// Bytes of new settings that are there.
    pub(super) staged: u32,
    /// A command that is carried out, other than to stop.
    pub(super) busy: Option<u16>,
    pub(super) segments: u32,
    pub(super) silent_hosts: u32,
    results: Slots<(u16, Result<(), Refused>), RESULTS>,
    last_ticket: u16,
    /// A silent host was a stop, or one that gave the command back, and the application has had no room for it yet.
    pub(super) owes_stop: bool,
    /// Settings are stored: the board may stand still meanwhile, and does not hold it against the host.
    pub(super) is_storing: bool,
    reported: (u32, StreamPhase),
}

impl<'q, A: Application, const AXES: usize> Board<'q, A, AXES> {
    /// After a start: nobody commands. Without an admission the board answers and moves nothing.
    pub fn new(app: A, admission: Option<Admission<'q, AXES>>, config: BoardConfig) -> Self {
        Self {
            app,
            admission,
            config,
            session: None,
            events: Events::new(),
            staged: 0,
            busy: None,
            segments: 0,
            silent_hosts: 0,
            results: Slots::new(),
            last_ticket: NOBODY,
            owes_stop: false,
            is_storing: false,
            reported: (0, StreamPhase::Idle),
        }
    }

    /// The application.
    pub const fn application(&mut self) -> &mut A {
        &mut self.app
    }

    /// The session that commands.
    #[must_use]
    pub fn session(&self) -> Option<u32> {
        self.session.map(|session| session.number)
    }

    /// How everything is.
    pub fn snapshot(&mut self, now: u64) -> Snapshot {
        let machine = self.app.machine();
        let mut snapshot = Snapshot {
            cycle: now,
            state: machine.state,
            events: self.events.next(),
            axes: machine.axes,
            ..Snapshot::default()
        };
        if let Some(admission) = &self.admission {
            snapshot.stream = admission.stream();
            snapshot.player = admission.player();
            snapshot.next_segment = admission.next_index();
            snapshot.credit = admission.credit();
        }
        snapshot
    }

    /// Takes what the application has to say, and watches the host. [`Link::poll`](super::Link::poll) does it too.
    pub fn poll(&mut self, now: u64) {
        if self.is_storing {
            // The first look after it is the last one with another time.
            self.is_storing = self.busy.is_some();
            if let Some(session) = &mut self.session {
                session.latest = session.latest.max(now);
            }
        }
        while let Some((ticket, result)) = self.app.result() {
            self.keep_result(ticket, result);
        }
        while let Some(event) = self.app.event() {
            self.events.add(event);
        }
        self.report_stream();
        self.watch_host(now);
    }

    fn keep_result(&mut self, ticket: u16, result: Result<(), Refused>) {
        if self.busy == Some(ticket) {
            self.busy = None;
        }
        if ticket == NOBODY {
            return;
        }
        if !self.results.put((ticket, result)) {
            // Its port has not fetched the oldest, and says that there was no answer.
            let age = |of: &(u16, _)| self.last_ticket.wrapping_sub(of.0);
            let oldest = self.results.iter().map(age).max();
            let last = self.last_ticket;
            self.results
                .take(|of| Some(last.wrapping_sub(of.0)) == oldest);
            self.results.put((ticket, result));
        }
    }

    fn report_stream(&mut self) {
        let Some(admission) = &self.admission else {
            return;
        };
        let (stream, player) = (admission.stream(), admission.player());
        if self.reported != (stream, player.phase) {
            self.reported = (stream, player.phase);
            self.events.add(Event::Stream {
                stream,
                phase: player.phase,
                finished: player.finished,
            });
        }
    }

    fn watch_host(&mut self, now: u64) {
        let silence = u64::from(self.config.silence);
        if let Some(session) = self.session
            && now.saturating_sub(session.latest) > silence
        {
            self.session = None;
            self.owes_stop = true;
            self.silent_hosts = self.silent_hosts.saturating_add(1);
            let session = session.number;
            self.events.add(Event::SilentHost { session });
        }
        if self.owes_stop {
            self.owes_stop = self.stop(NOBODY).is_err();
        }
    }

    /// Slows down along the path: a stream by its player, which is done at once, anything else by the application. Whether the application has
    /// the ticket.
    pub(super) fn stop(&mut self, ticket: u16) -> Result<bool, Refused> {
        if let Some(admission) = &mut self.admission
            && admission.player().phase.is_active()
        {
            admission.stop()?;
            return Ok(false);
        }
        self.app.post(ticket, Command::Stop)?;
        Ok(true)
    }

    pub(super) fn next_ticket(&mut self) -> u16 {
        self.last_ticket = self.last_ticket.checked_add(1).unwrap_or(NOBODY + 1);
        self.last_ticket
    }

    /// The result of a ticket, once.
    pub(super) fn take_result(&mut self, ticket: u16) -> Option<Result<(), Refused>> {
        let found = self.results.take(|result| result.0 == ticket);
        found.map(|(_, result)| result)
    }

    /// Whether no command is carried out.
    pub(super) fn check_free(&self) -> Result<(), Refused> {
        match self.busy {
            Some(ticket) => Err(Reason::Busy.because(0, ticket.into())),
            None => Ok(()),
        }
    }
}
