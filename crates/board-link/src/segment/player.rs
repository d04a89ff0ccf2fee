//! The half of the cycle: where the axes are in each cycle, along what was admitted and nothing else.

use core::sync::atomic::Ordering;

use trajectory::curve::Share;
use trajectory::{Position, Time};

use super::cruise::Cruise;
use super::halves::Receiver;
use super::phase::StreamPhase;
use super::queue::{Admitted, Order, Shared, Start, Status, Tail};
use super::quick::Quick;
use crate::config::WhenDry;
use crate::rate::Rate;

/// Plays what the [`Admission`](super::Admission) has admitted. A cycle takes the orders that have come, one square root at most, and the
/// value of one polynomial an axis.
pub struct Player<'q, const AXES: usize> {
    pub(super) segments: Receiver<'q, Admitted<AXES>>,
    orders: Receiver<'q, Order<AXES>>,
    pub(super) shared: &'q Shared,
    axes: usize,
    lead: Time,
    pub(super) start: Start<AXES>,
    phase: StreamPhase,
    /// Where the axes are between segments.
    stand: [Position; AXES],
    /// Since the start of the stream.
    pub(super) time: Time,
    pub(super) rate: Rate,
    pub(super) is_paused: bool,
    pub(super) is_stopping: bool,
    pub(super) is_ended: bool,
    /// It slows down, because there may be nothing more than this.
    pub(super) short_of: Option<Tail>,
    finished: u32,
    /// The way down from a steady rate to a floor, as it was worked out last.
    pub(super) way_down: (u32, i64, f32),
    pub(super) quick: Quick<AXES>,
    pub(super) cruise: Cruise,
}

impl<'q, const AXES: usize> Player<'q, AXES> {
    pub(super) fn new(
        segments: Receiver<'q, Admitted<AXES>>,
        orders: Receiver<'q, Order<AXES>>,
        shared: &'q Shared,
        axes: usize,
        rate: Rate,
        lead: Time,
    ) -> Self {
        Self {
            segments,
            orders,
            shared,
            axes,
            lead,
            start: Start {
                generation: shared.status().generation,
                at: 0,
                when_dry: WhenDry::End,
                override_rate: 0,
                from: [Position::ZERO; AXES],
            },
            phase: StreamPhase::Idle,
            stand: [Position::ZERO; AXES],
            time: Time::ZERO,
            rate,
            is_paused: false,
            is_stopping: false,
            is_ended: false,
            short_of: None,
            finished: 0,
            way_down: (0, -1, 0.0),
            quick: Quick::new(),
            cruise: Cruise::NONE,
        }
    }

    /// What becomes of the stream.
    #[must_use]
    pub const fn phase(&self) -> StreamPhase {
        self.phase
    }

    /// The cycle `now`. `stand` is where the set-points of the axes stand, for the start; whether `out` has the set-points of this cycle:
    /// as long as the stream is under way, and in the cycle in which it ends. Otherwise nothing is written.
    pub fn advance(&mut self, now: u64, stand: &[Position], out: &mut [Position]) -> bool {
        let has_set_points = self.step(now, stand);
        if has_set_points {
            self.write(out);
        }
        self.close(has_set_points)
    }

    /// The same in whole counts, rounded as [`Position::counts`] does it, for less.
    #[inline]
    pub fn advance_counts(&mut self, now: u64, stand: &[Position], out: &mut [i32]) -> bool {
        let axes = out.len().min(self.axes);
        let Some(out) = out.get_mut(..axes) else {
            return false;
        };
        self.cruise(out) || self.advance_anew(now, stand, out)
    }

    #[inline(never)]
    fn advance_anew(&mut self, now: u64, stand: &[Position], out: &mut [i32]) -> bool {
        // Before everything else: what changes in between is looked at in the next cycle.
        let changes = self.shared.changes();
        let has_set_points = self.step(now, stand);
        if has_set_points {
            self.write_counts(out);
        }
        let has_set_points = self.close(has_set_points);
        self.cruise = self.next_cruise(changes);
        has_set_points
    }

    /// Whether there are set-points.
    fn step(&mut self, now: u64, stand: &[Position]) -> bool {
        self.cruise = Cruise::NONE;
        self.obey();
        let before = self.phase;
        match self.phase {
            StreamPhase::Waiting => self.begin(now, stand),
            StreamPhase::Dry => self.go_on_after_dry(),
            _ => {}
        }
        if before == StreamPhase::Moving {
            self.go_on();
        }
        matches!(self.phase, StreamPhase::Moving | StreamPhase::Dry)
            || matches!(before, StreamPhase::Moving | StreamPhase::Dry)
    }

    fn close(&mut self, has_set_points: bool) -> bool {
        if !self.phase.is_active() {
            self.drop_old();
        }
        self.publish();
        has_set_points
    }

    /// Ends the stream at once, whatever it does, and whatever was ordered and has not begun: for an application whose axes do not follow.
    /// To be called in every cycle in which they do not, so that nothing of before moves them when they follow again.
    pub fn halt(&mut self) {
        self.cruise = Cruise::NONE;
        self.obey();
        if self.phase.is_active() {
            self.rate.stand();
            self.phase = StreamPhase::Stopped;
        }
        self.drop_old();
        self.publish();
    }

    fn obey(&mut self) {
        while let Some(order) = self.orders.receive() {
            match order {
                Order::Begin(start) => self.take_on(start),
                Order::End => self.is_ended = true,
                Order::Pause => self.is_paused = true,
                Order::Resume => self.is_paused = false,
                Order::Override(rate) => self.start.override_rate = rate,
                Order::Stop => self.is_stopping = true,
            }
        }
    }

    fn take_on(&mut self, start: Start<AXES>) {
        self.stand = start.from;
        self.start = start;
        self.phase = StreamPhase::Waiting;
        self.time = Time::ZERO;
        self.rate.stand();
        (self.is_paused, self.is_stopping, self.is_ended) = (false, false, false);
        self.short_of = None;
        self.finished = 0;
        self.quick.forget();
        self.drop_old();
    }

    /// Segments of streams that have ended, or were never played.
    fn drop_old(&mut self) {
        let (present, is_active) = (self.start.generation, self.phase.is_active());
        let is_old = |head: &Admitted<AXES>| {
            // A later one belongs to a stream whose begin has not been taken yet.
            let ahead = head.generation.wrapping_sub(present) as i16;
            ahead < 0 || (ahead == 0 && !is_active)
        };
        while self.segments.peek().is_some_and(is_old) {
            self.segments.receive();
        }
    }

    fn begin(&mut self, now: u64, stand: &[Position]) {
        if self.is_stopping {
            return self.finish(StreamPhase::Stopped);
        }
        if now < self.start.at || !self.has_lead() {
            return;
        }
        if self.segments.peek().is_none() {
            if self.is_ended {
                self.finish(StreamPhase::Complete);
            }
            return;
        }
        let from = self.start.from.iter().take(self.axes);
        let is_there = stand.len() == self.axes
            && from
                .zip(stand)
                .all(|(from, stand)| from.wide_counts() == stand.wide_counts());
        if !is_there {
            return self.finish(StreamPhase::Displaced);
        }
        self.phase = StreamPhase::Moving;
        // At rest the rate has no meaning: it is at once what it shall be, if what is buffered suffices to come down from it.
        let at_once = self.rate.running_at(self.goal_of_orders());
        let tail = self.shared.tail();
        if self.is_ended || at_once.way_down_after_a_rise_to(tail.floor()) + 1.0 < self.left(tail) {
            self.rate = at_once;
        }
    }

    /// Whether enough is buffered to move, or more cannot be waited for.
    fn has_lead(&self) -> bool {
        let tail = self.shared.tail();
        let buffered = Time::from_cycles(tail.cycles).since(self.time);
        let is_full = self.segments.is_full();
        buffered >= self.lead || self.is_ended || is_full
    }

    fn go_on_after_dry(&mut self) {
        if self.is_stopping {
            self.finish(StreamPhase::Stopped);
        } else if self.is_ended && self.segments.peek().is_none() {
            self.finish(StreamPhase::Complete);
        } else if self.short_of != Some(self.shared.tail()) && self.has_lead() {
            self.phase = StreamPhase::Moving;
        }
    }

    fn go_on(&mut self) {
        // Before the look for segments: one that comes in between is more than this end.
        let tail = self.shared.tail();
        let goal = self.goal();
        self.time = self.time.after(self.rate.advance(goal));
        while let Some(head) = self.segments.peek()
            && head.end <= self.time
        {
            if self.segments.len() == 1 {
                let end = Share::of(1, 1);
                self.stand = head.pieces.map(|piece| piece.at(end));
                self.time = head.end;
            }
            self.segments.receive();
            self.finished = self.finished.wrapping_add(1);
        }
        if self.segments.peek().is_none() {
            self.arrive(tail);
        } else if self.rate.is_standing() {
            self.rest();
        }
    }

    /// At the end of all that was admitted.
    fn arrive(&mut self, tail: Tail) {
        // Every axis is at rest here, whatever the rate.
        self.rate.stand();
        self.short_of = Some(tail);
        if self.is_stopping {
            self.finish(StreamPhase::Stopped);
        } else if self.is_ended {
            self.finish(StreamPhase::Complete);
        } else {
            self.run_dry();
        }
    }

    /// At rest on the way.
    fn rest(&mut self) {
        if self.is_stopping {
            self.finish(StreamPhase::Stopped);
        } else if self.goal_of_orders() != 0 && self.short_of.is_some_and(|tail| !tail.rests) {
            self.run_dry();
        }
    }

    fn run_dry(&mut self) {
        match self.start.when_dry {
            WhenDry::Wait => self.phase = StreamPhase::Dry,
            WhenDry::End => self.finish(StreamPhase::DriedUp),
        }
    }

    /// Ends the stream where the axes are.
    fn finish(&mut self, phase: StreamPhase) {
        let mut stand = self.stand;
        self.write(&mut stand);
        self.stand = stand;
        self.phase = phase;
    }

    fn write(&self, out: &mut [Position]) {
        let is_on_the_way = matches!(self.phase, StreamPhase::Moving | StreamPhase::Dry);
        let Some(head) = self.segments.peek().filter(|_| is_on_the_way) else {
            let stand = self.stand.iter().take(self.axes);
            out.iter_mut().zip(stand).for_each(|(out, at)| *out = *at);
            return;
        };
        let share = Share::of(
            self.time.since(head.start).ticks(),
            head.end.since(head.start).ticks(),
        );
        let pieces = head.pieces.iter().take(self.axes);
        out.iter_mut()
            .zip(pieces)
            .for_each(|(out, piece)| *out = piece.at(share));
    }

    fn write_counts(&mut self, out: &mut [i32]) {
        let is_on_the_way = matches!(self.phase, StreamPhase::Moving | StreamPhase::Dry);
        let Some(head) = self.segments.peek().filter(|_| is_on_the_way) else {
            let stand = self.stand.iter().take(self.axes);
            out.iter_mut()
                .zip(stand)
                .for_each(|(out, at)| *out = at.counts());
            return;
        };
        let pieces = head.pieces.iter().zip(&head.places).take(self.axes);
        let of = (head.generation, head.start);
        self.quick.take(of, head.scale, pieces);
        let elapsed = self.time.since(head.start);
        if !self.quick.write(elapsed, out) {
            self.write_doubts(elapsed, out);
        }
    }

    /// The counts that are in doubt, from the exact curves.
    #[inline(never)]
    pub(super) fn write_doubts(&self, elapsed: Time, out: &mut [i32]) {
        let Some(head) = self.segments.peek() else {
            return;
        };
        let duration = head.end.since(head.start);
        let share = Share::of(elapsed.ticks(), duration.ticks());
        for (axis, (out, piece)) in out.iter_mut().zip(&head.pieces).enumerate() {
            if self.quick.is_in_doubt(elapsed, axis) {
                *out = piece.at(share).counts();
            }
        }
    }

    #[inline(always)]
    pub(super) fn publish_time(&self) {
        let cycles = (self.time.ticks() >> 32) as u32;
        self.shared.time_cycles.store(cycles, Ordering::Relaxed);
    }

    fn publish(&self) {
        self.publish_time();
        self.shared.rate.store(self.rate.bits(), Ordering::Relaxed);
        self.shared.finished.store(self.finished, Ordering::Relaxed);
        self.shared.set_status(Status {
            generation: self.start.generation,
            phase: self.phase,
        });
    }
}
