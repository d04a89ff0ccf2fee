//! The truth about one axis: a few independent facts, small enough to enumerate.
//!
//! Nothing about an axis is written in two places. What users see as [`AxisState`](crate::AxisState) is computed from the facts, and
//! only [`step`](super::step::step) changes them.

/// What is known of the drive; each value needs the one before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Knowledge {
    /// Nothing, or nothing that still holds.
    Unknown,
    /// Identified, its configuration accepted, its position within the travel.
    Checked,
    /// Checked, and the shaft has stood still long enough since.
    Standing,
    /// Standing, and its position taken as the anchor of the ledger.
    Anchored,
}

/// What is known of the power of the drive. It is driven towards the goal, as often as that takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Power {
    /// The drive has not reported it, and this master did not switch it on.
    Unclear,
    /// This master switched it on, and has lost sight of it since.
    OnUnconfirmed,
    /// The drive reports that it is off.
    Off,
    /// The enable command waits for its frame.
    OnWanted,
    /// The enable command was accepted by the controller; the drive has not confirmed it.
    OnSent,
    /// The drive reports that it is on, and this master enabled or adopted it.
    On,
    /// The drive reports that it is on, and this master did not enable it: it came up with its servo on, or somebody else enabled
    /// it. It is left alone, because a load may hang on it, until `disable` or `adopt`.
    FoundOn,
    /// The disable command waits for its frame.
    OffWanted,
    /// The disable command was accepted by the controller; the drive has not confirmed it.
    OffSent,
}

impl Power {
    /// Whether the motor may be energised.
    #[must_use]
    pub const fn may_be_on(self) -> bool {
        !matches!(self, Self::Off | Self::OnWanted)
    }

    /// Whether the drive has to report it before anything is decided about it.
    #[must_use]
    pub const fn is_unclear(self) -> bool {
        matches!(self, Self::Unclear | Self::OnUnconfirmed)
    }
}

/// What moves the axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Motion {
    /// Nothing.
    Rest,
    /// Set-points of a ramp to standstill.
    Ramp,
    /// Set-points of the application.
    Stream,
    /// Nothing yet, but the drive was sent a move that a trigger starts.
    Loaded,
    /// The same, and every drive that is to start with it has answered since: the trigger may go out.
    Armed,
    /// The drive, by itself. Without a goal that asks for it, it is told to stop.
    DriveMove,
}

/// What the application asked for last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Goal {
    /// No power.
    Off,
    /// Power, no set-points.
    Hold,
    /// Power and set-points.
    Stream,
    /// Power, and a motion that the drive makes by itself.
    Move,
    /// The same, loaded first and started by a trigger together with other drives.
    SyncMove,
}

impl Goal {
    /// Whether a motion of the drive itself is asked for.
    #[must_use]
    pub const fn is_move(self) -> bool {
        matches!(self, Self::Move | Self::SyncMove)
    }
}

/// What keeps the axis from moving until `clear`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Latch {
    /// Nothing.
    None,
    /// A fault of its own.
    Own,
    /// A fault of another axis of its group.
    Group,
}

/// A procedure beside the cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Work {
    /// None.
    None,
    /// It only reads.
    Read,
    /// It changes the drive: origin, parameters.
    Write,
    /// It makes the drive usable: reset, configuration, fault reset.
    Repair,
}

impl Work {
    /// Whether it and a motor with power exclude each other.
    #[must_use]
    pub const fn needs_off(self) -> bool {
        matches!(self, Self::Write | Self::Repair)
    }
}

/// The holding brake that this master operates by frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Brake {
    /// There is none, or the drive operates it by itself.
    Absent,
    /// It was not commanded since the drive is known.
    Unclear,
    /// The drive confirmed the command to open it.
    Open,
    /// The drive confirmed the command to close it.
    Closed,
}

/// The facts of one axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[expect(
    missing_docs,
    reason = "each field has the name of its type, which is documented"
)]
// The first four are read as one word: see `word`.
#[repr(C)]
pub struct Facts {
    pub knowledge: Knowledge,
    pub power: Power,
    pub motion: Motion,
    pub brake: Brake,
    pub goal: Goal,
    pub latch: Latch,
    pub work: Work,
}

impl Facts {
    /// Whether this master has switched the drive on, or is about to, or moves it; until the drive confirms that it is off. A drive that was found
    /// on has not its power from this master.
    #[must_use]
    pub const fn has_own_power(&self) -> bool {
        let is_others = matches!(self.power, Power::Unclear | Power::Off | Power::FoundOn);
        !is_others || !matches!(self.motion, Motion::Rest)
    }

    /// An axis of which nothing is known.
    #[must_use]
    pub const fn start(brake: Brake) -> Self {
        Self {
            knowledge: Knowledge::Unknown,
            power: Power::Unclear,
            motion: Motion::Rest,
            goal: Goal::Off,
            latch: Latch::None,
            work: Work::None,
            brake,
        }
    }

    /// Knowledge, power, motion and brake, lowest byte first: what is asked for each set-point, compared at once.
    #[inline]
    const fn word(&self) -> u32 {
        u32::from_le_bytes([
            self.knowledge as u8,
            self.power as u8,
            self.motion as u8,
            self.brake as u8,
        ])
    }

    /// Whether a drive with these may be moved: it has power and its anchor, and no brake holds it.
    #[inline]
    pub(crate) const fn can_move(&self) -> bool {
        const MASK: u32 = 0xFF << 24 | 0xFFFF;
        const FREE: u32 = Facts::word_of(Motion::Rest, Brake::Absent);
        const OPEN: u32 = Facts::word_of(Motion::Rest, Brake::Open);
        matches!(self.word() & MASK, FREE | OPEN)
    }

    /// Whether the set-points of the application may go out.
    #[inline]
    pub(crate) const fn streams(&self) -> bool {
        const FREE: u32 = Facts::word_of(Motion::Stream, Brake::Absent);
        const OPEN: u32 = Facts::word_of(Motion::Stream, Brake::Open);
        matches!(self.word(), FREE | OPEN)
    }

    /// The word of an axis with power and anchor.
    const fn word_of(motion: Motion, brake: Brake) -> u32 {
        let facts = Self {
            knowledge: Knowledge::Anchored,
            power: Power::On,
            motion,
            ..Self::start(brake)
        };
        facts.word()
    }

    /// Whether the axis moves: by set-points, or by its drive itself.
    #[must_use]
    pub const fn moves(&self) -> bool {
        self.sends_set_points() || matches!(self.motion, Motion::DriveMove)
    }

    /// Whether set-points go out.
    #[must_use]
    pub const fn sends_set_points(&self) -> bool {
        matches!(self.motion, Motion::Ramp | Motion::Stream)
    }

    /// Whether the drive was told of a motion of its own, or is to be told.
    #[must_use]
    pub const fn has_own_move(&self) -> bool {
        self.goal.is_move()
            || matches!(
                self.motion,
                Motion::Loaded | Motion::Armed | Motion::DriveMove
            )
    }

    /// Whether the drive makes a motion of its own that is not wanted any more.
    #[must_use]
    pub const fn is_to_stop_itself(&self) -> bool {
        matches!(self.motion, Motion::DriveMove) && !self.goal.is_move()
    }

    /// Whether the application wants power, or the axis still moves.
    #[must_use]
    pub const fn is_in_use(&self) -> bool {
        !matches!(self.goal, Goal::Off) || self.moves()
    }

    /// Whether the checks of the drive go on: nothing is known, and no fault waits for `clear`.
    #[must_use]
    pub const fn is_checking(&self) -> bool {
        matches!(self.knowledge, Knowledge::Unknown) && !matches!(self.latch, Latch::Own)
    }

    /// Whether the axis waits for a shaft that stands still.
    #[must_use]
    pub const fn awaits_standstill(&self) -> bool {
        matches!(self.knowledge, Knowledge::Checked) && self.wants_anchor()
    }

    /// Whether the axis waits for the position that becomes its anchor.
    #[must_use]
    pub const fn awaits_anchor(&self) -> bool {
        matches!(self.knowledge, Knowledge::Standing) && self.wants_anchor()
    }

    /// Whether the drive keeps its anchor by its own power.
    #[must_use]
    pub const fn holds_anchor(&self) -> bool {
        matches!(self.knowledge, Knowledge::Anchored) && matches!(self.power, Power::On)
    }

    const fn wants_anchor(&self) -> bool {
        !matches!(self.goal, Goal::Off)
            && matches!(self.latch, Latch::None)
            && matches!(self.power, Power::Off | Power::On)
    }

    /// Whether the report of the drive about its power is needed.
    #[must_use]
    pub const fn awaits_power(&self) -> bool {
        self.power.is_unclear() || matches!(self.power, Power::OnSent | Power::OffSent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_read_as_one_word_is_what_the_facts_say() {
        let brakes = [Brake::Absent, Brake::Unclear, Brake::Open, Brake::Closed];
        let motions = [Motion::Rest, Motion::Ramp, Motion::Stream];
        let knowledges = [
            Knowledge::Unknown,
            Knowledge::Checked,
            Knowledge::Standing,
            Knowledge::Anchored,
        ];
        let powers = [
            Power::Unclear,
            Power::OnUnconfirmed,
            Power::Off,
            Power::OnWanted,
            Power::OnSent,
            Power::On,
            Power::FoundOn,
            Power::OffWanted,
            Power::OffSent,
        ];
        for (brake, motion) in brakes
            .iter()
            .flat_map(|brake| motions.map(|motion| (*brake, motion)))
        {
            for (knowledge, power) in knowledges
                .iter()
                .flat_map(|known| powers.map(|power| (*known, power)))
            {
                let facts = Facts {
                    knowledge,
                    power,
                    motion,
                    ..Facts::start(brake)
                };
                let can_move = knowledge == Knowledge::Anchored
                    && power == Power::On
                    && matches!(brake, Brake::Absent | Brake::Open);
                assert_eq!(facts.can_move(), can_move, "{facts:?}");
                let streams = can_move && motion == Motion::Stream;
                assert_eq!(facts.streams(), streams, "{facts:?}");
            }
        }
    }

    #[test]
    fn power_that_is_unclear_or_being_switched_is_awaited() {
        let awaited = |power| {
            let facts = Facts::start(Brake::Absent);
            Facts { power, ..facts }.awaits_power()
        };
        let yes = [
            Power::Unclear,
            Power::OnUnconfirmed,
            Power::OnSent,
            Power::OffSent,
        ];
        assert_eq!(yes.map(awaited), [true; 4]);
        let no = [
            Power::Off,
            Power::OnWanted,
            Power::On,
            Power::FoundOn,
            Power::OffWanted,
        ];
        assert_eq!(no.map(awaited), [false; 5]);
    }
}
