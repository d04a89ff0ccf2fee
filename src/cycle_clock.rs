//! The beat of the cycle.

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Instant, Ticker};

use crate::config::CYCLE_US;

/// Time from one cycle to the next.
pub(crate) const PERIOD: Duration = Duration::from_micros(CYCLE_US as u64);

static BEAT: Signal<CriticalSectionRawMutex, Beat> = Signal::new();

/// Beats for ever. A task of its own: in the task of the cycle the timer would be set anew for every frame that comes or goes, because
/// each of them polls everything that the task waits for.
#[embassy_executor::task]
pub(crate) async fn run() {
    let mut clock = CycleClock::start();
    loop {
        BEAT.signal(clock.next().await);
    }
}

/// Waits for the next beat; the latest one when several have passed. Cancelling it loses nothing.
pub(crate) async fn beat() -> Beat {
    BEAT.wait().await
}

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
struct CycleClock {
    ticker: Ticker,
    planned: Instant,
}

impl CycleClock {
    /// Starts the clock; the first beat comes a period from now.
    fn start() -> Self {
        let planned = Instant::now();
        let mut ticker = Ticker::every(PERIOD);
        ticker.reset_at(planned);
        Self { ticker, planned }
    }

    async fn next(&mut self) -> Beat {
        self.ticker.next().await;
        let now = Instant::now();
        let elapsed = now.saturating_duration_since(self.planned).as_ticks();
        let periods = elapsed / PERIOD.as_ticks();
        let planned = self.planned + Duration::from_ticks(periods * PERIOD.as_ticks());
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
