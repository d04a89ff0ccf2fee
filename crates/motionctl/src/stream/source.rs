//! The set-points of a stream, as a source of set-points.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender};

use board_link::{Phase, Refusal, SetPointBuffer};
use schemars::JsonSchema;
use serde::Serialize;
use trajectory::{Position, Time};

use super::answer::{Answer, Clock};
use crate::counted::counted;
use crate::recording::AxisNaming;
use crate::set_points::{Order, SetPointSource, Speed, Step};
use crate::trajectory::{Layout, TimedCounts};

/// Most axes of a stream: as many as a bus has drives.
const MOST_AXES: usize = 63;
/// Set-points that are kept: half a second at 1 kHz and what the checks look back on.
const POINTS: usize = 640;
/// Most lines that a cycle takes.
const MOST_LINES: usize = 64;
/// A sender is told its credit at most once in so many cycles.
const TELL_CYCLES: u64 = 5;
/// The buffer's clock at the first set-point, in seconds: room for earlier times, which are refused.
const FIRST_S: f64 = 1.0;

/// The buffer of a stream.
pub(crate) type Buffer = SetPointBuffer<MOST_AXES, POINTS>;

/// What the thread that reads hands on.
#[derive(Debug)]
pub(super) enum Incoming {
    Names(Arc<Layout>),
    SetPoint {
        line: u64,
        set_point: TimedCounts,
    },
    Order {
        line: u64,
        order: Order,
    },
    Status {
        line: u64,
    },
    End {
        line: u64,
    },
    /// A line that is not used, and was answered.
    Bad {
        line: u64,
    },
    /// The sender has gone.
    Gone,
}

/// What came in, for the summary.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub(crate) struct StreamReport {
    /// Lines that were dealt with.
    lines: u64,
    /// Set-points that were taken.
    taken: u32,
    /// Set-points that were refused.
    refused: u32,
    /// The same by the number of the error.
    refused_by_number: Vec<(u16, u32)>,
    /// Lines that could not be read.
    unusable: u64,
    /// How often the set-points ran out.
    ran_dry: u32,
    /// Answers that the sender did not fetch in time.
    lost_answers: u64,
}

/// A stream as a source of set-points.
pub(crate) struct StreamSource {
    buffer: Box<Buffer>,
    cycle_s: f64,
    incoming: Receiver<Incoming>,
    answers: SyncSender<Answer>,
    /// Taken from the channel, and without room yet.
    held: Option<Incoming>,
    zero_s: Option<f64>,
    positions: Vec<Position>,
    line: u64,
    unusable: u64,
    lost_answers: u64,
    asked_percent: u16,
    told: (u64, usize),
    told_at_cycle: u64,
    cycle: u64,
    dry_before: u32,
    is_gone: bool,
    has_end: bool,
    is_held_to: u16,
    notices: VecDeque<String>,
    naming: Option<Vec<AxisNaming>>,
}

impl StreamSource {
    pub(super) fn new(
        buffer: Box<Buffer>,
        cycle_us: u32,
        incoming: Receiver<Incoming>,
        answers: SyncSender<Answer>,
    ) -> Self {
        Self {
            positions: vec![Position::ZERO; buffer.axes()],
            buffer,
            cycle_s: f64::from(cycle_us) * 1e-6,
            incoming,
            answers,
            held: None,
            zero_s: None,
            line: 0,
            unusable: 0,
            lost_answers: 0,
            asked_percent: 100,
            told: (0, 0),
            told_at_cycle: 0,
            cycle: 0,
            dry_before: 0,
            is_gone: false,
            has_end: false,
            is_held_to: 0,
            notices: VecDeque::new(),
            naming: None,
        }
    }

    /// What came in.
    pub(crate) fn report(&self) -> StreamReport {
        let counters = self.buffer.counters();
        let by_number = counters.refused.iter().enumerate();
        StreamReport {
            lines: self.line,
            taken: counters.taken,
            refused: counters.refused_in_all(),
            refused_by_number: by_number
                .filter(|(_, count)| **count > 0)
                .map(|(number, count)| (200 + number as u16, *count))
                .collect(),
            unusable: self.unusable,
            ran_dry: counters.dry,
            lost_answers: self.lost_answers,
        }
    }

    fn answer(&mut self, answer: Answer) {
        // Whoever does not read loses answers; the cycle waits for nobody.
        if self.answers.try_send(answer).is_err() {
            self.lost_answers += 1;
        }
    }

    fn note(&mut self, text: String) {
        self.answer(Answer::Note(text.clone()));
        self.notices.push_back(text);
    }

    /// What has come since the last cycle, as far as there is room.
    fn take_lines(&mut self) {
        for _ in 0..MOST_LINES {
            let Some(next) = self.held.take().or_else(|| self.incoming.try_recv().ok()) else {
                return;
            };
            let is_set_point = matches!(next, Incoming::SetPoint { .. });
            if is_set_point && self.buffer.is_open() && self.buffer.credit() == 0 {
                self.held = Some(next);
                return;
            }
            self.take(next);
        }
    }

    fn take(&mut self, incoming: Incoming) {
        match incoming {
            Incoming::Names(layout) => {
                self.naming = Some(layout.naming());
                let credit = self.buffer.credit();
                self.notices
                    .push_back(format!("the stream drives {}", layout.describe()));
                self.answer(Answer::Ready { layout, credit });
            }
            Incoming::SetPoint { line, set_point } => self.set_point(line, &set_point),
            Incoming::Order { line, order } => {
                self.line = line;
                self.order(order);
            }
            Incoming::Status { line } => {
                self.line = line;
                let text = format!(
                    "phase={:?} speed={:.0} asked={} paused={} buffered_ms={:.0}",
                    self.buffer.phase(),
                    self.buffer.percent(),
                    self.asked_percent,
                    self.buffer.is_paused(),
                    f64::from(self.buffer.buffered().cycles()) * self.cycle_s * 1e3
                );
                self.answer(Answer::Status { line, text });
            }
            Incoming::End { line } => {
                self.line = line;
                self.has_end = true;
                self.buffer.end();
            }
            Incoming::Bad { line } => {
                self.line = line;
                self.unusable += 1;
            }
            Incoming::Gone => self.gone(),
        }
    }

    fn gone(&mut self) {
        if self.has_end || self.is_gone {
            return;
        }
        self.is_gone = true;
        self.buffer.end();
        self.note(
            "the sender has gone without an end: the axes come to rest at its last set-point"
                .to_owned(),
        );
    }

    fn set_point(&mut self, line: u64, set_point: &TimedCounts) {
        self.line = line;
        let first_s = set_point.time_s - FIRST_S;
        let zero_s = *self.zero_s.get_or_insert(first_s);
        let cycles = (set_point.time_s - zero_s) / self.cycle_s;
        // A time before the clock is its first one, and one behind its end its last: both are refused.
        let time = Time::from_ticks((cycles * (1_u64 << 32) as f64).round() as u64);
        let positions: Vec<Position> = set_point
            .counts
            .iter()
            .map(|counts| Position::from_units((counts * Position::UNITS as f64).round() as i64))
            .collect();
        if let Err(refusal) = self.buffer.push(time, &positions) {
            let is_first = matches!(refusal, Refusal::Start { .. });
            let clock = Clock {
                cycle_s: self.cycle_s,
                zero_s,
                sent_s: set_point.time_s,
            };
            if is_first {
                // The next one may be the first.
                self.zero_s = None;
            }
            self.answer(Answer::Refused {
                line,
                refusal,
                clock,
            });
        }
    }

    fn tell_credit(&mut self) {
        let now = (self.line, self.buffer.credit());
        if now != self.told && self.cycle >= self.told_at_cycle + TELL_CYCLES {
            self.told = now;
            self.told_at_cycle = self.cycle;
            let (line, credit) = now;
            self.answer(Answer::Ok { line, credit });
        }
    }

    fn watch(&mut self) {
        let dry = self.buffer.counters().dry;
        if dry > self.dry_before {
            self.dry_before = dry;
            let buffered = f64::from(self.buffer.buffered().cycles()) * self.cycle_s * 1e3;
            self.note(format!(
                "the set-points ran out: the axes slow down and come to rest at the last one, {buffered:.0} ms ahead"
            ));
        }
        let highest = self.buffer.highest_percent() as u16;
        let is_held = self.asked_percent > highest && self.asked_percent > 100;
        if is_held && self.is_held_to != self.asked_percent {
            self.is_held_to = self.asked_percent;
            self.note(format!(
                "speed {} % would exceed the limits of an axis: held to {highest} %",
                self.asked_percent
            ));
        }
    }

    fn step(&self, phase: Phase) -> Step {
        match phase {
            Phase::Waiting | Phase::Moving | Phase::Dry => Step::Goes,
            Phase::Complete if self.is_gone => Step::RanOut,
            Phase::Complete => Step::Completed,
            Phase::DriedUp => Step::RanOut,
            Phase::Stopped => Step::Stopped,
        }
    }
}

impl SetPointSource for StreamSource {
    fn axes(&self) -> usize {
        self.positions.len()
    }

    fn next(&mut self, row: &mut [i32]) -> Step {
        self.cycle += 1;
        self.take_lines();
        let phase = self.buffer.advance(&mut self.positions);
        for (row, position) in row.iter_mut().zip(&self.positions) {
            *row = position.counts();
        }
        self.watch();
        self.tell_credit();
        self.step(phase)
    }

    fn order(&mut self, order: Order) {
        match order {
            Order::Pause => self.buffer.pause(),
            Order::Resume => self.buffer.resume(),
            Order::Stop => self.buffer.stop(),
            Order::Override(percent) => {
                self.asked_percent = percent;
                self.is_held_to = 0;
                // It is at most the largest: whoever gives an order checks it.
                let _ = self.buffer.set_override(percent);
            }
        }
    }

    fn speed(&self) -> Speed {
        Speed {
            asked_percent: self.asked_percent,
            actual_percent: self.buffer.percent(),
            is_paused: self.buffer.is_paused(),
        }
    }

    fn progress(&self) -> (u64, Option<u64>) {
        let first = FIRST_S / self.cycle_s;
        let passed = f64::from(self.buffer.time().cycles()) - first;
        (passed as u64, None)
    }

    fn next_notice(&mut self) -> Option<String> {
        self.notices.pop_front()
    }

    fn take_naming(&mut self) -> Option<Vec<AxisNaming>> {
        self.naming.take()
    }
}

impl core::fmt::Display for StreamReport {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(
            f,
            "stream: {}, {} taken, {} refused",
            counted(self.lines, "line", "lines"),
            counted(u64::from(self.taken), "set-point", "set-points"),
            self.refused
        )?;
        for (number, count) in &self.refused_by_number {
            write!(f, ", {count} with error {number}")?;
        }
        if self.unusable > 0 {
            write!(
                f,
                ", {} not usable",
                counted(self.unusable, "line", "lines")
            )?;
        }
        if self.ran_dry > 0 {
            write!(f, "; ran out {} times", self.ran_dry)?;
        }
        if self.lost_answers > 0 {
            write!(f, "; {} answers were not fetched", self.lost_answers)?;
        }
        Ok(())
    }
}
