//! The set-points of a stream, as a source of set-points.

use board_link::{Counters, Phase, Refusal, SetPointBuffer};
use trajectory::{Position, Time};

use super::conversation::{Conversation, FIRST_S, SetPointTaker, StreamReport, status};
use crate::recording::AxisNaming;
use crate::set_points::{Order, SetPointSource, Speed, Step, held};

/// Most axes of a stream: as many as a bus has drives.
const MOST_AXES: usize = 63;
/// Set-points that are kept: half a second at 1 kHz and what the checks look back on.
const POINTS: usize = 640;
/// A sender is told its credit at most once in so many cycles.
const TELL_CYCLES: u64 = 5;

/// The buffer of a stream.
pub(crate) type Buffer = SetPointBuffer<MOST_AXES, POINTS>;

/// A stream as a source of set-points.
pub(crate) struct StreamSource {
    conversation: Conversation,
    buffered: Buffered,
    positions: Vec<Position>,
    told_at_cycle: u64,
    cycle: u64,
    dry_before: u32,
    is_held_to: u16,
}

/// The buffer, and what was asked of it.
struct Buffered {
    buffer: Box<Buffer>,
    cycle_s: f64,
    asked_percent: u16,
}

impl StreamSource {
    pub(super) fn new(buffer: Box<Buffer>, conversation: Conversation) -> Self {
        Self {
            positions: vec![Position::ZERO; buffer.axes()],
            buffered: Buffered {
                buffer,
                cycle_s: conversation.cycle_s(),
                asked_percent: 100,
            },
            conversation,
            told_at_cycle: 0,
            cycle: 0,
            dry_before: 0,
            is_held_to: 0,
        }
    }

    /// What came in.
    pub(crate) fn report(&self) -> StreamReport {
        self.conversation.report(self.buffered.buffer.counters())
    }

    fn tell_credit(&mut self) {
        if self.cycle >= self.told_at_cycle + TELL_CYCLES
            && self.conversation.tell_credit(&self.buffered)
        {
            self.told_at_cycle = self.cycle;
        }
    }

    fn watch(&mut self) {
        let dry = self.buffered.buffer.counters().dry;
        if dry > self.dry_before {
            self.dry_before = dry;
            let buffered = self.buffered.buffered_ms();
            self.conversation.note(format!(
                "the set-points ran out: the axes slow down and come to rest at the last one, {buffered:.0} ms ahead"
            ));
        }
        let highest = self.buffered.buffer.highest_percent() as u16;
        let asked = self.buffered.asked_percent;
        let is_held = asked > highest && asked > 100;
        if is_held && self.is_held_to != asked {
            self.is_held_to = asked;
            self.conversation.note(held(asked, highest));
        }
    }

    fn step(&self, phase: Phase) -> Step {
        match phase {
            Phase::Waiting | Phase::Moving | Phase::Dry => Step::Goes,
            Phase::Complete if self.conversation.is_gone() => Step::RanOut,
            Phase::Complete => Step::Completed,
            Phase::DriedUp => Step::RanOut,
            Phase::Stopped => Step::Stopped,
        }
    }
}

impl Buffered {
    fn buffered_ms(&self) -> f64 {
        f64::from(self.buffer.buffered().cycles()) * self.cycle_s * 1e3
    }

    fn speed(&self) -> Speed {
        Speed {
            asked_percent: self.asked_percent,
            actual_percent: self.buffer.percent(),
            is_paused: self.buffer.is_paused(),
        }
    }
}

impl SetPointTaker for Buffered {
    fn is_open(&self) -> bool {
        self.buffer.is_open()
    }

    fn credit(&self) -> usize {
        self.buffer.credit()
    }

    fn push(&mut self, time: Time, positions: &[Position]) -> Result<(), Refusal> {
        self.buffer.push(time, positions)
    }

    fn end(&mut self, _is_gone: bool) {
        self.buffer.end();
    }

    fn order(&mut self, order: Order) {
        match order {
            Order::Pause => self.buffer.pause(),
            Order::Resume => self.buffer.resume(),
            Order::Stop => self.buffer.stop(),
            Order::Override(percent) => {
                self.asked_percent = percent;
                // It is at most the largest: whoever gives an order checks it.
                let _ = self.buffer.set_override(percent);
            }
        }
    }

    fn status(&self) -> String {
        status(self.buffer.phase(), self.speed(), self.buffered_ms())
    }

    fn counters(&self) -> Counters {
        *self.buffer.counters()
    }
}

impl SetPointSource for StreamSource {
    fn axes(&self) -> usize {
        self.positions.len()
    }

    fn next(&mut self, row: &mut [i32]) -> Step {
        self.cycle += 1;
        let asked = self.buffered.asked_percent;
        self.conversation.take_lines(&mut self.buffered);
        if self.buffered.asked_percent != asked {
            self.is_held_to = 0;
        }
        let phase = self.buffered.buffer.advance(&mut self.positions);
        for (row, position) in row.iter_mut().zip(&self.positions) {
            *row = position.counts();
        }
        self.watch();
        self.tell_credit();
        self.step(phase)
    }

    fn order(&mut self, order: Order) {
        if matches!(order, Order::Override(_)) {
            self.is_held_to = 0;
        }
        self.buffered.order(order);
    }

    fn speed(&self) -> Speed {
        self.buffered.speed()
    }

    fn progress(&self) -> (u64, Option<u64>) {
        let first = FIRST_S / self.buffered.cycle_s;
        let passed = f64::from(self.buffered.buffer.time().cycles()) - first;
        (passed as u64, None)
    }

    fn next_notice(&mut self) -> Option<String> {
        self.conversation.next_notice()
    }

    fn take_naming(&mut self) -> Option<Vec<AxisNaming>> {
        self.conversation.take_naming()
    }
}
