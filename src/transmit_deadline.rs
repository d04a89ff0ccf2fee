//! How long a frame may wait in the controller.

use crate::config::CYCLE_US;

/// Transmit places of either controller: mailboxes or buffers.
pub(crate) const PLACES: usize = 3;

/// A frame that has not gone out by then is stale: 20 ms, when a set-point has only some cycles to be sent in.
const TRANSMIT_US: u32 = 20_000;
const TRANSMIT_CYCLES: u32 = TRANSMIT_US / CYCLE_US;
/// Cycles from throwing frames away to the next attempt to send: a second, because what is wrong takes a person to mend.
pub(crate) const RETRY_CYCLES: u32 = 1_000_000 / CYCLE_US;

/// Age of the frame in each transmit place.
pub(crate) struct TransmitDeadline {
    cycles: [u32; PLACES],
}

impl TransmitDeadline {
    /// No frame waits.
    pub(crate) const fn new() -> Self {
        Self {
            cycles: [0; PLACES],
        }
    }

    /// A frame was put into a place.
    pub(crate) fn note_queued(&mut self, place: usize) {
        if let Some(cycles) = self.cycles.get_mut(place) {
            *cycles = 0;
        }
    }

    /// A cycle passes; true when a frame has waited too long.
    pub(crate) fn pass_cycle(&mut self, occupied: [bool; PLACES]) -> bool {
        for (cycles, occupied) in self.cycles.iter_mut().zip(occupied) {
            *cycles = if occupied { *cycles + 1 } else { 0 };
        }
        self.cycles.iter().any(|&cycles| cycles > TRANSMIT_CYCLES)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_late_when_it_stays_and_not_when_its_place_is_used_again() {
        let mut deadline = TransmitDeadline::new();
        for _ in 0..10 * TRANSMIT_CYCLES {
            deadline.note_queued(1);
            assert!(!deadline.pass_cycle([false, true, false]));
        }
        let cycles = (0..).take_while(|_| !deadline.pass_cycle([false, true, false]));
        assert_eq!(cycles.count() as u32, TRANSMIT_CYCLES - 1);
    }
}
