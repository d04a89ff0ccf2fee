//! Time windows in which the bus does not work.
//!
//! Specification: a node starts only on an idle bus, and bus-off recovery counts only recessive bits. What a stuck or noisy bus does to a node depends
//! on the place of the fault, so there are two kinds: one in which the frames wait, and one in which every attempt is an error. A third
//! case, a node alone behind an open cable, needs no window: disconnect the other nodes, and the missing acknowledge does the rest.

use core::fmt;

/// What an outage does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutageKind {
    /// The bus is never idle, so that nobody starts. Frames stay pending, error counters stay. A frame that began before is finished.
    Blocked,
    /// Every attempt ends in a bit error, also one that began before: senders go towards bus-off.
    Disturbed,
}

/// A window `from_ns..until_ns` in which the bus does not work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outage {
    /// What it does.
    pub kind: OutageKind,
    /// First instant.
    pub from_ns: u64,
    /// First instant behind it.
    pub until_ns: u64,
}

/// An outage that ends before it begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EmptyOutage {
    /// What was asked for.
    pub outage: Outage,
}

impl fmt::Display for EmptyOutage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Outage {
            from_ns, until_ns, ..
        } = self.outage;
        write!(
            f,
            "outage from {from_ns} ns until {until_ns} ns is empty; its end must lie behind its begin"
        )
    }
}

impl core::error::Error for EmptyOutage {}

/// Outages that are not over yet, by their begin.
#[derive(Debug, Clone, Default)]
pub(crate) struct Outages(Vec<Outage>);

impl Outages {
    pub(crate) fn add(&mut self, outage: Outage) -> Result<(), EmptyOutage> {
        if outage.from_ns >= outage.until_ns {
            return Err(EmptyOutage { outage });
        }
        let place = self
            .0
            .partition_point(|other| other.from_ns <= outage.from_ns);
        self.0.insert(place, outage);
        Ok(())
    }

    /// Forgets what ended at or before `from_ns`, the earliest instant that will still be asked about.
    pub(crate) fn forget_before(&mut self, from_ns: u64) {
        if !self.0.is_empty() {
            self.0.retain(|outage| outage.until_ns > from_ns);
        }
    }

    /// First instant at or after `at_ns` at which the bus is not blocked.
    pub(crate) fn unblocked_from(&self, at_ns: u64) -> u64 {
        let blocked = self
            .0
            .iter()
            .filter(|outage| outage.kind == OutageKind::Blocked);
        blocked.fold(at_ns, |at, outage| {
            if outage.from_ns <= at {
                at.max(outage.until_ns)
            } else {
                at
            }
        })
    }

    /// First instant in `from_ns..until_ns` at which the bus is disturbed.
    pub(crate) fn first_disturbance(&self, from_ns: u64, until_ns: u64) -> Option<u64> {
        let disturbed = self
            .0
            .iter()
            .filter(|outage| outage.kind == OutageKind::Disturbed);
        let mut overlapping =
            disturbed.filter(|outage| outage.from_ns < until_ns && outage.until_ns > from_ns);
        overlapping.next().map(|outage| outage.from_ns.max(from_ns))
    }

    /// The recessive spans of an otherwise idle bus from `from_ns` to `until_ns`, in order.
    pub(crate) fn recessive_spans(
        &self,
        from_ns: u64,
        until_ns: u64,
    ) -> impl Iterator<Item = (u64, u64)> {
        let mut start = from_ns;
        let ends = self
            .0
            .iter()
            .map(|outage| (outage.from_ns, outage.until_ns))
            .chain([(until_ns, until_ns)]);
        ends.filter_map(move |(from, until)| {
            let span = (start, from.min(until_ns));
            start = start.max(until);
            (span.0 < span.1).then_some(span)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outages(list: &[(OutageKind, u64, u64)]) -> Outages {
        let mut outages = Outages::default();
        for &(kind, from_ns, until_ns) in list {
            outages
                .add(Outage {
                    kind,
                    from_ns,
                    until_ns,
                })
                .unwrap();
        }
        outages
    }

    #[test]
    fn blocked_windows_that_touch_act_as_one() {
        let outages = outages(&[
            (OutageKind::Blocked, 20, 30),
            (OutageKind::Blocked, 10, 20),
            (OutageKind::Disturbed, 30, 40),
        ]);
        assert_eq!(
            [9, 10, 25, 30].map(|at| outages.unblocked_from(at)),
            [9, 30, 30, 30]
        );
    }

    #[test]
    fn disturbance_is_found_where_it_first_overlaps() {
        let outages = outages(&[(OutageKind::Disturbed, 10, 20)]);
        assert_eq!(outages.first_disturbance(0, 10), None);
        assert_eq!(outages.first_disturbance(0, 11), Some(10));
        assert_eq!(outages.first_disturbance(15, 30), Some(15));
        assert_eq!(outages.first_disturbance(20, 30), None);
    }

    #[test]
    fn recessive_spans_leave_outages_out() {
        let outages = outages(&[
            (OutageKind::Blocked, 10, 20),
            (OutageKind::Disturbed, 15, 30),
            (OutageKind::Blocked, 50, 60),
        ]);
        assert_eq!(
            outages.recessive_spans(0, 100).collect::<Vec<_>>(),
            [(0, 10), (30, 50), (60, 100)]
        );
        assert_eq!(
            outages.recessive_spans(12, 55).collect::<Vec<_>>(),
            [(30, 50)]
        );
        assert_eq!(
            outages.recessive_spans(70, 80).collect::<Vec<_>>(),
            [(70, 80)]
        );
    }

    #[test]
    fn empty_outage_is_refused() {
        let outage = Outage {
            kind: OutageKind::Blocked,
            from_ns: 5,
            until_ns: 5,
        };
        assert_eq!(Outages::default().add(outage), Err(EmptyOutage { outage }));
    }
}
