//! Who looks at a simulation while it runs, and may interfere.

use super::error::SimError;
use crate::control::Wish;
use crate::recording::Recording;
use crate::set_points::Speed;

/// What a spectator wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Order {
    /// Ramp down and end the motion.
    Stop,
    /// Pause, speed and stop of the motion, on its path.
    Motion(Wish),
    /// Let the drive of an axis report an alarm.
    Alarm(usize),
    /// Pull the drive of an axis off the bus.
    Unplug(usize),
    /// Plug it in again.
    PlugIn(usize),
}

/// Someone who is shown every cycle of a run that is recorded.
pub(crate) trait Spectator {
    /// Called after each cycle; may wait, so that virtual time passes like real time.
    fn after_cycle(&mut self, recording: &Recording) -> Result<Vec<Order>, SimError>;

    /// How fast the motion goes, before each picture.
    fn speed(&mut self, speed: Speed);

    /// Called once, when nothing will change any more.
    fn end(&mut self, recording: &Recording, verdict: &str, is_good: bool) -> Result<(), SimError>;

    /// Whether messages would disturb what it shows.
    fn owns_terminal(&self) -> bool;
}

/// No spectator.
pub(crate) struct Nobody;

impl Spectator for Nobody {
    fn after_cycle(&mut self, _recording: &Recording) -> Result<Vec<Order>, SimError> {
        Ok(Vec::new())
    }

    fn speed(&mut self, _speed: Speed) {}

    fn end(&mut self, _: &Recording, _: &str, _: bool) -> Result<(), SimError> {
        Ok(())
    }

    fn owns_terminal(&self) -> bool {
        false
    }
}
