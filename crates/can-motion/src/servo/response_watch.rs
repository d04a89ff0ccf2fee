//! How long a drive takes to answer: learned from the first reply on, and tracked.

use bus_plan::ResponseWindow;
use bus_user::Instant;

use crate::core::stamp::Stamp;

/// Replies after which the older half of what was seen is forgotten: a single late reply does not count for ever.
const HALF: u8 = 64;

/// A window that nothing was seen in begins behind its end.
const NOTHING: ResponseWindow = ResponseWindow {
    min_us: u32::MAX,
    max_us: 0,
};

/// Shortest and longest response of one drive, of its latest 64 to 128 replies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ResponseWatch {
    latest: ResponseWindow,
    earlier: ResponseWindow,
    /// When the request had left, as far as the master can know.
    asked_at: Stamp,
    is_asked: bool,
    replies: u8,
}

impl ResponseWatch {
    /// No reply was seen.
    pub(crate) const NEW: Self = Self {
        latest: NOTHING,
        earlier: NOTHING,
        asked_at: Stamp::ZERO,
        is_asked: false,
        replies: 0,
    };

    /// A request leaves the controller at this time.
    pub(crate) const fn asked(&mut self, at: Instant) {
        self.asked_at = Stamp::of(at);
        self.is_asked = true;
    }

    /// The reply to it came in at this time, after so long on the wire.
    pub(crate) fn replied(&mut self, at: Instant, on_wire_us: u32) {
        if !core::mem::take(&mut self.is_asked) {
            return;
        }
        if self.replies >= HALF {
            self.earlier = core::mem::replace(&mut self.latest, NOTHING);
            self.replies = 0;
        }
        self.replies += 1;
        let us = self.asked_at.after(on_wire_us).age_us(at);
        self.latest.min_us = self.latest.min_us.min(us);
        self.latest.max_us = self.latest.max_us.max(us);
    }

    /// What was seen; `None` before the first reply.
    pub(crate) fn window(&self) -> Option<ResponseWindow> {
        let window = ResponseWindow {
            min_us: self.latest.min_us.min(self.earlier.min_us),
            max_us: self.latest.max_us.max(self.earlier.max_us),
        };
        (window.min_us <= window.max_us).then_some(window)
    }

    /// As [`Stamp::keep`].
    pub(crate) const fn keep_stamps(&mut self, now: Instant, is_long_ago: bool) {
        self.asked_at.keep(now, is_long_ago);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn watch(responses_us: impl IntoIterator<Item = u32>) -> ResponseWatch {
        let mut watch = ResponseWatch::NEW;
        for us in responses_us {
            watch.asked(Instant::from_us(1_000));
            watch.replied(Instant::from_us(1_050) + us, 50);
        }
        watch
    }

    #[test]
    fn the_window_covers_every_reply() {
        assert_eq!(watch([]).window(), None);
        let window = ResponseWindow {
            min_us: 380,
            max_us: 620,
        };
        assert_eq!(watch([500, 380, 620, 400]).window(), Some(window));
    }

    #[test]
    fn an_outlier_is_forgotten() {
        let many = |count| core::iter::once(5_000).chain(core::iter::repeat_n(500, count));
        assert_eq!(watch(many(100)).window().unwrap().max_us, 5_000);
        assert_eq!(watch(many(200)).window().unwrap().max_us, 500);
    }

    #[test]
    fn a_reply_that_nobody_asked_for_says_nothing() {
        let mut watch = watch([500]);
        watch.replied(Instant::from_us(9_000), 50);
        assert_eq!(watch.window().unwrap().max_us, 500);
    }
}
