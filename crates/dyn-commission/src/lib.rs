#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

mod answers;
mod ask;
mod assign;
mod byte_order;
mod group3_order;
mod scan;

pub use answers::{AnswerCount, CountAnswers};
pub use ask::Ask;
pub use assign::{AssignId, AssignResult};
pub use byte_order::{ByteOrderProbe, ByteOrderResult};
pub use group3_order::{Group3Order, Group3Readings};
pub use scan::{FoundDrive, Scan, ScanResult};

use bus_user::{BusErrorKind, BusUser, Instant, Outcome, Progress, Sink};
use dyn_can::{
    Address, DataFrame, Dialect, DriveError, DynFrame, FrameError, Reply, ReplyKind, Request,
};

/// Time to listen for a reply, and for a data error after a command. Longer than any response that was measured (D65).
const LISTEN_US: u32 = 20_000;

/// One frame to send, or none, and what to listen for afterwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Exchange {
    /// `None` listens without sending.
    frame: Option<DataFrame>,
    /// The kind of the answer that is counted; `None` counts none.
    answer: Option<ReplyKind>,
    /// The first answer ends the window.
    ends_with_answer: bool,
    listen_us: u32,
}

impl Exchange {
    /// A request whose answer is awaited. `None` when the dialect does not let it be sent.
    fn ask(request: Request, to: Address, dialect: &Dialect) -> Option<Self> {
        let frame = request.encode(to, dialect).ok()?;
        Some(Self {
            frame: Some(frame),
            answer: request.reply_kind(),
            ends_with_answer: true,
            listen_us: LISTEN_US,
        })
    }

    /// A frame after which only an error may come.
    const fn tell(frame: DataFrame, listen_us: u32) -> Self {
        Self {
            frame: Some(frame),
            answer: None,
            ends_with_answer: false,
            listen_us,
        }
    }

    /// Sends nothing and listens to whatever is on the bus.
    const fn listen(listen_us: u32) -> Self {
        Self {
            frame: None,
            answer: None,
            ends_with_answer: false,
            listen_us,
        }
    }

    /// The same, to the end of its window: another drive may answer too.
    const fn counting_answers(self) -> Self {
        Self {
            ends_with_answer: false,
            ..self
        }
    }

    /// The same with a window of so many microseconds.
    const fn listening(self, listen_us: u32) -> Self {
        Self { listen_us, ..self }
    }
}

/// What came back in the window of an exchange.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Heard {
    /// The awaited answer, when it decodes.
    reply: Option<Reply>,
    /// The frame of the answer, also of one that does not decode.
    reply_frame: Option<DataFrame>,
    /// Number of awaited answers.
    answers: u8,
    /// Number of frames of any kind.
    frames: u8,
    /// The drive refused something.
    data_error: bool,
}

/// A commissioning task: what to send next, given what was heard.
pub trait Script {
    /// What the task finds out.
    type Result;

    /// The next exchange, or the result. The first call gets an empty [`Heard`].
    fn next(&mut self, heard: Heard) -> Result<Exchange, Self::Result>;

    /// How the drive at hand reads the documents.
    fn dialect(&self) -> &Dialect;
}

#[derive(Debug)]
enum Phase<R> {
    Sending(Exchange),
    Listening {
        exchange: Exchange,
        until: Instant,
        heard: Heard,
    },
    Done(R),
}

/// Runs one script.
#[derive(Debug)]
pub struct Commissioner<S: Script> {
    script: S,
    phase: Phase<S::Result>,
    windows: u32,
}

impl<S: Script> Commissioner<S> {
    /// Starts a task.
    pub fn new(mut script: S) -> Self {
        let phase = Self::step(&mut script, Heard::default());
        Self {
            script,
            phase,
            windows: 0,
        }
    }

    fn step(script: &mut S, heard: Heard) -> Phase<S::Result> {
        match script.next(heard) {
            Ok(exchange) => Phase::Sending(exchange),
            Err(result) => Phase::Done(result),
        }
    }

    /// Lets time pass; call it at least every millisecond.
    pub fn tick(&mut self, now: Instant) {
        if let Phase::Listening { until, heard, .. } = self.phase
            && now >= until
        {
            self.phase = Self::step(&mut self.script, heard);
        }
    }

    /// The result, once the task is done.
    pub const fn result(&self) -> Option<&S::Result> {
        match &self.phase {
            Phase::Done(result) => Some(result),
            _ => None,
        }
    }

    /// Windows in which it has listened so far: a number that stays shows that nothing gets out to the bus.
    pub const fn windows(&self) -> u32 {
        self.windows
    }

    /// The task itself, for what it has found so far.
    pub const fn script(&self) -> &S {
        &self.script
    }

    fn hear(&mut self, frame: &DataFrame) {
        let Phase::Listening {
            exchange, heard, ..
        } = &mut self.phase
        else {
            return;
        };
        heard.frames = heard.frames.saturating_add(1);
        let Some(sent) = exchange.frame else { return };
        if frame.address() != sent.address() {
            return;
        }
        let dialect = self.script.dialect();
        if let Ok((_, Reply::DriveError(error))) = Reply::decode(frame, None, dialect) {
            heard.data_error |= error == DriveError::DataError;
            return;
        }
        let Some(kind) = exchange
            .answer
            .filter(|kind| kind.function() == frame.function())
        else {
            return;
        };
        heard.answers = heard.answers.saturating_add(1);
        heard.reply_frame = Some(*frame);
        heard.reply = Reply::decode(frame, Some(kind), dialect)
            .ok()
            .map(|(_, reply)| reply);
        if exchange.ends_with_answer {
            let heard = *heard;
            self.phase = Self::step(&mut self.script, heard);
        }
    }
}

impl<S: Script> BusUser for Commissioner<S> {
    type Frame = DataFrame;

    fn send<K: Sink<DataFrame>>(&mut self, now: Instant, sink: &mut K) -> Progress {
        while let Phase::Sending(exchange) = self.phase {
            let outcome = exchange.frame.map(|frame| sink.offer(&frame));
            if matches!(outcome, Some(Outcome::Full)) {
                return Progress::Blocked;
            }
            self.windows = self.windows.wrapping_add(1);
            // Where the controller failed, whether the frame went out is not known; silence in the window says no.
            self.phase = Phase::Listening {
                exchange,
                until: now + exchange.listen_us,
                heard: Heard::default(),
            };
            if let Some(Outcome::Displaced(frame)) = outcome {
                self.on_displaced(now, &frame);
            }
        }
        Progress::Idle
    }

    fn on_displaced(&mut self, _: Instant, frame: &DataFrame) {
        if let Phase::Listening { exchange, .. } = self.phase
            && exchange.frame == Some(*frame)
        {
            self.phase = Phase::Sending(exchange);
        }
    }

    fn on_receive_error(&mut self, _: Instant, _: BusErrorKind) {}

    fn on_frame(&mut self, _: Instant, frame: &DataFrame) {
        self.hear(frame);
    }

    fn on_foreign_frame(&mut self, _: Instant, _: FrameError) {
        if let Phase::Listening { heard, .. } = &mut self.phase {
            heard.frames = heard.frames.saturating_add(1);
        }
    }
}
