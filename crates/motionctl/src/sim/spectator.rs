//! Who looks at a simulation while it runs, and may interfere.

use super::error::SimError;
use super::faults::Fault;
use super::summary::Summary;
use crate::recording::Recording;

/// What a spectator wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Order {
    /// Ramp down and end the motion.
    Stop,
    /// Let something go wrong.
    Fault(Fault),
}

/// Someone who is shown every cycle of a run that is recorded.
pub(crate) trait Spectator {
    /// Called after each cycle; may wait, so that virtual time passes like real time.
    fn after_cycle(&mut self, recording: &Recording) -> Result<Vec<Order>, SimError>;

    /// Called once, when nothing will change any more.
    fn end(&mut self, recording: &Recording, summary: &Summary) -> Result<(), SimError>;

    /// Whether messages would disturb what it shows.
    fn owns_terminal(&self) -> bool;
}

/// No spectator.
pub(crate) struct Nobody;

impl Spectator for Nobody {
    fn after_cycle(&mut self, _recording: &Recording) -> Result<Vec<Order>, SimError> {
        Ok(Vec::new())
    }

    fn end(&mut self, _recording: &Recording, _summary: &Summary) -> Result<(), SimError> {
        Ok(())
    }

    fn owns_terminal(&self) -> bool {
        false
    }
}
