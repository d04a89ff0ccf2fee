//! What the status LED shows.

use crate::config::CYCLE_US;
use crate::supervisor::{Axes, State};

/// Each bit of a pattern lasts an eighth of a second; a pattern of 16 is two seconds.
const BIT_CYCLES: u32 = 125_000 / CYCLE_US;

/// The patterns, first bit lowest. README.md explains them to the user.
/// The crystal does not run.
pub(crate) const NO_CRYSTAL: u16 = 0b0000_0001_0101_0101;
/// The configuration cannot work.
pub(crate) const REFUSED: u16 = 0b0000_0000_0101_0101;
/// The controller does not get onto the bus.
pub(crate) const OFF_THE_BUS: u16 = 0b0000_0000_0000_0101;
const UNCONFIRMED: u16 = 0b0001_0111_0001_0111;
const LOCKED: u16 = 0b0101_0101_0101_0101;
const FAULT: u16 = 0b0011_0011_0011_0011;
const STOPPED: u16 = 0b0000_0000_0001_0101;
const WAITING: u16 = 0b0000_0000_0000_0001;
const OFF: u16 = 0b0000_0000_1111_1111;
const FOUND_ON: u16 = 0b0000_1111_0000_1111;
const ON: u16 = 0b0111_1111_0111_1111;
const RUNNING: u16 = 0b1111_1111_1111_1111;

/// Plays the pattern of a state.
pub(crate) struct LedPattern {
    cycles: u32,
    bit: u32,
}

impl LedPattern {
    /// At the beginning of the pattern.
    pub(crate) const fn new() -> Self {
        Self { cycles: 0, bit: 0 }
    }

    /// Whether the LED is lit in this cycle, for a state of the machine.
    pub(crate) fn update(&mut self, state: State, axes: Axes) -> bool {
        self.play(pattern(state, axes))
    }

    /// Whether the LED is lit in this cycle of a pattern.
    pub(crate) fn play(&mut self, pattern: u16) -> bool {
        self.cycles += 1;
        if self.cycles >= BIT_CYCLES {
            self.cycles = 0;
            self.bit = (self.bit + 1) % u16::BITS;
        }
        pattern >> self.bit & 1 != 0
    }
}

const fn pattern(state: State, axes: Axes) -> u16 {
    match state {
        // Whatever else is the case: somebody may reach into the machine.
        _ if axes.unconfirmed => UNCONFIRMED,
        State::Locked => LOCKED,
        State::Stopped => STOPPED,
        _ if axes.faulted => FAULT,
        State::Starting | State::Released | State::GettingReady => WAITING,
        State::Off if axes.found_on => FOUND_ON,
        State::Off => OFF,
        State::On => ON,
        State::Running => RUNNING,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_state_has_a_pattern_of_its_own() {
        let found_on = Axes {
            found_on: true,
            ..Axes::default()
        };
        let faulted = Axes {
            faulted: true,
            ..found_on
        };
        let unconfirmed = Axes {
            unconfirmed: true,
            ..faulted
        };
        let mut patterns = [found_on, faulted, unconfirmed]
            .map(|axes| pattern(State::Off, axes))
            .to_vec();
        patterns.extend([NO_CRYSTAL, REFUSED, OFF_THE_BUS]);
        for state in [
            State::Locked,
            State::Stopped,
            State::Off,
            State::Released,
            State::On,
            State::Running,
        ] {
            patterns.push(pattern(state, Axes::default()));
        }
        let all = patterns.len();
        patterns.sort_unstable();
        patterns.dedup();
        assert_eq!(patterns.len(), all);
    }

    #[test]
    fn a_pattern_takes_two_seconds() {
        let mut led = LedPattern::new();
        let cycles = 2_000_000 / CYCLE_US;
        let lit = (0..cycles)
            .filter(|_| led.update(State::Off, Axes::default()))
            .count();
        assert_eq!(lit as u32, cycles / 2);
    }
}
