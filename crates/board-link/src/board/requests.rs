//! What everybody may read.

use super::application::Application;
use super::link::Link;
use super::shared::Board;
use crate::message::{Answer, Counters, Request};
use crate::reason::Reason;
use crate::refused::Refused;
use crate::segment::Admission;

impl<const OUT: usize> Link<OUT> {
    /// Answers a request that reads.
    pub(super) fn read<A: Application, const AXES: usize>(
        &mut self,
        board: &mut Board<'_, A, AXES>,
        request: &Request,
        now: u64,
    ) -> Result<Answer, Refused> {
        match request {
            Request::Hello => Ok(board.info(now)),
            Request::TimeSync { host_us } => Ok(Answer::Time {
                host_us: *host_us,
                cycle: now,
            }),
            Request::ReadSettings { offset } => board.read_settings(*offset),
            Request::ReadFault { index } => board.fault(*index),
            Request::ReadCounters => Ok(Answer::Counters(self.counters(board))),
            Request::Snapshots { period } => {
                self.set_snapshots(*period, now);
                Ok(Answer::Done)
            }
            Request::Events { from } => {
                self.cursor = board.events.nearest(*from);
                Ok(Answer::Events {
                    oldest: board.events.oldest(),
                    next: board.events.next(),
                })
            }
            Request::ReadOrigin { axis } if A::HOMES => board.origin(*axis),
            // It was asked whether it reads; a board that never homes has no origins.
            _ => Err(Reason::Unsupported.plain()),
        }
    }

    /// What came in at this port, and what was lost.
    pub fn counters<A: Application, const AXES: usize>(
        &self,
        board: &mut Board<'_, A, AXES>,
    ) -> Counters {
        Counters {
            frames: self.decoder.frames(),
            losses: *self.decoder.losses(),
            segments: board.segments,
            silent_hosts: board.silent_hosts,
            late_cycles: board.app.machine().late_cycles,
            ..self.counters
        }
    }
}

impl<A: Application, const AXES: usize> Board<'_, A, AXES> {
    fn info(&self, now: u64) -> Answer {
        let mut info = self.app.info();
        let (axes, segments) = self.admission.as_ref().map_or((0, 0), |admission| {
            (admission.axes() as u8, admission.capacity() as u16)
        });
        (info.axes, info.segments, info.uptime) = (axes, segments, now);
        Answer::Info(info)
    }

    fn origin(&mut self, axis: u8) -> Result<Answer, Refused> {
        let axes = self.admission.as_ref().map_or(0, Admission::axes);
        if usize::from(axis) >= axes {
            return Err(Reason::NoEntry.because(axes as i64, axis.into()));
        }
        Ok(Answer::Origin(self.app.origin(axis.into())))
    }

    fn fault(&mut self, index: u32) -> Result<Answer, Refused> {
        let entry = self.app.fault(index);
        entry
            .map(Answer::Fault)
            .ok_or_else(|| Reason::NoEntry.because(self.app.info().faults.into(), index.into()))
    }
}
