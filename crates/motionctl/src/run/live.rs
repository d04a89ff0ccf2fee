//! The view of a motion on a real bus, in a thread of its own: whatever becomes of the terminal, the motion does not wait.

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use ratatui::crossterm::event::{self, Event, KeyCode, KeyEventKind};

use crate::interrupt;
use crate::live_view::{LOAD_WINDOW_US, Screen, TakenTerminal};
use crate::output;
use crate::recording::{About, Item, Recording, Viewer};

/// Time between two pictures.
const PICTURE: Duration = Duration::from_millis(50);
/// Events and messages that are kept for the picture.
const EVENTS: usize = 100;
const MESSAGES: usize = 3;

const KEYS: &str =
    "up/down select  s or Ctrl-C stop: slows down, again: at once  q stop and leave the view";
const KEYS_AT_END: &str = "q leave the view";

/// A view that is open.
pub(super) struct LiveView {
    verdict: Sender<(String, bool)>,
    thread: JoinHandle<()>,
}

impl LiveView {
    /// Takes the terminal and shows what the viewer is given.
    pub(super) fn open(about: &About) -> io::Result<(Self, Viewer)> {
        let terminal = TakenTerminal::take()?;
        terminal.keep_signals()?;
        let (viewer, items) = Viewer::new();
        let (verdict, verdicts) = channel();
        let view = View {
            terminal,
            recording: Recording::new(about.clone()),
            selected: 0,
            is_leaving: false,
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
        Ok((Self { verdict, thread }, viewer))
    }

    /// Shows the result until the user leaves; the drives are off.
    pub(super) fn end(self, verdict: &str, is_good: bool) {
        // A view that was left before is no failure, and its thread has told of one.
        let _ = self.verdict.send((verdict.to_owned(), is_good));
        let _ = self.thread.join();
    }
}

struct View {
    terminal: TakenTerminal,
    recording: Recording,
    selected: usize,
    is_leaving: bool,
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
        let mut is_over = false;
        while !self.is_leaving {
            let next = Instant::now() + PICTURE;
            is_over |= self.take(items, next);
            if is_over && verdict.is_none() {
                verdict = verdicts.recv_timeout(PICTURE).ok();
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

    /// Takes what came until the next picture; true when nothing will come any more.
    fn take(&mut self, items: &Receiver<Arc<Item>>, until: Instant) -> bool {
        loop {
            let left = until.saturating_duration_since(Instant::now());
            match items.recv_timeout(left) {
                Ok(item) => self.recording.add(&item),
                Err(RecvTimeoutError::Timeout) => break,
                Err(RecvTimeoutError::Disconnected) => {
                    std::thread::sleep(left);
                    return true;
                }
            }
            if left.is_zero() {
                break;
            }
        }
        self.recording.forget_before(LOAD_WINDOW_US, EVENTS);
        false
    }

    fn draw(&mut self, verdict: Option<(&str, bool)>) -> io::Result<()> {
        let is_stopping = interrupt::requests() > 0 && verdict.is_none();
        self.terminal.draw(&Screen {
            recording: &self.recording,
            selected: self.selected,
            off_the_bus: &[],
            head: "on the bus",
            status: if is_stopping { "STOPPING" } else { "" },
            keys: if verdict.is_some() { KEYS_AT_END } else { KEYS },
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
                KeyCode::Char('s') if !is_over => interrupt::request(),
                KeyCode::Char('q') | KeyCode::Esc => {
                    self.is_leaving = true;
                    if !is_over {
                        interrupt::request();
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }
}
