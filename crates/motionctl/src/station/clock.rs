//! Time of this computer, and serving a bus while it passes.

use std::time::Duration;

use can_motion::{BusUser, Instant, Progress, service};

use crate::link::{Link, LinkFault};

/// The wait for an adapter that has no room at the moment.
const WAIT_FOR_ROOM_US: u64 = 200;

/// Microseconds since the start.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Clock {
    start: std::time::Instant,
}

impl Clock {
    /// A clock that starts now.
    pub(crate) fn start() -> Self {
        Self {
            start: std::time::Instant::now(),
        }
    }

    /// The present moment.
    pub(crate) fn now(&self) -> Instant {
        // A program that runs for half a million years reads the largest number from then on.
        Instant::from_us(u64::try_from(self.start.elapsed().as_micros()).unwrap_or(u64::MAX))
    }
}

/// Hands frames both ways until a moment has come.
///
/// # Errors
/// The fault of the link, after which nothing gets through any more.
pub(crate) fn serve_until<U: BusUser>(
    user: &mut U,
    link: &mut Link,
    clock: &Clock,
    until: Instant,
) -> Result<(), LinkFault> {
    loop {
        let progress = service(user, link, clock.now());
        if let Some(fault) = link.fault() {
            return Err(fault);
        }
        let left_us = until.us_since(clock.now());
        if left_us == 0 {
            return Ok(());
        }
        let most_us = match progress {
            Progress::Idle => left_us,
            Progress::Blocked => left_us.min(WAIT_FOR_ROOM_US),
        };
        link.wait(Duration::from_micros(most_us));
    }
}
