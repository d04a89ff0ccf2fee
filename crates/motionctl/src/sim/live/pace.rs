//! Virtual time that passes like real time, or so many times as fast.

use std::time::{Duration, Instant};

/// When the simulation is this late, real time is not caught up with: it starts anew.
const LATE: Duration = Duration::from_millis(200);

/// How virtual time relates to real time.
pub(super) struct Pace {
    speed: f64,
    /// A pair of times that belong together.
    anchor: Option<(Instant, u64)>,
    is_behind: bool,
}

impl Pace {
    pub(super) fn new() -> Self {
        Self {
            speed: 1.0,
            anchor: None,
            is_behind: false,
        }
    }

    /// How many virtual seconds pass in a real one.
    pub(super) fn set_speed(&mut self, speed: f64) {
        self.speed = speed;
        self.anchor = None;
    }

    /// Lets real time begin now at this virtual time.
    pub(super) fn restart(&mut self, virtual_us: u64) {
        self.anchor = Some((Instant::now(), virtual_us));
    }

    /// How long to wait before virtual time may go on; `None` when it may.
    pub(super) fn wait(&mut self, virtual_us: u64) -> Option<Duration> {
        let now = Instant::now();
        let (anchor, anchor_us) = *self.anchor.get_or_insert((now, virtual_us));
        let due = due(anchor_us, virtual_us, self.speed);
        let passed = now - anchor;
        if passed > due + LATE {
            self.is_behind = true;
            self.anchor = Some((now, virtual_us));
            return None;
        }
        if passed >= due {
            return None;
        }
        self.is_behind = false;
        Some(due - passed)
    }

    /// Whether the simulation cannot keep up.
    pub(super) fn is_behind(&self) -> bool {
        self.is_behind
    }
}

/// Real time between two virtual times.
fn due(from_us: u64, until_us: u64, speed: f64) -> Duration {
    Duration::from_secs_f64(until_us.saturating_sub(from_us) as f64 * 1e-6 / speed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speed_divides_real_time() {
        assert_eq!(due(1_000_000, 1_500_000, 1.0), Duration::from_millis(500));
        assert_eq!(due(1_000_000, 1_500_000, 10.0), Duration::from_millis(50));
        assert_eq!(due(2, 1, 1.0), Duration::ZERO);
    }
}
