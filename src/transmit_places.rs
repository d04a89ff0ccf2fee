//! What waits in the transmit places of the controller, and for how long.

use crate::config::CYCLE_US;

/// Transmit places of either controller: mailboxes or buffers.
pub(crate) const PLACES: usize = 3;

/// A frame that has not gone out by then is stale: 20 ms, when a set-point has only some cycles to be sent in.
const TRANSMIT_US: u32 = 20_000;
const TRANSMIT_CYCLES: u32 = TRANSMIT_US / CYCLE_US;
/// Cycles from throwing frames away to the next attempt to send: a second, because what is wrong takes a person to mend.
pub(crate) const RETRY_CYCLES: u32 = 1_000_000 / CYCLE_US;

/// A frame in a place.
#[derive(Clone, Copy)]
struct Queued<F> {
    frame: F,
    /// Frames queued before it, modulo 2^32.
    number: u32,
    cycles: u32,
}

/// The transmit places; each frame that was put into one is kept here, because the drivers do not show it again.
pub(crate) struct TransmitPlaces<F> {
    places: [Option<Queued<F>>; PLACES],
    queued: u32,
}

impl<F: Copy> TransmitPlaces<F> {
    /// No frame waits.
    pub(crate) const fn new() -> Self {
        Self {
            places: [None; PLACES],
            queued: 0,
        }
    }

    /// A frame was put into a place.
    pub(crate) fn note_queued(&mut self, place: usize, frame: F) {
        if let Some(to) = self.places.get_mut(place) {
            *to = Some(Queued {
                frame,
                number: self.queued,
                cycles: 0,
            });
            self.queued = self.queued.wrapping_add(1);
        }
    }

    /// A cycle passes; true when a frame has waited too long.
    pub(crate) fn pass_cycle(&mut self, occupied: [bool; PLACES]) -> bool {
        let mut is_late = false;
        for (place, occupied) in self.places.iter_mut().zip(occupied) {
            *place = place.filter(|_| occupied);
            if let Some(queued) = place {
                queued.cycles += 1;
                is_late |= queued.cycles > TRANSMIT_CYCLES;
            }
        }
        is_late
    }

    /// The place and the frame that go last, unless they are also those that go next: that frame may be on the wire already.
    pub(crate) fn last_behind_another(&self, occupied: [bool; PLACES]) -> Option<(usize, F)> {
        let waiting = (0..).zip(&self.places).zip(occupied);
        let waiting = waiting.filter_map(|((place, queued), occupied)| {
            queued.filter(|_| occupied).map(|queued| (place, queued))
        });
        if waiting.clone().count() < 2 {
            return None;
        }
        let (place, queued) =
            waiting.min_by_key(|(_, queued)| self.queued.wrapping_sub(queued.number))?;
        Some((place, queued.frame))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_late_when_it_stays_and_not_when_its_place_is_used_again() {
        let mut places = TransmitPlaces::new();
        for _ in 0..10 * TRANSMIT_CYCLES {
            places.note_queued(1, 'a');
            assert!(!places.pass_cycle([false, true, false]));
        }
        let cycles = (0..).take_while(|_| !places.pass_cycle([false, true, false]));
        assert_eq!(cycles.count() as u32, TRANSMIT_CYCLES - 1);
    }

    #[test]
    fn the_youngest_comes_back_first_and_the_oldest_never() {
        let mut places = TransmitPlaces::new();
        for _ in 0..2 {
            // Also when the count has wrapped.
            places.queued = places.queued.wrapping_sub(2);
            for (place, frame) in [(2, 'a'), (0, 'b'), (1, 'c')] {
                places.note_queued(place, frame);
            }
            assert_eq!(places.last_behind_another([true; 3]), Some((1, 'c')));
            assert_eq!(
                places.last_behind_another([true, false, true]),
                Some((0, 'b'))
            );
            assert_eq!(places.last_behind_another([false, false, true]), None);
            assert_eq!(places.last_behind_another([false; 3]), None);
        }
    }
}
