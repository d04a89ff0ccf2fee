//! The latest frames, calls and events, for the report of a finding.

use std::collections::VecDeque;
use std::fmt::{self, Debug};

use dyn_can::DataFrame;

/// Something that happened.
#[derive(Debug, Clone)]
#[expect(dead_code, reason = "read by their debug text")]
pub(super) enum Entry<E> {
    Cycle(u64),
    Call(&'static str, usize),
    Offered(DataFrame, &'static str),
    GivenBack(DataFrame),
    OnWire(DataFrame),
    Delivered(DataFrame),
    Happened(&'static str, usize),
    Event(Option<u8>, E),
}

/// The latest entries, at most so many.
#[derive(Debug)]
pub(super) struct History<E> {
    entries: VecDeque<(u64, Entry<E>)>,
    most: usize,
}

impl<E> History<E> {
    pub(super) fn new(most: usize) -> Self {
        Self {
            entries: VecDeque::new(),
            most,
        }
    }

    pub(super) fn note(&mut self, now_us: u64, entry: Entry<E>) {
        if self.entries.len() >= self.most {
            self.entries.pop_front();
        }
        self.entries.push_back((now_us, entry));
    }
}

impl<E: Debug> fmt::Display for History<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at_us, entry) in &self.entries {
            writeln!(f, "  {at_us} us {entry:?}")?;
        }
        Ok(())
    }
}
