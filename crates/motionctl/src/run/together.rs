//! Several buses that move as one: they start when all are ready, take their rows from one motion, and what stops one stops all.
//!
//! Each bus has a thread, because each waits for its own link. The first one leads: it asks the motion for the rows, and the others take
//! theirs from what it has published, a cycle later at most.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::recording::AxisNaming;
use crate::set_points::{Order, SetPointSource, Speed, Step};

/// Rows that are kept for a bus that is late: half a second at 1 kHz.
const ROWS: usize = 512;
/// A bus that is further behind leaves rows out; its axes owe them, and catch up.
const MOST_BEHIND: u64 = 3;

/// What the buses know of each other.
#[derive(Debug)]
pub(super) struct Together {
    buses: usize,
    ready: AtomicUsize,
    failure: Mutex<Option<String>>,
    rows: Mutex<Rows>,
    /// What a stream calls the axes of all buses.
    naming: Mutex<Option<Vec<AxisNaming>>>,
}

#[derive(Debug, Default)]
struct Rows {
    /// Number of the oldest row.
    first: u64,
    rows: VecDeque<Vec<i32>>,
    end: Option<Step>,
}

impl Together {
    pub(super) fn new(buses: usize) -> Self {
        Self {
            buses,
            ready: AtomicUsize::new(0),
            failure: Mutex::default(),
            rows: Mutex::default(),
            naming: Mutex::default(),
        }
    }

    /// One bus more is ready.
    pub(super) fn is_ready(&self) {
        self.ready.fetch_add(1, Ordering::SeqCst);
    }

    /// Whether every bus is ready.
    pub(super) fn may_start(&self) -> bool {
        self.ready.load(Ordering::SeqCst) >= self.buses
    }

    /// A bus cannot go on; the first reason counts.
    pub(super) fn fail(&self, reason: String) {
        lock(&self.failure).get_or_insert(reason);
    }

    /// Why the buses cannot go on.
    pub(super) fn failure(&self) -> Option<String> {
        lock(&self.failure).clone()
    }

    fn publish(&self, row: &[i32], step: Step) {
        let mut rows = lock(&self.rows);
        rows.rows.push_back(row.to_vec());
        if rows.rows.len() > ROWS {
            rows.rows.pop_front();
            rows.first += 1;
        }
        rows.end = (step != Step::Goes).then_some(step);
    }
}

/// A thread that panicked leaves numbers that are whole.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The motion, for the first bus.
pub(super) struct Leader<'a> {
    source: &'a mut dyn SetPointSource,
    together: Arc<Together>,
    row: Vec<i32>,
    own: Range<usize>,
}

impl<'a> Leader<'a> {
    pub(super) fn new(
        source: &'a mut dyn SetPointSource,
        together: Arc<Together>,
        own: Range<usize>,
    ) -> Self {
        Self {
            row: vec![0; source.axes()],
            source,
            together,
            own,
        }
    }
}

impl SetPointSource for Leader<'_> {
    fn axes(&self) -> usize {
        self.own.len()
    }

    fn next(&mut self, row: &mut [i32]) -> Step {
        let step = self.source.next(&mut self.row);
        self.together.publish(&self.row, step);
        row.copy_from_slice(&self.row[self.own.clone()]);
        step
    }

    fn order(&mut self, order: Order) {
        self.source.order(order);
    }

    fn speed(&self) -> Speed {
        self.source.speed()
    }

    fn progress(&self) -> (u64, Option<u64>) {
        self.source.progress()
    }

    fn next_notice(&mut self) -> Option<String> {
        self.source.next_notice()
    }

    fn take_naming(&mut self) -> Option<Vec<AxisNaming>> {
        let naming = self.source.take_naming()?;
        let own = naming.get(self.own.clone()).map(<[_]>::to_vec);
        *lock(&self.together.naming) = Some(naming);
        own
    }
}

/// The part of another bus.
pub(super) struct Part {
    together: Arc<Together>,
    own: Range<usize>,
    /// Number of its next row.
    next: u64,
    is_named: bool,
}

impl Part {
    pub(super) fn new(together: Arc<Together>, own: Range<usize>) -> Self {
        Self {
            together,
            own,
            next: 0,
            is_named: false,
        }
    }
}

impl SetPointSource for Part {
    fn axes(&self) -> usize {
        self.own.len()
    }

    fn next(&mut self, row: &mut [i32]) -> Step {
        let rows = lock(&self.together.rows);
        let published = rows.first + rows.rows.len() as u64;
        if published.saturating_sub(self.next) > MOST_BEHIND {
            self.next = published - 1;
        }
        if let Some(all) = rows.rows.get((self.next - rows.first) as usize) {
            row.copy_from_slice(&all[self.own.clone()]);
            self.next += 1;
        }
        match rows.end {
            Some(end) if self.next == published => end,
            _ => Step::Goes,
        }
    }

    /// Orders go to the motion, which the first bus has.
    fn order(&mut self, _order: Order) {}

    fn speed(&self) -> Speed {
        Speed {
            asked_percent: 100,
            actual_percent: 100.0,
            is_paused: false,
        }
    }

    fn progress(&self) -> (u64, Option<u64>) {
        (self.next, None)
    }

    fn next_notice(&mut self) -> Option<String> {
        None
    }

    fn take_naming(&mut self) -> Option<Vec<AxisNaming>> {
        if self.is_named {
            return None;
        }
        let naming = lock(&self.together.naming);
        let own = naming.as_ref()?.get(self.own.clone())?.to_vec();
        self.is_named = true;
        Some(own)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_bus_takes_each_row_once_and_catches_up_when_it_is_late() {
        let together = Arc::new(Together::new(2));
        let mut part = Part::new(Arc::clone(&together), 1..2);
        let mut row = [0];
        // Nothing is there yet.
        assert_eq!((part.next(&mut row), row), (Step::Goes, [0]));
        for number in 1..=2 {
            together.publish(&[0, number], Step::Goes);
        }
        assert_eq!((part.next(&mut row), row), (Step::Goes, [1]));
        assert_eq!((part.next(&mut row), row), (Step::Goes, [2]));
        assert_eq!((part.next(&mut row), row), (Step::Goes, [2]));
        for number in 3..=1_000 {
            together.publish(&[0, number], Step::Goes);
        }
        assert_eq!((part.next(&mut row), row), (Step::Goes, [1_000]));
        together.publish(&[0, 7], Step::Completed);
        assert_eq!((part.next(&mut row), row), (Step::Completed, [7]));
        assert_eq!((part.next(&mut row), row), (Step::Completed, [7]));
    }

    #[test]
    fn all_start_together_and_the_first_failure_counts() {
        let together = Together::new(2);
        together.is_ready();
        assert!(!together.may_start() && together.failure().is_none());
        together.is_ready();
        assert!(together.may_start());
        together.fail("first".to_owned());
        together.fail("second".to_owned());
        assert_eq!(together.failure().as_deref(), Some("first"));
    }
}
