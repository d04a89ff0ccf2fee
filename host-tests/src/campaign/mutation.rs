//! Masters that are broken on purpose, from outside: production code has no hooks.

use std::collections::VecDeque;

use can_motion::{
    BusErrorKind, BusUser, GroupId, Instant, Outcome, Progress, ServoMaster, Sink, Timeouts,
};
use drive_sim::Frame;
use dyn_can::{DataFrame, DynFrame, FrameError, FunctionCode};
use embedded_can::nb::Can;

use super::scenario::MOST_AXES;

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
    /// A bus on which nothing gets through for seconds is no fault.
    BridgesOutages,
    /// The frame of a relative move goes out twice.
    RepeatsMoves,
    /// Where a move ends is told a little wrong.
    MissesEnds,
}

impl Mutation {
    /// Every broken master.
    pub const BROKEN: [Self; 9] = [
        Self::DropsDisplaced,
        Self::CountsOnWouldBlock,
        Self::BelievesLateReply,
        Self::AsksTogether,
        Self::ReplaysQueue,
        Self::ResumesAfterBusOff,
        Self::BridgesOutages,
        Self::RepeatsMoves,
        Self::MissesEnds,
    ];

    /// The timeouts of this master.
    pub(super) fn timeouts(self, drawn: Timeouts) -> Timeouts {
        match self {
            Self::BridgesOutages => Timeouts {
                stuck_us: 10_000_000,
                ..drawn
            },
            _ => drawn,
        }
    }
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
    pub(super) master: &'a mut ServoMaster<MOST_AXES>,
    pub(super) mutation: Mutation,
    pub(super) memory: &'a mut Memory,
    pub(super) reply_us: u64,
}

impl Mutant<'_> {
    /// The cycle is over: what could not be sent in it is queued instead of merged.
    pub(super) fn end_cycle(&mut self, now: Instant) {
        if self.mutation != Mutation::ReplaysQueue {
            return;
        }
        let queue = &mut self.memory.extra;
        let mut sink = |frame: &DataFrame| {
            if frame.function() != FunctionCode::GoRelativePosPd {
                return Outcome::Full;
            }
            queue.push_back(*frame);
            Outcome::Accepted
        };
        let _ = self.master.send(now, &mut sink);
    }

    /// What the mutation makes of a frame that the controller has just accepted; a late reply that it now believes.
    fn accepted(
        mutation: Mutation,
        memory: &mut Memory,
        now: Instant,
        frame: &DataFrame,
    ) -> Option<DataFrame> {
        if mutation == Mutation::RepeatsMoves && frame.function() == FunctionCode::GoRelativePosPtp
        {
            memory.extra.push_back(*frame);
        }
        if frame.function() != FunctionCode::GeneralRead {
            return None;
        }
        match mutation {
            Mutation::AsksTogether if frame.data() == [0x1B] => {
                let torque = DataFrame::new(frame.id(), &[0x1E]).expect("the same identifier");
                memory.extra.push_back(torque);
                None
            }
            Mutation::BelievesLateReply => {
                memory.asked_us.retain(|(id, _)| *id != frame.id());
                memory.asked_us.push((frame.id(), now.as_us()));
                let mut late = memory.late.iter();
                let place = late.position(|late| late.id() == frame.id())?;
                Some(memory.late.remove(place))
            }
            _ => None,
        }
    }

    /// The frame as the mutation lets it out.
    fn told(mutation: Mutation, frame: &DataFrame) -> DataFrame {
        let moves = frame.function() == FunctionCode::GoAbsolutePosSync;
        match (mutation, frame.data()) {
            (Mutation::MissesEnds, [rest @ .., last]) if moves => {
                let data = [rest, &[last ^ 1]].concat();
                DataFrame::new(frame.id(), &data).expect("as long as before")
            }
            _ => *frame,
        }
    }

    /// Offers what only the mutant wants.
    fn send_extra<S: Sink<DataFrame>>(&mut self, now: Instant, sink: &mut S) -> Progress {
        while let Some(frame) = self.memory.extra.front() {
            match sink.offer(frame) {
                Outcome::Full => return Progress::Blocked,
                Outcome::Displaced(displaced) => self.on_displaced(now, &displaced),
                Outcome::Accepted | Outcome::Failed(_) => {}
            }
            self.memory.extra.pop_front();
        }
        Progress::Idle
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
    type Frame = DataFrame;

    fn send<S: Sink<DataFrame>>(&mut self, now: Instant, sink: &mut S) -> Progress {
        loop {
            if self.send_extra(now, sink) == Progress::Blocked {
                return Progress::Blocked;
            }
            // One frame of the master at a time, because a mutation may have something to say behind each.
            let (mutation, memory) = (self.mutation, &mut *self.memory);
            let (mut offered, mut believed) = (false, None);
            let mut one = |frame: &DataFrame| {
                if offered {
                    return Outcome::Full;
                }
                let told = Self::told(mutation, frame);
                let outcome = sink.offer(&told);
                if matches!(outcome, Outcome::Accepted | Outcome::Displaced(_)) {
                    offered = true;
                    believed = Self::accepted(mutation, memory, now, frame);
                }
                match outcome {
                    Outcome::Displaced(_) if mutation == Mutation::DropsDisplaced => {
                        Outcome::Accepted
                    }
                    other => other,
                }
            };
            let progress = self.master.send(now, &mut one);
            if let Some(late) = believed {
                self.master.on_frame(now, &late);
            }
            if !offered {
                return progress;
            }
        }
    }

    fn on_displaced(&mut self, now: Instant, frame: &DataFrame) {
        if self.mutation != Mutation::DropsDisplaced {
            self.master.on_displaced(now, frame);
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
