//! The threads of a stream: one lets senders in, one reads, one writes.

use std::io::{self, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Instant;

use board_link::{AxisLimits, Config};
use trajectory::Position;

use super::answer::{Answer, LAST_WORDS, Out, write_answers};
use super::conversation::{Conversation, Incoming};
use super::parser::{Parsed, Parser};
use super::source::{Buffer, StreamSource};
use crate::endpoint::{Endpoint, EndpointError, LineReader, Listener, Peer};
use crate::trajectory::MotionOptions;

/// Lines that wait for the next cycle.
const WAITING_LINES: usize = 32;
/// Answers that wait for the sender to read.
const WAITING_ANSWERS: usize = 1_024;

/// A place where a sender can come; nobody is let in yet.
pub(crate) struct Open {
    endpoint: Endpoint,
    listener: Option<Listener>,
}

/// A stream that runs.
pub(crate) struct Session {
    answers: SyncSender<Answer>,
    writer: JoinHandle<()>,
    /// Held as long as senders may come.
    _listener: Option<Listener>,
}

impl Open {
    /// Opens the port or the socket.
    ///
    /// # Errors
    /// [`EndpointError`].
    pub(crate) fn new(endpoint: &Endpoint, allow_remote: bool) -> Result<Self, EndpointError> {
        let listener = match endpoint {
            Endpoint::StandardInput => None,
            endpoint => Some(Listener::open(endpoint, allow_remote)?),
        };
        Ok(Self {
            endpoint: endpoint.clone(),
            listener,
        })
    }

    /// Where senders find it.
    pub(crate) fn place(&self) -> String {
        match (
            &self.endpoint,
            self.listener.as_ref().and_then(Listener::port),
        ) {
            (Endpoint::StandardInput, _) => "standard input".to_owned(),
            (Endpoint::Tcp { host, .. }, Some(port)) => {
                format!("tcp:{}:{port}", host.as_deref().unwrap_or("127.0.0.1"))
            }
            (endpoint, _) => endpoint.to_string(),
        }
    }

    /// Lets a sender in whose set-points are buffered here.
    ///
    /// # Errors
    /// When the system has no threads or handles left, or there are more axes than a stream can have.
    pub(crate) fn start(
        self,
        options: &MotionOptions,
        limits: &[AxisLimits],
        config: Config,
        cycle_us: u32,
    ) -> io::Result<(Session, StreamSource)> {
        let stand = vec![Position::ZERO; limits.len()];
        let buffer = Buffer::new(limits, &stand, config).map(Box::new);
        let buffer = buffer.ok_or_else(|| io::Error::other("too many axes for a stream"))?;
        let (session, conversation) = self.admit(options, limits.len(), cycle_us)?;
        Ok((session, StreamSource::new(buffer, conversation)))
    }

    /// Lets a sender in whose set-points are taken elsewhere.
    ///
    /// # Errors
    /// When the system has no threads or handles left.
    pub(crate) fn admit(
        self,
        options: &MotionOptions,
        axes: usize,
        cycle_us: u32,
    ) -> io::Result<(Session, Conversation)> {
        let (lines, incoming) = sync_channel(WAITING_LINES);
        let (answers, written) = sync_channel(WAITING_ANSWERS);
        let reader = Reader {
            options: options.clone(),
            axes,
            lines,
            answers: answers.clone(),
        };
        let spawn = std::thread::Builder::new;
        let writer = match &self.listener {
            None => {
                spawn().spawn(move || reader.read(io::stdin()))?;
                spawn().spawn(move || write_answers(&written, Out::User { shown: 0 }))?
            }
            Some(listener) => {
                let door = listener.handle()?;
                let (hand_over, first) = sync_channel::<Peer>(1);
                spawn().spawn(move || let_in(&door, &reader, &hand_over))?;
                spawn().spawn(move || write_to(&first, &written))?
            }
        };
        let conversation = Conversation::new(cycle_us, incoming, answers.clone());
        let session = Session {
            answers,
            writer,
            _listener: self.listener,
        };
        Ok((session, conversation))
    }
}

impl Session {
    /// Tells the sender how the motion ended, and waits a little for it to listen.
    pub(crate) fn close(self, how: &str) {
        let told = self.answers.try_send(Answer::End(how.to_owned()));
        let start = Instant::now();
        while told.is_ok() && !self.writer.is_finished() && start.elapsed() < LAST_WORDS {
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
    }
}

/// The first one is the writer; everybody else is told so.
fn let_in(door: &crate::endpoint::Door, reader: &Reader, hand_over: &SyncSender<Peer>) {
    let is_taken = Arc::new(AtomicBool::new(false));
    while let Ok(peer) = door.next() {
        if is_taken.swap(true, Ordering::Relaxed) {
            peer.dismiss(
                "error 0 301 this stream has a writer already: expected one at a time, got another",
            );
            continue;
        }
        let Ok(answers) = peer.again() else {
            continue;
        };
        let _ = hand_over.send(answers);
        let reader = reader.clone();
        // Without a thread nobody reads it, and the sender gets no credit.
        let _ = std::thread::Builder::new().spawn(move || reader.read(peer));
    }
}

fn write_to(first: &Receiver<Peer>, answers: &Receiver<Answer>) {
    // Answers to nobody are the end of a motion without a sender.
    loop {
        match first.recv_timeout(std::time::Duration::from_millis(20)) {
            Ok(peer) => return write_answers(answers, Out::Peer(peer)),
            Err(std::sync::mpsc::RecvTimeoutError::Disconnected) => return,
            Err(std::sync::mpsc::RecvTimeoutError::Timeout) => {
                let mut waiting = answers.try_iter();
                if waiting.any(|answer| matches!(answer, Answer::End(_))) {
                    return;
                }
            }
        }
    }
}

/// Reads the lines of a sender.
#[derive(Clone)]
struct Reader {
    options: MotionOptions,
    axes: usize,
    lines: SyncSender<Incoming>,
    answers: SyncSender<Answer>,
}

impl Reader {
    fn read(&self, input: impl Read) {
        let mut parser = Parser::new(&self.options, self.axes);
        let mut lines = LineReader::new(input);
        let (mut number, mut knows_json) = (0, false);
        // A connection that breaks is one that ends.
        while let Ok(Some(line)) = lines.next() {
            number += 1;
            let parsed = parser.line(number, &line);
            if parser.is_json() && !knows_json {
                knows_json = true;
                let _ = self.answers.send(Answer::Json);
            }
            if self.hand_on(number, parsed).is_err() {
                return;
            }
        }
        let _ = self.lines.send(Incoming::Gone);
    }

    /// Waits until there is room: that is what holds a sender back that does not look at its credit.
    fn hand_on(
        &self,
        line: u64,
        parsed: Result<Parsed, super::parser::LineError>,
    ) -> Result<(), std::sync::mpsc::SendError<Incoming>> {
        let incoming = match parsed {
            Ok(Parsed::Nothing) => return Ok(()),
            Ok(Parsed::Names(layout)) => Incoming::Names(layout),
            Ok(Parsed::SetPoint(set_point, layout)) => {
                if let Some(layout) = layout {
                    self.lines.send(Incoming::Names(layout))?;
                }
                Incoming::SetPoint { line, set_point }
            }
            Ok(Parsed::Order(order)) => Incoming::Order { line, order },
            Ok(Parsed::Status) => Incoming::Status { line },
            Ok(Parsed::End) => Incoming::End { line },
            Err(error) => {
                // A sender that reads no answers is read no further.
                let _ = self.answers.try_send(Answer::Bad { line, error });
                Incoming::Bad { line }
            }
        };
        self.lines.send(incoming)
    }
}
