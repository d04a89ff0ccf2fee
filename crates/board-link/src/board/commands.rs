//! Who commands, and what a command does.

use trajectory::Position;

use super::application::{Application, Command};
use super::shared::{Board, Session};
use crate::message::{Answer, BoardState, Event, Request};
use crate::reason::Reason;
use crate::refused::Refused;
use crate::segment::{Begin, OfAxes, Segment};

/// What becomes of a command.
pub(super) enum Outcome {
    /// It is done, or refused.
    Answered(Result<Answer, Refused>),
    /// The application has this ticket.
    Posted(u16),
}

impl<'q, A: Application, const AXES: usize> Board<'q, A, AXES> {
    /// A session that does not command is refused.
    pub(super) fn check_session(&mut self, number: u32, now: u64) -> Result<(), Refused> {
        match &mut self.session {
            Some(session) if session.number == number => {
                session.latest = session.latest.max(now);
                Ok(())
            }
            Some(session) => Err(Reason::Taken.because(session.number.into(), number.into())),
            None => Err(Reason::NoSession.because(0, number.into())),
        }
    }

    /// Carries out a command of a session.
    pub(super) fn command(&mut self, session: u32, request: &Request, now: u64) -> Outcome {
        let answer = match request {
            Request::Stop => return self.stop_for_host(),
            Request::Halt => return self.post(Command::Halt, false),
            Request::Claim => self.claim(session, now),
            _ => match self.check_session(session, now) {
                Ok(()) => return self.command_of_owner(request, now),
                Err(refused) => Err(refused),
            },
        };
        Outcome::Answered(answer)
    }

    fn claim(&mut self, number: u32, now: u64) -> Result<Answer, Refused> {
        if number == 0 {
            return Err(Reason::NoSession.because(1, 0));
        }
        match self.check_session(number, now) {
            Err(refused) if refused.is(Reason::Taken) => return Err(refused),
            Err(_) => {
                self.session = Some(Session {
                    number,
                    latest: now,
                });
                self.events.add(Event::Claimed { session: number });
            }
            Ok(()) => {}
        }
        Ok(Answer::Claimed {
            silence: self.config.silence,
            events: self.events.next(),
        })
    }

    fn command_of_owner(&mut self, request: &Request, now: u64) -> Outcome {
        let answer = match request {
            Request::Enable => return self.post(Command::Enable, true),
            // Never held up by a command that is under way: it may be the one that switches the drives on.
            Request::Disable => return self.post(Command::Disable, false),
            Request::Clear => return self.post(Command::Clear, true),
            Request::Home => match self.check_standing() {
                Ok(()) => return self.post(Command::Home, true),
                Err(refused) => Err(refused),
            },
            Request::CommitSettings { length, checksum } => {
                match self.check_settings(*length, *checksum) {
                    Ok(()) => {
                        let length = *length;
                        return self.post(Command::SaveSettings { length }, true);
                    }
                    Err(refused) => Err(refused),
                }
            }
            Request::Release => self.release(),
            Request::Heartbeat => Ok(self.alive()),
            Request::Begin(begin) => self.begin(begin, now).map(|()| Answer::Done),
            Request::Segment {
                stream,
                index,
                segment,
            } => self.segment(*stream, *index, segment),
            Request::End { .. } | Request::Pause | Request::Resume | Request::Override { .. } => {
                self.order(request)
            }
            Request::WriteSettings { offset, bytes } => self.write_settings(*offset, bytes),
            Request::CheckSettings { length, checksum } => self
                .check_settings(*length, *checksum)
                .map(|()| Answer::Done),
            // What reads and what stops is done elsewhere.
            _ => Err(Reason::Unsupported.plain()),
        };
        Outcome::Answered(answer)
    }

    fn alive(&self) -> Answer {
        let admission = self.admission.as_ref();
        let (next, credit) = admission.map_or((0, 0), |admission| {
            (admission.next_index(), admission.credit())
        });
        Answer::Alive {
            events: self.events.next(),
            next,
            credit,
        }
    }

    /// Whether no stream moves the axes, or will.
    fn check_standing(&self) -> Result<(), Refused> {
        let admission = self.admission.as_ref();
        match admission.filter(|admission| A::HOMES && admission.player().phase.is_active()) {
            Some(admission) => Err(Reason::Moving.because(admission.stream().into(), 0)),
            None => Ok(()),
        }
    }

    fn release(&mut self) -> Result<Answer, Refused> {
        if let Some(admission) = &mut self.admission
            && admission.player().phase.is_active()
        {
            admission.stop()?;
        }
        // It may be a homing.
        self.owes_stop |= A::HOMES && self.busy.is_some();
        if let Some(session) = self.session.take() {
            let session = session.number;
            self.events.add(Event::Released { session });
        }
        Ok(Answer::Done)
    }

    /// An order to the stream.
    fn order(&mut self, request: &Request) -> Result<Answer, Refused> {
        let admission = self.admission.as_mut().ok_or(NO_SETTINGS)?;
        match request {
            Request::End { stream } => admission.end(*stream),
            Request::Pause => admission.pause(),
            Request::Resume => admission.resume(),
            Request::Override { percent } => admission.set_override(*percent),
            _ => Err(Reason::Unsupported.plain()),
        }
        .map(|()| Answer::Done)
    }

    fn begin(&mut self, begin: &Begin, now: u64) -> Result<(), Refused> {
        let machine = self.app.machine();
        let (enabled, state) = (BoardState::Enabled as i64, machine.state as i64);
        let mut axes = machine.axes.iter().enumerate();
        let faulted = axes.find(|(_, axis)| axis.fault != 0);
        match (machine.state, faulted) {
            (BoardState::Enabled, _) => {}
            (BoardState::StopOpen, _) => return Err(Reason::StopInput.plain()),
            (BoardState::EnableInactive, _) => return Err(Reason::EnableInput.plain()),
            (BoardState::Locked, _) => return Err(Reason::Locked.plain()),
            (BoardState::Faulted, Some((axis, of))) => {
                return Err(Reason::Faulted.at(axis, 0, of.fault.into()));
            }
            (BoardState::Faulted, None) => return Err(Reason::Faulted.because(enabled, state)),
            _ => return Err(Reason::NotEnabled.because(enabled, state)),
        }
        let stand = machine.axes.iter();
        let stand: OfAxes<Position> = stand
            .map(|axis| Position::from_counts(axis.target))
            .collect();
        let admission = self.admission.as_mut().ok_or(NO_SETTINGS)?;
        if A::HOMES {
            for axis in 0..admission.axes() {
                admission.set_origin(axis, self.app.origin(axis))?;
            }
            // It may be a homing that the cycle has not taken yet: a stop would find the stream, and not the homing.
            if let Some(ticket) = self.busy {
                return Err(Reason::Busy.because(0, ticket.into()));
            }
        }
        admission.begin(begin, &stand, now)
    }

    fn segment(&mut self, stream: u32, index: u32, segment: &Segment) -> Result<Answer, Refused> {
        let admission = self.admission.as_mut().ok_or(NO_SETTINGS)?;
        let is_there = stream == admission.stream() && index < admission.next_index();
        if !is_there {
            admission.push(stream, index, segment)?;
            self.segments = self.segments.saturating_add(1);
        }
        Ok(Answer::Taken {
            next: admission.next_index(),
            credit: admission.credit(),
        })
    }

    fn stop_for_host(&mut self) -> Outcome {
        let ticket = self.next_ticket();
        match self.stop(ticket) {
            Ok(true) => Outcome::Posted(ticket),
            Ok(false) => Outcome::Answered(Ok(Answer::Done)),
            Err(refused) => Outcome::Answered(Err(refused)),
        }
    }

    /// One command at a time, but for those that stop.
    fn post(&mut self, command: Command, is_alone: bool) -> Outcome {
        if is_alone && let Err(refused) = self.check_free() {
            return Outcome::Answered(Err(refused));
        }
        let ticket = self.next_ticket();
        match self.app.post(ticket, command) {
            Ok(()) => {
                if is_alone {
                    self.busy = Some(ticket);
                }
                self.is_storing |= matches!(command, Command::SaveSettings { .. });
                Outcome::Posted(ticket)
            }
            Err(refused) => Outcome::Answered(Err(refused)),
        }
    }
}

const NO_SETTINGS: Refused =
    Reason::NotReady.because(BoardState::Enabled as i64, BoardState::NoSettings as i64);
