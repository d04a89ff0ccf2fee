//! What becomes of a stream of segments.

use serde::{Deserialize, Serialize};

/// What becomes of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum StreamPhase {
    /// None was begun.
    #[default]
    Idle,
    /// It waits for its start, or for enough segments.
    Waiting,
    /// The axes are on their way, or paused on it.
    Moving,
    /// The segments ran out, the axes stand on the way, and go on when enough follow.
    Dry,
    /// The axes stand where its end was announced.
    Complete,
    /// The segments ran out, the axes stand on the way, and that is the end.
    DriedUp,
    /// It was told to stop, and the axes stand on the way.
    Stopped,
    /// At its start the axes stood elsewhere: nothing has moved.
    Displaced,
}

impl StreamPhase {
    const ALL: [Self; 8] = [
        Self::Idle,
        Self::Waiting,
        Self::Moving,
        Self::Dry,
        Self::Complete,
        Self::DriedUp,
        Self::Stopped,
        Self::Displaced,
    ];

    /// Whether it moves the axes, or may do so yet.
    #[must_use]
    pub const fn is_active(self) -> bool {
        matches!(self, Self::Waiting | Self::Moving | Self::Dry)
    }

    /// The number on the wire.
    pub(super) const fn number(self) -> u8 {
        self as u8
    }

    pub(super) fn of_number(number: u8) -> Self {
        let all = Self::ALL.iter();
        let found = all.copied().find(|phase| phase.number() == number);
        found.unwrap_or_default()
    }
}

/// What a player does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct PlayerState {
    /// What becomes of the stream.
    pub phase: StreamPhase,
    /// Whole cycles of the stream that have passed.
    pub time_cycles: u32,
    /// Segments that have been played to their end.
    pub finished: u32,
    /// Percent of the speed of the stream, at this moment.
    pub percent: u16,
}
