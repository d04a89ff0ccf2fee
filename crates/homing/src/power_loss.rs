//! What is known after the drive has lost its power.

/// What a drive knows of its position when it starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PositionMemory {
    /// It counts from 0 wherever its shaft stands.
    Incremental,
    /// It has a stored zero, and moves its motor there when it starts.
    MovesToStoredZero,
    /// It keeps its position over any number of turns, also one that changed without power.
    MultiTurn,
}

/// What is known of the position of an axis after its drive has lost its power.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AfterPowerLoss {
    /// Nothing: home again before any move to a position.
    HomeAgain,
    /// The motor moves by itself at power-on. Where the axis is afterwards is only as sure as the drive's memory of whole turns, which
    /// its documents do not state: home again, or compare with a mark on the machine.
    MovesAndCheck,
    /// The position is still known.
    Known,
}

impl AfterPowerLoss {
    /// What is known with this drive. It is the same for the software origin and for the drive's own zero: both stand on the count of the
    /// drive.
    #[must_use]
    pub const fn of(memory: PositionMemory) -> Self {
        match memory {
            PositionMemory::Incremental => Self::HomeAgain,
            PositionMemory::MovesToStoredZero => Self::MovesAndCheck,
            PositionMemory::MultiTurn => Self::Known,
        }
    }
}
