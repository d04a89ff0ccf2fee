//! A view of the running simulation in the terminal, with keys that interfere.

mod keys;
mod pace;
mod screen;

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use can_motion::ServoMaster;
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event};

use super::error::SimError;
use super::recording::Recording;
use super::setup::{MOST_AXES, Setup};
use super::spectator::{Order, Spectator};
use super::summary::Summary;
use crate::set_points::Speed as MotionSpeed;
use crate::trajectory::Plan;
use keys::{Key, Panel, Wish};
use pace::Pace;
use screen::Screen;

/// Time between two pictures.
const PICTURE: Duration = Duration::from_millis(50);

/// The live view; the terminal is itself again when this is dropped.
pub(super) struct LiveView {
    terminal: DefaultTerminal,
    panel: Panel,
    pace: Pace,
    last_picture: Option<Instant>,
    motion_us: u64,
    speed: Option<MotionSpeed>,
}

impl LiveView {
    /// Takes the terminal.
    pub(super) fn open(setup: &Setup, plan: &Plan) -> Result<Self, SimError> {
        if !std::io::stdout().is_terminal() || !std::io::stdin().is_terminal() {
            let reason = "standard input and output are no terminal";
            return Err(SimError::Terminal(std::io::Error::other(reason)));
        }
        let terminal = ratatui::try_init().map_err(SimError::Terminal)?;
        Ok(Self {
            terminal,
            panel: Panel::new(setup.drives.clone()),
            pace: Pace::new(),
            last_picture: None,
            motion_us: plan.cycles() as u64 * u64::from(setup.cycle_us),
            speed: None,
        })
    }

    /// A picture when it is time for one, and the keys that were pressed.
    fn picture(
        &mut self,
        recording: &Recording,
        states: &[String],
    ) -> Result<Vec<Order>, SimError> {
        let now = Instant::now();
        if self.last_picture.is_some_and(|last| now - last < PICTURE) {
            return Ok(Vec::new());
        }
        self.last_picture = Some(now);
        self.draw(recording, states, None)?;
        self.read_keys(Duration::ZERO)
    }

    fn draw(
        &mut self,
        recording: &Recording,
        states: &[String],
        verdict: Option<&str>,
    ) -> Result<(), SimError> {
        let screen = Screen {
            recording,
            states,
            panel: &self.panel,
            motion_us: self.motion_us,
            is_behind: self.pace.is_behind(),
            speed: self.speed,
            verdict,
        };
        self.terminal
            .draw(|frame| screen.draw(frame))
            .map_err(SimError::Terminal)?;
        Ok(())
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
    fn after_cycle(
        &mut self,
        recording: &Recording,
        master: &ServoMaster<MOST_AXES>,
        places: &[usize],
    ) -> Result<Vec<Order>, SimError> {
        let now_us = recording.samples.last().map_or(0, |sample| sample.at_us);
        let states: Vec<String> = places
            .iter()
            .filter_map(|&place| master.snapshot(place))
            .map(|axis| axis.state.to_string())
            .collect();
        let mut orders = self.picture(recording, &states)?;
        while self.panel.is_frozen() {
            self.draw(recording, &states, None)?;
            orders.extend(self.read_keys(PICTURE)?);
            self.pace.restart(now_us);
        }
        // Waits in steps, so that keys work at any speed.
        while let Some(wait) = self.pace.wait(now_us).filter(|_| !self.panel.is_leaving()) {
            std::thread::sleep(wait.min(PICTURE));
            orders.extend(self.picture(recording, &states)?);
        }
        Ok(orders)
    }

    fn speed(&mut self, speed: MotionSpeed) {
        self.speed = Some(speed);
    }

    fn end(&mut self, recording: &Recording, summary: &Summary) -> Result<(), SimError> {
        let states: Vec<String> = summary.axes.iter().map(|axis| axis.state.clone()).collect();
        while !self.panel.is_leaving() {
            self.draw(recording, &states, Some(summary.verdict()))?;
            // Nothing runs any more that could obey.
            let _ = self.read_keys(PICTURE)?;
        }
        Ok(())
    }

    fn owns_terminal(&self) -> bool {
        true
    }
}

impl Drop for LiveView {
    fn drop(&mut self) {
        ratatui::restore();
    }
}
