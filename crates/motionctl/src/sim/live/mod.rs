//! A view of the running simulation in the terminal, with keys that interfere.

mod keys;
mod pace;

use std::time::{Duration, Instant};

use ratatui::crossterm::event::{self, Event};

use super::error::SimError;
use super::spectator::{Order, Spectator};
use crate::live_view::{Screen, TakenTerminal};
use crate::output;
use crate::recording::Recording;
use crate::set_points::Speed as MotionSpeed;
use keys::{KEYS, KEYS_WITHOUT_PATH, Key, Panel, Wish};
use pace::Pace;

/// Messages of the tool that are shown.
const MESSAGES: usize = 2;

/// Time between two pictures.
const PICTURE: Duration = Duration::from_millis(50);

/// The live view; the terminal is itself again when this is dropped.
pub(super) struct LiveView {
    terminal: TakenTerminal,
    panel: Panel,
    /// It can be paused, and played at another speed.
    has_path: bool,
    pace: Pace,
    last_picture: Option<Instant>,
    motion_us: u64,
    speed: Option<MotionSpeed>,
}

impl LiveView {
    /// Takes the terminal, for so many axes and a motion of this length.
    pub(super) fn open(axes: usize, motion_us: u64, has_path: bool) -> Result<Self, SimError> {
        let terminal = TakenTerminal::take().map_err(SimError::Terminal)?;
        Ok(Self {
            terminal,
            panel: Panel::new(axes),
            has_path,
            pace: Pace::new(),
            last_picture: None,
            motion_us,
            speed: None,
        })
    }

    /// A picture when it is time for one, and the keys that were pressed.
    fn picture(&mut self, recording: &Recording) -> Result<Vec<Order>, SimError> {
        let now = Instant::now();
        if self.last_picture.is_some_and(|last| now - last < PICTURE) {
            return Ok(Vec::new());
        }
        self.last_picture = Some(now);
        self.draw(recording, None)?;
        self.read_keys(Duration::ZERO)
    }

    fn draw(
        &mut self,
        recording: &Recording,
        verdict: Option<(&str, bool)>,
    ) -> Result<(), SimError> {
        let status = if self.panel.is_frozen() {
            "FROZEN"
        } else if self.speed.is_some_and(|speed| speed.is_paused) {
            "PAUSED"
        } else if self.pace.is_behind() {
            "too slow for real time"
        } else {
            ""
        };
        let screen = Screen {
            recording,
            selected: self.panel.selected(),
            off_the_bus: self.panel.unplugged(),
            head: &format!(
                "motion {:.1} s at {:.0} %   time {}x",
                self.motion_us as f64 * 1e-6,
                self.speed.map_or(100.0, |speed| speed.actual_percent),
                self.panel.speed()
            ),
            status,
            keys: if self.has_path {
                KEYS
            } else {
                KEYS_WITHOUT_PATH
            },
            events_title: &format!(
                " events;  keys a and p are for {} ",
                recording.name(self.panel.selected())
            ),
            messages: &output::held(MESSAGES),
            verdict,
        };
        self.terminal.draw(&screen).map_err(SimError::Terminal)
    }

    /// Every key that was pressed; waits for the first one for a while.
    fn read_keys(&mut self, mut patience: Duration) -> Result<Vec<Order>, SimError> {
        let mut orders = Vec::new();
        while event::poll(patience).map_err(SimError::Terminal)? {
            patience = Duration::ZERO;
            let Event::Key(pressed) = event::read().map_err(SimError::Terminal)? else {
                continue;
            };
            let Some(key) = Key::of(&pressed) else {
                continue;
            };
            match self.panel.press(key) {
                Some(Wish::Order(order)) => orders.push(order),
                Some(Wish::Speed(speed)) => self.pace.set_speed(speed),
                None => {}
            }
        }
        Ok(orders)
    }
}

impl Spectator for LiveView {
    fn after_cycle(&mut self, recording: &Recording) -> Result<Vec<Order>, SimError> {
        let now_us = recording.latest.as_ref().map_or(0, |sample| sample.at_us);
        let mut orders = self.picture(recording)?;
        while self.panel.is_frozen() {
            self.draw(recording, None)?;
            orders.extend(self.read_keys(PICTURE)?);
            self.pace.restart(now_us);
        }
        // Waits in steps, so that keys work at any speed.
        while let Some(wait) = self.pace.wait(now_us).filter(|_| !self.panel.is_leaving()) {
            std::thread::sleep(wait.min(PICTURE));
            orders.extend(self.picture(recording)?);
        }
        Ok(orders)
    }

    fn speed(&mut self, speed: MotionSpeed) {
        self.speed = Some(speed);
    }

    fn end(&mut self, recording: &Recording, verdict: &str, is_good: bool) -> Result<(), SimError> {
        while !self.panel.is_leaving() {
            self.draw(recording, Some((verdict, is_good)))?;
            // Nothing runs any more that could obey.
            let _ = self.read_keys(PICTURE)?;
        }
        Ok(())
    }

    fn owns_terminal(&self) -> bool {
        true
    }
}
