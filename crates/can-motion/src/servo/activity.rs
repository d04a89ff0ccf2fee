//! What a drive does besides the life of its axis: a procedure, or a motion that it makes by itself. One at a time.

use crate::servo::own_move::OwnMove;
use crate::servo::procedure::Run;

/// The one thing that is under way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Activity {
    None,
    Procedure(Run),
    Own(OwnMove),
}

impl Activity {
    pub(super) const fn is_none(&self) -> bool {
        matches!(self, Self::None)
    }

    pub(super) const fn run(&self) -> Option<&Run> {
        match self {
            Self::Procedure(run) => Some(run),
            Self::None | Self::Own(_) => None,
        }
    }

    pub(super) const fn run_mut(&mut self) -> Option<&mut Run> {
        match self {
            Self::Procedure(run) => Some(run),
            Self::None | Self::Own(_) => None,
        }
    }

    pub(super) const fn own(&self) -> Option<&OwnMove> {
        match self {
            Self::Own(own) => Some(own),
            Self::None | Self::Procedure(_) => None,
        }
    }

    pub(super) const fn own_mut(&mut self) -> Option<&mut OwnMove> {
        match self {
            Self::Own(own) => Some(own),
            Self::None | Self::Procedure(_) => None,
        }
    }
}
