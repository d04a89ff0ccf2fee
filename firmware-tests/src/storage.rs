//! Registers without a model of their own: they keep what is written.

use std::collections::{BTreeMap, HashMap};

/// How often a register was touched.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Touched {
    /// Reads.
    pub reads: u64,
    /// Writes.
    pub writes: u64,
}

/// Plain storage, with a record of what was touched: an entry there is a register that the firmware uses and no model explains.
#[derive(Debug, Clone, Default)]
pub struct Storage {
    values: HashMap<u32, u32>,
    touched: BTreeMap<u32, Touched>,
}

impl Storage {
    /// Back to these values; the record goes on.
    pub fn reset(&mut self, values: &[(u32, u32)]) {
        self.values = values.iter().copied().collect();
    }

    /// The value without leaving a trace.
    #[must_use]
    pub fn peek(&self, address: u32) -> u32 {
        self.values.get(&address).copied().unwrap_or(0)
    }

    /// Sets a value without leaving a trace.
    pub fn poke(&mut self, address: u32, value: u32) {
        self.values.insert(address, value);
    }

    /// A register was read.
    pub fn note_read(&mut self, address: u32) {
        self.touched.entry(address).or_default().reads += 1;
    }

    /// Writes a register.
    pub fn write(&mut self, address: u32, value: u32) {
        self.touched.entry(address).or_default().writes += 1;
        self.values.insert(address, value);
    }

    /// What was touched, by address.
    #[must_use]
    pub fn touched(&self) -> &BTreeMap<u32, Touched> {
        &self.touched
    }
}
