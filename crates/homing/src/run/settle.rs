//! The time for which set-points rest.

/// Since when the set-points rest.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Settling {
    pub(super) rested_us: Option<u64>,
}

impl Settling {
    /// How long the set-points rest; `None` while they move.
    pub(super) fn rests_us(&mut self, is_at_rest: bool, now_us: u64) -> Option<u64> {
        if !is_at_rest {
            return None;
        }
        let since = *self.rested_us.get_or_insert(now_us);
        Some(now_us.saturating_sub(since))
    }
}
