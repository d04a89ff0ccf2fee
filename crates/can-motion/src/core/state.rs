//! The life of an axis as users see it: a view of its facts.

use core::fmt;

use super::facts::{Facts, Goal, Knowledge, Latch, Motion, Power};
use super::step::Input;

/// How far the checks of a drive are, while nothing is known of it yet. A family needs not have all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Stage {
    /// Waits until the drive has started.
    PowerOn,
    /// Whether it answers.
    Probing,
    /// What it is.
    Identifying,
    /// How it is configured.
    CheckingConfig,
    /// Whether it reports a fault.
    CheckingStatus,
    /// Where it stands.
    Locating,
}

/// Where an axis is in its life.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum AxisState {
    /// Waits until the drive has started.
    PowerOn,
    /// Asks whether the drive answers.
    Probing,
    /// Asks what the drive is.
    Identifying,
    /// Reads the configuration of the drive.
    CheckingConfig,
    /// Reads the status of the drive.
    CheckingStatus,
    /// Reads the position of the drive.
    Locating,
    /// Checked, and the drive reports no power.
    Ready,
    /// Checked, and the drive reports power that this master did not switch on. `adopt` takes it over, `disable` switches it off.
    FoundOn,
    /// Waits until the shaft has stood still long enough.
    AwaitingStandstill,
    /// Reads the position again: target = position, so that nothing jumps.
    Anchoring,
    /// The enable command is to be sent or confirmed.
    Enabling,
    /// A set-point every cycle.
    Streaming,
    /// A set-point every cycle, slowing down with its group.
    RampingDown,
    /// Enabled, no set-points; resumes on the application's word.
    Holding,
    /// The drive makes a motion by itself.
    DriveMoving,
    /// The drive was told to end the motion that it makes by itself, or is to be told.
    DriveStopping,
    /// The drive was sent a move that a trigger starts. When it is not wanted any more, `disable` the group: what a drive forgets
    /// without that is not documented (D57).
    Loaded,
    /// The disable command is to be sent or confirmed; it is repeated until the drive confirms it.
    Disabling,
    /// Stopped by a fault, until `clear`.
    Faulted,
}

impl AxisState {
    /// The state that these facts show.
    #[must_use]
    pub const fn of(facts: &Facts, stage: Stage) -> Self {
        match (facts.motion, facts.power) {
            (Motion::Stream, _) => return Self::Streaming,
            (Motion::Ramp, _) => return Self::RampingDown,
            (Motion::DriveMove, _) if facts.goal.is_move() => return Self::DriveMoving,
            (Motion::DriveMove, _) => return Self::DriveStopping,
            (_, Power::OffWanted | Power::OffSent) => return Self::Disabling,
            _ => {}
        }
        if !matches!(facts.latch, Latch::None) {
            return Self::Faulted;
        }
        if matches!(facts.motion, Motion::Loaded | Motion::Armed) {
            return Self::Loaded;
        }
        match (facts.knowledge, facts.power, facts.goal) {
            (_, Power::OnWanted | Power::OnSent, _) => Self::Enabling,
            (Knowledge::Unknown, ..) => Self::of_stage(stage),
            (_, Power::FoundOn, _) => Self::FoundOn,
            (_, Power::Unclear | Power::OnUnconfirmed, _) => Self::CheckingStatus,
            (_, _, Goal::Off) => Self::Ready,
            (Knowledge::Checked, ..) => Self::AwaitingStandstill,
            (Knowledge::Standing, ..) => Self::Anchoring,
            (Knowledge::Anchored, ..) => Self::Holding,
        }
    }

    const fn of_stage(stage: Stage) -> Self {
        match stage {
            Stage::PowerOn => Self::PowerOn,
            Stage::Probing => Self::Probing,
            Stage::Identifying => Self::Identifying,
            Stage::CheckingConfig => Self::CheckingConfig,
            Stage::CheckingStatus => Self::CheckingStatus,
            Stage::Locating => Self::Locating,
        }
    }

    /// Whether the axis sends a set-point every cycle.
    #[must_use]
    pub const fn sends_set_points(self) -> bool {
        matches!(self, Self::Streaming | Self::RampingDown)
    }

    /// Whether the drive is enabled, as far as this master knows.
    #[must_use]
    pub const fn is_enabled(self) -> bool {
        matches!(
            self,
            Self::Streaming | Self::RampingDown | Self::Holding | Self::DriveMoving
        )
    }
}

impl fmt::Display for AxisState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::PowerOn => "waiting for power-on",
            Self::Probing => "probing",
            Self::Identifying => "identifying",
            Self::CheckingConfig => "checking configuration",
            Self::CheckingStatus => "checking status",
            Self::Locating => "reading the position",
            Self::Ready => "ready",
            Self::FoundOn => "found enabled",
            Self::AwaitingStandstill => "awaiting standstill",
            Self::Anchoring => "anchoring",
            Self::Enabling => "enabling",
            Self::Streaming => "streaming",
            Self::RampingDown => "ramping down",
            Self::Holding => "holding",
            Self::DriveMoving => "moving by itself",
            Self::DriveStopping => "ending its own motion",
            Self::Loaded => "loaded for a trigger",
            Self::Disabling => "disabling",
            Self::Faulted => "faulted",
        })
    }
}

/// Why an axis changed its state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reason {
    /// The application asked for it.
    Command,
    /// A reading came.
    Reading,
    /// The command frame was accepted by the controller.
    Sent,
    /// The controller gave the command frame back unsent.
    Displaced,
    /// A waiting time is over.
    Elapsed,
    /// The ramp reached standstill.
    Standstill,
    /// The motion that the drive made by itself ended.
    MoveEnded,
    /// Every axis of the group is ready to stream.
    Group,
    /// A fault of this axis or its group.
    Fault,
}

impl Reason {
    pub(crate) const fn of(input: Input) -> Self {
        match input {
            Input::Enable
            | Input::Adopt
            | Input::Resume
            | Input::Rearm
            | Input::Stop
            | Input::Halt
            | Input::Disable
            | Input::Clear
            | Input::Move
            | Input::SyncMove
            | Input::StartWork(_) => Self::Command,
            Input::Checked
            | Input::Stands
            | Input::Turns
            | Input::Anchored
            | Input::SaysOn
            | Input::SaysOff
            | Input::BrakeOpened
            | Input::BrakeClosed
            | Input::WorkEnded
            | Input::Restarted => Self::Reading,
            Input::Accepted(_) => Self::Sent,
            Input::Displaced(_) => Self::Displaced,
            Input::ConfirmTimeout => Self::Elapsed,
            Input::RampDone => Self::Standstill,
            Input::MoveEnded(_) => Self::MoveEnded,
            Input::Fault { .. } | Input::GroupFault { .. } => Self::Fault,
            Input::Start | Input::Arm => Self::Group,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn what_moves_is_enabled_and_what_holds_too() {
        let states = [
            (AxisState::Streaming, true, true),
            (AxisState::RampingDown, true, true),
            (AxisState::Holding, false, true),
            (AxisState::Enabling, false, false),
            (AxisState::Faulted, false, false),
        ];
        for (state, moves, is_enabled) in states {
            assert_eq!(
                (state.sends_set_points(), state.is_enabled()),
                (moves, is_enabled)
            );
        }
        assert_eq!(AxisState::FoundOn.to_string(), "found enabled");
    }
}
