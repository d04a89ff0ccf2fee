//! The settings of an axis that its servo works with. What the start alone needs is not among them.

use dyn_can::{DriveId, GearNumber};

use crate::core::family::{GroupId, Reaction};
use crate::servo::config::{AxisConfig, DialectChoice, Limits, ReadBackScale};
use crate::servo::fault::Reactions;

/// From [`AxisConfig`], whose fields have these names.
#[derive(Debug, Clone, Copy)]
pub(super) struct Settings {
    pub(super) limits: Limits,
    pub(super) read_back: ReadBackScale,
    pub(super) gear: GearNumber,
    pub(super) drive: DriveId,
    pub(super) group: GroupId,
    reactions: PackedReactions,
    /// The dialect is to be detected.
    pub(super) detects_dialect: bool,
    pub(super) unwatched: bool,
    pub(super) load_can_fall: bool,
}

/// Two bits for each reaction.
#[derive(Debug, Clone, Copy)]
struct PackedReactions(u16);

impl PackedReactions {
    fn of(reactions: &Reactions) -> Self {
        let Reactions {
            alarm,
            data_error,
            lost,
            backlog,
            position,
            bus,
        } = *reactions;
        let all = [alarm, data_error, lost, backlog, position, bus];
        Self(all.iter().rev().fold(0, |bits, reaction| {
            let code = match reaction {
                Reaction::Halt => 0,
                Reaction::RampDown => 1,
                Reaction::Disable => 2,
            };
            bits << 2 | code
        }))
    }

    fn unpack(self) -> Reactions {
        let reaction = |place: u16| match self.0 >> (2 * place) & 3 {
            0 => Reaction::Halt,
            1 => Reaction::RampDown,
            _ => Reaction::Disable,
        };
        Reactions {
            alarm: reaction(0),
            data_error: reaction(1),
            lost: reaction(2),
            backlog: reaction(3),
            position: reaction(4),
            bus: reaction(5),
        }
    }
}

impl Settings {
    pub(super) fn reactions(&self) -> Reactions {
        self.reactions.unpack()
    }

    pub(super) fn of(axis: &AxisConfig) -> Self {
        Self {
            limits: axis.limits,
            read_back: axis.read_back,
            gear: axis.gear,
            drive: axis.drive,
            group: axis.group,
            reactions: PackedReactions::of(&axis.reactions),
            detects_dialect: axis.dialect == DialectChoice::Detect,
            unwatched: axis.unwatched,
            load_can_fall: axis.load_can_fall,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_reactions_are_those_that_were_packed() {
        let [halt, ramp, disable] = [Reaction::Halt, Reaction::RampDown, Reaction::Disable];
        for [alarm, data_error, lost, backlog, position, bus] in [
            [halt, ramp, disable, halt, ramp, disable],
            [disable, halt, ramp, ramp, disable, halt],
            [ramp, disable, halt, disable, halt, ramp],
        ] {
            let reactions = Reactions {
                alarm,
                data_error,
                lost,
                backlog,
                position,
                bus,
            };
            assert_eq!(PackedReactions::of(&reactions).unpack(), reactions);
        }
    }
}
