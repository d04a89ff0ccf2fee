//! For which frames an adapter has answered. Time comes in as an argument.
//!
//! Answers have no number, so they belong to frames only by their order, and an answer that is lost, or one too many, shifts all
//! later ones. A frame that was taken must not be given back, because its step would be sent twice; so a refusal is believed only when
//! the answers since the window was empty last are as many as the frames. What does not add up is a frame of unknown fate.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use drive_sim::Frame;

/// Frames on their way to an adapter that answers. Less than the queue of any adapter, so that one is seldom refused.
pub(super) const MOST_UNANSWERED: usize = 16;
/// An answer that has not come after so long never will: what happened to its frame is not known. Less than the time without
/// set-points after which the master gives up, and longer than a PC lets a program wait.
pub(crate) const ANSWER_LIMIT: Duration = Duration::from_millis(400);
/// After a refusal: longer than adapters on USB hold an answer back (16 ms), so that a refusal too many shows.
const QUIET: Duration = Duration::from_millis(50);

/// The answer to a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Answer {
    Taken,
    Refused,
}

/// Whether an adapter answers for frames at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Manner {
    /// It had no chance yet.
    Unknown,
    Answers,
    Silent,
}

/// The answers since a refusal, which belong to frames that wait.
#[derive(Debug)]
struct Doubt {
    answers: Vec<Answer>,
    begun: Instant,
    latest: Instant,
}

/// The frames that an adapter has not answered for yet.
#[derive(Debug)]
pub(super) struct Window {
    most: usize,
    manner: Manner,
    /// Oldest first, each with the time when it was handed over.
    unanswered: VecDeque<(Frame, Instant)>,
    /// To be given back.
    refused: VecDeque<Frame>,
    doubt: Option<Doubt>,
    latest_sent: Option<Instant>,
    /// The adapter has answered for more frames than there were: its refusals cannot be believed.
    answers_too_often: bool,
    unknown: usize,
}

impl Window {
    /// A window for so many frames.
    pub(super) fn new(most: usize) -> Self {
        Self {
            most,
            manner: Manner::Unknown,
            unanswered: VecDeque::new(),
            refused: VecDeque::new(),
            doubt: None,
            latest_sent: None,
            answers_too_often: false,
            unknown: 0,
        }
    }

    /// Whether one more frame may be handed over.
    pub(super) fn has_room(&self) -> bool {
        self.manner == Manner::Silent || (self.doubt.is_none() && self.unanswered.len() < self.most)
    }

    /// Whether the adapter was seen to answer for no frame.
    pub(super) fn is_silent(&self) -> bool {
        self.manner == Manner::Silent
    }

    /// A frame was handed over.
    pub(super) fn sent(&mut self, frame: Frame, now: Instant) {
        self.latest_sent = Some(now);
        if self.manner != Manner::Silent {
            self.unanswered.push_back((frame, now));
        }
    }

    /// An answer came.
    pub(super) fn answer(&mut self, answer: Answer, now: Instant) {
        if let Some(doubt) = &mut self.doubt {
            doubt.answers.push(answer);
            doubt.latest = now;
        } else if answer == Answer::Taken {
            if self.unanswered.pop_front().is_none() && self.manner == Manner::Answers {
                self.answers_too_often = true;
            }
        } else if !self.unanswered.is_empty() {
            self.doubt = Some(Doubt {
                answers: vec![answer],
                begun: now,
                latest: now,
            });
        } else if self.may_be_of_a_frame(now) {
            self.unknown += 1;
        }
        if answer == Answer::Taken {
            self.manner = Manner::Answers;
        }
    }

    /// Whether a refusal that no waiting frame explains may belong to a frame all the same. With an adapter that answers for each
    /// frame once it cannot, and is noise.
    fn may_be_of_a_frame(&self, now: Instant) -> bool {
        let is_recent = |sent| now.saturating_duration_since(sent) < ANSWER_LIMIT;
        (self.manner == Manner::Silent || self.answers_too_often)
            && self.latest_sent.is_some_and(is_recent)
    }

    /// Time passes: settles what can be settled.
    pub(super) fn tick(&mut self, now: Instant) {
        let age = |since| now.saturating_duration_since(since);
        if let Some(doubt) = self.doubt.take_if(|doubt| {
            let is_whole = doubt.answers.len() >= self.unanswered.len();
            is_whole && age(doubt.latest) >= QUIET
                || doubt.answers.len() > self.unanswered.len()
                || age(doubt.begun) >= ANSWER_LIMIT
        }) {
            self.settle(&doubt);
        } else if self.doubt.is_none()
            && let Some((_, sent)) = self.unanswered.front()
            && age(*sent) >= ANSWER_LIMIT
        {
            self.expire();
        }
    }

    fn settle(&mut self, doubt: &Doubt) {
        let frames = self.unanswered.len();
        let taken = doubt
            .answers
            .iter()
            .filter(|&&answer| answer == Answer::Taken)
            .count();
        if self.answers_too_often || doubt.answers.len() < frames {
            self.expire();
        } else if doubt.answers.len() == frames {
            let answers = self.unanswered.drain(..).zip(&doubt.answers);
            let refused = answers.filter(|&(_, &answer)| answer == Answer::Refused);
            self.refused.extend(refused.map(|((frame, _), _)| frame));
        } else if taken >= frames {
            // Every frame was taken, so no refusal was of a frame.
            self.unanswered.clear();
        } else {
            self.expire();
        }
    }

    /// Nobody knows what happened to the frames that wait. Of an adapter that has never answered nothing else is expected.
    fn expire(&mut self) {
        let frames = self.unanswered.len();
        self.unanswered.clear();
        let is_silent = self.manner == Manner::Unknown;
        if is_silent {
            self.manner = Manner::Silent;
        } else {
            self.unknown += frames;
        }
    }

    /// The next frame that the adapter has refused.
    pub(super) fn take_refused(&mut self) -> Option<Frame> {
        self.refused.pop_front()
    }

    /// The number of frames since the last call of which nobody knows whether they went out.
    pub(super) fn take_unknown(&mut self) -> usize {
        std::mem::take(&mut self.unknown)
    }
}

#[cfg(test)]
mod tests;
