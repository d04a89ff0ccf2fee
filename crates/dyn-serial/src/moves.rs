//! Coordinated moves of several drives: the packet sequences of Make_LinearLine and Make_CircularArc.
//!
//! **Not verified on a drive.** The manual has one example of each (section 7.7, examples 7 and 8) and leaves open which
//! drive is which axis, what the unit of the feed rate is, and how a feed rate and a turning sense share one word (M15).
//! Nothing acknowledges a word, so a lost packet leaves the drives waiting in the middle of a sequence. Use these builders
//! on a bench, not on a machine.

use dyn_values::{Counts28, FeedRate};

use crate::address::Address;
use crate::function::RequestFunction;
use crate::groups::Groups;
use crate::packet::Packet;

/// A line of up to three axes: the distances of X, Y and Z, and the feed rate. All axes arrive together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LinearMove {
    /// Distances of X, Y and Z from where they are.
    pub distances: [Counts28; 3],
    /// Feed rate.
    pub feed_rate: FeedRate,
}

impl LinearMove {
    /// The four packets in their order, to the general id (example 7).
    #[must_use]
    pub fn packets(&self) -> [Packet; 4] {
        let [x, y, z] = self.distances.map(Counts28::get);
        [x, y, z, i32::from(self.feed_rate.get())]
            .map(|word| to_all(RequestFunction::MakeLinearLine, word))
    }
}

/// Turning sense of an arc, as the sign of the feed rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Turn {
    /// Clockwise: a positive feed rate.
    Clockwise,
    /// Counter-clockwise: a negative feed rate.
    CounterClockwise,
}

/// An arc of two axes around a center. A circle takes two halves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CircularMove {
    /// Start minus center, on both axes of the plane.
    pub start: [Counts28; 2],
    /// End minus center, on both axes of the plane.
    pub end: [Counts28; 2],
    /// Number of the plane: 0 is X-Y, others are not named.
    pub plane: u8,
    /// Turning sense.
    pub turn: Turn,
    /// Feed rate.
    pub feed_rate: FeedRate,
}

impl CircularMove {
    /// The five packets in their order, to the general id (example 8, whose text then counts four).
    #[must_use]
    pub fn packets(&self) -> [Packet; 5] {
        let [x0, y0] = self.start.map(Counts28::get);
        let [x1, y1] = self.end.map(Counts28::get);
        [x0, y0, x1, y1, self.plane_and_feed()]
            .map(|word| to_all(RequestFunction::MakeCircularArc, word))
    }

    /// Plane in the upper byte, signed feed rate in the lower one: our reading of a formula without operators (M15).
    fn plane_and_feed(&self) -> i32 {
        let feed = self.feed_rate.get();
        let low = match self.turn {
            Turn::Clockwise => feed,
            Turn::CounterClockwise => feed.wrapping_neg(),
        };
        i32::from(self.plane) << 8 | i32::from(low)
    }
}

fn to_all(function: RequestFunction, word: i32) -> Packet {
    Packet::compose(Address::All, function.code(), Groups::signed(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turning_sense_and_plane_share_a_word() {
        let arc = |plane, turn| CircularMove {
            start: [Counts28::MIN; 2],
            end: [Counts28::MAX; 2],
            plane,
            turn,
            feed_rate: FeedRate::new(1).unwrap(),
        };
        assert_eq!(arc(0, Turn::Clockwise).plane_and_feed(), 1);
        assert_eq!(arc(0, Turn::CounterClockwise).plane_and_feed(), 0xFF);
        assert_eq!(arc(2, Turn::Clockwise).plane_and_feed(), 0x201);
    }
}
