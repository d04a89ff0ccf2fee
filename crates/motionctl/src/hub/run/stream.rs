//! Where twists come from: a file that is read before anything moves, or standard input, line by line.

use std::collections::VecDeque;
use std::io::BufRead as _;
use std::path::Path;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::Instant;

use crate::hub::error::HubError;
use crate::twist::{TwistError, TwistLine, TwistReader, read_file};

/// How far ahead of its time the latest line of a sender may be that is taken for a live one, in microseconds.
const LIVE_US: f64 = 100_000.0;

/// Lines that come, and lines that wait for their time.
pub(super) struct Twists {
    waiting: VecDeque<TwistLine>,
    live: Option<Receiver<Arrival>>,
    /// When the first line of a live stream came.
    first_came: Option<Instant>,
    /// The time of the first line, and the moment for which it is meant.
    origin: Option<(f64, u64)>,
}

/// A line of standard input, and when it came.
type Arrival = (Instant, Result<TwistLine, TwistError>);

/// What is due.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Due {
    /// The latest line whose time has come.
    Twist(TwistLine),
    /// Nothing yet.
    Nothing,
    /// The last line was given out, and there will be no more.
    Over,
}

impl Twists {
    /// A file, or standard input for `-`.
    ///
    /// # Errors
    /// [`HubError::Input`] for a file that cannot be used.
    pub(super) fn open(source: &str) -> Result<Self, HubError> {
        if source == "-" {
            return Ok(Self {
                waiting: VecDeque::new(),
                live: Some(listen()),
                first_came: None,
                origin: None,
            });
        }
        let lines = read_file(Path::new(source))
            .map_err(|error| HubError::Input(format!("{source}: {error}")))?;
        Ok(Self {
            waiting: lines.into(),
            live: None,
            first_came: None,
            origin: None,
        })
    }

    /// The twist that is due. Call it once a cycle.
    ///
    /// # Errors
    /// A line that cannot be used, after which nothing more is read.
    pub(super) fn due(&mut self, now_us: u64) -> Result<Due, TwistError> {
        let is_open = self.receive()?;
        let mut due = Due::Nothing;
        while let Some(line) = self.waiting.front().copied() {
            let age_us = self.age_of_first_us(is_open);
            let meant_us = now_us.saturating_sub(age_us);
            let (first_s, at_us) = *self.origin.get_or_insert((line.time_s, meant_us));
            let from_first_us = ((line.time_s - first_s) * 1e6).round();
            // Half a microsecond of a day and more is exact in a double.
            if from_first_us > now_us.saturating_sub(at_us) as f64 {
                return Ok(due);
            }
            self.waiting.pop_front();
            due = Due::Twist(line);
        }
        Ok(match due {
            Due::Nothing if !is_open => Due::Over,
            due => due,
        })
    }

    /// How long ago the first line of a live sender came, while the wheels were still being enabled: what it said then is over. A sender
    /// that has ended already, or whose lines are far ahead of their times, is a file in a pipe, and begins now.
    fn age_of_first_us(&self, is_open: bool) -> u64 {
        let (Some(came), true) = (self.first_came, is_open) else {
            return 0;
        };
        let age_us = u64::try_from(came.elapsed().as_micros()).unwrap_or(u64::MAX);
        if span_us(&self.waiting) > age_us as f64 + LIVE_US {
            0
        } else {
            age_us
        }
    }

    /// Takes what has come; tells whether more may come.
    fn receive(&mut self) -> Result<bool, TwistError> {
        let Some(live) = &self.live else {
            return Ok(false);
        };
        loop {
            match live.try_recv() {
                Ok((came, line)) => {
                    self.first_came.get_or_insert(came);
                    self.waiting.push_back(line?);
                }
                Err(TryRecvError::Empty) => return Ok(true),
                Err(TryRecvError::Disconnected) => return Ok(false),
            }
        }
    }
}

/// From the first line that waits to the latest.
fn span_us(waiting: &VecDeque<TwistLine>) -> f64 {
    match (waiting.front(), waiting.back()) {
        (Some(first), Some(last)) => (last.time_s - first.time_s) * 1e6,
        _ => 0.0,
    }
}

/// Reads standard input on a thread of its own, because reading waits.
fn listen() -> Receiver<Arrival> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        let mut reader = TwistReader::default();
        for line in std::io::stdin().lock().lines() {
            let line = match line {
                Ok(line) => reader.line(&line).transpose(),
                Err(error) => Some(Err(TwistError::Read(format!("cannot read it: {error}")))),
            };
            let Some(line) = line else { continue };
            let is_wrong = line.is_err();
            // Nobody listens any more at the end of the program.
            if sender.send((Instant::now(), line)).is_err() || is_wrong {
                return;
            }
        }
    });
    receiver
}

#[cfg(test)]
mod tests {
    use super::*;
    use diff_drive::Twist;

    fn line(time_s: f64) -> TwistLine {
        TwistLine {
            time_s,
            twist: Twist::ZERO,
        }
    }

    #[test]
    fn lines_are_due_at_their_times_from_the_first() {
        let mut twists = Twists {
            waiting: [line(5.0), line(5.02), line(5.03), line(6.0)].into(),
            live: None,
            first_came: None,
            origin: None,
        };
        let mut due = |us| twists.due(us).unwrap();
        assert_eq!(due(1_000_000), Due::Twist(line(5.0)));
        assert_eq!(due(1_019_999), Due::Nothing);
        // A cycle that was late takes the latest.
        assert_eq!(due(1_040_000), Due::Twist(line(5.03)));
        assert_eq!(due(2_000_000), Due::Twist(line(6.0)));
        assert_eq!(due(2_000_001), Due::Over);
    }

    #[test]
    fn a_line_that_cannot_be_used_ends_the_stream() {
        let (sender, live) = channel();
        let mut twists = Twists {
            waiting: VecDeque::new(),
            live: Some(live),
            first_came: None,
            origin: None,
        };
        assert_eq!(twists.due(0), Ok(Due::Nothing));
        sender.send((Instant::now(), Ok(line(0.0)))).unwrap();
        assert_eq!(twists.due(10), Ok(Due::Twist(line(0.0))));
        let wrong = (Instant::now(), Err(TwistError::Empty));
        sender.send(wrong).unwrap();
        assert_eq!(twists.due(20), Err(TwistError::Empty));
    }

    /// A stream whose first line came so long ago, and what is due first.
    fn first_due(ago_ms: u64, times_s: &[f64], is_open: bool) -> Due {
        let (sender, live) = channel();
        let came = Instant::now() - std::time::Duration::from_millis(ago_ms);
        for time_s in times_s {
            sender.send((came, Ok(line(*time_s)))).unwrap();
        }
        let _kept = is_open.then_some(sender);
        let mut twists = Twists {
            waiting: VecDeque::new(),
            live: Some(live),
            first_came: None,
            origin: None,
        };
        twists.due(60_000_000).unwrap()
    }

    #[test]
    fn a_live_sender_is_not_replayed_and_a_file_in_a_pipe_is() {
        let times = [0.0, 0.5, 1.0, 1.5, 2.0];
        // Two seconds of somebody at a stick: the latest counts.
        assert_eq!(first_due(2_050, &times, true), Due::Twist(line(2.0)));
        // Everything came at once: it is a file, and begins now.
        assert_eq!(first_due(10, &times, true), Due::Twist(line(0.0)));
        assert_eq!(first_due(2_050, &times, false), Due::Twist(line(0.0)));
    }
}
