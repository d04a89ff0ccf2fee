//! How long a drive takes to answer: learned from the first reply on, and tracked.

use bus_plan::ResponseWindow;
use bus_user::Instant;

/// Replies after which the older half of what was seen is forgotten: a single late reply does not count for ever.
const HALF: u8 = 64;

/// Shortest and longest response of one drive, of its latest 64 to 128 replies.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ResponseWatch {
    /// When the request had left, as far as the master can know.
    asked_at: Option<Instant>,
    latest: Option<ResponseWindow>,
    earlier: Option<ResponseWindow>,
    replies: u8,
}

impl ResponseWatch {
    /// A request leaves the controller at this time.
    pub(crate) fn asked(&mut self, at: Instant) {
        self.asked_at = Some(at);
    }

    /// The reply to it came in at this time, after so long on the wire.
    pub(crate) fn replied(&mut self, at: Instant, on_wire_us: u32) {
        let Some(asked_at) = self.asked_at.take() else {
            return;
        };
        if self.replies >= HALF {
            self.earlier = self.latest.take();
            self.replies = 0;
        }
        self.replies += 1;
        let us = at.us_since(asked_at + on_wire_us);
        let us = u32::try_from(us).unwrap_or(u32::MAX);
        let one = ResponseWindow {
            min_us: us,
            max_us: us,
        };
        self.latest = ResponseWindow::union(self.latest, Some(one));
    }

    /// What was seen; `None` before the first reply.
    pub(crate) fn window(&self) -> Option<ResponseWindow> {
        ResponseWindow::union(self.latest, self.earlier)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn watch(responses_us: impl IntoIterator<Item = u32>) -> ResponseWatch {
        let mut watch = ResponseWatch::default();
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
