//! What is read and how often.

use crate::servo::poll_kind::PollKind;

/// Periods of the polls of one axis in microseconds; `None` turns a poll off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PollPeriods {
    /// Status byte.
    pub status_us: Option<u32>,
    /// Position.
    pub position_us: Option<u32>,
    /// Torque.
    pub torque_us: Option<u32>,
    /// Motor speed.
    pub speed_us: Option<u32>,
    /// Diagnostic counter: shows that the drive lives and that it did not restart.
    pub counter_us: Option<u32>,
}

impl PollPeriods {
    /// Status and position at 50 Hz.
    pub const DEFAULT: Self = Self {
        status_us: Some(20_000),
        position_us: Some(20_000),
        torque_us: None,
        speed_us: None,
        counter_us: None,
    };

    /// No polls.
    pub const OFF: Self = Self {
        status_us: None,
        position_us: None,
        torque_us: None,
        speed_us: None,
        counter_us: None,
    };

    /// The period of one kind.
    #[must_use]
    pub const fn of(&self, kind: PollKind) -> Option<u32> {
        match kind {
            PollKind::Status => self.status_us,
            PollKind::Position => self.position_us,
            PollKind::Torque => self.torque_us,
            PollKind::Speed => self.speed_us,
            PollKind::Counter => self.counter_us,
        }
    }
}
