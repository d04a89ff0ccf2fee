//! The way of a CAN controller onto the bus, at the start and after a failure, one step a cycle: nothing here waits.
//!
//! After a failure nobody knows which of the frames in the controller went out, and a set-point is relative: one that goes out
//! a second late moves the axis although nobody believes it. So the controller is emptied first, and only an empty one is let onto
//! the bus again.

use crate::config::CYCLE_US;
use crate::misbehaviour::{self, Fault};
use crate::transmit_places::RETRY_CYCLES;

/// A controller answers a request within some bits when it answers at all. Afterwards it is reset.
const ANSWER_CYCLES: u32 = 20_000_u32.div_ceil(CYCLE_US);
/// A reset ends a bus-off, so time takes the place of the 128 times 11 recessive bits that the controller owes (ISO 11898-1,
/// section 12.1.4.4): 141 ms at 10 kbit/s, the slowest rate of the drives.
const REST_CYCLES: u32 = 150_000_u32.div_ceil(CYCLE_US);

/// A controller, as far as its recovery goes. No call waits.
pub(crate) trait Cell {
    /// Resets it: afterwards it is off the bus, empty and without settings.
    fn reset(&mut self);
    /// Asks for the mode in which the settings can be written; it takes no part in the traffic there.
    fn request_initialisation(&mut self);
    /// Whether it is in that mode.
    fn is_initialising(&self) -> bool;
    /// Writes the settings and leaves that mode.
    fn set_up_and_join(&mut self);
    /// Whether it takes part in the traffic: it has seen 11 recessive bits, and 128 times as many after a bus-off.
    fn has_joined(&self) -> bool;
    /// Whether it is bus-off.
    fn is_bus_off(&self) -> bool;
    /// Asks it to give up every frame that waits to be sent.
    fn discard_pending(&mut self);
    /// Whether no frame waits to be sent.
    fn is_empty(&self) -> bool;
}

/// Fault confinement state of the controller (ISO 11898-1), and whether it gets its frames through at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub(crate) enum FaultState {
    /// Normal: both error counters below 128.
    ErrorActive,
    /// One error counter at 128 or above: the controller takes part but can no longer enforce its errors.
    ErrorPassive,
    /// A frame waited too long: nobody acknowledges, or the bus is never free. What waited was thrown away.
    Stuck,
    /// The transmit error counter went over 255, and the controller has not been brought back since.
    BusOff,
    /// It waits for recessive bits, to take part for the first time or again.
    Joining,
}

impl FaultState {
    /// The controller does not send, and the fate of what it was given is not known.
    pub(crate) const fn is_down(self) -> bool {
        matches!(self, Self::Stuck | Self::BusOff | Self::Joining)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Power-on.
    Unset,
    /// Was reset in place of an answer.
    Resting,
    /// Initialisation is requested.
    Initialising,
    /// Waiting for recessive bits, for ever on a bus that is held dominant or has no transceiver.
    Joining,
    OnBus,
    /// Nobody acknowledged: being emptied; the next attempt comes later.
    Pausing,
    /// Bus-off: being emptied. Initialisation comes only afterwards, because within it bxCAN gives no frame up.
    Emptying,
}

/// Where a controller is on its way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Recovery {
    phase: Phase,
    /// Since the phase began.
    cycles: u32,
}

impl Recovery {
    /// At power-on.
    pub(crate) const fn new() -> Self {
        Self {
            phase: Phase::Unset,
            cycles: 0,
        }
    }

    /// Whether the controller is on the bus, unless it has gone bus-off meanwhile.
    #[inline(always)]
    pub(crate) fn is_over(&self) -> bool {
        matches!(self.phase, Phase::OnBus)
    }

    /// One step, once a cycle until it returns true: at once when there is nothing to do.
    pub(crate) fn step(&mut self, cell: &mut impl Cell) -> bool {
        self.cycles = self.cycles.saturating_add(1);
        match self.phase {
            Phase::OnBus if !cell.is_bus_off() => return true,
            Phase::OnBus => self.empty(cell, Phase::Emptying),
            Phase::Pausing if cell.is_bus_off() => self.enter(Phase::Emptying),
            Phase::Pausing if self.cycles <= RETRY_CYCLES => {}
            Phase::Pausing if cell.is_empty() => self.initialise(cell),
            Phase::Emptying if is_taken_for_empty(cell) => self.initialise(cell),
            Phase::Emptying if self.cycles <= ANSWER_CYCLES => {}
            Phase::Initialising if cell.is_initialising() => {
                cell.set_up_and_join();
                self.enter(Phase::Joining);
            }
            Phase::Initialising if self.cycles <= ANSWER_CYCLES => {}
            Phase::Resting if self.cycles > REST_CYCLES => self.initialise(cell),
            Phase::Resting => {}
            Phase::Joining if cell.has_joined() => {
                self.enter(Phase::OnBus);
                return true;
            }
            Phase::Joining => {}
            Phase::Unset => {
                cell.reset();
                self.initialise(cell);
            }
            Phase::Pausing | Phase::Emptying | Phase::Initialising => {
                cell.reset();
                self.enter(Phase::Resting);
            }
        }
        false
    }

    /// A frame has waited too long: throws away what waits.
    pub(crate) fn give_up(&mut self, cell: &mut impl Cell) {
        if self.phase == Phase::OnBus && !cell.is_bus_off() {
            self.empty(cell, Phase::Pausing);
        }
    }

    /// The state of the controller.
    pub(crate) fn fault_state(&self, is_bus_off: bool, is_passive: bool) -> FaultState {
        match self.phase {
            Phase::Pausing if !is_bus_off => FaultState::Stuck,
            Phase::OnBus if !is_bus_off && is_passive => FaultState::ErrorPassive,
            Phase::OnBus if !is_bus_off => FaultState::ErrorActive,
            Phase::Unset | Phase::Initialising | Phase::Joining if !is_bus_off => {
                FaultState::Joining
            }
            _ => FaultState::BusOff,
        }
    }

    fn empty(&mut self, cell: &mut impl Cell, phase: Phase) {
        if !misbehaviour::has(Fault::KeepOldFrames) {
            cell.discard_pending();
        }
        self.enter(phase);
    }

    fn initialise(&mut self, cell: &mut impl Cell) {
        cell.request_initialisation();
        self.enter(Phase::Initialising);
    }

    fn enter(&mut self, phase: Phase) {
        self.phase = phase;
        self.cycles = 0;
    }
}

fn is_taken_for_empty(cell: &impl Cell) -> bool {
    cell.is_empty() || misbehaviour::has(Fault::KeepOldFrames)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Answers what it is told to, and keeps what was asked of it.
    #[derive(Default)]
    struct Scripted {
        is_bus_off: bool,
        waiting: bool,
        discards: bool,
        initialises: bool,
        joins: bool,
        asked: Vec<&'static str>,
    }

    impl Cell for Scripted {
        fn reset(&mut self) {
            self.asked.push("reset");
            (self.is_bus_off, self.waiting) = (false, false);
        }
        fn request_initialisation(&mut self) {
            self.asked.push("initialise");
        }
        fn is_initialising(&self) -> bool {
            self.initialises
        }
        fn set_up_and_join(&mut self) {
            self.asked.push("join");
            assert!(!self.waiting, "let onto the bus with old frames");
        }
        fn has_joined(&self) -> bool {
            self.joins && !self.is_bus_off
        }
        fn is_bus_off(&self) -> bool {
            self.is_bus_off
        }
        fn discard_pending(&mut self) {
            self.asked.push("discard");
            self.waiting &= !self.discards;
        }
        fn is_empty(&self) -> bool {
            !self.waiting
        }
    }

    fn steps(recovery: &mut Recovery, cell: &mut Scripted, cycles: u32) -> bool {
        (0..cycles).any(|_| recovery.step(cell))
    }

    fn on_bus() -> (Recovery, Scripted) {
        let (mut recovery, mut cell) = (Recovery::new(), Scripted::default());
        (cell.initialises, cell.joins) = (true, true);
        assert!(steps(&mut recovery, &mut cell, 3));
        assert_eq!(cell.asked, ["reset", "initialise", "join"]);
        cell.asked.clear();
        (recovery, cell)
    }

    #[test]
    fn it_waits_for_ever_on_a_bus_that_is_never_idle() {
        let (mut recovery, mut cell) = (Recovery::new(), Scripted::default());
        cell.initialises = true;
        assert!(!steps(&mut recovery, &mut cell, 100_000));
        assert_eq!(recovery.fault_state(false, false), FaultState::Joining);
        cell.joins = true;
        assert!(steps(&mut recovery, &mut cell, 1));
        assert_eq!(recovery.fault_state(false, false), FaultState::ErrorActive);
    }

    #[test]
    fn a_controller_that_does_not_answer_is_reset_again_and_again() {
        let (mut recovery, mut cell) = (Recovery::new(), Scripted::default());
        let resets = |cell: &Scripted| cell.asked.iter().filter(|&&what| what == "reset").count();
        assert!(!steps(&mut recovery, &mut cell, 1_000_000 / CYCLE_US));
        assert!((5..=7).contains(&resets(&cell)), "{:?}", cell.asked);
        (cell.initialises, cell.joins) = (true, true);
        assert!(steps(&mut recovery, &mut cell, 2 * REST_CYCLES));
    }

    #[test]
    fn out_of_bus_off_it_is_emptied_before_it_joins() {
        let (mut recovery, mut cell) = on_bus();
        (cell.is_bus_off, cell.waiting) = (true, true);
        assert!(!steps(&mut recovery, &mut cell, ANSWER_CYCLES));
        assert_eq!(cell.asked, ["discard"]);
        assert_eq!(recovery.fault_state(true, true), FaultState::BusOff);
        cell.waiting = false;
        assert!(!steps(&mut recovery, &mut cell, 10));
        assert_eq!(recovery.fault_state(true, true), FaultState::BusOff);
        assert_eq!(cell.asked, ["discard", "initialise", "join"]);
        cell.is_bus_off = false;
        assert!(steps(&mut recovery, &mut cell, 1));
    }

    #[test]
    fn one_that_keeps_its_frames_is_reset_and_rests_as_long_as_a_bus_off_takes() {
        let (mut recovery, mut cell) = on_bus();
        (cell.is_bus_off, cell.waiting) = (true, true);
        assert!(!steps(
            &mut recovery,
            &mut cell,
            ANSWER_CYCLES + REST_CYCLES
        ));
        assert_eq!(cell.asked, ["discard", "reset"]);
        assert!(steps(&mut recovery, &mut cell, 10));
    }

    #[test]
    fn what_nobody_acknowledges_is_thrown_away_and_tried_again_later() {
        let (mut recovery, mut cell) = on_bus();
        (cell.waiting, cell.discards) = (true, true);
        recovery.give_up(&mut cell);
        assert_eq!(recovery.fault_state(false, true), FaultState::Stuck);
        assert!(!steps(&mut recovery, &mut cell, RETRY_CYCLES));
        assert_eq!(cell.asked, ["discard"]);
        assert!(steps(&mut recovery, &mut cell, 3));
    }

    #[test]
    fn a_bus_off_while_it_pauses_is_recovered_from() {
        let (mut recovery, mut cell) = on_bus();
        (cell.waiting, cell.discards) = (true, true);
        recovery.give_up(&mut cell);
        cell.is_bus_off = true;
        assert!(!steps(&mut recovery, &mut cell, 5));
        assert_eq!(recovery.fault_state(true, true), FaultState::BusOff);
        cell.is_bus_off = false;
        assert!(steps(&mut recovery, &mut cell, 5));
    }
}
