//! The latest frames, calls and events, for the report of a finding.

use std::collections::VecDeque;
use std::fmt::{self, Debug};

use dyn_can::DataFrame;

/// Entries that are kept.
const KEPT: usize = 30;

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

/// The latest entries.
#[derive(Debug)]
pub(super) struct History<E>(VecDeque<(u64, Entry<E>)>);

impl<E> History<E> {
    pub(super) fn new() -> Self {
        Self(VecDeque::with_capacity(KEPT))
    }

    pub(super) fn note(&mut self, now_us: u64, entry: Entry<E>) {
        if self.0.len() == KEPT {
            self.0.pop_front();
        }
        self.0.push_back((now_us, entry));
    }
}

impl<E: Debug> fmt::Display for History<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at_us, entry) in &self.0 {
            writeln!(f, "  {at_us} us {entry:?}")?;
        }
        Ok(())
    }
}
