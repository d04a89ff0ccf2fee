//! A procedure under way: what it waits for, and where a reply leads.

use bus_user::Instant;
use dyn_can::{Reply, ReplyKind, Request};

use super::{Procedure, ProcedureEnd};
use crate::core::facts::{Goal, Power};
use crate::core::family::View;

/// From a write to its read-back: the documents state 10 ms for a new drive id and nothing for parameters (D33).
const WRITE_SETTLE_US: u32 = 20_000;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Reading,
    Writing,
    Settling { until: Instant },
    ReadingBack,
}

/// A procedure under way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Run {
    procedure: Procedure,
    phase: Phase,
    /// The master itself leads the drive back to position mode.
    is_way_back: bool,
}

impl Run {
    pub(crate) const fn new(procedure: Procedure) -> Self {
        let phase = if procedure.reading().is_some() {
            Phase::Reading
        } else {
            Phase::Writing
        };
        Self {
            procedure,
            phase,
            is_way_back: false,
        }
    }

    /// A write that leads the drive back to position mode, when it has no power.
    pub(crate) const fn way_back(procedure: Procedure) -> Self {
        Self {
            is_way_back: true,
            ..Self::new(procedure)
        }
    }

    pub(crate) const fn is_way_back(&self) -> bool {
        self.is_way_back
    }

    /// Whether it is its turn: the way back waits until the drive is off for good.
    pub(crate) fn may_go_on(&self, view: &View) -> bool {
        let facts = &view.facts;
        !self.is_way_back || (facts.power == Power::Off && facts.goal == Goal::Off)
    }

    pub(crate) const fn procedure(&self) -> Procedure {
        self.procedure
    }

    pub(crate) const fn wanted_reading(&self) -> Option<ReplyKind> {
        match self.phase {
            Phase::Reading | Phase::ReadingBack => self.procedure.reading(),
            Phase::Writing | Phase::Settling { .. } => None,
        }
    }

    pub(crate) const fn wanted_command(&self) -> Option<Request> {
        match self.phase {
            Phase::Writing => self.procedure.command(),
            _ => None,
        }
    }

    /// The controller accepted the command.
    pub(crate) fn sent(&mut self, now: Instant) {
        self.phase = Phase::Settling {
            until: now + WRITE_SETTLE_US,
        };
    }

    /// The controller gave the command back unsent. Returns whether it had accepted it.
    pub(crate) fn returned(&mut self) -> bool {
        let was_sent = self.explains_data_error();
        self.phase = Phase::Writing;
        was_sent
    }

    /// Time passes; the end of a procedure without a reading.
    pub(crate) fn tick(&mut self, now: Instant) -> Option<ProcedureEnd> {
        let is_settled = matches!(self.phase, Phase::Settling { until } if now >= until);
        if !is_settled {
            return None;
        }
        self.phase = Phase::ReadingBack;
        let is_blind = self.procedure.reading().is_none();
        is_blind.then_some(ProcedureEnd::Sent)
    }

    pub(crate) fn replied(&mut self, reply: Reply) -> Option<ProcedureEnd> {
        match self.phase {
            Phase::Reading if !self.procedure.writes() => Some(ProcedureEnd::Read(reply)),
            Phase::Reading if self.procedure.is_in(&reply) => Some(ProcedureEnd::Unchanged),
            Phase::Reading => {
                self.phase = Phase::Writing;
                None
            }
            Phase::ReadingBack if self.procedure.is_in(&reply) => Some(ProcedureEnd::Written),
            Phase::ReadingBack => Some(ProcedureEnd::NotTaken(reply)),
            Phase::Writing | Phase::Settling { .. } => None,
        }
    }

    /// True while a data error can only mean the command of this procedure.
    pub(crate) const fn explains_data_error(&self) -> bool {
        matches!(self.phase, Phase::Settling { .. } | Phase::ReadingBack)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dyn_can::{MaxAcceleration, MaxSpeed, ParamGroup2, SetParamGroup2};

    fn speed(value: i32) -> Procedure {
        Procedure::WriteGroup2(SetParamGroup2 {
            max_speed: MaxSpeed::new(value).ok(),
            max_acceleration: None,
        })
    }

    fn present(value: i32) -> Reply {
        Reply::ParamGroup2(ParamGroup2 {
            max_speed: MaxSpeed::new(value).unwrap(),
            max_acceleration: MaxAcceleration::MAX,
        })
    }

    #[test]
    fn what_is_there_already_is_not_written() {
        let mut run = Run::new(speed(40));
        assert_eq!(run.wanted_reading(), Some(ReplyKind::ParamGroup2));
        assert_eq!(run.wanted_command(), None);
        assert_eq!(run.replied(present(40)), Some(ProcedureEnd::Unchanged));
    }

    #[test]
    fn a_write_is_read_back() {
        let at = Instant::from_us;
        let mut run = Run::new(speed(40));
        assert_eq!(run.replied(present(30)), None);
        assert!(matches!(
            run.wanted_command(),
            Some(Request::SetParamGroup2(_))
        ));
        run.sent(at(0));
        assert_eq!((run.wanted_command(), run.wanted_reading()), (None, None));
        assert!(run.returned());
        assert!(run.wanted_command().is_some());
        assert!(!run.returned(), "it has left once");
        run.sent(at(1_000));
        assert!(run.explains_data_error());
        assert_eq!(run.tick(at(20_999)), None);
        assert_eq!(run.wanted_reading(), None);
        assert_eq!(run.tick(at(21_000)), None);
        assert_eq!(run.wanted_reading(), Some(ReplyKind::ParamGroup2));
        let mut other = run;
        assert_eq!(
            other.replied(present(30)),
            Some(ProcedureEnd::NotTaken(present(30)))
        );
        assert_eq!(run.replied(present(40)), Some(ProcedureEnd::Written));
    }
}
