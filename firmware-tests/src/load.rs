//! How many instructions each handler took.

use std::collections::BTreeMap;

/// The thread, in place of an exception number.
pub const THREAD: u16 = 0;

/// Instructions of one handler, or of the thread between two sleeps, those of handlers in between excluded.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Load {
    /// How often it ran.
    pub runs: u64,
    /// Instructions altogether.
    pub instructions: u64,
    /// Instructions of the longest run.
    pub longest: u64,
}

/// The longest stretch with interrupts masked (PRIMASK).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Masked {
    /// Instructions of the longest stretch.
    pub longest: u64,
    /// Where it began.
    pub begins_at: u32,
    present: u64,
    present_at: u32,
}

impl Masked {
    /// A straight run of code at `address` is about to be executed.
    pub fn note(&mut self, address: u32, instructions: u64, is_masked: bool) {
        if !is_masked {
            self.present = 0;
            return;
        }
        if self.present == 0 {
            self.present_at = address;
        }
        self.present += instructions;
        if self.present > self.longest {
            (self.longest, self.begins_at) = (self.present, self.present_at);
        }
    }
}

/// Accounts by exception number.
#[derive(Debug, Clone, Default)]
pub struct Accounts {
    loads: BTreeMap<u16, Load>,
    /// Instructions already run in the interrupted contexts, innermost last.
    interrupted: Vec<u64>,
    /// Instruction count at which the present run began, interruptions taken off.
    mark: u64,
}

impl Accounts {
    /// What ran so far.
    #[must_use]
    pub fn loads(&self) -> &BTreeMap<u16, Load> {
        &self.loads
    }

    /// Forgets what ran so far, to measure from here.
    pub fn clear(&mut self) {
        self.loads.clear();
    }

    /// The thread wakes at this instruction count.
    pub fn wake(&mut self, instructions: u64) {
        self.mark = instructions;
    }

    /// A handler begins.
    pub fn enter(&mut self, instructions: u64) {
        self.interrupted.push(instructions - self.mark);
        self.mark = instructions;
    }

    /// A handler ends.
    pub fn leave(&mut self, exception: u16, instructions: u64) {
        self.book(exception, instructions);
        self.mark = instructions - self.interrupted.pop().unwrap_or(0);
    }

    /// The thread goes to sleep.
    pub fn sleep(&mut self, instructions: u64) {
        self.book(THREAD, instructions);
        self.mark = instructions;
    }

    /// Everything was thrown away.
    pub fn reset(&mut self, instructions: u64) {
        self.interrupted.clear();
        self.mark = instructions;
    }

    fn book(&mut self, who: u16, instructions: u64) {
        let run = instructions - self.mark;
        let load = self.loads.entry(who).or_default();
        load.runs += 1;
        load.instructions += run;
        load.longest = load.longest.max(run);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_masked_stretch_is_kept_with_its_place() {
        let mut masked = Masked::default();
        for (address, instructions, is_masked) in [
            (1, 10, true),
            (2, 90, false),
            (3, 5, true),
            (4, 6, true),
            (5, 1, false),
            (6, 10, true),
        ] {
            masked.note(address, instructions, is_masked);
        }
        assert_eq!((masked.longest, masked.begins_at), (11, 3));
    }

    #[test]
    fn a_handler_is_not_charged_for_the_one_that_interrupts_it() {
        let mut accounts = Accounts::default();
        accounts.wake(100);
        accounts.enter(110);
        accounts.enter(130);
        accounts.leave(20, 137);
        accounts.leave(40, 140);
        accounts.sleep(145);
        let of = |who| accounts.loads()[&who].instructions;
        assert_eq!((of(20), of(40), of(THREAD)), (7, 23, 15));
    }
}
