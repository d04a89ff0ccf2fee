//! What the application tells in every cycle.

/// A value and when it was read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reading<T> {
    /// The value.
    pub value: T,
    /// When it came, in microseconds of the clock of the calls.
    pub at_us: u64,
}

impl<T> Reading<T> {
    /// How old it is, in microseconds; 0 for one of the future.
    #[must_use]
    pub const fn age_us(&self, now_us: u64) -> u64 {
        now_us.saturating_sub(self.at_us)
    }
}

/// What is known of the axis in a cycle. Positions are in counts of the set-points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Inputs {
    /// Where the set-points that were sent have led.
    pub sent_counts: i32,
    /// The position that the drive reported last.
    pub position: Option<Reading<i32>>,
    /// The torque that the drive reported last, in thousandths of its peak, positive where it turns the motor towards larger counts.
    /// The sign of a reply belongs to the revision of the drive: let its codec apply it.
    pub torque_permille: Option<Reading<i16>>,
    /// The level of the switch, debounced where it bounces; true is high.
    pub switch: Option<Reading<bool>>,
}
