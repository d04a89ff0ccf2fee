//! What a step is: a name, what it shows, what the machine must have for it, and what it does.

use super::need::Need;
use super::place::Place;
use crate::error::Error;

/// One step of the checks.
pub(super) struct Step {
    /// The word that chooses it on the command line.
    pub(super) name: &'static str,
    /// What it checks, in one line.
    pub(super) purpose: &'static str,
    /// What the machine must have, in the order in which it is looked for.
    pub(super) needs: &'static [&'static Need],
    /// What it does.
    pub(super) action: Action,
}

/// What a step does.
pub(super) enum Action {
    /// Runs cargo with each of these lines, words separated by spaces.
    Cargo(&'static [&'static str]),
    /// The same with tasks of this program that build for the boards; they receive the toolchain that was found.
    ForBoards(&'static [&'static str]),
    /// Anything else. Its result is what it could not check, with the reasons.
    Call(fn(&Place) -> Result<Vec<String>, Error>),
}

impl Step {
    /// A step that runs cargo.
    pub(super) const fn cargo(
        name: &'static str,
        purpose: &'static str,
        lines: &'static [&'static str],
    ) -> Self {
        Self::new(name, purpose, Action::Cargo(lines))
    }

    /// A step that runs tasks of this program which build for the boards.
    pub(super) const fn for_boards(
        name: &'static str,
        purpose: &'static str,
        lines: &'static [&'static str],
    ) -> Self {
        Self::new(name, purpose, Action::ForBoards(lines))
    }

    /// A step that is more than a line for cargo.
    pub(super) const fn call(
        name: &'static str,
        purpose: &'static str,
        function: fn(&Place) -> Result<Vec<String>, Error>,
    ) -> Self {
        Self::new(name, purpose, Action::Call(function))
    }

    const fn new(name: &'static str, purpose: &'static str, action: Action) -> Self {
        Self {
            name,
            purpose,
            needs: &[],
            action,
        }
    }

    /// The same step on a machine that must have these.
    pub(super) const fn needs(self, needs: &'static [&'static Need]) -> Self {
        Self { needs, ..self }
    }
}
