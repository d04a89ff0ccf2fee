//! Masters that are broken on purpose, from outside: production code has no hooks.

use std::collections::VecDeque;

use can_motion::{BusErrorKind, BusUser, GroupId, Instant, Master};
use drive_sim::Frame;
use dyn_can::{DataFrame, DynFrame, FrameError, FunctionCode};
use embedded_can::nb::Can;

use super::generate::MOST_AXES;

/// How the master is broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mutation {
    /// Not at all.
    None,
    /// A frame that the controller gives back is forgotten.
    DropsDisplaced,
    /// A set-point that found no room is counted as sent.
    CountsOnWouldBlock,
    /// A reply that came too late is taken for the answer to the next request.
    BelievesLateReply,
    /// Torque is asked right behind position.
    AsksTogether,
    /// Set-points that could not be sent are queued and replayed.
    ReplaysQueue,
    /// After bus-off the axes are cleared and enabled again by themselves.
    ResumesAfterBusOff,
}

impl Mutation {
    /// Every broken master.
    pub const BROKEN: [Self; 6] = [
        Self::DropsDisplaced,
        Self::CountsOnWouldBlock,
        Self::BelievesLateReply,
        Self::AsksTogether,
        Self::ReplaysQueue,
        Self::ResumesAfterBusOff,
    ];
}

/// What a mutant remembers from call to call.
#[derive(Debug, Default)]
pub(super) struct Memory {
    /// When each drive was last asked for a position or torque.
    asked_us: Vec<(u16, u64)>,
    late: Vec<DataFrame>,
    extra: VecDeque<DataFrame>,
    has_recovered: bool,
}

/// A master under a mutation.
pub(super) struct Mutant<'a> {
    pub(super) master: &'a mut Master<MOST_AXES>,
    pub(super) mutation: Mutation,
    pub(super) memory: &'a mut Memory,
    pub(super) reply_us: u64,
}

/// A frame of the master, or one that only the mutant wants.
pub(super) enum Wanted {
    Real(can_motion::Outgoing),
    Extra(DataFrame),
}

impl AsRef<DataFrame> for Wanted {
    fn as_ref(&self) -> &DataFrame {
        match self {
            Self::Real(outgoing) => outgoing.as_ref(),
            Self::Extra(frame) => frame,
        }
    }
}

impl Mutant<'_> {
    /// The cycle is over: what could not be sent in it is queued instead of merged.
    pub(super) fn end_cycle(&mut self, now: Instant) {
        if self.mutation != Mutation::ReplaysQueue {
            return;
        }
        while let Some(outgoing) = self.master.next_frame() {
            if outgoing.as_ref().function() != FunctionCode::GoRelativePosPd {
                break;
            }
            self.memory.extra.push_back(*outgoing.as_ref());
            self.master.on_accepted(now, &outgoing);
        }
    }

    /// The controller takes part in the bus again.
    pub(super) fn recovered(&mut self, now: Instant) {
        self.master.on_bus_recovered(now);
        self.memory.has_recovered = true;
    }

    /// A cycle begins.
    pub(super) fn begin_cycle(&mut self, now: Instant) {
        if self.mutation == Mutation::ResumesAfterBusOff && self.memory.has_recovered {
            for group in [GroupId(0), GroupId(1)] {
                let _ = self.master.clear(now, group);
                let _ = self.master.enable(now, group);
            }
        }
        self.master.begin_cycle(now);
    }
}

impl BusUser for Mutant<'_> {
    type Outgoing = Wanted;
    type Frame = DataFrame;

    fn next_frame(&self) -> Option<Wanted> {
        let extra = self.memory.extra.front().copied().map(Wanted::Extra);
        extra.or_else(|| self.master.next_frame().map(Wanted::Real))
    }

    fn on_accepted(&mut self, now: Instant, outgoing: &Wanted) {
        let Wanted::Real(outgoing) = outgoing else {
            self.memory.extra.pop_front();
            return;
        };
        self.master.on_accepted(now, outgoing);
        let frame = outgoing.as_ref();
        if frame.function() != FunctionCode::GeneralRead {
            return;
        }
        match self.mutation {
            Mutation::AsksTogether if frame.data() == [0x1B] => {
                let torque = DataFrame::new(frame.id(), &[0x1E]).expect("the same identifier");
                self.memory.extra.push_back(torque);
            }
            Mutation::BelievesLateReply => {
                self.memory.asked_us.retain(|(id, _)| *id != frame.id());
                self.memory.asked_us.push((frame.id(), now.as_us()));
                if let Some(place) = self
                    .memory
                    .late
                    .iter()
                    .position(|late| late.id() == frame.id())
                {
                    let late = self.memory.late.remove(place);
                    self.master.on_frame(now, &late);
                }
            }
            _ => {}
        }
    }

    fn on_displaced(&mut self, now: Instant, frame: &DataFrame) {
        if self.mutation != Mutation::DropsDisplaced {
            self.master.on_displaced(now, frame);
        }
    }

    fn on_transmit_error(&mut self, now: Instant, outgoing: &Wanted, kind: BusErrorKind) {
        if let Wanted::Real(outgoing) = outgoing {
            self.master.on_transmit_error(now, outgoing, kind);
        }
    }

    fn on_receive_error(&mut self, now: Instant, kind: BusErrorKind) {
        self.master.on_receive_error(now, kind);
    }

    fn on_frame(&mut self, now: Instant, frame: &DataFrame) {
        let is_late = |&(id, asked_us): &(u16, u64)| {
            id == frame.id() && now.as_us() > asked_us + self.reply_us
        };
        if self.mutation == Mutation::BelievesLateReply && self.memory.asked_us.iter().any(is_late)
        {
            self.memory.late.push(*frame);
        }
        self.master.on_frame(now, frame);
    }

    fn on_foreign_frame(&mut self, now: Instant, error: FrameError) {
        self.master.on_foreign_frame(now, error);
    }
}

/// A controller that loses set-points without a word when it has no room.
pub(super) struct Leaky<C> {
    pub(super) inner: C,
    pub(super) leaks: bool,
}

impl<C: Can<Frame = Frame>> Can for Leaky<C> {
    type Frame = Frame;
    type Error = C::Error;

    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, C::Error> {
        let outcome = self.inner.transmit(frame);
        let is_set_point = DataFrame::from_can(frame)
            .is_ok_and(|frame| frame.function() == FunctionCode::GoRelativePosPd);
        match outcome {
            Err(nb::Error::WouldBlock) if self.leaks && is_set_point => Ok(None),
            other => other,
        }
    }

    fn receive(&mut self) -> nb::Result<Frame, C::Error> {
        self.inner.receive()
    }
}
