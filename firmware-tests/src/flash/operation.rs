//! What changes the flash, and when.

use core::ops::Range;

/// What changes the flash.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Change {
    /// Programming an item.
    Program {
        /// Its address.
        address: u32,
        /// Its bytes.
        size: u32,
        /// Its value.
        value: u64,
    },
    /// Erasing a sector or page.
    Erase(Range<u32>),
}

impl Change {
    pub(super) fn first(&self) -> u32 {
        match self {
            Self::Program { address, .. } => *address,
            Self::Erase(range) => range.start,
        }
    }

    pub(super) fn range(&self) -> Range<u32> {
        match self {
            Self::Program { address, size, .. } => *address..address + size,
            Self::Erase(range) => range.clone(),
        }
    }
}

/// An operation of the flash.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Operation {
    /// What it changes.
    pub change: Change,
    /// When it began.
    pub starts_ns: u64,
    /// When it ends.
    pub ends_ns: u64,
}
