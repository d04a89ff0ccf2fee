//! What is said between a sender and whoever takes its set-points.

use core::fmt;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender};

use board_link::{Counters, Refusal};
use schemars::JsonSchema;
use serde::Serialize;
use trajectory::{Position, Time};

use super::answer::{Answer, Clock};
use crate::counted::counted;
use crate::recording::AxisNaming;
use crate::set_points::{Order, Speed};
use crate::trajectory::{Layout, TimedCounts};

/// Most lines that are taken at once.
const MOST_LINES: usize = 64;
/// The clock of the taker at the first set-point, in seconds: room for earlier times, which are refused.
pub(super) const FIRST_S: f64 = 1.0;
/// Numbers of refusals begin here.
pub(super) const REFUSALS: u16 = 200;

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

/// Takes the set-points of a sender. Axes are those of the sender, positions count from where they stood.
pub(crate) trait SetPointTaker {
    /// Whether set-points are taken: no end was announced or ordered, and they have not run out for good.
    fn is_open(&self) -> bool;

    /// So many set-points the sender may send now.
    fn credit(&self) -> usize;

    /// Takes a set-point; the first one has the time 1 s.
    ///
    /// # Errors
    /// [`Refusal`]; nothing of it moves anything.
    fn push(&mut self, time: Time, positions: &[Position]) -> Result<(), Refusal>;

    /// No set-point comes any more. The sender has said so, or has gone.
    fn end(&mut self, is_gone: bool);

    /// An order of the sender.
    fn order(&mut self, order: Order);

    /// How it goes, as answer to `status`.
    fn status(&self) -> String;

    /// What came in.
    fn counters(&self) -> Counters;
}

/// The answer to `status`.
pub(crate) fn status(phase: impl fmt::Debug, speed: Speed, buffered_ms: f64) -> String {
    format!(
        "phase={phase:?} speed={:.0} asked={} paused={} buffered_ms={buffered_ms:.0}",
        speed.actual_percent, speed.asked_percent, speed.is_paused
    )
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

/// The lines of a sender, and the answers to it.
pub(crate) struct Conversation {
    cycle_s: f64,
    incoming: Receiver<Incoming>,
    answers: SyncSender<Answer>,
    /// Taken from the channel, and without room yet.
    held: Option<Incoming>,
    zero_s: Option<f64>,
    line: u64,
    unusable: u64,
    lost_answers: u64,
    told: (u64, usize),
    is_gone: bool,
    has_end: bool,
    notices: VecDeque<String>,
    naming: Option<Vec<AxisNaming>>,
}

impl Conversation {
    pub(super) fn new(
        cycle_us: u32,
        incoming: Receiver<Incoming>,
        answers: SyncSender<Answer>,
    ) -> Self {
        Self {
            cycle_s: f64::from(cycle_us) * 1e-6,
            incoming,
            answers,
            held: None,
            zero_s: None,
            line: 0,
            unusable: 0,
            lost_answers: 0,
            told: (0, 0),
            is_gone: false,
            has_end: false,
            notices: VecDeque::new(),
            naming: None,
        }
    }

    /// The cycle of the taker in seconds.
    pub(crate) const fn cycle_s(&self) -> f64 {
        self.cycle_s
    }

    /// Whether the sender has gone without an end.
    pub(crate) const fn is_gone(&self) -> bool {
        self.is_gone
    }

    /// What came in.
    pub(crate) fn report(&self, counters: &Counters) -> StreamReport {
        let by_number = counters.refused.iter().enumerate();
        StreamReport {
            lines: self.line,
            taken: counters.taken,
            refused: counters.refused_in_all(),
            refused_by_number: by_number
                .filter(|(_, count)| **count > 0)
                .map(|(number, count)| (REFUSALS + number as u16, *count))
                .collect(),
            unusable: self.unusable,
            ran_dry: counters.dry,
            lost_answers: self.lost_answers,
        }
    }

    /// What the user has to be told, oldest first.
    pub(crate) fn next_notice(&mut self) -> Option<String> {
        self.notices.pop_front()
    }

    /// What the sender calls its axes, once it has said so.
    pub(crate) fn take_naming(&mut self) -> Option<Vec<AxisNaming>> {
        self.naming.take()
    }

    fn answer(&mut self, answer: Answer) {
        // Whoever does not read loses answers; nothing that moves waits for it.
        if self.answers.try_send(answer).is_err() {
            self.lost_answers += 1;
        }
    }

    /// Tells sender and user.
    pub(crate) fn note(&mut self, text: String) {
        self.answer(Answer::Note(text.clone()));
        self.notices.push_back(text);
    }

    /// What has come since the last time, as far as there is room.
    pub(crate) fn take_lines(&mut self, taker: &mut impl SetPointTaker) {
        for _ in 0..MOST_LINES {
            let Some(next) = self.held.take().or_else(|| self.incoming.try_recv().ok()) else {
                return;
            };
            let is_set_point = matches!(next, Incoming::SetPoint { .. });
            if is_set_point && taker.is_open() && taker.credit() == 0 {
                self.held = Some(next);
                return;
            }
            self.take(next, taker);
        }
    }

    fn take(&mut self, incoming: Incoming, taker: &mut impl SetPointTaker) {
        match incoming {
            Incoming::Names(layout) => {
                self.naming = Some(layout.naming());
                let credit = taker.credit();
                self.notices
                    .push_back(format!("the stream drives {}", layout.describe()));
                self.answer(Answer::Ready { layout, credit });
            }
            Incoming::SetPoint { line, set_point } => self.set_point(line, &set_point, taker),
            Incoming::Order { line, order } => {
                self.line = line;
                taker.order(order);
            }
            Incoming::Status { line } => {
                self.line = line;
                let text = taker.status();
                self.answer(Answer::Status { line, text });
            }
            Incoming::End { line } => {
                self.line = line;
                self.has_end = true;
                taker.end(false);
            }
            Incoming::Bad { line } => {
                self.line = line;
                self.unusable += 1;
            }
            Incoming::Gone => self.gone(taker),
        }
    }

    fn gone(&mut self, taker: &mut impl SetPointTaker) {
        if self.has_end || self.is_gone {
            return;
        }
        self.is_gone = true;
        taker.end(true);
        self.note(
            "the sender has gone without an end: its last set-point is taken for the end"
                .to_owned(),
        );
    }

    fn set_point(&mut self, line: u64, set_point: &TimedCounts, taker: &mut impl SetPointTaker) {
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
        if let Err(refusal) = taker.push(time, &positions) {
            let is_first = taker.counters().taken == 0;
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

    /// Tells the sender its credit, where it has another one; whether it did.
    pub(crate) fn tell_credit(&mut self, taker: &impl SetPointTaker) -> bool {
        let now = (self.line, taker.credit());
        if now == self.told {
            return false;
        }
        self.told = now;
        let (line, credit) = now;
        self.answer(Answer::Ok { line, credit });
        true
    }
}

impl fmt::Display for StreamReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
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

#[cfg(test)]
mod tests {
    use board_link::{AxisLimits, Config, SetPointBuffer};
    use trajectory::Limits;

    use super::*;

    struct Taker {
        buffer: Box<SetPointBuffer<1, 640>>,
        is_taken: Vec<bool>,
    }

    impl SetPointTaker for Taker {
        fn is_open(&self) -> bool {
            true
        }

        fn credit(&self) -> usize {
            self.buffer.credit()
        }

        fn push(&mut self, time: Time, positions: &[Position]) -> Result<(), Refusal> {
            let taken = self.buffer.push(time, positions);
            self.is_taken.push(taken.is_ok());
            taken
        }

        fn end(&mut self, _: bool) {}

        fn order(&mut self, _: Order) {}

        fn status(&self) -> String {
            String::new()
        }

        fn counters(&self) -> Counters {
            *self.buffer.counters()
        }
    }

    /// Whether each set-point was taken.
    fn taken(set_points: &[(f64, f64)]) -> Vec<bool> {
        let (send, lines) = std::sync::mpsc::channel();
        let (answers, _answered) = std::sync::mpsc::sync_channel(100);
        let mut conversation = Conversation::new(1_000, lines, answers);
        let limits = AxisLimits {
            motion: Limits::without_jerk(100.0, 10.0).unwrap(),
            lowest: Position::from_counts(-1_000),
            highest: Position::from_counts(1_000),
        };
        let config = Config::with_cycles_per_second(1_000);
        let buffer = SetPointBuffer::new(&[limits], &[Position::ZERO], config).unwrap();
        let mut taker = Taker {
            buffer: Box::new(buffer),
            is_taken: Vec::new(),
        };
        for (line, &(time_s, counts)) in (1..).zip(set_points) {
            let set_point = TimedCounts {
                time_s,
                counts: vec![counts],
            };
            send.send(Incoming::SetPoint { line, set_point }).unwrap();
        }
        conversation.take_lines(&mut taker);
        taker.is_taken
    }

    /// The clock of a stream begins with the first set-point that is taken, whatever those before were refused for.
    #[test]
    fn a_sender_begins_anew_after_its_first_set_point_was_refused() {
        for (first, reason) in [(500.0, "start"), (5_000.0, "travel")] {
            for began_s in [1_000.0, -5_000_000.0, 1.7e9] {
                let points = [(began_s, first), (0.0, 0.0), (0.02, 1.0), (0.04, 3.0)];
                assert_eq!(
                    taken(&points),
                    [false, true, true, true],
                    "{reason} {began_s}"
                );
            }
        }
    }
}
