//! A drive and a controller beside the facts: what the master believes against what is.
//!
//! The drive obeys the frames that reach it, in the order in which the controller took them. A frame may be lost on the way or given
//! back. The drive may let go or start anew by itself, with its motor on or off; the master then receives a fault.

use can_motion::facts::{Brake, Class, Facts, Input, Loss, Power};

use crate::promises::sends;
use crate::rules::{BRAKES, Rules, inputs};
use crate::walk::{Broken, Held, hold, walk};

/// Frames that the controller took and the drive has not received.
const DEPTH: usize = 3;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Pair {
    facts: Facts,
    is_on: bool,
    is_braked: bool,
    /// It did so by itself at least once; a frame that was under way may then reach a drive that let go.
    has_started_anew: bool,
    under_way: [Option<Class>; DEPTH],
}

#[derive(Debug, Clone, Copy)]
enum Event {
    Master(Input),
    /// The oldest frame reaches the drive.
    Arrives,
    /// The oldest frame is lost.
    Vanishes,
    /// The drive lets go or starts anew; its motor is then on or off.
    StartsAnew {
        is_on: bool,
    },
}

impl Pair {
    fn start(brake: Brake, is_on: bool) -> Self {
        Self {
            facts: Facts::start(brake),
            is_on,
            is_braked: false,
            has_started_anew: false,
            under_way: [None; DEPTH],
        }
    }

    fn has_under_way(&self, classes: &[Class]) -> bool {
        self.under_way
            .iter()
            .flatten()
            .any(|class| classes.contains(class))
    }

    fn next(self, rules: &Rules, event: Event) -> Option<Self> {
        match event {
            Event::Master(input) => self.by(rules, input),
            Event::Arrives => {
                let (class, mut after) = self.oldest()?;
                match class {
                    Class::SwitchOn => after.is_on = true,
                    Class::SwitchOff => after.is_on = false,
                    Class::BrakeOpen => after.is_braked = false,
                    _ => after.is_braked = true,
                }
                Some(after)
            }
            Event::Vanishes => self.oldest().map(|(_, after)| after),
            Event::StartsAnew { is_on } => {
                let input = Input::Fault {
                    loss: Loss::Drive,
                    ramp: false,
                };
                let facts = rules.next(self.facts, input)?;
                Some(Self {
                    facts,
                    is_on,
                    has_started_anew: true,
                    ..self
                })
            }
        }
    }

    fn oldest(mut self) -> Option<(Class, Self)> {
        let class = self.under_way[0]?;
        self.under_way.rotate_left(1);
        self.under_way[DEPTH - 1] = None;
        Some((class, self))
    }

    fn by(mut self, rules: &Rules, input: Input) -> Option<Self> {
        const SWITCHES: [Class; 2] = [Class::SwitchOn, Class::SwitchOff];
        const BRAKE: [Class; 2] = [Class::BrakeOpen, Class::BrakeClose];
        let is_sent = matches!(self.facts.power, Power::OnSent | Power::OffSent);
        let is_confirming = is_sent && self.has_under_way(&SWITCHES);
        let (power, facts) = (self.facts.power, rules.next(self.facts, input)?);
        match input {
            // Reports are true, and confirm a command only when asked for after it was transmitted.
            Input::SaysOn if !self.is_on || is_confirming => return None,
            Input::SaysOff if self.is_on || is_confirming => return None,
            Input::BrakeOpened if self.is_braked || self.has_under_way(&BRAKE) => return None,
            Input::BrakeClosed if !self.is_braked || self.has_under_way(&BRAKE) => return None,
            // That the drive started anew comes from the drive.
            Input::Fault {
                loss: Loss::Drive, ..
            } => return None,
            // The command goes out once, until it is due again.
            Input::Accepted(Class::SwitchOn) if power != Power::OnWanted => return None,
            Input::Accepted(Class::SwitchOff) if power != Power::OffWanted => return None,
            Input::Accepted(class) if SWITCHES.contains(&class) || BRAKE.contains(&class) => {
                *self.under_way.iter_mut().find(|place| place.is_none())? = Some(class);
            }
            Input::Displaced(class) if SWITCHES.contains(&class) => {
                let place = self.under_way.iter().rposition(|&c| c == Some(class))?;
                self.under_way[place..].rotate_left(1);
                self.under_way[DEPTH - 1] = None;
            }
            _ => {}
        }
        self.facts = facts;
        Some(self)
    }
}

fn check(before: Pair, event: Event, after: Pair) -> Held {
    let facts = &after.facts;
    let may_come_on = after.is_on || after.has_under_way(&[Class::SwitchOn]);
    hold(
        !matches!(facts.power, Power::Off | Power::OnWanted) || !may_come_on,
        "a drive that the master takes for off is off, and no command is under way that switches it on",
    )?;
    hold(
        !sends(facts) || after.is_on,
        "set-points go to a drive that is on",
    )?;
    let arrives = |class| matches!(event, Event::Arrives) && before.under_way[0] == Some(class);
    let has_brake = facts.brake != Brake::Absent;
    hold(
        !has_brake || !arrives(Class::SwitchOff) || !before.is_on || after.is_braked,
        "power goes off behind a closed brake",
    )?;
    hold(
        !arrives(Class::BrakeClose) || !sends(facts),
        "the brake closes at rest",
    )?;
    hold(
        !arrives(Class::BrakeOpen) || after.is_on || after.has_started_anew,
        "the brake opens when the drive holds",
    )
}

/// The number of combinations of facts, drive and frames under way, without and with a brake.
pub(crate) fn beliefs_are_true(rules: &Rules) -> Result<Vec<usize>, Broken> {
    let mut events: Vec<Event> = inputs().into_iter().map(Event::Master).collect();
    events.extend([
        Event::Arrives,
        Event::Vanishes,
        Event::StartsAnew { is_on: true },
        Event::StartsAnew { is_on: false },
    ]);
    let walk_from = |brake| {
        let starts = [true, false].map(|is_on| Pair::start(brake, is_on));
        walk(
            &starts,
            &events,
            |pair, event| pair.next(rules, event),
            check,
        )
    };
    let counts = BRAKES.map(|brake| walk_from(brake).map(|seen| seen.len()));
    counts.into_iter().collect()
}
