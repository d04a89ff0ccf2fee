//! The one exit: which frames may be handed to the controller.

use super::facts::{Brake, Facts, Goal, Knowledge, Latch, Motion, Power, Work};

/// What a frame is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Class {
    /// It moves the motor: the set-point of a cycle.
    SetPoint,
    /// It starts a motion that the drive makes by itself.
    DriveMove,
    /// It loads a move that a trigger starts.
    Load,
    /// It starts the loaded moves of every drive on the bus.
    Trigger,
    /// It ends a motion that the drive makes by itself.
    DriveStop,
    /// It keeps a motor at rest that needs a frame for that.
    StopFrame,
    /// It switches the power of the motor on.
    SwitchOn,
    /// It switches the power of the motor off.
    SwitchOff,
    /// It asks for what the master has to know.
    Reading,
    /// It asks for what the application wants to know.
    Poll,
    /// It changes the drive.
    Write,
    /// It makes the drive usable again.
    Repair,
    /// It closes the holding brake.
    BrakeClose,
    /// It opens the holding brake.
    BrakeOpen,
}

impl Class {
    /// Every class.
    pub const ALL: [Self; 14] = [
        Self::SetPoint,
        Self::DriveMove,
        Self::Load,
        Self::Trigger,
        Self::DriveStop,
        Self::StopFrame,
        Self::SwitchOn,
        Self::SwitchOff,
        Self::Reading,
        Self::Poll,
        Self::Write,
        Self::Repair,
        Self::BrakeClose,
        Self::BrakeOpen,
    ];

    /// Whether the frame is about a motion that the drive makes by itself.
    #[must_use]
    pub const fn is_of_own_move(self) -> bool {
        matches!(
            self,
            Self::DriveMove | Self::Load | Self::Trigger | Self::DriveStop
        )
    }

    /// The class of the frame that goes to a drive in every cycle, where a family has such a frame whether the axis moves or not.
    #[must_use]
    pub const fn of_cycle(facts: &Facts) -> Self {
        // Power goes off behind the brake.
        let is_held = matches!(facts.brake, Brake::Absent | Brake::Closed);
        match (facts.power, facts.motion) {
            (Power::OnWanted | Power::OnSent, _) => Self::SwitchOn,
            (Power::OffWanted | Power::OffSent, _) if is_held => Self::SwitchOff,
            (_, Motion::Rest | Motion::Loaded | Motion::Armed) => Self::StopFrame,
            (_, Motion::Ramp | Motion::Stream) => Self::SetPoint,
            (_, Motion::DriveMove) => Self::DriveMove,
        }
    }
}

/// Whether a frame of this class may be handed to the controller. Asked for every frame, every time, at the single place where frames
/// are offered.
#[must_use]
#[inline(always)]
pub const fn may_leave(class: Class, facts: &Facts) -> bool {
    // A comparison of one word decides for nearly every set-point, and a question moves nothing.
    match class {
        Class::Reading | Class::Poll => true,
        Class::SetPoint if facts.streams() => true,
        _ => may_leave_seldom(class, facts),
    }
}

/// [`may_leave`] of every class. Not inlined: the short way needs what it looks at as one word.
#[inline(never)]
const fn may_leave_seldom(class: Class, facts: &Facts) -> bool {
    let is_at_rest = !facts.moves();
    let is_wanted = !matches!(facts.goal, Goal::Off);
    let is_free_of_faults = matches!(facts.latch, Latch::None);
    let is_off_for_good = matches!(facts.power, Power::Off) && !is_wanted;
    let can_move = facts.can_move();
    let may_move_itself = can_move && is_free_of_faults && !facts.work.needs_off();
    match class {
        Class::Reading | Class::Poll => true,
        Class::SetPoint => facts.sends_set_points() && can_move,
        // A motion may take more than one frame to begin.
        Class::DriveMove => {
            matches!(facts.goal, Goal::Move)
                && matches!(facts.motion, Motion::Rest | Motion::DriveMove)
                && may_move_itself
        }
        Class::Load => {
            matches!(facts.goal, Goal::SyncMove)
                && matches!(facts.motion, Motion::Rest)
                && may_move_itself
        }
        Class::Trigger => {
            matches!(facts.goal, Goal::SyncMove)
                && matches!(facts.motion, Motion::Armed)
                && may_move_itself
        }
        // Whatever is known, but not to a drive that somebody else may have set in motion.
        Class::DriveStop => {
            facts.is_to_stop_itself() && !matches!(facts.power, Power::Unclear | Power::FoundOn)
        }
        // A drive that may have been enabled by somebody else is not touched.
        Class::StopFrame => is_at_rest && !matches!(facts.power, Power::Unclear | Power::FoundOn),
        Class::SwitchOn => {
            matches!(facts.power, Power::OnWanted | Power::OnSent)
                && matches!(facts.knowledge, Knowledge::Anchored)
                && is_wanted
                && is_free_of_faults
                && !facts.work.needs_off()
        }
        Class::SwitchOff => {
            matches!(facts.power, Power::OffWanted | Power::OffSent)
                && matches!(facts.brake, Brake::Absent | Brake::Closed)
        }
        Class::Write => matches!(facts.work, Work::Write) && is_off_for_good && is_free_of_faults,
        Class::Repair => matches!(facts.work, Work::Repair) && is_off_for_good,
        Class::BrakeClose => {
            is_at_rest
                && !is_wanted
                && !(facts.power.is_unclear() || matches!(facts.power, Power::FoundOn))
                && matches!(facts.brake, Brake::Unclear | Brake::Open)
        }
        Class::BrakeOpen => {
            is_wanted
                && is_free_of_faults
                && matches!(facts.power, Power::On)
                && matches!(facts.brake, Brake::Unclear | Brake::Closed)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// While the brake still closes, a drive that gets a frame in every cycle is told to stop, not to switch off.
    #[test]
    fn power_goes_off_behind_the_brake() {
        for power in [Power::OffWanted, Power::OffSent] {
            let class = |brake| {
                let facts = Facts::start(brake);
                Class::of_cycle(&Facts { power, ..facts })
            };
            let held = [Brake::Absent, Brake::Closed].map(class);
            assert_eq!(held, [Class::SwitchOff; 2], "{power:?}");
            let loose = [Brake::Open, Brake::Unclear].map(class);
            assert_eq!(loose, [Class::StopFrame; 2], "{power:?}");
        }
    }
}
