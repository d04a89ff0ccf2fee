//! At most one outstanding request per drive, because there is only one place to note it.
//!
//! Request and reply share one identifier and a General_Read reply does not say what it is (D6, D31): a second request
//! could collide with the late reply to the first on the wire, or take it for its own. One slot per drive rules both
//! out. The slot stays closed after a timeout (quarantine) and for a moment after a reply, so that late and repeated
//! replies are recognised and dropped.

use bus_user::Instant;
use dyn_can::ReplyKind;

use crate::core::stamp::Stamp;

/// What a drive owes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum RequestSlot {
    /// Nothing; the next request may go out.
    #[default]
    Free,
    /// A reply is awaited.
    Waiting {
        /// What was asked.
        kind: ReplyKind,
        /// When waiting ends.
        deadline: Stamp,
    },
    /// Nothing is awaited, but replies to what was asked may still come: they are dropped.
    Closed {
        /// What was asked last.
        kind: ReplyKind,
        /// When the slot is free again.
        until: Stamp,
    },
}

/// A reply that nobody waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) enum Unawaited {
    /// It repeats, or comes after the end of, the latest request.
    Late,
    /// Nothing of the kind was asked.
    Stray,
}

impl RequestSlot {
    pub(crate) const fn is_free(&self) -> bool {
        matches!(self, Self::Free)
    }

    /// Lets time pass as [`Self::expire`]; false, with nothing done, when a reply did not come.
    #[inline]
    pub(crate) fn pass(&mut self, now: Instant) -> bool {
        match *self {
            Self::Waiting { deadline, .. } => !deadline.has_come(now),
            Self::Closed { until, .. } if until.has_come(now) => {
                *self = Self::Free;
                true
            }
            Self::Closed { .. } | Self::Free => true,
        }
    }

    /// The controller accepted a request.
    pub(crate) fn ask(&mut self, kind: ReplyKind, now: Instant, timeout_us: u32) {
        *self = Self::Waiting {
            kind,
            deadline: Stamp::of(now).after(timeout_us),
        };
    }

    /// The controller returned the request unsent, or its fate does not matter any more.
    pub(crate) fn forget(&mut self) {
        *self = Self::Free;
    }

    /// The request that a frame with this function answers, and when waiting for it ends.
    pub(crate) fn awaited(
        &self,
        function: dyn_can::FunctionCode,
    ) -> Result<(ReplyKind, Stamp), Unawaited> {
        match *self {
            Self::Waiting { kind, deadline } if kind.function() == function => Ok((kind, deadline)),
            Self::Closed { kind, .. } if kind.function() == function => Err(Unawaited::Late),
            _ => Err(Unawaited::Stray),
        }
    }

    /// Waiting is over; the slot stays closed for `closed_us`.
    pub(crate) fn close(&mut self, now: Instant, closed_us: u32) {
        if let Self::Waiting { kind, .. } = *self {
            *self = Self::Closed {
                kind,
                until: Stamp::of(now).after(closed_us),
            };
        }
    }

    /// As [`Stamp::keep`].
    pub(crate) fn keep_stamps(&mut self, now: Instant, is_long_ago: bool) {
        if let Self::Waiting {
            deadline: stamp, ..
        }
        | Self::Closed { until: stamp, .. } = self
        {
            stamp.keep(now, is_long_ago);
        }
    }

    /// Lets time pass; the request whose reply did not come, once.
    pub(crate) fn expire(&mut self, now: Instant, quarantine_us: u32) -> Option<ReplyKind> {
        match *self {
            Self::Waiting { kind, deadline } if deadline.has_come(now) => {
                self.close(now, quarantine_us);
                Some(kind)
            }
            Self::Closed { until, .. } if until.has_come(now) => {
                *self = Self::Free;
                None
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dyn_can::FunctionCode;

    const TIMEOUT_US: u32 = 5_000;

    fn at(us: u64) -> Instant {
        Instant::from_us(us)
    }

    #[test]
    fn a_reply_after_the_timeout_is_late_and_the_slot_stays_closed() {
        let mut slot = RequestSlot::default();
        slot.ask(ReplyKind::Position, at(0), TIMEOUT_US);
        assert_eq!(slot.expire(at(4_999), TIMEOUT_US), None);
        assert_eq!(
            slot.expire(at(5_000), TIMEOUT_US),
            Some(ReplyKind::Position)
        );
        assert!(!slot.is_free());
        assert_eq!(
            slot.awaited(FunctionCode::GeneralRead),
            Err(Unawaited::Late)
        );
        assert_eq!(slot.expire(at(9_999), TIMEOUT_US), None);
        assert!(!slot.is_free());
        assert_eq!(slot.expire(at(10_000), TIMEOUT_US), None);
        assert!(slot.is_free());
    }

    #[test]
    fn a_reply_to_something_else_is_stray() {
        let mut slot = RequestSlot::default();
        assert_eq!(
            slot.awaited(FunctionCode::ReadDriveStatus),
            Err(Unawaited::Stray)
        );
        slot.ask(ReplyKind::Torque, at(0), TIMEOUT_US);
        assert_eq!(
            slot.awaited(FunctionCode::ReadDriveStatus),
            Err(Unawaited::Stray)
        );
        assert_eq!(
            slot.awaited(FunctionCode::GeneralRead),
            Ok((ReplyKind::Torque, Stamp::of(at(TIMEOUT_US.into()))))
        );
    }

    #[test]
    fn a_repeated_reply_meets_a_closed_slot() {
        let mut slot = RequestSlot::default();
        slot.ask(ReplyKind::Position, at(0), TIMEOUT_US);
        slot.close(at(600), 1_000);
        assert_eq!(
            slot.awaited(FunctionCode::GeneralRead),
            Err(Unawaited::Late)
        );
        slot.expire(at(1_600), TIMEOUT_US);
        assert!(slot.is_free());
    }
}
