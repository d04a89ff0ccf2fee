//! What was read of an axis that shall stand still.

/// What was seen of an axis that shall stand still.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Ready {
    pub(super) began_us: Option<u64>,
    /// When the readings began to be fresh.
    pub(super) since_us: Option<u64>,
    /// Smallest and largest position since.
    pub(super) range: Option<(i32, i32)>,
    /// Positions since.
    pub(super) positions: u8,
    last_us: u64,
}

impl Ready {
    pub(super) fn note(&mut self, position: i32, at_us: u64) {
        if self.positions > 0 && at_us == self.last_us {
            return;
        }
        let (low, high) = self.range.unwrap_or((position, position));
        self.range = Some((low.min(position), high.max(position)));
        self.positions = self.positions.saturating_add(1);
        self.last_us = at_us;
    }

    pub(super) fn spread(&self) -> u32 {
        self.range.map_or(0, |(low, high)| high.abs_diff(low))
    }
}
