//! Work on a bus that does not get on.

use can_motion::Instant;

/// Far longer than any drive has to answer, in microseconds.
const LIMIT_US: u64 = 2_000_000;

/// Notices that a scan stays at one place, because nothing that it sends gets out.
#[derive(Debug)]
pub(crate) struct StallWatch<P> {
    place: P,
    since: Instant,
}

impl<P: PartialEq> StallWatch<P> {
    /// A watch that begins at a place.
    pub(crate) const fn new(place: P, now: Instant) -> Self {
        Self { place, since: now }
    }

    /// Whether the place has been the same for 2 s.
    pub(crate) fn stalls_at(&mut self, place: P, now: Instant) -> bool {
        if place != self.place {
            *self = Self::new(place, now);
        }
        now.us_since(self.since) >= LIMIT_US
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_place_that_stays_is_a_stall() {
        let at = Instant::from_us;
        let mut watch = StallWatch::new(1, at(0));
        assert!(!watch.stalls_at(1, at(1_999_999)));
        assert!(!watch.stalls_at(2, at(2_500_000)));
        assert!(!watch.stalls_at(2, at(4_499_999)));
        assert!(watch.stalls_at(2, at(4_500_000)));
    }
}
