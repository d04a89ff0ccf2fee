//! Finite differences of what goes out.

use trajectory::Position;

/// Positions, velocities, accelerations and jerks of a run, at their largest.
#[derive(Debug, Default, Clone, Copy)]
pub(crate) struct Judge {
    before: [f64; 4],
    pub(crate) cycles: usize,
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
    pub(crate) jerk: f64,
    /// In whole counts, as they are sent.
    pub(crate) lowest: i64,
    pub(crate) highest: i64,
}

impl Judge {
    /// It stands here, and begins anew.
    #[allow(dead_code, reason = "one test has one motion")]
    pub(crate) fn stand_at(&mut self, position: Position) {
        self.before = [position.units() as f64 / Position::UNITS as f64; 4];
    }

    pub(crate) fn see(&mut self, position: Position) {
        let now = position.units() as f64 / Position::UNITS as f64;
        let sent = position.wide_counts();
        // Before the first cycle it stood.
        if self.cycles == 0 {
            self.before = [now; 4];
            (self.lowest, self.highest) = (sent, sent);
        }
        let [_, p3, p2, p1] = self.before;
        self.velocity = self.velocity.max((now - p1).abs());
        self.acceleration = self.acceleration.max((now - 2.0 * p1 + p2).abs());
        self.jerk = self.jerk.max((now - 3.0 * p1 + 3.0 * p2 - p3).abs());
        (self.lowest, self.highest) = (self.lowest.min(sent), self.highest.max(sent));
        self.before = [p3, p2, p1, now];
        self.cycles += 1;
    }
}
