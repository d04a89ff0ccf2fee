//! How evenly the set-points of each axis follow each other: the interval from one to the next, less the cycle.

use std::collections::BTreeMap;

use super::wire_frame::WireFrame;

/// Deviations of all intervals of a run.
#[derive(Debug, Default)]
pub(crate) struct Intervals {
    /// Identifier of the set-points and end of the latest one, for each axis.
    axes: Vec<(u32, Option<u64>)>,
    /// How often each deviation came, rounded to a microsecond.
    deviations_us: BTreeMap<i64, u64>,
}

impl Intervals {
    /// Set-points with these identifiers.
    pub(super) fn new(ids: impl Iterator<Item = u16>) -> Self {
        Self {
            axes: ids.map(|id| (id.into(), None)).collect(),
            deviations_us: BTreeMap::new(),
        }
    }

    /// Set-points with one more identifier.
    pub(super) fn add(&mut self, id: u16) {
        self.axes.push((id.into(), None));
    }

    /// The interval that half of all are not longer than, in microseconds.
    pub(super) fn median_us(&self) -> Option<i64> {
        let half = self.deviations_us.values().sum::<u64>().div_ceil(2);
        let mut below = 0;
        let mut intervals = self.deviations_us.iter();
        let found = intervals.find(|(_, count)| {
            below += **count;
            below >= half
        });
        found.map(|(us, _)| *us)
    }

    /// Takes the same intervals less another cycle.
    pub(super) fn set_cycle(&mut self, before_us: u32, cycle_us: u32) {
        let by = i64::from(before_us) - i64::from(cycle_us);
        let before = core::mem::take(&mut self.deviations_us);
        self.deviations_us = before
            .into_iter()
            .map(|(us, count)| (us + by, count))
            .collect();
    }

    pub(super) fn frame(&mut self, frame: &WireFrame, cycle_us: u32) {
        if frame.from_master == Some(false)
            || frame.failure.is_some()
            || frame.frame.is_extended()
            || frame.frame.is_remote()
        {
            return;
        }
        let mut axes = self.axes.iter_mut();
        let Some((_, latest_ns)) = axes.find(|(id, _)| *id == frame.frame.id()) else {
            return;
        };
        if let Some(before_ns) = latest_ns.replace(frame.end_ns) {
            let interval_us = frame.end_ns.saturating_sub(before_ns).div_ceil(1_000);
            let deviation_us = i64::try_from(interval_us)
                .unwrap_or(i64::MAX)
                .saturating_sub(i64::from(cycle_us));
            *self.deviations_us.entry(deviation_us).or_default() += 1;
        }
    }

    /// Interval less cycle of every set-point but the first of each axis, in microseconds, with how often it came.
    pub(crate) fn deviations_us(&self) -> &BTreeMap<i64, u64> {
        &self.deviations_us
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use can_decode::Frame;

    #[test]
    fn the_interval_of_each_axis_counts() {
        let mut intervals = Intervals::new([0x03C, 0x05C].into_iter());
        // Drive 2 is 30 us late once; a reply and a request are no set-points.
        for (end_us, id) in [
            (0, 0x03C),
            (200, 0x05C),
            (900, 0x029),
            (1_000, 0x03C),
            (1_230, 0x05C),
        ] {
            let frame = Frame::new(id, false, &[1]).unwrap();
            intervals.frame(
                &WireFrame::ended(end_us * 1_000, frame, Some(true), 1_000),
                1_000,
            );
        }
        assert_eq!(
            intervals.deviations_us().iter().collect::<Vec<_>>(),
            [(&0, &1), (&30, &1)]
        );
    }
}
