//! The beat of the cycle.

use embassy_time::{Duration, Instant, Ticker};

/// The beginning of a cycle.
#[derive(Clone, Copy)]
pub(crate) struct Beat {
    /// When it was planned.
    pub(crate) planned: Instant,
    /// How much later it came.
    pub(crate) delay: Duration,
}

/// A ticker that keeps its phase and leaves out the beats that it was too late for.
///
/// A plain [`Ticker`] makes up for them at once, one after the other, and the bus would see a burst of set-points.
pub(crate) struct CycleClock {
    ticker: Ticker,
    period: Duration,
    planned: Instant,
}

impl CycleClock {
    /// Starts the clock; the first beat comes a period from now.
    pub(crate) fn start(period: Duration) -> Self {
        let planned = Instant::now();
        let mut ticker = Ticker::every(period);
        ticker.reset_at(planned);
        Self {
            ticker,
            period,
            planned,
        }
    }

    /// Waits for the next beat. Cancelling it loses nothing.
    pub(crate) async fn next(&mut self) -> Beat {
        self.ticker.next().await;
        let now = Instant::now();
        let elapsed = now.saturating_duration_since(self.planned).as_ticks();
        let periods = elapsed / self.period.as_ticks();
        let planned = self.planned + Duration::from_ticks(periods * self.period.as_ticks());
        if periods > 1 {
            self.ticker.reset_at(planned);
        }
        self.planned = planned;
        Beat {
            planned,
            delay: now - planned,
        }
    }
}
