//! The view of a motion on a real bus, in a thread of its own: whatever becomes of the terminal, the motion does not wait.

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use ratatui::crossterm::event::{self, Event, KeyCode, KeyEventKind};

use super::{LOAD_WINDOW_US, Screen, TakenTerminal};
use crate::control::{Status, Wish, Wishes, wish};
use crate::interrupt;
use crate::output;
use crate::recording::{About, Item, Recording, Viewer};

/// Time between two pictures.
const PICTURE: Duration = Duration::from_millis(50);
/// Events and messages that are kept for the picture.
const EVENTS: usize = 100;
const MESSAGES: usize = 3;

const KEYS: &str = "up/down select  space pause  + - 1 speed  s stop on the path  Ctrl-C stop: slows down, again: at once  q stop and leave the view";
/// Of a motion that has no path on which it could pause.
const KEYS_TO_STOP: &str =
    "up/down select  s stop: slows down, again: at once  q stop and leave the view";
const KEYS_AT_END: &str = "q leave the view";

/// A view that is open.
pub(crate) struct BusView {
    /// Until the view shall end.
    verdict: Option<Sender<(String, bool)>>,
    thread: Option<JoinHandle<()>>,
}

impl BusView {
    /// Takes the terminal and shows what the viewer is given. Without anybody who obeys wishes the motion can only be stopped.
    pub(crate) fn open(about: &About, wishes: Option<&Wishes>) -> io::Result<(Self, Viewer)> {
        let terminal = TakenTerminal::take()?;
        terminal.keep_signals()?;
        let (viewer, items) = Viewer::new();
        let (verdict, verdicts) = channel();
        let view = View {
            terminal,
            recording: Recording::new(about.clone()),
            selected: 0,
            is_leaving: false,
            wishes: wishes.map(|wishes| (wishes.sender(), wishes.status())),
            requests: interrupt::requests(),
        };
        let thread = std::thread::Builder::new()
            .name("view".to_owned())
            .spawn(move || {
                let mut view = view;
                if let Err(error) = view.run(&items, &verdicts) {
                    drop(view);
                    output::tell(format_args!(
                        "the live view ended: {error}; the motion goes on"
                    ));
                }
            })?;
        let view = Self {
            verdict: Some(verdict),
            thread: Some(thread),
        };
        Ok((view, viewer))
    }

    /// Shows the result until the user leaves; the drives are off.
    pub(crate) fn end(self, verdict: &str, is_good: bool) {
        if let Some(sender) = &self.verdict {
            // A view that was left before is no failure, and its thread has told of one.
            let _ = sender.send((verdict.to_owned(), is_good));
        }
    }
}

impl Drop for BusView {
    /// Waits until the terminal is itself again: after the result until the user leaves, without one at once.
    fn drop(&mut self) {
        self.verdict = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

struct View {
    terminal: TakenTerminal,
    recording: Recording,
    selected: usize,
    is_leaving: bool,
    /// Those who obey, and what they do.
    wishes: Option<(Sender<Wish>, Arc<Status>)>,
    /// Requests to stop that were there before the end.
    requests: u32,
}

impl View {
    fn run(
        &mut self,
        items: &Receiver<Arc<Item>>,
        verdicts: &Receiver<(String, bool)>,
    ) -> io::Result<()> {
        let mut verdict = None;
        while !self.is_leaving {
            let next = Instant::now() + PICTURE;
            self.take(items, next);
            if verdict.is_none() {
                verdict = match verdicts.try_recv() {
                    Ok(verdict) => Some(verdict),
                    Err(TryRecvError::Empty) => None,
                    // The motion did not begin.
                    Err(TryRecvError::Disconnected) => return Ok(()),
                };
                // Ctrl-C from now on leaves the view.
                self.requests = interrupt::requests();
            }
            let shown = verdict.as_ref().map(|(text, good)| (text.as_str(), *good));
            self.draw(shown)?;
            self.keys(verdict.is_some())?;
            self.is_leaving |= verdict.is_some() && interrupt::requests() > self.requests;
        }
        Ok(())
    }

    /// Takes what comes until the next picture.
    fn take(&mut self, items: &Receiver<Arc<Item>>, until: Instant) {
        loop {
            let left = until.saturating_duration_since(Instant::now());
            match items.recv_timeout(left) {
                Ok(item) => self.recording.add(&item),
                Err(RecvTimeoutError::Timeout) => break,
                Err(RecvTimeoutError::Disconnected) => {
                    std::thread::sleep(left);
                    break;
                }
            }
            if left.is_zero() {
                break;
            }
        }
        self.recording.forget_before(LOAD_WINDOW_US, EVENTS);
    }

    fn draw(&mut self, verdict: Option<(&str, bool)>) -> io::Result<()> {
        let speed = self.wishes.as_ref().map(|(_, status)| status.speed());
        let is_paused = speed.is_some_and(|(_, is_paused)| is_paused);
        let status = match () {
            () if verdict.is_some() => "",
            () if interrupt::requests() > 0 => "STOPPING",
            () if is_paused => "PAUSED",
            () => "",
        };
        let head = match speed {
            Some((percent, _)) if self.has_begun() => format!("on the bus at {percent} %"),
            _ => "on the bus".to_owned(),
        };
        let keys = match (verdict, speed) {
            (Some(_), _) => KEYS_AT_END,
            (None, Some(_)) => KEYS,
            (None, None) => KEYS_TO_STOP,
        };
        self.terminal.draw(&Screen {
            recording: &self.recording,
            selected: self.selected,
            off_the_bus: &[],
            head: &head,
            status,
            keys,
            events_title: " events and messages ",
            messages: &output::held(MESSAGES),
            verdict,
        })
    }

    fn keys(&mut self, is_over: bool) -> io::Result<()> {
        while event::poll(Duration::ZERO)? {
            let Event::Key(key) = event::read()? else {
                continue;
            };
            if key.kind == KeyEventKind::Release {
                continue;
            }
            match key.code {
                KeyCode::Up | KeyCode::Char('k') => self.selected = self.selected.saturating_sub(1),
                KeyCode::Down | KeyCode::Char('j') => {
                    let last = self.recording.about.axes.len().saturating_sub(1);
                    self.selected = (self.selected + 1).min(last);
                }
                // Nothing goes on a path, or not yet.
                KeyCode::Char('s') if !is_over && !self.takes_wishes() => interrupt::request(),
                KeyCode::Char('q') | KeyCode::Esc => {
                    self.is_leaving = true;
                    if !is_over {
                        interrupt::request();
                    }
                }
                KeyCode::Char(key) if !is_over => {
                    let wish = u8::try_from(key).ok().and_then(wish);
                    if let (Some(wish), Some((wishes, _))) = (wish, &self.wishes) {
                        // Whoever has ended does not listen any more.
                        let _ = wishes.send(wish);
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn takes_wishes(&self) -> bool {
        self.has_begun() && self.wishes.is_some()
    }

    fn has_begun(&self) -> bool {
        self.recording.motion_start.is_some()
    }
}
