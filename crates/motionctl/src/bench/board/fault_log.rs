//! The faults that the board remembers over a reset, with the numbers of the firmware.

use std::cell::RefCell;
use std::rc::Rc;

use board_link::message::FaultEntry;
use board_settings::FaultNumber;

use super::application::FIRMWARE;

/// As many as the boards keep.
const KEPT: usize = 32;

/// The faults, latest last.
#[derive(Debug, Clone, Default)]
pub(super) struct FaultLog(Rc<RefCell<Kept>>);

#[derive(Debug, Default)]
struct Kept {
    entries: std::collections::VecDeque<FaultEntry>,
    next: u32,
}

impl FaultLog {
    pub(super) fn add(
        &self,
        uptime_ms: u32,
        axis: Option<u8>,
        FaultNumber { code, detail }: FaultNumber,
    ) {
        let mut kept = self.0.borrow_mut();
        let entry = FaultEntry {
            number: kept.next,
            uptime_ms,
            firmware: FIRMWARE.parse().unwrap_or_default(),
            axis,
            code,
            detail,
            ..FaultEntry::default()
        };
        kept.next = kept.next.wrapping_add(1);
        if kept.entries.len() == KEPT {
            kept.entries.pop_front();
        }
        kept.entries.push_back(entry);
    }

    /// 0 the latest.
    pub(super) fn get(&self, index: u32) -> Option<FaultEntry> {
        let kept = self.0.borrow();
        kept.entries.iter().rev().nth(index as usize).cloned()
    }

    pub(super) fn count(&self) -> u32 {
        self.0.borrow().entries.len() as u32
    }
}
