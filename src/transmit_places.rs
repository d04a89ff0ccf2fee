//! What waits in the transmit places of the controller, and for how long.

use crate::config::CYCLE_US;

/// Transmit places of either controller: mailboxes or buffers.
pub(crate) const PLACES: usize = 3;

/// One bit for each.
pub(crate) const ALL_PLACES: u32 = (1 << PLACES) - 1;

/// A frame that has not gone out by then is stale: 20 ms, when a set-point has only some cycles to be sent in.
const TRANSMIT_US: u32 = 20_000;
const TRANSMIT_CYCLES: u32 = TRANSMIT_US / CYCLE_US;
/// Cycles from throwing frames away to the next attempt to send: a second, because what is wrong takes a person to mend.
pub(crate) const RETRY_CYCLES: u32 = 1_000_000 / CYCLE_US;

/// Which places have a frame that waits: one bit each, from the lowest on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Occupied(pub(crate) u32);

impl Occupied {
    /// No frame waits.
    pub(crate) const NONE: Self = Self(0);
}

/// The transmit places. What is in them the controller knows.
pub(crate) struct TransmitPlaces {
    places: [Queued; PLACES],
    queued: u32,
}

/// The frame that was put into a place last.
#[derive(Clone, Copy)]
struct Queued {
    /// Frames queued before it, modulo 2^32.
    number: u32,
    /// For which it has waited.
    cycles: u32,
}

impl TransmitPlaces {
    /// No frame waits.
    pub(crate) const fn new() -> Self {
        const NEVER: Queued = Queued {
            number: 0,
            cycles: 0,
        };
        Self {
            places: [NEVER; PLACES],
            queued: 0,
        }
    }

    /// A frame was put into a place.
    #[inline(always)]
    pub(crate) fn note_queued(&mut self, place: usize) {
        let number = self.queued;
        if let Some(to) = self.places.get_mut(place) {
            *to = Queued { number, cycles: 0 };
            self.queued = number.wrapping_add(1);
        }
    }

    /// A cycle passes; true when a frame has waited too long.
    pub(crate) fn pass_cycle(&mut self, occupied: Occupied) -> bool {
        let mut is_late = false;
        let Occupied(mut rest) = occupied;
        if rest == 0 {
            // As in most cycles: everything of the one before has gone out.
            self.places.iter_mut().for_each(|queued| queued.cycles = 0);
            return false;
        }
        for queued in &mut self.places {
            queued.cycles = if rest & 1 != 0 { queued.cycles + 1 } else { 0 };
            is_late |= queued.cycles > TRANSMIT_CYCLES;
            rest >>= 1;
        }
        is_late
    }

    /// The place of the frame that goes last, unless it is also the one that goes next: that frame may be on the wire already.
    pub(crate) fn last_behind_another(&self, occupied: Occupied) -> Option<usize> {
        let Occupied(places) = occupied;
        if places.count_ones() < 2 {
            return None;
        }
        let all = self.places.iter().enumerate();
        let waiting = all.filter(|(place, _)| places >> place & 1 != 0);
        let last = waiting.min_by_key(|(_, queued)| self.queued.wrapping_sub(queued.number));
        last.map(|(place, _)| place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_late_when_it_stays_and_not_when_its_place_is_used_again() {
        let mut places = TransmitPlaces::new();
        for _ in 0..10 * TRANSMIT_CYCLES {
            places.note_queued(1);
            assert!(!places.pass_cycle(Occupied(0b010)));
        }
        let cycles = (0..).take_while(|_| !places.pass_cycle(Occupied(0b010)));
        assert_eq!(cycles.count() as u32, TRANSMIT_CYCLES - 1);
    }

    #[test]
    fn the_youngest_comes_back_first_and_the_oldest_never() {
        let mut places = TransmitPlaces::new();
        for _ in 0..2 {
            // Also when the count has wrapped.
            places.queued = places.queued.wrapping_sub(2);
            for place in [2, 0, 1] {
                places.note_queued(place);
            }
            assert_eq!(places.last_behind_another(Occupied(0b111)), Some(1));
            assert_eq!(places.last_behind_another(Occupied(0b101)), Some(0));
            assert_eq!(places.last_behind_another(Occupied(0b100)), None);
            assert_eq!(places.last_behind_another(Occupied::NONE), None);
        }
    }
}
