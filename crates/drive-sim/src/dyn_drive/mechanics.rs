//! What a shaft meets on its way: end stops, and a switch.
//!
//! Specification: stops and switch stand still in the room. Their places are command counts from where the shaft stood at 0 ns, and no origin and no
//! power cycle moves them. The shaft never passes a stop; it stops there without bouncing, and the motor pushes with a torque that grows in
//! proportion to its following error.

use dyn_can::{GearNumber, units};

/// Share of a turn by which the reference must be beyond a stop for the full torque: the integral part of a real loop gets there at once
/// or slowly, no document says.
const FULL_TORQUE_TURNS: f64 = 1.0 / 36.0;

/// What the shaft meets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mechanics {
    /// Ends of its way.
    pub stops: Option<EndStops>,
    /// A switch beside its way.
    pub switch: Option<Switch>,
}

impl Mechanics {
    /// Nothing: it turns for ever.
    pub const FREE: Self = Self {
        stops: None,
        switch: None,
    };
}

/// Ends of the way, in command counts from where the shaft stood at 0 ns. The shaft must start between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EndStops {
    /// The lowest position.
    pub low_counts: i64,
    /// The highest position.
    pub high_counts: i64,
}

impl EndStops {
    pub(super) fn of_gear(self, gear: GearNumber) -> Stops {
        let turn = f64::from(units::command_counts_per_turn(gear));
        Stops {
            low: self.low_counts as f64,
            high: self.high_counts as f64,
            full_torque_counts: turn * FULL_TORQUE_TURNS,
        }
    }
}

/// The stops as the motor meets them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stops {
    low: f64,
    high: f64,
    pub(super) full_torque_counts: f64,
}

impl Stops {
    /// The place of a shaft that wants to be here.
    pub(super) fn hold(&self, position: f64) -> f64 {
        position.max(self.low).min(self.high)
    }
}

/// The side of a switch on which it is operated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SwitchSide {
    /// At its place and above.
    Above,
    /// At its place and below.
    Below,
}

/// A switch, operated on one side of its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Switch {
    /// Its place, in command counts from where the shaft stood at 0 ns.
    pub at_counts: i64,
    /// Where it is operated.
    pub side: SwitchSide,
}

impl Switch {
    pub(super) const fn is_operated(self, position: i64) -> bool {
        match self.side {
            SwitchSide::Above => position >= self.at_counts,
            SwitchSide::Below => position <= self.at_counts,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_switch_is_operated_at_its_place_and_on_its_side() {
        let operated = |side| {
            let switch = Switch {
                at_counts: -10,
                side,
            };
            [-11, -10, -9].map(|position| switch.is_operated(position))
        };
        assert_eq!(operated(SwitchSide::Above), [false, true, true]);
        assert_eq!(operated(SwitchSide::Below), [true, true, false]);
    }
}
