//! The thread of a link: bytes between the port and the client. It keeps the session alive whatever Python does; what it is asked for
//! comes from [`Shared`].

use std::collections::HashMap;
use std::io;
use std::sync::Arc;
use std::time::{Duration, Instant};

use board_link::host::{Client, ClientConfig, Incoming, RequestError, StreamEnd};
use board_link::message::{Answer, Request};

use super::port::Port;
use super::state::{End, Shared, State, ends};

/// Segments on their way, and bytes that wait: few, so that a stop does not wait behind them.
const WINDOW: usize = 32;
const OUT: usize = 2_048;
/// After the command was given back the port is closed, with or without a reply.
const GOODBYE: Duration = Duration::from_millis(500);
/// Snapshots come so often.
const SNAPSHOT_US: u32 = 50_000;

/// What a ticket of the client stands for.
enum Waiter {
    Caller(u64),
    /// A request of the thread itself.
    Nobody,
    /// The one for snapshots.
    Snapshots,
    Goodbye,
}

pub(super) struct Worker {
    shared: Arc<Shared>,
    port: Port,
    client: Client<WINDOW, OUT>,
    start: Instant,
    tickets: HashMap<u16, Waiter>,
    wants_snapshots: bool,
    has_ended_snapshots: bool,
    /// The board has answered the request for snapshots: those before were asked for by another program.
    has_snapshots: bool,
    goodbye: Option<Instant>,
    is_over: bool,
}

impl Worker {
    pub(super) fn new(shared: Arc<Shared>, port: Port, config: ClientConfig, seed: u32) -> Self {
        Self {
            shared,
            port,
            client: Client::new(config, seed),
            start: Instant::now(),
            tickets: HashMap::new(),
            wants_snapshots: false,
            has_ended_snapshots: false,
            has_snapshots: false,
            goodbye: None,
            is_over: false,
        }
    }

    /// Runs until the link is closed or the port is gone.
    pub(super) fn run(mut self) {
        let mut buffer = [0; 4_096];
        while !self.is_over {
            if let Err(error) = self.turn(&mut buffer) {
                self.shared.lock().gone = Some(format!("the port is gone: {error}"));
                break;
            }
        }
        let shared = Arc::clone(&self.shared);
        let mut state = shared.lock();
        state.is_connected = false;
        self.give_up(&mut state);
        if state.gone.is_none() {
            state.gone = Some("the link is closed".to_owned());
        }
        drop(state);
        shared.tell();
    }

    fn turn(&mut self, buffer: &mut [u8]) -> io::Result<()> {
        let count = self.port.read(buffer)?;
        let now_us = self.start.elapsed().as_micros() as u64;
        let bytes = buffer.get(..count).unwrap_or_default();
        self.client.on_bytes(now_us, bytes);
        let shared = Arc::clone(&self.shared);
        let mut state = shared.lock();
        // Before the next stream is begun: the end of the one before is not its own.
        let mut has_news = self.take_all(&mut state);
        self.take_orders(&mut state);
        self.client.poll(now_us);
        has_news |= self.take_all(&mut state);
        drop(state);
        if has_news || count > 0 {
            shared.tell();
        }
        self.send()
    }

    fn send(&mut self) -> io::Result<()> {
        while !self.client.output().is_empty() {
            let count = self.port.write(self.client.output())?;
            if count == 0 {
                return Ok(());
            }
            self.client.consume(count);
        }
        Ok(())
    }

    fn take_orders(&mut self, state: &mut State) {
        if state.is_closing {
            return self.say_goodbye();
        }
        if self.wants_snapshots
            && let Some(info) = self.client.info()
        {
            let period = SNAPSHOT_US.div_ceil(info.cycle_us.max(1));
            if let Ok(ticket) = self.client.request(Request::Snapshots { period }) {
                self.tickets.insert(ticket, Waiter::Snapshots);
                self.wants_snapshots = false;
            }
        }
        self.pass_requests(state);
        self.pass_stream(state);
    }

    /// In order, but for what stops: that waits for nothing, and nothing that waited before it moves or enables behind it.
    fn pass_requests(&mut self, state: &mut State) {
        let urgent = state.requests.iter().position(|one| ends(&one.1));
        if let Some(urgent) = urgent {
            let (mut place, mut given_up) = (0, Vec::new());
            state.requests.retain(|(ticket, request)| {
                let moves = matches!(
                    request,
                    Request::Enable | Request::Home | Request::Resume | Request::Override { .. }
                );
                let is_kept = place >= urgent || !moves;
                place += 1;
                if !is_kept {
                    given_up.push(*ticket);
                }
                is_kept
            });
            for ticket in given_up {
                let _ = state
                    .replies
                    .insert(ticket, Err(RequestError::TimedOut { tries: 0 }));
            }
        }
        let urgent = state.requests.iter().position(|one| ends(&one.1));
        for place in [urgent, Some(0)].into_iter().flatten() {
            let Some((ticket, request)) = state.requests.get(place) else {
                continue;
            };
            match self.client.request(request.clone()) {
                Ok(number) => {
                    self.tickets.insert(number, Waiter::Caller(*ticket));
                }
                Err(RequestError::Busy) => continue,
                Err(error) => {
                    let _ = state.replies.insert(*ticket, Err(error));
                }
            }
            state.requests.remove(place);
        }
    }

    fn pass_stream(&mut self, state: &mut State) {
        // It would stop what was begun behind it.
        let waits = state.requests.iter().any(|one| ends(&one.1));
        let Some(stream) = &mut state.stream else {
            return;
        };
        if let Some(begin) = &stream.begin {
            if waits {
                return;
            }
            match self.client.begin(begin.clone()) {
                Ok(()) => stream.begin = None,
                // The one before is still at its end.
                Err(RequestError::Busy) => return,
                Err(_) => {
                    stream.begin = None;
                    stream.end = Some(End::Told(StreamEnd::Lost));
                }
            }
        }
        if stream.end.is_some() {
            stream.segments.clear();
        }
        while self.client.wants_segment() {
            let Some(segment) = stream.segments.pop_front() else {
                break;
            };
            // It was asked whether there is room.
            let _ = self.client.offer(segment);
        }
        if stream.is_finished && stream.segments.is_empty() && !stream.is_finish_told {
            stream.is_finish_told = true;
            self.client.finish();
        }
    }

    /// Takes what the client says; whether there was anything.
    fn take_all(&mut self, state: &mut State) -> bool {
        let mut has_news = false;
        while let Some(incoming) = self.client.next() {
            self.take(state, incoming);
            has_news = true;
        }
        has_news
    }

    fn take(&mut self, state: &mut State, incoming: Incoming) {
        match incoming {
            Incoming::Connected { .. } => {
                state.is_connected = true;
                state.unavailable = None;
                self.wants_snapshots = true;
                self.has_snapshots = false;
            }
            Incoming::Disconnected => {
                state.is_connected = false;
                self.give_up(state);
            }
            Incoming::Unavailable(refused) => state.unavailable = Some(refused),
            Incoming::Reply { ticket, result } => self.take_reply(state, ticket, result),
            Incoming::Stream(end) => {
                if let Some(stream) = &mut state.stream
                    && stream.begin.is_none()
                {
                    stream.end.get_or_insert(End::Told(end));
                    stream.segments.clear();
                }
            }
            Incoming::Event { number, event } => state.keep_event(number, event),
            Incoming::EventsLost(count) => state.events_lost += u64::from(count),
            Incoming::Snapshot(_) if !self.has_snapshots => {}
            Incoming::Snapshot(snapshot) => state.keep_snapshot(snapshot),
        }
    }

    fn take_reply(&mut self, state: &mut State, ticket: u16, result: Result<Answer, RequestError>) {
        match self.tickets.remove(&ticket) {
            Some(Waiter::Caller(caller)) => {
                let _ = state.replies.insert(caller, result);
            }
            Some(Waiter::Goodbye) => self.is_over = true,
            Some(Waiter::Snapshots) => self.has_snapshots = true,
            Some(Waiter::Nobody) | None => {}
        }
    }

    /// Nobody waits for an answer that cannot come.
    fn give_up(&mut self, state: &mut State) {
        for (ticket, _) in core::mem::take(&mut state.requests) {
            let _ = state.replies.insert(ticket, Err(RequestError::Lost));
        }
        for (_, waiter) in self.tickets.drain() {
            if let Waiter::Caller(ticket) = waiter {
                let _ = state.replies.insert(ticket, Err(RequestError::Lost));
            }
        }
        if let Some(stream) = &mut state.stream
            && stream.end.is_none()
        {
            stream.begin = None;
            stream.end = Some(End::Told(StreamEnd::Lost));
        }
    }

    /// Gives the command back, so that the next program need not wait.
    fn say_goodbye(&mut self) {
        let since = *self.goodbye.get_or_insert_with(Instant::now);
        self.is_over |= !self.client.is_connected() || since.elapsed() > GOODBYE;
        if !self.has_ended_snapshots {
            // They would wait for the next program.
            let end = Request::Snapshots { period: 0 };
            if let Ok(ticket) = self.client.request(end) {
                self.tickets.insert(ticket, Waiter::Nobody);
                self.has_ended_snapshots = true;
            }
            return;
        }
        let is_asked = self
            .tickets
            .values()
            .any(|one| matches!(one, Waiter::Goodbye));
        if !is_asked && let Ok(ticket) = self.client.request(Request::Release) {
            self.tickets.insert(ticket, Waiter::Goodbye);
        }
    }
}
