//! Seeded mistakes: the three functions with one decision wrong each. Every one must break a promise.

mod commands;
mod events;
mod exit;
mod faults;
mod needed;
mod own_moves;

use can_motion::facts::{Class, Facts, Input, transition};

use crate::rules::{RULES, Rules};

/// A mistake.
pub(crate) struct Mistake {
    /// Function and decision.
    pub(crate) name: &'static str,
    pub(crate) rules: Rules,
}

/// One for each decision in `accepts`, `transition` and `may_leave`.
pub(crate) fn all() -> Vec<Mistake> {
    let accepts = needed::ALL.iter().chain(own_moves::NEEDED);
    let accepts = accepts.map(|&(name, accepts)| Mistake {
        name,
        rules: Rules { accepts, ..RULES },
    });
    let exits = exit::ALL.iter().chain(own_moves::EXITS);
    let exits = exits.map(|&(name, may_leave)| Mistake {
        name,
        rules: Rules { may_leave, ..RULES },
    });
    let changes = [commands::ALL, events::ALL, faults::ALL, own_moves::CHANGES]
        .into_iter()
        .flatten();
    let changes = changes.map(|&(name, transition)| Mistake {
        name,
        rules: Rules {
            transition,
            ..RULES
        },
    });
    accepts.chain(exits).chain(changes).collect()
}

type Accepts = (&'static str, fn(&Facts, Input) -> bool);
type Exit = (&'static str, fn(Class, &Facts) -> bool);
type Change = (&'static str, fn(Facts, Input) -> Facts);

/// What is true after an input, with a mistake made of the facts before and after it.
fn then(
    before: Facts,
    input: Input,
    is_meant: bool,
    mistake: impl FnOnce(Facts) -> Facts,
) -> Facts {
    let after = transition(before, input);
    if is_meant { mistake(after) } else { after }
}

/// The facts when nothing happens.
fn settled(facts: Facts) -> Facts {
    transition(facts, Input::Accepted(Class::Poll))
}
