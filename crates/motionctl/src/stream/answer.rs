//! What a sender is told.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::mpsc::Receiver;
use std::time::Duration;

use board_link::Refusal;
use serde_json::json;
use trajectory::{Position, Time};

use super::conversation::REFUSALS;
use super::parser::LineError;
use crate::output::tell;
use crate::trajectory::Layout;

/// Errors of standard input that are shown; the others are counted.
const MOST_SHOWN: usize = 50;

/// Something that a sender is told.
#[derive(Debug, Clone)]
pub(super) enum Answer {
    /// The sender speaks JSON.
    Json,
    /// The names are understood; so many set-points may come.
    Ready { layout: Arc<Layout>, credit: usize },
    /// Everything up to this line is dealt with; so many set-points more may come.
    Ok { line: u64, credit: usize },
    /// A line that is not used.
    Bad { line: u64, error: LineError },
    /// A set-point that is not taken.
    Refused {
        line: u64,
        refusal: Refusal,
        clock: Clock,
    },
    /// How the motion goes.
    Status { line: u64, text: String },
    /// Something happened.
    Note(String),
    /// The motion has ended.
    End(String),
}

/// Between cycles of the buffer and the clock of the sender.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Clock {
    pub(super) cycle_s: f64,
    /// The time of the sender at cycle 0 of the buffer.
    pub(super) zero_s: f64,
    /// The time of the set-point, as it was sent.
    pub(super) sent_s: f64,
}

impl Clock {
    fn seconds(&self, time: Time) -> f64 {
        time.ticks() as f64 / (1_u64 << 32) as f64 * self.cycle_s + self.zero_s
    }
}

/// Writes answers until the motion has ended.
pub(super) fn write_answers(answers: &Receiver<Answer>, mut out: Out) {
    let mut words = Words {
        layout: None,
        is_json: false,
    };
    while let Ok(first) = answers.recv() {
        let mut batch = vec![first];
        batch.extend(answers.try_iter());
        let last_ok = batch
            .iter()
            .rposition(|answer| matches!(answer, Answer::Ok { .. }));
        let mut is_over = false;
        for (place, answer) in batch.into_iter().enumerate() {
            // The later one says everything that this one would say.
            if matches!(answer, Answer::Ok { .. }) && Some(place) != last_ok {
                continue;
            }
            is_over |= matches!(answer, Answer::End(_));
            if let Some(text) = words.of(answer)
                && out.say(&text).is_err()
            {
                return;
            }
        }
        if is_over {
            out.close();
            return;
        }
    }
}

/// Whom answers go to.
pub(super) enum Out {
    Peer(crate::endpoint::Peer),
    /// Standard input has no way back: what is wrong is shown to the user.
    User {
        shown: usize,
    },
}

impl Out {
    fn say(&mut self, text: &str) -> io::Result<()> {
        match self {
            Self::Peer(peer) => writeln!(peer, "{text}"),
            Self::User { shown } => {
                let is_error = text.starts_with("error") || text.contains("\"type\":\"error\"");
                if is_error && *shown < MOST_SHOWN {
                    tell(format_args!("stream: {text}"));
                    *shown += 1;
                    if *shown == MOST_SHOWN {
                        tell("stream: further errors are counted and not shown");
                    }
                }
                Ok(())
            }
        }
    }

    fn close(self) {
        if let Self::Peer(peer) = self {
            // The last word was said.
            peer.close();
        }
    }
}

/// Answers as lines.
struct Words {
    layout: Option<Arc<Layout>>,
    is_json: bool,
}

impl Words {
    fn of(&mut self, answer: Answer) -> Option<String> {
        let json = self.is_json;
        Some(match answer {
            Answer::Json => {
                self.is_json = true;
                return None;
            }
            Answer::Ready { layout, credit } => {
                let axes = layout.axes();
                self.layout = Some(layout);
                if json {
                    json!({"type": "ready", "axes": axes, "credit": credit}).to_string()
                } else {
                    format!("ready {axes} {credit}")
                }
            }
            Answer::Ok { line, credit } if json => {
                json!({"type": "ok", "line": line, "credit": credit}).to_string()
            }
            Answer::Ok { line, credit } => format!("ok {line} {credit}"),
            Answer::Bad { line, error } => self.error(line, error.number, &error.text),
            Answer::Refused {
                line,
                refusal,
                clock,
            } => {
                let number = REFUSALS + refusal.number() as u16;
                self.error(line, number, &self.refusal(&refusal, &clock))
            }
            Answer::Status { line, text } if json => {
                json!({"type": "status", "line": line, "text": text}).to_string()
            }
            Answer::Status { line, text } => format!("status {line} {text}"),
            Answer::Note(text) if json => json!({"type": "note", "text": text}).to_string(),
            Answer::Note(text) => format!("note {text}"),
            Answer::End(text) if json => json!({"type": "end", "text": text}).to_string(),
            Answer::End(text) => format!("end {text}"),
        })
    }

    fn error(&self, line: u64, number: u16, text: &str) -> String {
        if self.is_json {
            return json!({"type": "error", "line": line, "number": number, "text": text})
                .to_string();
        }
        format!("error {line} {number} {text}")
    }

    /// A refusal in the names and units of the sender.
    fn refusal(&self, refusal: &Refusal, clock: &Clock) -> String {
        let Some(layout) = &self.layout else {
            return refusal.to_string();
        };
        let sender = Sender { layout, clock };
        match *refusal {
            Refusal::Start {
                axis,
                expected,
                actual,
            } => format!(
                "{}: the first set-point must be where the axis stands: expected {}, got {}",
                layout.name(axis),
                sender.position(axis, expected),
                sender.position(axis, actual)
            ),
            Refusal::Past { expected, .. } => {
                sender.later("the time is in the past", "later than", expected)
            }
            Refusal::Order { expected, .. } => {
                sender.later("the time is out of order", "later than", expected)
            }
            Refusal::Close { expected, .. } => sender.later(
                "the time is too close to the set-points before",
                "at least",
                expected,
            ),
            Refusal::Ahead { expected, .. } => {
                sender.later("the time is too far ahead", "at most", expected)
            }
            Refusal::Late { expected, .. } => sender.later(
                "too late: the set-points ran out and the motion ends",
                "a set-point before the motion had to slow down for the one at",
                expected,
            ),
            Refusal::Travel {
                axis,
                lowest,
                highest,
                actual,
            } => format!(
                "{}: beyond its travel: expected {} to {}, got {}",
                layout.name(axis),
                sender.position(axis, lowest),
                sender.position(axis, highest),
                sender.position(axis, actual)
            ),
            Refusal::Velocity {
                axis,
                expected,
                actual,
            } => sender.derivative("too fast", axis, 1, expected, actual),
            Refusal::Acceleration {
                axis,
                expected,
                actual,
            } => sender.derivative("too much acceleration", axis, 2, expected, actual),
            Refusal::Jerk {
                axis,
                expected,
                actual,
            } => sender.derivative("too much jerk", axis, 3, expected, actual),
            ref other => other.to_string(),
        }
    }
}

struct Sender<'a> {
    layout: &'a Layout,
    clock: &'a Clock,
}

impl Sender<'_> {
    fn position(&self, axis: usize, position: Position) -> String {
        let counts = position.units() as f64 / Position::UNITS as f64;
        let (value, unit) = self.layout.in_unit(axis, counts);
        format!("{} {unit}", short(value))
    }

    fn later(&self, what: &str, than: &str, expected: Time) -> String {
        let (expected, unit) = self.layout.in_time_unit(self.clock.seconds(expected));
        let (actual, _) = self.layout.in_time_unit(self.clock.sent_s);
        format!(
            "{what}: expected {than} {} {unit}, got {} {unit}",
            short(expected),
            short(actual)
        )
    }

    fn derivative(&self, what: &str, axis: usize, order: i32, limit: f32, needs: f32) -> String {
        let per_s = self.clock.cycle_s.powi(-order);
        let [limit, needs] = [limit, needs].map(|value| {
            let (value, unit) = self.layout.in_unit(axis, f64::from(value) * per_s);
            (value.abs(), unit)
        });
        let per = ["/s", "/s²", "/s³"][(order - 1) as usize];
        format!(
            "{}: {what}: expected at most {} {}{per}, got {} {}{per}",
            self.layout.name(axis),
            short(limit.0),
            limit.1,
            short(needs.0),
            needs.1
        )
    }
}

/// Six places behind the point, without what says nothing.
fn short(value: f64) -> f64 {
    // Without a minus in front of zero.
    (value * 1e6).round() / 1e6 + 0.0
}

/// The patience for the last answers of a sender that does not read.
pub(super) const LAST_WORDS: Duration = Duration::from_millis(1_500);
